#include "sim/platform/shell_slot.h"

#include <svdpi.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <systemc>

namespace selfproj::sim {
namespace {

// Whether this is a clock of a frame, and whether it takes settings over, which the board does all the time between
// frames.
bool has_beat(const ColumnMomentsPins& pins) { return pins.beat_valid_i != 0 || pins.break_i != 0; }
bool has_beat(const GrayDecoderPins& pins) {
  return pins.beat_valid_i != 0 || pins.break_i != 0 || pins.frame_start_i != 0;
}
bool has_beat(const Median3x3Pins& pins) { return pins.s_valid_i != 0 || pins.s_break_i != 0; }

// The moments get their settings with the beats, and the median with a frame's start.
bool has_settings(const ColumnMomentsPins& /*pins*/) { return false; }
bool has_settings(const GrayDecoderPins& pins) { return pins.take_i != 0; }
bool has_settings(const Median3x3Pins& /*pins*/) { return false; }

// Clocks after which everything that came in has left: some registers, then a line of codes, or moments at half speed.
constexpr int kRegisters = 32;
int longest_way(const ColumnMomentsPins& /*pins*/) { return spec::kMaxColumns / 2 + kRegisters; }
int longest_way(const GrayDecoderPins& /*pins*/) { return kRegisters; }
int longest_way(const Median3x3Pins& /*pins*/) { return spec::kMaxColumns / 4 + kRegisters; }

template <class Pins>
bool are_equal_settings(const Pins& /*a*/, const Pins& /*b*/) {
  return true;
}
bool are_equal_settings(const GrayDecoderPins& a, const GrayDecoderPins& b) {
  return a.decode_i == b.decode_i && a.bits_i == b.bits_i && a.threshold_i == b.threshold_i &&
         a.columns_i == b.columns_i && a.rows_i == b.rows_i;
}

}  // namespace

template <class Block, class Pins>
ShellSlot<Block, Pins>* ShellSlot<Block, Pins>::the_one = nullptr;

template <class Block, class Pins>
ShellSlot<Block, Pins>::ShellSlot(const char* name) : block_(name) {
  if (the_one != nullptr) {
    throw std::logic_error("two shells of a kind at once");
  }
  the_one = this;
}

template <class Block, class Pins>
ShellSlot<Block, Pins>::~ShellSlot() {
  the_one = nullptr;
}

template <class Block, class Pins>
ShellSlot<Block, Pins>& ShellSlot<Block, Pins>::present() {
  if (the_one == nullptr) {
    throw std::logic_error("a board without its shell");
  }
  return *the_one;
}

template <class Block, class Pins>
void ShellSlot<Block, Pins>::start() {
  constexpr int kResetClocks = 4;
  constexpr int kSettlingClocks = 8;  // settings are in force at most this many clocks after they came
  pins_.rst_i = 1;
  for (int i = 0; i < kResetClocks; ++i) {
    block_.clock(pins_);
  }
  if (settings_) {
    block_.clock(*settings_);
    pins_.rst_i = 0;
    for (int i = 0; i < kSettlingClocks; ++i) {
      block_.clock(pins_);
    }
  }
  was_reset_ = true;
}

template <class Block, class Pins>
const Pins& ShellSlot<Block, Pins>::clock(const Pins& pins) {
  if (!sc_core::sc_get_current_process_handle().valid()) {
    if (has_beat(pins)) {
      throw std::logic_error("a beat came while the kernel of the shell did not run");
    }
    if (has_settings(pins)) {
      settings_ = pins;
    }
    return pins_;
  }
  if (!was_reset_) {
    start();
  }
  bool something = has_beat(pins) || pins.rst_i != 0;
  if (has_settings(pins) && !(settings_ && are_equal_settings(*settings_, pins))) {
    settings_ = pins;
    something = true;
  }
  quiet_ = something ? 0 : std::min(quiet_, longest_way(pins)) + 1;
  if (quiet_ > longest_way(pins)) {
    return pins_;
  }
  pins_ = pins;
  block_.clock(pins_);
  return pins_;
}

template class ShellSlot<ColumnMomentsBlock, ColumnMomentsPins>;
template class ShellSlot<GrayDecoderBlock, GrayDecoderPins>;
template class ShellSlot<Median3x3Block, Median3x3Pins>;

namespace {

// Takes values out of a word, one after another from bit 0, as the SystemVerilog packs them.
class Bits {
 public:
  explicit Bits(unsigned word) : word_(word) {}
  std::uint8_t next(unsigned width = 1) {
    const auto value = static_cast<std::uint8_t>(word_ & ((1U << width) - 1));
    word_ >>= width;
    return value;
  }

 private:
  unsigned word_;
};

// Packs values in the same way.
class Flags {
 public:
  Flags& add(unsigned value, unsigned width = 1) {
    word_ |= value << at_;
    at_ += width;
    return *this;
  }
  [[nodiscard]] unsigned word() const { return word_; }

