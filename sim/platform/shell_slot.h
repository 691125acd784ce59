// The place of sp_column_moments in a simulated board, with the SystemC shell in it.
//
// Vboard_hls (sim/device) calls it at every rising edge of the pixel clock. The shell is a module of the platform's
// kernel; it can run only while the kernel does. Before, when the host sets the registers, and after the end, nothing
// is under way in it, and its clock stands still; a beat would be an error. Its first clocks are those of a reset.
#ifndef SELFPROJ_SIM_PLATFORM_SHELL_SLOT_H
#define SELFPROJ_SIM_PLATFORM_SHELL_SLOT_H

#include "sim/shells/blocks.h"

namespace selfproj {

// One at a time: the simulated board has no other way to find it. Built before the board, and in elaboration.
class ShellSlot {
 public:
  // Throws std::logic_error where there is one already.
  ShellSlot();
  ShellSlot(const ShellSlot&) = delete;
  ShellSlot& operator=(const ShellSlot&) = delete;
  ~ShellSlot();

  // One clock, with the inputs of `pins`. Throws std::logic_error at a beat or a break while the kernel does not run.
  const ColumnMomentsPins& clock(const ColumnMomentsPins& pins);

  // The one that lives; there has to be one.
  static ShellSlot& present();

 private:
  ColumnMomentsBlock block_{"column_moments"};
  ColumnMomentsPins pins_;
  bool was_reset_ = false;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_PLATFORM_SHELL_SLOT_H
