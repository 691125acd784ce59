#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/gray_decoder.h"
#include "model/median3x3.h"
#include "sim/board/gray_engine.h"

namespace selfproj {
namespace {

class GrayModelEngine final : public GrayEngine {
 public:
  [[nodiscard]] std::string name() const override { return "model"; }
  [[nodiscard]] int max_rows() const override { return 1 << 15; }
  [[nodiscard]] int max_columns() const override { return 1 << 15; }

  void start(const GraySettings& settings, bool median) override {
    decoder_.emplace(settings);
    median_ = median;
    raw_.resize(median ? static_cast<std::size_t>(settings.rows) * static_cast<std::size_t>(settings.columns) : 0);
  }

  bool take(const ImageView& image, int pattern, std::uint16_t* codes) override {
    const bool due = decoder_->add_frame(image, pattern, true, median_ ? raw_.data() : codes);
    if (due && median_) {
      median3x3(raw_.data(), image.rows, image.columns, codes);
    }
    return due;
  }

 private:
  std::optional<GrayDecoder> decoder_;
  bool median_ = false;
  std::vector<std::uint16_t> raw_;
};

}  // namespace

std::unique_ptr<GrayEngine> make_gray_model_engine() { return std::make_unique<GrayModelEngine>(); }

}  // namespace selfproj
