#include "sim/platform/shell_slot.h"

#include <svdpi.h>

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <systemc>

namespace selfproj {
namespace {

ShellSlot* g_present = nullptr;

}  // namespace

ShellSlot::ShellSlot() {
  if (g_present != nullptr) {
    throw std::logic_error("two shells at once");
  }
  g_present = this;
}

ShellSlot::~ShellSlot() { g_present = nullptr; }

ShellSlot& ShellSlot::present() {
  if (g_present == nullptr) {
    throw std::logic_error("a board without its shell");
  }
  return *g_present;
}

const ColumnMomentsPins& ShellSlot::clock(const ColumnMomentsPins& pins) {
  if (!sc_core::sc_get_current_process_handle().valid()) {
    if (pins.beat_valid_i != 0 || pins.break_i != 0) {
      throw std::logic_error("a beat came while the kernel of the shell did not run");
    }
    return pins_;
  }
  if (!was_reset_) {
    constexpr int kResetClocks = 4;
    pins_.rst_i = 1;
    for (int i = 0; i < kResetClocks; ++i) {
      block_.clock(pins_);
    }
    was_reset_ = true;
  }
  pins_ = pins;
  block_.clock(pins_);
  return pins_;
}

}  // namespace selfproj

// Called by sim/shells/sp_column_moments.sv, which says what the bits are.
extern "C" void selfproj_shell_column_moments(unsigned flags, unsigned pixels, unsigned group, unsigned row,
                                              unsigned mode, unsigned threshold, unsigned* answer, svBitVecVal* data) {
  const auto flag = [flags](unsigned bit) { return static_cast<std::uint8_t>(flags >> bit & 1U); };
  selfproj::ColumnMomentsPins in;
  in.rst_i = flag(0);
  in.beat_valid_i = flag(1);
  in.beat_first_row_i = flag(2);
  in.beat_last_row_i = flag(3);
  in.beat_line_end_i = flag(4);
  in.one_group_i = flag(5);
  in.two_groups_i = flag(6);
  in.break_i = flag(7);
  in.accept_i = flag(8);
  in.beat_pixels_i = pixels;
  in.beat_group_i = static_cast<std::uint16_t>(group);
  in.beat_row_i = static_cast<std::uint16_t>(row);
  in.mode_i = static_cast<std::uint8_t>(mode);
  in.threshold_i = static_cast<std::uint8_t>(threshold);
  const selfproj::ColumnMomentsPins& out = selfproj::ShellSlot::present().clock(in);
  *answer = out.moments_valid_o | (out.moments_break_o != 0 ? 2U : 0U) | (out.spoiled_o != 0 ? 4U : 0U);
  for (std::size_t i = 0; i < out.moments_data_o.size(); ++i) {
    data[i] = out.moments_data_o[i];
  }
}
