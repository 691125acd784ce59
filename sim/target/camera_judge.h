#ifndef SELFPROJ_SIM_TARGET_CAMERA_JUDGE_H
#define SELFPROJ_SIM_TARGET_CAMERA_JUDGE_H

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "model/board.h"
#include "model/packet.h"
#include "model/test_camera.h"

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
    const std::uint64_t phase = packet.header.time_stamp % frame_clocks_;
    if (packet.header.time_stamp != time_stamp_ || !settings_of(packet.header)) {
      expect_frame(packet.header);
    }
    const auto due = expected_.find({packet.header.kind, packet.header.first_line});
    if (due == expected_.end() || phase != phase_.value_or(phase)) {
      return false;
    }
    phase_ = phase;
    PacketHeader header = due->second.header;
    // What the models do not know: which frame of the board it is, when it was, and what was lost before it.
    header.sequence = packet.header.sequence;
    header.time_stamp = packet.header.time_stamp;
    header.lost = packet.header.lost;
    // A board that is started within a frame gets the rest of it as stray beats before its first frame.
    first_time_stamp_ = first_time_stamp_.value_or(header.time_stamp);
    if (header.time_stamp == *first_time_stamp_) {
      header.flags |= packet.header.flags & spec::kFlagStrayBefore;
    }
    std::vector<std::uint8_t> bytes;
    append_packet(header, due->second.payload, due->second.status, bytes);
    return bytes.size() == packet.size && std::memcmp(bytes.data(), packet.bytes().data(), bytes.size()) == 0;
  }

 private:
  // Whether what is expected is of these settings.
  bool settings_of(const PacketHeader& header) {
    const bool moments = header.kind == spec::kKindMoments;
    return !moments || (header.mode == mode_ && header.threshold == threshold_);
  }

  // All packets of the frame.
  void expect_frame(const PacketHeader& header) {
    expected_.clear();
    time_stamp_ = header.time_stamp;
    mode_ = header.mode;
    threshold_ = header.threshold;
    BoardModel model([this](BoardPacket&& packet) {
      const std::pair place(packet.header.kind, packet.header.first_line);
      expected_.insert_or_assign(place, std::move(packet));
    });
    model.write({.image = true,
                 .columns = columns_,
                 .rows = rows_,
                 .mode = static_cast<Mode>(header.mode),
                 .threshold = header.threshold,
                 .stream = header.stream});
    const std::vector<std::uint8_t> pixels =
        test_camera_frame(columns_, rows_, static_cast<std::uint32_t>(header.time_stamp / frame_clocks_));
    const std::size_t line = static_cast<std::size_t>(columns_);
    for (std::size_t at = 0; at < pixels.size(); at += spec::kPixelsPerBeat) {
      VideoBeat beat{.start = at == 0, .line_end = (at + spec::kPixelsPerBeat) % line == 0};
      std::memcpy(beat.pixels.data(), pixels.data() + at, beat.pixels.size());
      model.beat({.clock = 1000 + at}, beat);
    }
  }

  int columns_;
  int rows_;
  std::optional<std::uint64_t> first_time_stamp_;
  std::uint64_t frame_clocks_;
  std::uint64_t time_stamp_ = UINT64_MAX;
  std::uint8_t mode_ = 0;
  std::uint8_t threshold_ = 0;
  std::optional<std::uint64_t> phase_;  // of the time stamps, the same in all packets
  std::map<std::pair<std::uint8_t, std::uint16_t>, BoardPacket> expected_;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_TARGET_CAMERA_JUDGE_H
