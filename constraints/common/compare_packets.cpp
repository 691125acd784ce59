// Compares recorded packets of a board with the models, byte by byte.
//
//     compare_packets FILE COLUMNSxROWS FRAME_CLOCKS
//     compare_packets FILE COLUMNSxROWS triggered=FRAME_CLOCKS
//     compare_packets FILE COLUMNSxROWS codes=BITS
//     compare_packets FILE replay IMAGE...
//
// In the first three forms the board looked at the test camera. Which frame a packet is of follows from its time stamp.
// The settings are those of its header. In the second form triggers made the frames, and the board may have missed the
// first of them. The moments in the first moments packet then show which frame it is of; if raw images are compared,
// these must be grey moments, exact or compact. In the third form the test camera showed the patterns of a code of BITS
// bits in turn, beginning with the frame of the first packet, and the board decoded them. Which frame a packet is of
// then follows from its sequence number. In the last form images were replayed to the board: its frame number k, from
// 0, must be image number k. Prints JSON. Exit status 1 if a packet differs, or if there is none.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "constraints/common/scoreboard.h"
#include "host/files/input_file.h"
#include "host/images/image_files.h"
#include "selfproj/model/packet.h"

namespace selfproj::sim {
namespace {

using Bytes = std::span<const std::uint8_t>;
using Matches = std::function<bool(const model::PacketView&)>;

// Patterns in turn, from the first packet's frame on.
class CodesScoreboard {
 public:
  CodesScoreboard(int columns, int rows, int bits)
      : columns_(columns),
        rows_(rows),
        bits_(bits),
        model_([this](model::BoardPacket&& packet) { expected_.expect(std::move(packet)); }) {
    settings_.columns = columns;
    settings_.rows = rows;
    settings_.threshold = kThreshold;
    settings_.codes = true;
    settings_.code_bits = bits;
  }

  // Whether the packet is that of the models. Packets come in the order of their frames.
  bool matches(const model::PacketView& packet) {
    const model::PacketHeader& header = packet.header;
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
      show_frame(model_, model::test_camera_pattern(columns_, rows_, bits_, pattern), columns_,
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
  model::BoardSettings settings_;
  FramePackets expected_;
  model::BoardModel model_;
  bool begun_ = false;
  std::uint64_t first_ = 0;   // frame of the first packet, which has pattern 0
  std::uint64_t frames_ = 0;  // the next one
};

class ReplayScoreboard {
 public:
  explicit ReplayScoreboard(std::vector<std::string> images) : images_(std::move(images)) {}

  // Whether the packet is that of the models.
  bool matches(const model::PacketView& packet) {
    const std::uint64_t number = packet.header.sequence;
    if (number >= images_.size()) {
      return false;
    }
    if (frame_ != number || !expected_.settings_of(packet.header)) {
      frame_ = number;
      const images::Image image = images::read_image(images_[number], std::nullopt);
      expected_.expect(image.pixels, image.columns, image.rows, packet.header);
    }
    return expected_.has(packet, number == 0);
  }

 private:
  std::vector<std::string> images_;
  std::optional<std::uint64_t> frame_;
  FramePackets expected_;
};

// Reads the packet at bytes[at], and moves `at` behind it. Returns false if there is none.
bool next_packet(Bytes bytes, std::size_t& at, model::PacketView& packet) {
  const bool there = at < bytes.size() && model::parse_packet(bytes.subspan(at), packet) == model::PacketError::none;
  at += there ? packet.size : 0;
  return there;
}

void find_first_frame(Bytes bytes, CameraScoreboard& scoreboard) {
  model::PacketView packet;
  for (std::size_t at = 0; next_packet(bytes, at, packet);) {
    if (model::has_columns(packet.header.kind)) {
      static_cast<void>(scoreboard.find_frame(packet));  // otherwise no packet will be equal
      return;
    }
  }
}

template <class Scoreboard>
Matches matches_of(std::shared_ptr<Scoreboard> scoreboard) {
  return [scoreboard = std::move(scoreboard)](const model::PacketView& packet) { return scoreboard->matches(packet); };
}

// The comparison that the words behind FILE name.
Matches matches_of(const std::vector<std::string>& words, Bytes bytes) {
  int columns = 0;
  int rows = 0;
  int bits = 0;
  unsigned long long frame_clocks = 0;
  if (words.size() == 2 && std::sscanf(words[0].c_str(), "%dx%d", &columns, &rows) == 2) {
    const char* const what = words[1].c_str();
    if (std::sscanf(what, "codes=%d", &bits) == 1 && bits > 0) {
      return matches_of(std::make_shared<CodesScoreboard>(columns, rows, bits));
    }
    const bool triggered = std::sscanf(what, "triggered=%llu", &frame_clocks) == 1;
    if ((triggered || std::sscanf(what, "%llu", &frame_clocks) == 1) && frame_clocks > 0) {
      auto scoreboard = std::make_shared<CameraScoreboard>(columns, rows, frame_clocks);
      if (triggered) {
        find_first_frame(bytes, *scoreboard);
      }
      return matches_of(std::move(scoreboard));
    }
  }
  throw std::runtime_error(
      "usage: compare_packets FILE COLUMNSxROWS FRAME_CLOCKS|triggered=FRAME_CLOCKS|codes=BITS, or FILE replay "
      "IMAGE...");
}

int run(const std::vector<std::string>& words) {
  const bool replay = words.size() > 2 && words[1] == "replay";
  std::vector<std::string> images;
  std::string counts = "{";
  if (replay) {
    images = images::image_arguments({words.begin() + 2, words.end()});
    counts += "\"images\": " + std::to_string(images.size()) + ", ";
  }
  const std::string text = words.empty() ? "" : files::read_input(words[0], std::size_t{1} << 32U);
  const Bytes bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  const Matches matches = replay ? matches_of(std::make_shared<ReplayScoreboard>(std::move(images)))
                                 : matches_of({words.begin() + (words.empty() ? 0 : 1), words.end()}, bytes);
  std::uint64_t packets = 0;
  std::uint64_t equal = 0;
  model::PacketView packet;
  std::size_t at = 0;
  while (next_packet(bytes, at, packet)) {
    ++packets;
    equal += matches(packet) ? 1 : 0;
  }
  std::printf("%s\"packets\": %llu, \"equal\": %llu}\n", counts.c_str(), static_cast<unsigned long long>(packets),
              static_cast<unsigned long long>(equal));
  return packets != 0 && equal == packets && at == bytes.size() ? 0 : 1;
}

}  // namespace
}  // namespace selfproj::sim

int main(int argc, char** argv) {
  try {
    return selfproj::sim::run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "compare_packets: %s\n", error.what());
    return 2;
  }
}
