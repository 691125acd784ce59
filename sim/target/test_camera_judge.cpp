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
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/io/input_file.h"
#include "model/packet.h"
#include "sim/target/camera_judge.h"

namespace selfproj {
namespace {

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
  CameraJudge judge(columns, rows, frame_clocks);
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
