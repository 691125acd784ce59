// What of a frame's last row waits in the line buffer of a kernel of the column moments, and when it leaves: a group of
// four columns every second step.
#ifndef SELFPROJ_HLS_LAST_ROW_H
#define SELFPROJ_HLS_LAST_ROW_H

#include "hls/moments_arithmetic.h"
#include "hls/types.h"

namespace selfproj {
namespace hls {

class LastRow {
 public:
  // The row has ended and is still being read.
  bool draining() const { return ended_; }
  // Two columns leave with the next step, whatever comes: the other two of the group that was read in the last one.
  bool odd() const { return odd_; }
  // These are the frame's last.
  bool odd_is_last() const { return odd_ && odd_last_; }
  // A last row comes or leaves.
  bool busy() const { return active_ || odd_; }
  // A group that an earlier step pushed leaves in this one.
  bool drains() const { return waiting_ != 0 && !odd_; }
  // That group.
  Group group() const { return group_; }

  // The end of a step: `push`, a group came; `push_end`, it is the row's last; `broken`, the frame breaks after it;
  // `drain`, drains() of this step.
  void step(bool push, bool push_end, bool broken, bool drain) {
#pragma HLS inline
    Uint<kWaitingBits> waiting = waiting_;
    if (push && !drain) {
      waiting = waiting + 1;
    } else if (!push && drain) {
      waiting = waiting - 1;
    }
    const bool cut = broken_ || (broken && (push || (active_ && !ended_)));  // but not for a frame that came later
    const bool ended = ended_ || push_end || cut;
    const bool last = ended && waiting == 0;  // nothing is left in the line buffer
    odd_ = drain;
    odd_last_ = last && !cut;
    broken_ = cut && !last;
    active_ = (active_ || push) && !last;
    ended_ = ended && !last;
    waiting_ = waiting;
    if (last) {
      group_ = 0;
    } else if (drain) {
      group_ = group_ + 1;
    }
  }

 private:
  static constexpr int kWaitingBits = bits_for(spec::kMaxColumns / kLanes);

  Uint<kWaitingBits> waiting_ = 0;  // groups in the line buffer
  Group group_ = 0;                 // next group to drain
  bool active_ = false;             // a last row comes or leaves
  bool ended_ = false;              // no more of it will come
  bool broken_ = false;             // it ended because its frame broke
  bool odd_ = false;
  bool odd_last_ = false;
};

}  // namespace hls
}  // namespace selfproj

#endif  // SELFPROJ_HLS_LAST_ROW_H
