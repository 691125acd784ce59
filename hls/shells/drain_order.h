// When the groups of a last row leave the line buffer of ColumnMomentsShell and ColumnRunsShell: as in
// rtl/moments/sp_drain_order.sv, every second clock, while they come in at one group per clock.
#ifndef SELFPROJ_HLS_SHELLS_DRAIN_ORDER_H
#define SELFPROJ_HLS_SHELLS_DRAIN_ORDER_H

#include "hls/moments_arithmetic.h"

namespace selfproj {
namespace hls {

template <typename F>
struct DrainOrder {
  typename F::GroupCount waiting;  // groups in the line buffer
  bool ended, break_wait;
  bool odd;                    // a group was requested one clock ago
  bool active, was_active;     // in this clock, and in the previous one
  bool broke;                  // nothing is left before the break: reported one clock ago
  typename F::Group group;     // the next to request
  typename F::Group s1_group;  // the one that was requested last

  void reset() {
    waiting = 0;
    ended = false;
    break_wait = false;
    odd = false;
    active = false;
    was_active = false;
    broke = false;
    group = 0;
    s1_group = 0;
  }

  // Whether a group is requested in the clock that begins.
  bool drains() const { return waiting != 0 && !odd; }

  // The end of a clock. `drain`: a group was requested. `push`: a group goes into the line buffer. `line_end`: it is
  // the row's last. `broken`: the frame breaks.
  void step(bool drain, bool push, bool line_end, bool broken) {
    was_active = active;
    const bool last_read = drain && ended && waiting == 1;
    const bool break_now = break_wait && waiting == 0 && !odd;
    const bool over = last_read || break_now;
    broke = break_now;
    odd = drain;
    if (push && !drain) {
      waiting = waiting + 1;
    } else if (!push && drain) {
      waiting = waiting - 1;
    }
    if ((push && line_end) || broken) {
      ended = true;
    } else if (over) {
      ended = false;
    }
    if (broken) {
      break_wait = true;
    } else if (break_now) {
      break_wait = false;
    }
    if (push) {
      active = true;
    } else if (over) {
      active = false;
    }
    if (drain) {
      s1_group = group;
    }
    if (over) {
      group = 0;
    } else if (drain) {
      group = group + 1;
    }
  }
};

}  // namespace hls
}  // namespace selfproj

#endif  // SELFPROJ_HLS_SHELLS_DRAIN_ORDER_H
