// The places of the blocks in a simulated board that have their SystemC shells in them.
//
// Vboard_hls and Vboard_scanner_hls (sim/board) call them at every rising edge of the pixel clock. A shell is a module
// of the platform's kernel; it can run only while the kernel does. Before, when the host sets the registers, and after
// the end, nothing is under way in it, and its clock stands still; a beat would be an error. Settings that come then
// are handed on as soon as it runs. Its first clocks are those of a reset.
#ifndef SELFPROJ_SIM_PLATFORM_SHELL_SLOT_H
#define SELFPROJ_SIM_PLATFORM_SHELL_SLOT_H

#include <optional>

#include "sim/board/shell_blocks.h"

namespace selfproj {

// One of a kind at a time: the simulated board has no other way to find it. Built before the board, and in elaboration.
// For ColumnMomentsBlock, GrayDecoderBlock, Median3x3Block with their pins.
template <class Block, class Pins>
class ShellSlot {
 public:
  // `name` in the kernel. Throws std::logic_error where there is one already.
  explicit ShellSlot(const char* name);
  ShellSlot(const ShellSlot&) = delete;
  ShellSlot& operator=(const ShellSlot&) = delete;
  ~ShellSlot();

  // One clock, with the inputs of `pins`. The block's own clock stands still where nothing has come for so long that
  // all that was under way has left; its outputs stay as they are. Throws std::logic_error at a beat or a break while
  // the kernel does not run.
  const Pins& clock(const Pins& pins);

  // The one that lives; there has to be one.
  static ShellSlot& present();

 private:
  void start();

  static ShellSlot* the_one;

  Block block_;
  Pins pins_;
  std::optional<Pins> settings_;  // the last that were taken over
  bool was_reset_ = false;
  int quiet_ = 0;  // clocks since something came, as far as it matters
};

using ColumnMomentsSlot = ShellSlot<ColumnMomentsBlock, ColumnMomentsPins>;
using GrayDecoderSlot = ShellSlot<GrayDecoderBlock, GrayDecoderPins>;
using Median3x3Slot = ShellSlot<Median3x3Block, Median3x3Pins>;

}  // namespace selfproj

#endif  // SELFPROJ_SIM_PLATFORM_SHELL_SLOT_H
