// Compares recorded packets of a board that looks at the test camera with the models, byte by byte.
//
//     test_camera_judge FILE COLUMNSxROWS FRAME_CLOCKS
//
// Which frame a packet is of follows from its time stamp. The settings are those of its header. Prints JSON. Exit
// status 1 if a packet differs, or if there is none.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/io/input_file.h"
#include "model/board.h"
#include "model/packet.h"
#include "model/test_camera.h"

namespace selfproj {
namespace {

class Judge {
 public:
  Judge(int columns, int rows, std::uint64_t frame_clocks)
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

int run(const std::vector<std::string>& words) {
  int columns = 0;
  int rows = 0;
  unsigned long long frame_clocks = 0;
  if (words.size() != 3 || std::sscanf(words[1].c_str(), "%dx%d", &columns, &rows) != 2 ||
      std::sscanf(words[2].c_str(), "%llu", &frame_clocks) != 1 || frame_clocks == 0) {
    throw std::runtime_error("usage: test_camera_judge FILE COLUMNSxROWS FRAME_CLOCKS");
  }
  const std::string text = read_input(words[0], std::size_t{1} << 32U);
  const std::span<const std::uint8_t> bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  Judge judge(columns, rows, frame_clocks);
  std::uint64_t packets = 0;
  std::uint64_t equal = 0;
  PacketView packet;
  std::size_t at = 0;
  while (at < bytes.size() && parse_packet(bytes.subspan(at), packet) == PacketError::none) {
    at += packet.size;
    ++packets;
    equal += judge.judge(packet) ? 1 : 0;
  }
  std::printf("{\"packets\": %llu, \"equal\": %llu}\n", static_cast<unsigned long long>(packets),
              static_cast<unsigned long long>(equal));
  return packets != 0 && equal == packets && at == bytes.size() ? 0 : 1;
}

}  // namespace
}  // namespace selfproj

int main(int argc, char** argv) {
  try {
    return selfproj::run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "test_camera_judge: %s\n", error.what());
    return 2;
  }
}
