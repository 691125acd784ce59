// Replay: a board puts frames together from the datagrams of a host (docs/packet-reference.md), as rtl/camera does.
#ifndef SELFPROJ_MODEL_REPLAY_H
#define SELFPROJ_MODEL_REPLAY_H

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "model/datagram.h"

namespace selfproj::model {

struct ReplayHeader {
  std::uint16_t session = 0;
  std::uint32_t frame = 0;
  std::uint32_t offset = 0;
  std::uint16_t length = 0;
  std::uint16_t columns = 0;
  std::uint16_t rows = 0;

  bool operator==(const ReplayHeader&) const = default;
};

// The longest piece of a frame in datagrams of this many bytes: whole beats of four pixels.
constexpr std::size_t replay_piece(std::size_t datagram_bytes) {
  return (datagram_bytes - spec::kReplayHeaderBytes) / spec::kPixelsPerBeat * spec::kPixelsPerBeat;
}

// Writes spec::kReplayHeaderBytes bytes.
void write_replay_header(const ReplayHeader& header, std::uint8_t* bytes);

// Largest frame that a board replays; columns 0: none.
struct ReplaySize {
  int columns = 0;  // a multiple of 4
  int rows = 0;
};

// The registers of these names.
struct ReplayCounts {
  std::uint32_t frame = 0;
  std::uint32_t offset = 0;
  std::uint32_t frames = 0;
  std::uint32_t dropped = 0;
  std::uint32_t ignored = 0;

  bool operator==(const ReplayCounts&) const = default;
};

struct ReplayFrame {
  int columns = 0;
  int rows = 0;
  std::vector<std::uint8_t> pixels = {};

  bool operator==(const ReplayFrame&) const = default;
};

class ReplayModel {
 public:
  // `size`: of the build.
  explicit ReplayModel(const ReplaySize& size) : size_(size) {}

  // The register replay_session is written: frame 0 is due.
  void begin(std::uint16_t session);

  // Replay is not the source, or no host has the session: what has come of a frame is forgotten.
  void forget() { pixels_.clear(); }

  // A datagram that came to the port of replay.
  struct Datagram {
    std::span<const std::uint8_t> came;  // whole words; those behind `bytes` are filling
    std::size_t bytes = 0;               // of the datagram, as UDP says
    bool damaged = false;
    bool may_send = true;  // it is from the host that has the session, and replay is the source
  };

  // Returns the frame that it makes whole. This leaves as video, and until left() nothing else is taken.
  std::optional<ReplayFrame> datagram(const Datagram& datagram);

  // The frame has left.
  void left();

  [[nodiscard]] bool leaving() const { return leaving_; }
  [[nodiscard]] ReplayCounts counts() const;

 private:
  [[nodiscard]] bool fits(const ReplayHeader& header) const;

  ReplaySize size_;
  std::uint16_t session_ = 0;
  std::uint32_t frame_ = 0;
  int columns_ = 0;  // of the frame of which a part has come
  int rows_ = 0;
  std::vector<std::uint8_t> pixels_;  // that part
  bool leaving_ = false;
  std::uint32_t frames_ = 0;
  std::uint32_t dropped_ = 0;
  std::uint32_t ignored_ = 0;
};

}  // namespace selfproj::model

#endif  // SELFPROJ_MODEL_REPLAY_H
