// Codes from the HLS kernel: its C simulation, one step for each clock.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>

#include "hls/gray_decoder.h"
#include "sim/board/gray_engine.h"
#include "sim/board/hls_streams.h"

namespace selfproj {
namespace {

class GrayHlsEngine final : public GrayEngine {
 public:
  [[nodiscard]] std::string name() const override { return "hls"; }
  [[nodiscard]] int max_rows() const override { return kRows; }
  [[nodiscard]] int max_columns() const override { return kColumns; }

  void start(const GraySettings& settings, bool median) override {
    kernel_ = std::make_unique<Kernel>();
    setup_.columns = settings.columns;
    setup_.rows = settings.rows;
    setup_.bits = settings.bits;
    setup_.threshold = settings.threshold;
    setup_.median = median;
  }

  bool take(const ImageView& image, int pattern, std::uint16_t* codes) override {
    push_frame(image, video_);
    const hls::PatternIndex index = pattern;
    bool more = true;
    while (more || !video_.empty()) {
      more = kernel_->step(video_, setup_, index, codes_);
    }
    const std::size_t all = static_cast<std::size_t>(image.rows) * static_cast<std::size_t>(image.columns);
    std::size_t count = 0;
    hls::AxisBeat<64> beat;
    while (codes_.read_nb(beat)) {
      if (count == all) {
        throw std::runtime_error("engine hls: more codes than pixels");
      }
      const std::uint64_t words = beat.data.to_uint64();
      for (unsigned i = 0; i < spec::kPixelsPerBeat; ++i) {
        codes[count++] = static_cast<std::uint16_t>(words >> (spec::kCodeWordBits * i));
      }
    }
    if (count != 0 && count != all) {
      throw std::runtime_error("engine hls: a part of a code image");
    }
    return count != 0;
  }

 private:
  static constexpr int kColumns = 4096;
  static constexpr int kRows = 4095;
  using Kernel = hls::GrayDecoderKernel<kColumns, kRows>;

  std::unique_ptr<Kernel> kernel_;
  hls::GraySetup setup_;
  hls::Stream<hls::AxisBeat<32>> video_;
  hls::Stream<hls::AxisBeat<64>> codes_;
};

}  // namespace

std::unique_ptr<GrayEngine> make_gray_hls_engine() { return std::make_unique<GrayHlsEngine>(); }

}  // namespace selfproj
