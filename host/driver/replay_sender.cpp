#include "host/driver/replay_sender.h"

#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "host/driver/control.h"
#include "host/driver/udp_socket.h"
#include "selfproj/files/user_error.h"

namespace selfproj::driver {
namespace {

// Questions without progress that follow each other at once, and the pauses behind them, which double. A frame leaves
// the board within some milliseconds.
constexpr int kAtOnce = 4;
constexpr std::chrono::milliseconds kPause(1);
constexpr std::chrono::milliseconds kLongestPause(100);

// Older boards read registers that they have not as 0.
model::ReplaySize largest_of(RegisterPort& board) {
  const std::uint32_t video = board.word(spec::kLinkVideo);
  const model::ReplaySize largest{
      .columns = static_cast<int>(field_of(video, spec::kLinkVideoReplayColumnsLsb, spec::kLinkVideoReplayColumnsBits)),
      .rows = static_cast<int>(field_of(video, spec::kLinkVideoReplayRowsLsb, spec::kLinkVideoReplayRowsBits))};
  if (board.word(spec::kLinkId) != spec::kLinkIdReset || largest.columns == 0 || largest.rows == 0) {
    throw UserError(board.uri(), "this board has no replay");
  }
  return largest;
}

void write(RegisterPort& board, std::uint32_t address, std::uint32_t value, const std::string& what) {
  if (board.write(address, value) != Written::applied) {
    throw UserError(board.uri(), "the board refuses " + what);
  }
}

}  // namespace

std::uint32_t video_source(RegisterPort& board) { return board.word(spec::kLinkSource); }

void set_video_source(RegisterPort& board, std::uint32_t source) {
  // A board of before would take the address for one of its own registers.
  if (board.word(spec::kLinkId) != spec::kLinkIdReset || board.word(spec::kLinkVideo) == 0) {
    throw UserError(board.uri(), "the source of this board's frames cannot be chosen");
  }
  write(board, spec::kLinkSource, source, "this source of frames; it is built without it, or another host owns it");
  if (video_source(board) != source) {
    throw UserError(board.uri(), "the board keeps another source of frames");
  }
}

ReplaySender::ReplaySender(RegisterPort& board, const std::string& host, const ReplayOptions& options)
    : board_(board),
      options_(options),
      largest_(largest_of(board)),
      socket_(open_udp_socket(board.uri(), {.host = host, .port = options.port})),
      source_before_(video_source(board)),
      session_(static_cast<std::uint16_t>(board.word(spec::kLinkReplaySession) + 1 + std::random_device()() % 0x8000U)),
      datagram_(options.datagram_bytes) {
  set_video_source(board_, spec::kSourceReplay);
  write(board_, spec::kLinkReplaySession, session_, "a session of replay");
}

ReplaySender::State ReplaySender::state() {
  constexpr std::array kAddresses = {spec::kLinkReplayFrame, spec::kLinkReplayOffset, spec::kLinkReplayFrames};
  const std::vector<std::uint32_t> words = board_.read(kAddresses);
  return {.frame = words[0], .offset = words[1], .frames = words[2]};
}

std::uint64_t ReplaySender::send_from(const model::ImageView& frame, std::size_t offset) {
  const std::size_t all = static_cast<std::size_t>(frame.columns) * static_cast<std::size_t>(frame.rows);
  const std::size_t piece = model::replay_piece(options_.datagram_bytes);
  std::uint64_t sent = 0;
  for (std::size_t at = offset; at < all; at += piece, ++sent) {
    const std::size_t length = std::min(piece, all - at);
    model::write_replay_header({.session = session_,
                                .frame = number_,
                                .offset = static_cast<std::uint32_t>(at),
                                .length = static_cast<std::uint16_t>(length),
                                .columns = static_cast<std::uint16_t>(frame.columns),
                                .rows = static_cast<std::uint16_t>(frame.rows)},
                               datagram_.data());
    std::memcpy(datagram_.data() + spec::kReplayHeaderBytes, frame.pixels + at, length);
    // An error of the network is like a lost datagram.
    static_cast<void>(::send(socket_.number(), datagram_.data(), spec::kReplayHeaderBytes + length, 0));
  }
  datagrams_ += sent;
  return sent;
}

void ReplaySender::send(const model::ImageView& frame) {
  const std::string size = std::to_string(frame.columns) + " x " + std::to_string(frame.rows);
  if (frame.columns > largest_.columns || frame.rows > largest_.rows) {
    throw UserError(board_.uri(), "a frame of " + size + " pixels is too large to be replayed; the largest has " +
                                      std::to_string(largest_.columns) + " x " + std::to_string(largest_.rows));
  }
  if (frame.columns % spec::kPixelsPerBeat != 0 || frame.stride != frame.columns) {
    throw UserError(board_.uri(), "a frame of " + size + " pixels: its columns are no multiple of 4");
  }
  State last = state();
  const std::uint32_t left_before = last.frames;
  send_from(frame, 0);
  for (int idle = 0; idle < options_.tries; ++idle) {
    if (idle > kAtOnce) {
      std::this_thread::sleep_for(std::min(kPause * (1 << std::min(idle - kAtOnce, 10)), kLongestPause));
    }
    const State now = state();
    if (now.frames != left_before) {
      ++number_;
      ++frames_;
      return;
    }
    if (now != last) {
      idle = 0;
    }
    last = now;
    if (now.frame == number_) {
      repeated_ += send_from(frame, now.offset);
    }  // else it is whole, and about to leave
  }
  throw UserError(board_.uri(), "the board takes no frames from this host; has another host started it?");
}

void ReplaySender::end() { set_video_source(board_, source_before_); }

}  // namespace selfproj::driver
