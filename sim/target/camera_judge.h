#ifndef SELFPROJ_SIM_TARGET_CAMERA_JUDGE_H
#define SELFPROJ_SIM_TARGET_CAMERA_JUDGE_H

#include <cstdint>
#include <optional>

#include "model/packet.h"
#include "model/test_camera.h"
#include "sim/target/frame_packets.h"

namespace selfproj {

// Compares packets of a board that looks at the test camera with the models, byte by byte. Which frame a packet is of
// follows from its time stamp. The settings are those of its header.
class CameraJudge {
 public:
  // The size of the camera's image, and the pixel clocks from one frame to the next.
  CameraJudge(int columns, int rows, std::uint64_t frame_clocks)
      : columns_(columns), rows_(rows), frame_clocks_(frame_clocks) {}

  // Returns whether the packet is that of the models.
  bool judge(const PacketView& packet) {
    const std::uint64_t time_stamp = packet.header.time_stamp;
    const std::uint64_t phase = time_stamp % frame_clocks_;
    if (time_stamp != time_stamp_ || !expected_.settings_of(packet.header)) {
      time_stamp_ = time_stamp;
      const auto frame = static_cast<std::uint32_t>(time_stamp / frame_clocks_);
      expected_.expect(test_camera_frame(columns_, rows_, frame), columns_, rows_, packet.header);
    }
    first_time_stamp_ = first_time_stamp_.value_or(time_stamp);
    if (phase != phase_.value_or(phase) || !expected_.has(packet, time_stamp == *first_time_stamp_)) {
      return false;
    }
    phase_ = phase;
    return true;
  }

 private:
  int columns_;
  int rows_;
  std::uint64_t frame_clocks_;
  std::optional<std::uint64_t> first_time_stamp_;
  std::uint64_t time_stamp_ = UINT64_MAX;
  std::optional<std::uint64_t> phase_;  // of the time stamps, the same in all packets
  FramePackets expected_;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_TARGET_CAMERA_JUDGE_H
