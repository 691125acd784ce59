// Codes from the RTL: beats go into the Verilated decoder as the frame tracker would give them, and codes come out.
#include <verilated.h>

#include <cstdint>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>

#include "Vgray.h"
#include "sim/board/gray_engine.h"

namespace selfproj {
namespace {

class GrayRtlEngine final : public GrayEngine {
 public:
  GrayRtlEngine() : dut_(std::make_unique<Vgray>(&context_)) {
    dut_->rst_i = 1;
    dut_->beat_valid_i = 0;
    dut_->frame_start_i = 0;
    dut_->take_i = 0;
    dut_->break_i = 0;
    for (int i = 0; i < 4; ++i) {
      tick();
    }
    dut_->rst_i = 0;
  }
  GrayRtlEngine(const GrayRtlEngine&) = delete;
  GrayRtlEngine& operator=(const GrayRtlEngine&) = delete;
  ~GrayRtlEngine() override { dut_->final(); }

  [[nodiscard]] std::string name() const override { return "rtl"; }
  [[nodiscard]] int max_rows() const override { return 4095; }  // parameters of Vgray in sim/board/CMakeLists.txt
  [[nodiscard]] int max_columns() const override { return 4096; }

  void start(const GraySettings& settings, bool median) override {
    settings_ = settings;
    dut_->decode_i = 1;
    dut_->median_i = median;
    dut_->bits_i = static_cast<CData>(settings.bits);
    dut_->threshold_i = static_cast<CData>(settings.threshold);
    dut_->columns_i = static_cast<SData>(settings.columns);
    dut_->rows_i = static_cast<SData>(settings.rows);
    // A break makes the decoder wait for plane 0, even if the settings have not changed.
    dut_->break_i = 1;
    tick();
    dut_->break_i = 0;
    idle();
  }

  bool take(const ImageView& image, int pattern, std::uint16_t* codes) override {
    out_ = codes;
    left_ = static_cast<std::int64_t>(image.rows) * image.columns;
    const std::int64_t all = left_;
    dut_->pattern_i = static_cast<SData>(pattern);  // nothing of the previous frame is under way any more
    for (int row = 0; row < image.rows; ++row) {
      const std::uint8_t* line = image.pixels + row * image.stride;
      for (int column = 0; column < image.columns; column += spec::kPixelsPerBeat) {
        std::uint32_t pixels = 0;
        for (int i = spec::kPixelsPerBeat - 1; i >= 0; --i) {
          pixels = pixels << 8U | line[column + i];
        }
        const bool first = row == 0 && column == 0;
        dut_->take_i = first;
        dut_->frame_start_i = first;
        dut_->beat_valid_i = 1;
        dut_->beat_pixels_i = pixels;
        dut_->beat_line_start_i = column == 0;
        dut_->beat_line_end_i = column + spec::kPixelsPerBeat == image.columns;
        dut_->beat_last_row_i = row + 1 == image.rows;
        tick();
      }
    }
    dut_->beat_valid_i = 0;
    dut_->frame_start_i = 0;
    dut_->take_i = 0;
    idle();
    if (left_ != 0 && left_ != all) {
      throw std::runtime_error("the decoder gave a part of a code image");
    }
    return left_ == 0;
  }

 private:
  // Runs until everything under way is out.
  void idle() {
    for (int i = 0; i < settings_.columns / spec::kPixelsPerBeat + 40; ++i) {
      tick();
    }
  }

  void tick() {
    dut_->clk_i = 0;
    dut_->eval();
    dut_->clk_i = 1;
    dut_->eval();
    if (dut_->codes_valid_o != 0) {
      if (left_ < spec::kPixelsPerBeat) {
        throw std::runtime_error("the decoder gave more codes than pixels");
      }
      for (int i = 0; i < spec::kPixelsPerBeat; ++i) {
        *out_++ = static_cast<std::uint16_t>(dut_->codes_o >> (16 * i));
      }
      left_ -= spec::kPixelsPerBeat;
    }
  }

  VerilatedContext context_;
  std::unique_ptr<Vgray> dut_;
  GraySettings settings_;
  std::uint16_t* out_ = nullptr;
  std::int64_t left_ = 0;  // codes still to come
};

}  // namespace

std::unique_ptr<GrayEngine> make_gray_rtl_engine() { return std::make_unique<GrayRtlEngine>(); }

}  // namespace selfproj
