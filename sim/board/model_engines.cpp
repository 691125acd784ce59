#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "selfproj/model/column_runs.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/model/gray_match.h"
#include "selfproj/model/median3x3.h"
#include "selfproj/model/packet_payload.h"
#include "sim/board/engines.h"

namespace selfproj::sim {
namespace {

class ModelEngine final : public MomentsEngine {
 public:
  [[nodiscard]] std::string name() const override { return "model"; }

  void process(std::span<const model::ImageView> frames, const MomentsSettings& settings,
               std::span<model::Runs> out) override {
    const model::Measure& measure = settings.measure;
    std::vector<std::uint8_t> payload(model::moments_payload_bytes(measure.mode, settings.columns));
    for (std::size_t i = 0; i < frames.size(); ++i) {
      out[i].resize(measure.select, settings.columns);
      model::measure_columns(frames[i], measure, out[i].view());
      if (measure.select == model::Select::strongest) {  // as a packet tells it
        const model::ColumnWord word = model::column_word(measure.select, measure.mode);
        model::pack_columns(word, settings.columns, out[i].view(), payload.data());
        model::unpack_columns(word, settings.columns, payload.data(), out[i].view());
      }
    }
  }
};

}  // namespace

std::unique_ptr<MomentsEngine> make_moments_model_engine() { return std::make_unique<ModelEngine>(); }

namespace {

class GrayModelEngine final : public GrayEngine {
 public:
  [[nodiscard]] std::string name() const override { return "model"; }
  [[nodiscard]] int max_rows() const override { return 1 << 15; }
  [[nodiscard]] int max_columns() const override { return 1 << 15; }

  void start(const model::GraySettings& settings, bool median) override {
    decoder_.emplace(settings);
    median_ = median;
    raw_.resize(median ? static_cast<std::size_t>(settings.rows) * static_cast<std::size_t>(settings.columns) : 0);
  }

  bool take(const model::ImageView& image, int pattern, std::uint16_t* codes) override {
    const bool due = decoder_->add_frame(image, pattern, true, median_ ? raw_.data() : codes);
    if (due && median_) {
      model::median3x3(raw_.data(), image.rows, image.columns, codes);
    }
    return due;
  }

 private:
  std::optional<model::GrayDecoder> decoder_;
  bool median_ = false;
  std::vector<std::uint16_t> raw_;
};

}  // namespace

std::unique_ptr<GrayEngine> make_gray_model_engine() { return std::make_unique<GrayModelEngine>(); }

namespace {

class MatchModelEngine final : public MatchEngine {
 public:
  MatchModelEngine(std::vector<std::uint16_t> table, int bits) : table_(std::move(table)), bits_(bits) {}

  [[nodiscard]] std::string name() const override { return "model"; }

  void look_up(const std::uint16_t* codes, int rows, int columns, std::uint16_t* lines) override {
    model::GrayMatch::look_up(codes, static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns), bits_,
                              table_.data(), lines);
  }

 private:
  std::vector<std::uint16_t> table_;
  int bits_;
};

}  // namespace

std::unique_ptr<MatchEngine> make_match_model_engine(std::vector<std::uint16_t> table, int bits) {
  return std::make_unique<MatchModelEngine>(std::move(table), bits);
}

}  // namespace selfproj::sim
