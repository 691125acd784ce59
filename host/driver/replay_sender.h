// Sends frames to a board on the network that replays them (docs/packet-reference.md), and chooses where its frames
// come from.
#ifndef SELFPROJ_HOST_DRIVER_REPLAY_SENDER_H
#define SELFPROJ_HOST_DRIVER_REPLAY_SENDER_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "host/driver/register_port.h"
#include "host/files/file_descriptor.h"
#include "model/datagram.h"
#include "model/replay.h"
#include "model/spec/generated/register_table.h"
#include "selfproj/model/column_moments.h"

namespace selfproj::driver {

struct SourceName {
  std::string_view name;  // as commands have it
  std::uint32_t value;    // of the register `source`
};

inline constexpr std::array<SourceName, 4> kSourceNames{{
    {"camera", spec::kSourceCamera},
    {"test-camera", spec::kSourceTestCamera},
    {"replay", spec::kSourceReplay},
    {"patterns", spec::kSourcePatterns},
}};

// Where the board's frames come from: the register `source`.
std::uint32_t video_source(RegisterPort& board);

// Throws UserError if the board has no such source.
void set_video_source(RegisterPort& board, std::uint32_t source);

struct ReplayOptions {
  std::uint16_t port = spec::kReplayPort;              // of the board
  std::size_t datagram_bytes = model::kDatagramBytes;  // longest datagram
  int tries = 30;  // times that datagrams are sent without any progress of the board; about two seconds
};

// For one thread at a time. Every error is a UserError that begins with the board's URI.
class ReplaySender {
 public:
  // Makes replay the source of the board at HOST, whose registers these are, and begins a session. Throws if the board
  // has no replay. The board takes frames only from the host that has started it.
  ReplaySender(RegisterPort& board, const std::string& host, const ReplayOptions& options = {});

  // The largest frame.
  [[nodiscard]] model::ReplaySize largest() const { return largest_; }

  // Sends a frame of this many columns, a multiple of 4, and rows without gaps, and repeats what is missing, until the
  // frame has left as video. Throws if the frame is too large, or if the board takes nothing.
  void send(const model::ImageView& frame);

  [[nodiscard]] std::uint64_t frames() const { return frames_; }        // that have left as video
  [[nodiscard]] std::uint64_t datagrams() const { return datagrams_; }  // sent
  [[nodiscard]] std::uint64_t repeated() const { return repeated_; }    // of them, those sent again

  // The source that the board had before takes its place again.
  void end();

 private:
  struct State {
    std::uint32_t frame = 0;
    std::uint32_t offset = 0;
    std::uint32_t frames = 0;

    bool operator==(const State&) const = default;
  };

  [[nodiscard]] State state();
  // Returns how many datagrams it were.
  std::uint64_t send_from(const model::ImageView& frame, std::size_t offset);

  RegisterPort& board_;
  ReplayOptions options_;
  model::ReplaySize largest_;
  files::FileDescriptor socket_;
  std::uint32_t source_before_ = 0;
  std::uint16_t session_ = 0;
  std::uint32_t number_ = 0;  // of the next frame
  std::vector<std::uint8_t> datagram_;
  std::uint64_t frames_ = 0;
  std::uint64_t datagrams_ = 0;
  std::uint64_t repeated_ = 0;
};

}  // namespace selfproj::driver

#endif  // SELFPROJ_HOST_DRIVER_REPLAY_SENDER_H
