// What the models say of a frame, and comparison with what a board has sent.
#ifndef SELFPROJ_CONSTRAINTS_COMMON_SCOREBOARD_H
#define SELFPROJ_CONSTRAINTS_COMMON_SCOREBOARD_H

#include <cstdint>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "model/test_camera.h"
#include "selfproj/model/board.h"
#include "selfproj/model/packet.h"

namespace selfproj::sim {

// A frame of the camera through the models. Its first beat comes at inputs.clock.
void show_frame(model::BoardModel& model, std::span<const std::uint8_t> pixels, int columns, model::BoardInputs inputs);

// The packets that a board sends of a frame, with the settings of a packet that came.
class FramePackets {
 public:
  // Of `pixels`, rows · columns of them, with the mode, threshold and stream of `header`.
  void expect(std::span<const std::uint8_t> pixels, int columns, int rows, const model::PacketHeader& header);

  // A packet of another model of the board.
  void expect(model::BoardPacket&& packet);
  void clear() { expected_.clear(); }

  // Whether what is expected is of the settings of this packet.
  [[nodiscard]] bool settings_of(const model::PacketHeader& header) const {
    return !model::has_columns(header.kind) ||
           (header.kind == kind_ && header.mode == mode_ && header.threshold == threshold_);
  }

  // Whether the packet is one of them, byte by byte. What the models do not know is taken from the packet: which frame
  // of the board it is, when it was, and what was lost before it. `may_stray`: a board that is started within a frame
  // gets the rest of it as stray beats before its first frame.
  [[nodiscard]] bool has(const model::PacketView& packet, bool may_stray) const;

 private:
  std::uint8_t kind_ = 0;
  std::uint8_t mode_ = 0;
  std::uint16_t threshold_ = 0;
  std::map<std::pair<std::uint8_t, std::uint16_t>, model::BoardPacket> expected_;
};

// Compares packets of a board that looks at the test camera with the models, byte by byte. Which frame a packet is of
// follows from its time stamp. The settings are those of its header. The camera runs free from the reset on, or
// triggers make its frames. With triggers, find_frame() must first find out which picture the first frame shows.
class CameraScoreboard {
 public:
  // The size of the camera's image, and the pixel clocks from one frame to the next.
  CameraScoreboard(int columns, int rows, std::uint64_t frame_clocks)
      : columns_(columns), rows_(rows), frame_clocks_(frame_clocks) {}

  // Finds a frame that has the moments of this packet: with grey moments, exact or compact, it shows the same picture,
  // with binary ones lines in the same places. The frames of all packets are then counted from there. Returns false if
  // there is none.
  bool find_frame(const model::PacketView& moments) {
    const auto rows = static_cast<std::uint32_t>(rows_);
    const std::uint32_t pictures = std::lcm(rows - 3, kBrightnesses);
    for (first_frame_ = 0; first_frame_ < pictures; ++first_frame_) {
      expect(moments.header);
      if (expected_.has(moments, true)) {
        return true;
      }
    }
    first_frame_ = 0;
    return false;
  }

  // Whether the packet is that of the models.
  bool matches(const model::PacketView& packet) {
    const std::uint64_t time_stamp = packet.header.time_stamp;
    const std::uint64_t phase = time_stamp % frame_clocks_;
    if (time_stamp != time_stamp_ || !expected_.settings_of(packet.header)) {
      time_stamp_ = time_stamp;
      expect(packet.header);
    }
    first_time_stamp_ = first_time_stamp_.value_or(time_stamp);
    if (phase != phase_.value_or(phase) || !expected_.has(packet, time_stamp == *first_time_stamp_)) {
      return false;
    }
    phase_ = phase;
    return true;
  }

 private:
  static constexpr std::uint32_t kBrightnesses = 64;  // after so many frames the line is as bright again

  void expect(const model::PacketHeader& header) {
    const auto frame = static_cast<std::uint32_t>(header.time_stamp / frame_clocks_ + first_frame_);
    expected_.expect(model::test_camera_frame(columns_, rows_, frame), columns_, rows_, header);
  }

  int columns_;
  int rows_;
  std::uint64_t frame_clocks_;
  std::uint32_t first_frame_ = 0;  // of the time stamps below frame_clocks_
  std::optional<std::uint64_t> first_time_stamp_;
  std::uint64_t time_stamp_ = UINT64_MAX;
  std::optional<std::uint64_t> phase_;  // of the time stamps, the same in all packets
  FramePackets expected_;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_CONSTRAINTS_COMMON_SCOREBOARD_H
