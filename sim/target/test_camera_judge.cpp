// Compares recorded packets of a board that looks at the test camera with the models, byte by byte.
//
//     test_camera_judge FILE COLUMNSxROWS FRAME_CLOCKS
//     test_camera_judge FILE COLUMNSxROWS triggered=FRAME_CLOCKS
//     test_camera_judge FILE COLUMNSxROWS codes=BITS
//
// Which frame a packet is of follows from its time stamp. The settings are those of its header. In the second form
// triggers made the frames, and the board may have missed the first of them. The moments in the first moments packet
// then show which frame it is of; if raw images are compared, these must be grey moments. In the third form the test
// camera showed the patterns of a code of BITS bits in turn, beginning with the frame of the first packet, and the
// board decoded them. Which frame a packet is of then follows from its sequence number. Prints JSON. Exit status 1 if a
// packet differs, or if there is none.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/files/input_file.h"
#include "model/packet.h"
#include "sim/target/camera_judge.h"
#include "sim/target/frame_packets.h"

namespace selfproj {
namespace {

// Patterns in turn, from the first packet's frame on.
class CodesJudge {
 public:
  CodesJudge(int columns, int rows, int bits)
      : columns_(columns),
        rows_(rows),
        bits_(bits),
        model_([this](BoardPacket&& packet) { expected_.expect(std::move(packet)); }) {
    settings_.columns = columns;
    settings_.rows = rows;
    settings_.threshold = kThreshold;
    settings_.codes = true;
    settings_.code_bits = bits;
  }

  // Returns whether the packet is that of the models. Packets come in the order of their frames.
  bool judge(const PacketView& packet) {
    const PacketHeader& header = packet.header;
    if (!begun_) {
      begun_ = true;
      first_ = frames_ = header.sequence;
    }
    if (header.sequence < frames_ && header.sequence + 1 != frames_) {
      return false;
    }
    for (; frames_ <= header.sequence; ++frames_) {
      settings_.stream = header.stream;
      model_.write(settings_);
      expected_.clear();
      const auto pattern = static_cast<int>((frames_ - first_) % static_cast<std::uint64_t>(2 * bits_));
      show_frame(model_, test_camera_pattern(columns_, rows_, bits_, pattern), columns_,
                 {.clock = (frames_ + 1) * kFrameClocks, .pattern = static_cast<std::uint16_t>(pattern)});
    }
    return expected_.has(packet, header.sequence == first_);
  }

 private:
  static constexpr int kThreshold = 100;  // of the moments
  static constexpr std::uint64_t kFrameClocks = 125'000;

  int columns_;
  int rows_;
  int bits_;
  BoardSettings settings_;
  FramePackets expected_;
  BoardModel model_;
  bool begun_ = false;
  std::uint64_t first_ = 0;   // frame of the first packet, which has pattern 0
  std::uint64_t frames_ = 0;  // the next one
};

struct Form {
  int columns = 0;
  int rows = 0;
  int bits = 0;                         // 0 where no codes were decoded
  unsigned long long frame_clocks = 0;  // 0 where they were
  bool triggered = false;
};

Form read_form(const std::vector<std::string>& words) {
  Form form;
  const bool sized = words.size() == 3 && std::sscanf(words[1].c_str(), "%dx%d", &form.columns, &form.rows) == 2;
  const char* const what = sized ? words[2].c_str() : "";
  form.triggered = std::sscanf(what, "triggered=%llu", &form.frame_clocks) == 1;
  const bool codes = std::sscanf(what, "codes=%d", &form.bits) == 1 && form.bits > 0;
  const bool free = !form.triggered && !codes && std::sscanf(what, "%llu", &form.frame_clocks) == 1;
  if (!codes && (!(form.triggered || free) || form.frame_clocks == 0)) {
    throw std::runtime_error(
        "usage: test_camera_judge FILE COLUMNSxROWS FRAME_CLOCKS|triggered=FRAME_CLOCKS|codes=BITS");
  }
  return form;
}

// Reads the packet at bytes[at], and moves `at` behind it. Returns false if there is none.
bool next_packet(std::span<const std::uint8_t> bytes, std::size_t& at, PacketView& packet) {
  const bool there = at < bytes.size() && parse_packet(bytes.subspan(at), packet) == PacketError::none;
  at += there ? packet.size : 0;
  return there;
}

void find_first_frame(std::span<const std::uint8_t> bytes, CameraJudge& judge) {
  PacketView packet;
  for (std::size_t at = 0; next_packet(bytes, at, packet);) {
    if (packet.header.kind == spec::kKindMoments) {
      static_cast<void>(judge.find_frame(packet));  // otherwise no packet will be equal
      return;
    }
  }
}

int run(const std::vector<std::string>& words) {
  const Form form = read_form(words);
  const std::string text = read_input(words[0], std::size_t{1} << 32U);
  const std::span<const std::uint8_t> bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  CameraJudge judge(form.columns, form.rows, std::max(form.frame_clocks, 1ULL));
  CodesJudge codes(form.columns, form.rows, std::max(form.bits, 1));
  if (form.triggered) {
    find_first_frame(bytes, judge);
  }
  std::uint64_t packets = 0;
  std::uint64_t equal = 0;
  PacketView packet;
  std::size_t at = 0;
  while (next_packet(bytes, at, packet)) {
    ++packets;
    equal += (form.bits != 0 ? codes.judge(packet) : judge.judge(packet)) ? 1 : 0;
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
