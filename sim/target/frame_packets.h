// What the models say of a frame: the packets that a board sends of it, with the settings of a packet that came.
#ifndef SELFPROJ_SIM_TARGET_FRAME_PACKETS_H
#define SELFPROJ_SIM_TARGET_FRAME_PACKETS_H

#include <cstdint>
#include <map>
#include <span>
#include <utility>

#include "model/board.h"
#include "model/packet.h"

namespace selfproj {

// A frame of the camera through the models. Its first beat comes at inputs.clock.
void show_frame(BoardModel& model, std::span<const std::uint8_t> pixels, int columns, BoardInputs inputs);

class FramePackets {
 public:
  // Of `pixels`, rows · columns of them, with the mode, threshold and stream of `header`.
  void expect(std::span<const std::uint8_t> pixels, int columns, int rows, const PacketHeader& header);

  // A packet of another model of the board.
  void expect(BoardPacket&& packet);
  void clear() { expected_.clear(); }

  // Whether what is expected is of the settings of this packet.
  [[nodiscard]] bool settings_of(const PacketHeader& header) const {
    const bool moments = header.kind == spec::kKindMoments;
    return !moments || (header.mode == mode_ && header.threshold == threshold_);
  }

  // Whether the packet is one of them, byte by byte. What the models do not know is taken from the packet: which frame
  // of the board it is, when it was, and what was lost before it. `may_stray`: a board that is started within a frame
  // gets the rest of it as stray beats before its first frame.
  [[nodiscard]] bool has(const PacketView& packet, bool may_stray) const;

 private:
  std::uint8_t mode_ = 0;
  std::uint8_t threshold_ = 0;
  std::map<std::pair<std::uint8_t, std::uint16_t>, BoardPacket> expected_;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_TARGET_FRAME_PACKETS_H
