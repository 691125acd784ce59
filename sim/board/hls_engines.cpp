// Moments and codes from the SystemC shells of hls/, one clock after another.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "selfproj/model/generated/selfproj_spec.h"
#include "selfproj/model/little_endian.h"
#include "selfproj/model/packet.h"
#include "sim/board/engines.h"
#include "sim/board/moments_blocks.h"
#include "sim/board/shell_blocks.h"

namespace selfproj::sim {
namespace {

// All modules must exist before SystemC's kernel first runs. One engine after another uses them, and each begins with a
// reset.
struct Shells {
  ColumnMomentsBlock moments{"moments"};
  ColumnRunsBlock runs{"runs"};
  GrayDecoderBlock decoder{"decoder"};
  Median3x3Block median{"median"};
};

Shells& shells() {
  static Shells all;
  return all;
}

class HlsEngine final : public MomentsEngine {
 public:
  [[nodiscard]] std::string name() const override { return "hls"; }

  void process(std::span<const model::ImageView> frames, const MomentsSettings& settings,
               std::span<model::Runs> out) override {
    const model::Measure& measure = settings.measure;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      std::vector<std::uint8_t> bytes;
      if (measure.select == model::Select::strongest) {
        ColumnRunsPins pins;
        pins.strongest_i = 1;
        pins.gap_i = static_cast<std::uint8_t>(measure.gap);
        bytes = payload_of(shells().runs, pins, frames[i], measure);
      } else {
        ColumnMomentsPins pins;
        pins.one_group_i = settings.columns == spec::kPixelsPerBeat;
        pins.two_groups_i = settings.columns == 2 * spec::kPixelsPerBeat;
        bytes = payload_of(shells().moments, pins, frames[i], measure);
      }
      if (bytes.size() != model::moments_payload_bytes(measure.mode, settings.columns)) {
        throw std::runtime_error("engine hls: frame " + std::to_string(i + 1) + " gave no whole payload");
      }
      out[i].resize(measure.select, settings.columns);
      model::unpack_columns(model::column_word(measure.select, measure.mode), settings.columns, bytes.data(),
                            out[i].view());
    }
  }
};

// The decoder with its memory, and the median behind it, wired as in sp_gray_core.
class GrayHlsEngine final : public GrayEngine {
 public:
  [[nodiscard]] std::string name() const override { return "hls"; }
  // The decoder does not count rows: it only sees whether their number changes.
  [[nodiscard]] int max_rows() const override { return 4095; }
  [[nodiscard]] int max_columns() const override { return spec::kMaxColumns; }

  void start(const model::GraySettings& settings, bool median) override {
    decoder_ = {};
    median_ = {};
    reset_shell(shells().decoder, decoder_);
    reset_shell(shells().median, median_);
    const auto pixels = static_cast<std::size_t>(settings.rows) * static_cast<std::size_t>(settings.columns);
    memory_.resize(pixels / spec::kPixelsPerBeat);
    decoder_.decode_i = 1;
    decoder_.bits_i = static_cast<std::uint8_t>(settings.bits);
    decoder_.threshold_i = static_cast<std::uint8_t>(settings.threshold);
    decoder_.columns_i = static_cast<std::uint16_t>(settings.columns);
    decoder_.rows_i = static_cast<std::uint16_t>(settings.rows);
    median_.s_median_i = median;
  }

  bool take(const model::ImageView& image, int pattern, std::uint16_t* codes) override {
    out_ = codes;
    left_ = static_cast<std::size_t>(image.rows) * static_cast<std::size_t>(image.columns);
    const std::size_t all = left_;
    decoder_.pattern_i = static_cast<std::uint16_t>(pattern);  // nothing of the previous frame is under way any more
    decoder_.beat_valid_i = 1;
    for (int row = 0; row < image.rows; ++row) {
      const std::uint8_t* line = image.pixels + row * image.stride;
      decoder_.beat_last_row_i = row + 1 == image.rows;
      for (int column = 0; column < image.columns; column += spec::kPixelsPerBeat) {
        const bool first = row == 0 && column == 0;
        decoder_.take_i = first;
        decoder_.frame_start_i = first;
        decoder_.beat_pixels_i = model::load_little_endian<std::uint32_t>(line + column);
        decoder_.beat_line_start_i = column == 0;
        decoder_.beat_line_end_i = column + spec::kPixelsPerBeat == image.columns;
        tick();
      }
    }
    decoder_.beat_valid_i = 0;
    decoder_.take_i = 0;
    decoder_.frame_start_i = 0;
    for (int i = 0; i < image.columns / spec::kPixelsPerBeat + kShellRegisters; ++i) {  // the median's last line
      tick();
    }
    if (left_ != 0 && left_ != all) {
      throw std::runtime_error("engine hls: a part of a code image");
    }
    return left_ == 0;
  }

 private:
  void tick() {
    access_memory();
    median_.s_valid_i = decoder_.codes_valid_o;
    median_.s_codes_i = decoder_.codes_o;
    median_.s_start_i = decoder_.codes_start_o;
    median_.s_line_start_i = decoder_.codes_line_start_o;
    median_.s_line_end_i = decoder_.codes_line_end_o;
    median_.s_last_row_i = decoder_.codes_last_row_o;
    median_.s_break_i = decoder_.codes_break_o;
    median_.s_status_i = decoder_.codes_status_o;
    decoder_.busy_i = median_.busy_o;
    shells().decoder.clock(decoder_);
    shells().median.clock(median_);
    if (median_.m_valid_o != 0) {
      if (left_ < spec::kPixelsPerBeat) {
        throw std::runtime_error("engine hls: more codes than pixels");
      }
      for (unsigned i = 0; i < spec::kPixelsPerBeat; ++i) {
        *out_++ = static_cast<std::uint16_t>(median_.m_codes_o >> (spec::kCodeWordBits * i));
      }
      left_ -= spec::kPixelsPerBeat;
    }
  }

  // A word appears two clocks after its request.
  void access_memory() {
    decoder_.mem_data_i = arriving_;
    arriving_ = requested_;
    if (decoder_.mem_read_o != 0) {
      read_at_ = decoder_.mem_read_first_o != 0 ? 0 : read_at_ + 1;
      requested_ = memory_[read_at_];
    }
    if (decoder_.mem_write_o != 0) {
      write_at_ = decoder_.mem_write_first_o != 0 ? 0 : write_at_ + 1;
      memory_[write_at_] = decoder_.mem_data_o;
    }
  }

  GrayDecoderPins decoder_;
  Median3x3Pins median_;
  std::vector<Wide128> memory_;  // the states of four pixels
  Wide128 requested_{};
  Wide128 arriving_{};  // requested a clock before that
  std::size_t read_at_ = 0;
  std::size_t write_at_ = 0;
  std::uint16_t* out_ = nullptr;
  std::size_t left_ = 0;  // codes still to come
};

}  // namespace

std::unique_ptr<MomentsEngine> make_moments_hls_engine() { return std::make_unique<HlsEngine>(); }

std::unique_ptr<GrayEngine> make_gray_hls_engine() { return std::make_unique<GrayHlsEngine>(); }

}  // namespace selfproj::sim
