// Compares recorded packets of a board that looks at the test camera with the models, byte by byte.
//
//     test_camera_judge FILE COLUMNSxROWS FRAME_CLOCKS
//
// Which frame a packet is of follows from its time stamp. The settings are those of its header. Prints JSON. Exit
// status 1 if a packet differs, or if there is none.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/io/input_file.h"
#include "model/packet.h"
#include "model/test_camera.h"
#include "sim/target/frame_packets.h"

namespace selfproj {
namespace {

class Judge {
 public:
  Judge(int columns, int rows, std::uint64_t frame_clocks)
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
