// What the models say of a frame: the packets that a board sends of it, with the settings of a packet that came.
#ifndef SELFPROJ_SIM_TARGET_FRAME_PACKETS_H
#define SELFPROJ_SIM_TARGET_FRAME_PACKETS_H

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "model/board.h"
#include "model/packet.h"

namespace selfproj {

class FramePackets {
 public:
  // Of `pixels`, rows · columns of them, with the mode, threshold and stream of `header`.
  void expect(std::span<const std::uint8_t> pixels, int columns, int rows, const PacketHeader& header) {
    expected_.clear();
    mode_ = header.mode;
    threshold_ = header.threshold;
    BoardModel model([this](BoardPacket&& packet) {
      const std::pair place(packet.header.kind, packet.header.first_line);
      expected_.insert_or_assign(place, std::move(packet));
    });
    model.write({.image = true,
                 .columns = columns,
                 .rows = rows,
                 .mode = static_cast<Mode>(header.mode),
                 .threshold = header.threshold,
                 .stream = header.stream});
    const auto line = static_cast<std::size_t>(columns);
    for (std::size_t at = 0; at < pixels.size(); at += spec::kPixelsPerBeat) {
      VideoBeat beat{.start = at == 0, .line_end = (at + spec::kPixelsPerBeat) % line == 0};
      std::memcpy(beat.pixels.data(), pixels.data() + at, beat.pixels.size());
      model.beat({.clock = 1000 + at}, beat);
    }
  }

  // Whether what is expected is of the settings of this packet.
  [[nodiscard]] bool settings_of(const PacketHeader& header) const {
    const bool moments = header.kind == spec::kKindMoments;
    return !moments || (header.mode == mode_ && header.threshold == threshold_);
  }

  // Whether the packet is one of them, byte by byte. What the models do not know is taken from the packet: which frame
  // of the board it is, when it was, and what was lost before it. `may_stray`: a board that is started within a frame
  // gets the rest of it as stray beats before its first frame.
  [[nodiscard]] bool has(const PacketView& packet, bool may_stray) const {
    const auto due = expected_.find({packet.header.kind, packet.header.first_line});
    if (due == expected_.end()) {
      return false;
    }
    PacketHeader header = due->second.header;
    header.sequence = packet.header.sequence;
    header.time_stamp = packet.header.time_stamp;
    header.lost = packet.header.lost;
    if (may_stray) {
      header.flags |= packet.header.flags & spec::kFlagStrayBefore;
    }
    std::vector<std::uint8_t> bytes;
    append_packet(header, due->second.payload, due->second.status, bytes);
    return bytes.size() == packet.size && std::memcmp(bytes.data(), packet.bytes().data(), bytes.size()) == 0;
  }

 private:
  std::uint8_t mode_ = 0;
  std::uint8_t threshold_ = 0;
  std::map<std::pair<std::uint8_t, std::uint16_t>, BoardPacket> expected_;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_TARGET_FRAME_PACKETS_H
