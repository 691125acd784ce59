// Compares recorded packets of a board to which images were replayed with the models, byte by byte.
//
//     replay_judge FILE IMAGE...
//
// The board's frame number k, from 0, must be image number k. The settings are those of a packet's header. Prints JSON.
// Exit status 1 if a packet differs, or if there is none.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/files/input_file.h"
#include "host/images/image_files.h"
#include "model/packet.h"
#include "sim/target/frame_packets.h"

namespace selfproj {
namespace {

int run(const std::vector<std::string>& words) {
  if (words.size() < 2) {
    throw std::runtime_error("usage: replay_judge FILE IMAGE...");
  }
  const std::vector<std::string> images = image_arguments({words.begin() + 1, words.end()});
  const std::string text = read_input(words[0], std::size_t{1} << 32U);
  const std::span<const std::uint8_t> bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  FramePackets expected;
  std::optional<std::uint64_t> frame;
  std::uint64_t packets = 0;
  std::uint64_t equal = 0;
  PacketView packet;
  std::size_t at = 0;
  while (at < bytes.size() && parse_packet(bytes.subspan(at), packet) == PacketError::none) {
    at += packet.size;
    ++packets;
    const std::uint64_t number = packet.header.sequence;
    if (number >= images.size()) {
      continue;
    }
    if (frame != number || !expected.settings_of(packet.header)) {
      frame = number;
      const Image image = read_image(images[number], std::nullopt);
      expected.expect(image.pixels, image.columns, image.rows, packet.header);
    }
    equal += expected.has(packet, number == 0) ? 1 : 0;
  }
  std::printf("{\"images\": %zu, \"packets\": %llu, \"equal\": %llu}\n", images.size(),
              static_cast<unsigned long long>(packets), static_cast<unsigned long long>(equal));
  return packets != 0 && equal == packets && at == bytes.size() ? 0 : 1;
}

}  // namespace
}  // namespace selfproj

int main(int argc, char** argv) {
  try {
    return selfproj::run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "replay_judge: %s\n", error.what());
    return 2;
  }
}
