// The places of blocks in a simulated board that hold SystemC shells.
//
// Vboard_hls and Vboard_scanner_hls (sim/board) call them at every rising edge of the pixel clock. A shell is a module
// of the platform's kernel, and can run only while the kernel does. Before that, when the host sets the registers, and
// after the end, nothing is under way in it, and its clock stands still; a beat would be an error. Settings that come
// meanwhile are passed on as soon as it runs. Its first clocks are those of a reset.
#ifndef SELFPROJ_SIM_PLATFORM_SHELL_SLOT_H
#define SELFPROJ_SIM_PLATFORM_SHELL_SLOT_H

#include <optional>

#include "sim/board/moments_blocks.h"
#include "sim/board/shell_blocks.h"

namespace selfproj::sim {

// Only one of a kind may exist at a time, because the simulated board has no other way to find it. It is built before
// the board, during elaboration. For ColumnMomentsBlock, GrayDecoderBlock and Median3x3Block with their pins.
template <class Block, class Pins>
class ShellSlot {
 public:
  // `name` is its name in the kernel. Throws std::logic_error if there is one already.
  explicit ShellSlot(const char* name);
  ShellSlot(const ShellSlot&) = delete;
  ShellSlot& operator=(const ShellSlot&) = delete;
  ~ShellSlot();

  // One clock with the inputs of `pins`. The block's own clock stops when nothing has come for long enough that
  // everything under way has left; its outputs then keep their values. Throws std::logic_error at a beat or a break
  // while the kernel does not run.
  const Pins& clock(const Pins& pins);

  // The existing one; there must be one.
  static ShellSlot& present();

 private:
  void start();

  static ShellSlot* the_one;

  Block block_;
  Pins pins_;
  std::optional<Pins> settings_;  // the last ones that were taken over
  bool was_reset_ = false;
  int quiet_ = 0;  // clocks since the last input, up to a limit
};

using ColumnMomentsSlot = ShellSlot<ColumnMomentsBlock, ColumnMomentsPins>;
using GrayDecoderSlot = ShellSlot<GrayDecoderBlock, GrayDecoderPins>;
using Median3x3Slot = ShellSlot<Median3x3Block, Median3x3Pins>;

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_PLATFORM_SHELL_SLOT_H
