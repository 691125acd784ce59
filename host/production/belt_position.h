// Where the belt is, frame by frame.
#ifndef SELFPROJ_HOST_PRODUCTION_BELT_POSITION_H
#define SELFPROJ_HOST_PRODUCTION_BELT_POSITION_H

#include <cstdint>

#include "selfproj/model/packet.h"
#include "selfproj/model/pixel_clock.h"
#include "selfproj/rig/rig.h"

namespace selfproj::production {

// Adds up the way of the belt, in mm since the first frame, by the encoder or by speed and time stamps, as the rig's
// section `parts` says. Both counters may wrap. Where the time stamps go back the board was restarted, and the belt is
// assumed to have moved on by the last step.
class BeltPosition {
 public:
  explicit BeltPosition(const rig::Rig& rig)
      : by_encoder_(rig.parts.value_or(rig::RigParts{}).by_encoder),
        mm_per_count_(rig.conveyor.encoder_mm_per_count),
        mm_per_s_(rig.conveyor.speed_mm_per_s),
        clock_hz_(rig.pixel_clock_hz()),
        step_(rig.conveyor.speed_mm_per_s / rig.camera.sent().frame_rate_hz) {}

  // Takes the next frame and returns the position.
  double add(const model::PacketHeader& header) {
    restarted_ = any_ && header.time_stamp < time_stamp_;
    pause_s_ = any_ && !restarted_ ? model::seconds_of_clocks(header.time_stamp - time_stamp_, clock_hz_) : 0;
    if (any_ && !restarted_) {
      step_ = by_encoder_ ? static_cast<std::int32_t>(header.encoder - encoder_) * mm_per_count_ : pause_s_ * mm_per_s_;
    }
    position_ += any_ ? step_ : 0;
    any_ = true;
    time_stamp_ = header.time_stamp;
    encoder_ = header.encoder;
    return position_;
  }

  // Between the last two frames: whether the board was restarted, and the time by their stamps.
  [[nodiscard]] bool restarted() const { return restarted_; }
  [[nodiscard]] double pause_s() const { return pause_s_; }

 private:
  bool by_encoder_;
  double mm_per_count_;
  double mm_per_s_;
  double clock_hz_;
  double step_;
  double position_ = 0;
  double pause_s_ = 0;
  bool any_ = false;
  bool restarted_ = false;
  std::uint64_t time_stamp_ = 0;
  std::uint32_t encoder_ = 0;
};

}  // namespace selfproj::production

#endif  // SELFPROJ_HOST_PRODUCTION_BELT_POSITION_H
