// Moments from the HLS kernel: its C simulation, one step for each clock.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "hls/column_moments.h"
#include "hls/column_runs.h"
#include "hls/gray_decoder.h"
#include "selfproj/model/packet.h"
#include "sim/board/engines.h"
#include "sim/board/hls_streams.h"

namespace selfproj::sim {
namespace {

class HlsEngine final : public MomentsEngine {
 public:
  [[nodiscard]] std::string name() const override { return "hls"; }

  void process(std::span<const model::ImageView> frames, const MomentsSettings& settings,
               std::span<model::Runs> out) override {
    const model::Measure& measure = settings.measure;
    hls::MomentsSetup setup;
    setup.columns = settings.columns;
    setup.rows = settings.rows;
    setup.mode = static_cast<unsigned>(measure.mode);
    setup.threshold = measure.threshold;
    setup.strongest = measure.select == model::Select::strongest;
    setup.gap = measure.gap;
    setup.first_row = measure.window.first;
    setup.last_row = measure.window.last;
    const std::size_t size = model::moments_payload_bytes(measure.mode, settings.columns);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      push_frame(frames[i], video_);
      bool more = true;
      while (more || !video_.empty()) {
        more = setup.strongest ? runs_kernel_->step(video_, setup, payload_) : kernel_->step(video_, setup, payload_);
      }
      bytes_.clear();
      hls::AxisBeat<128> beat;
      while (payload_.read_nb(beat)) {
        append_beat(beat, bytes_);
        if (beat.last != (bytes_.size() == size ? 1U : 0U)) {
          break;
        }
      }
      if (bytes_.size() != size) {
        throw std::runtime_error("engine hls: frame " + std::to_string(i + 1) + " gave no whole payload");
      }
      out[i].resize(measure.select, settings.columns);
      model::unpack_columns(measure.select, measure.mode, settings.columns, bytes_.data(), out[i].view());
    }
  }

 private:
  std::unique_ptr<hls::ColumnMomentsKernel> kernel_ = std::make_unique<hls::ColumnMomentsKernel>();
  std::unique_ptr<hls::ColumnRunsKernel> runs_kernel_ = std::make_unique<hls::ColumnRunsKernel>();
  hls::Stream<hls::AxisBeat<32>> video_;
  hls::Stream<hls::AxisBeat<128>> payload_;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace

std::unique_ptr<MomentsEngine> make_moments_hls_engine() { return std::make_unique<HlsEngine>(); }

// Codes from the HLS kernel: its C simulation, one step for each clock.

namespace {

class GrayHlsEngine final : public GrayEngine {
 public:
  [[nodiscard]] std::string name() const override { return "hls"; }
  [[nodiscard]] int max_rows() const override { return kRows; }
  [[nodiscard]] int max_columns() const override { return kColumns; }

  void start(const model::GraySettings& settings, bool median) override {
    kernel_ = std::make_unique<Kernel>();
    setup_.columns = settings.columns;
    setup_.rows = settings.rows;
    setup_.bits = settings.bits;
    setup_.threshold = settings.threshold;
    setup_.median = median;
  }

  bool take(const model::ImageView& image, int pattern, std::uint16_t* codes) override {
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

}  // namespace selfproj::sim