 private:
  unsigned word_ = 0;
  unsigned at_ = 0;
};

Wide128 wide_of(const svBitVecVal* words) { return {words[0], words[1], words[2], words[3]}; }

void copy(const Wide128& wide, svBitVecVal* words) {
  for (std::size_t i = 0; i < wide.size(); ++i) {
    words[i] = wide[i];
  }
}

void copy(std::uint64_t wide, svBitVecVal* words) {
  words[0] = static_cast<svBitVecVal>(wide);
  words[1] = static_cast<svBitVecVal>(wide >> 32);
}

std::uint64_t long_of(const svBitVecVal* words) { return std::uint64_t{words[1]} << 32 | words[0]; }

}  // namespace
}  // namespace selfproj::sim

// Called by the modules of the same names in sim/board/shells, which define the bits.

extern "C" void selfproj_shell_column_moments(unsigned flags, unsigned pixels, unsigned group, unsigned row,
                                              unsigned mode, unsigned threshold, unsigned* answer, svBitVecVal* data) {
  selfproj::sim::Bits bits(flags);
  selfproj::sim::ColumnMomentsPins in;
  in.rst_i = bits.next();
  in.beat_valid_i = bits.next();
  in.beat_first_row_i = bits.next();
  in.beat_last_row_i = bits.next();
  in.beat_line_end_i = bits.next();
  in.one_group_i = bits.next();
  in.two_groups_i = bits.next();
  in.break_i = bits.next();
  in.accept_i = bits.next();
  in.beat_pixels_i = pixels;
  in.beat_group_i = static_cast<std::uint16_t>(group);
  in.beat_row_i = static_cast<std::uint16_t>(row);
  in.mode_i = static_cast<std::uint8_t>(mode);
  in.threshold_i = static_cast<std::uint8_t>(threshold);
  const selfproj::sim::ColumnMomentsPins& out = selfproj::sim::ColumnMomentsSlot::present().clock(in);
  *answer = selfproj::sim::Flags().add(out.moments_valid_o).add(out.moments_break_o).add(out.spoiled_o).word();
  selfproj::sim::copy(out.moments_data_o, data);
}

extern "C" void selfproj_shell_gray_decoder(unsigned flags, unsigned settings, unsigned size, unsigned pixels,
                                            unsigned pattern, const svBitVecVal* mem, unsigned* answer,
                                            svBitVecVal* mem_out, svBitVecVal* codes, unsigned* abandoned) {
  selfproj::sim::Bits bits(flags);
  selfproj::sim::GrayDecoderPins in;
  in.rst_i = bits.next();
  in.take_i = bits.next();
  in.decode_i = bits.next();
  in.beat_valid_i = bits.next();
  in.beat_line_start_i = bits.next();
  in.beat_line_end_i = bits.next();
  in.beat_last_row_i = bits.next();
  in.frame_start_i = bits.next();
  in.break_i = bits.next();
  in.mem_late_i = bits.next();
  in.busy_i = bits.next();
  in.break_status_i = bits.next(selfproj::hls::kStatusBits);
  in.bits_i = static_cast<std::uint8_t>(settings & 0xFU);
  in.threshold_i = static_cast<std::uint8_t>(settings >> 4);
  in.columns_i = static_cast<std::uint16_t>(size & 0xFFFFU);
  in.rows_i = static_cast<std::uint16_t>(size >> 16);
  in.beat_pixels_i = pixels;
  in.pattern_i = static_cast<std::uint16_t>(pattern);
  in.mem_data_i = selfproj::sim::wide_of(mem);
  const selfproj::sim::GrayDecoderPins& out = selfproj::sim::GrayDecoderSlot::present().clock(in);
  *answer = selfproj::sim::Flags()
                .add(out.mem_read_o)
                .add(out.mem_read_first_o)
                .add(out.mem_write_o)
                .add(out.mem_write_first_o)
                .add(out.mem_end_o)
                .add(out.codes_valid_o)
                .add(out.codes_start_o)
                .add(out.codes_line_start_o)
                .add(out.codes_line_end_o)
                .add(out.codes_last_row_o)
                .add(out.codes_break_o)
                .add(out.codes_status_o, selfproj::hls::kStatusBits)
                .word();
  selfproj::sim::copy(out.mem_data_o, mem_out);
  selfproj::sim::copy(out.codes_o, codes);
  *abandoned = out.abandoned_o;
}

extern "C" void selfproj_shell_median3x3(unsigned flags, const svBitVecVal* codes, unsigned* answer,
                                         svBitVecVal* codes_out) {
  selfproj::sim::Bits bits(flags);
  selfproj::sim::Median3x3Pins in;
  in.rst_i = bits.next();
  in.s_valid_i = bits.next();
  in.s_start_i = bits.next();
  in.s_line_start_i = bits.next();
  in.s_line_end_i = bits.next();
  in.s_last_row_i = bits.next();
  in.s_break_i = bits.next();
  in.s_median_i = bits.next();
  in.s_status_i = bits.next(selfproj::hls::kStatusBits);
  in.s_codes_i = selfproj::sim::long_of(codes);
  const selfproj::sim::Median3x3Pins& out = selfproj::sim::Median3x3Slot::present().clock(in);
  *answer = selfproj::sim::Flags()
                .add(out.busy_o)
                .add(out.m_valid_o)
                .add(out.m_start_o)
                .add(out.m_line_start_o)
                .add(out.m_line_end_o)
                .add(out.m_break_o)
                .add(out.m_status_o, selfproj::hls::kStatusBits)
                .word();
  selfproj::sim::copy(out.m_codes_o, codes_out);
}
