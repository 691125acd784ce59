// The Verilated board beside the model of the board: every beat goes into both, every packet that comes out must equal,
// byte by byte, the one the model gives, with the exact number of packets lost before it in its header.
#ifndef SELFPROJ_TESTS_RTL_BOARD_SCOREBOARD_H
#define SELFPROJ_TESTS_RTL_BOARD_SCOREBOARD_H

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "model/board.h"
#include "model/packet.h"
#include "sim/board/board_device.h"

namespace selfproj::test {

// Beats of a packet with so many bytes of payload.
inline std::size_t packet_beats(std::size_t payload_bytes) {
  return (spec::kHeaderBytes + spec::kTrailerBytes + payload_bytes) / spec::kPacketBeatBytes;
}

// What the board's counters have counted before a run.
struct BoardCounts {
  std::uint64_t clocks = 0;
  std::uint64_t frames = 0;
  std::uint32_t broken = 0;
  std::uint32_t stray = 0;
  std::uint32_t abandoned = 0;
  std::map<std::uint8_t, std::uint32_t> lost;  // of each kind
};

template <class Model>
class Scoreboard {
 public:
  // `median_built`: see BoardModel; of no concern in a build without codes.
  explicit Scoreboard(const BoardDeviceOptions& options = {}, bool median_built = true)
      : device_(options),
        median_built_(median_built),
        model_([this](BoardPacket&& packet) { expect(std::move(packet)); }, median_built) {
    device_.on_packet([this](std::span<const std::uint8_t> bytes) { receive(bytes); });
    device_.on_clock([this](std::uint64_t clock) { before_clock(clock); });
    device_.on_beat([this](std::uint64_t clock, const VideoBeat& beat) {
      model_.beat({.clock = clock, .encoder = encoder_, .pattern = pattern_}, beat);
      if (beat.start && on_frame_) {
        pattern_ = pattern_ == last_pattern_ ? 0 : static_cast<std::uint16_t>(pattern_ + 1);
      }
    });
  }

  BoardDevice<Model>& device() { return device_; }
  BoardModel& model() { return model_; }

  // Settings for the next frame start. Only where no frame can start during the register accesses.
  void write(const BoardSettings& settings) {
    device_.write(settings);
    model_.write(settings);
  }

  // The board's counters stand so much higher than the model's. Before the first frame.
  void counted_before(BoardCounts counts) { before_ = std::move(counts); }
  [[nodiscard]] const BoardCounts& counted_before() const { return before_; }

  // Both forget everything, in the middle of whatever they were doing.
  void reset() {
    before_ = {};
    device_.reset();
    model_ = BoardModel([this](BoardPacket&& packet) { expect(std::move(packet)); }, median_built_);
    streams_.clear();
    on_frame_ = false;
    pattern_ = 0;
    encoder_ = 0;
  }

  // Runs until all beats that wait are in.
  void play() {
    while (device_.queued() != 0) {
      device_.run(1);
    }
  }

  // The pattern index advances with every frame.
  void count_patterns_on_frames(int last_pattern) {
    on_frame_ = true;
    last_pattern_ = static_cast<std::uint16_t>(last_pattern);
    device_.write(spec::kRegTriggerControl,
                  1U << spec::kRegTriggerControlOnFrameLsb | static_cast<std::uint32_t>(last_pattern)
                                                                 << spec::kRegTriggerControlLastPatternLsb);
  }

  // The encoder turns one step every so many clocks (at least 4), in changing directions, first forward or back; 0
  // stops it.
  void turn_encoder(int clocks_a_step, bool back = false) {
    encoder_period_ = clocks_a_step;
    encoder_back_ = back;
  }

  // All that was sent is out; what has not come was lost, and the counters of the board say so.
  void finish() {
    turn_encoder(0);
    device_.drain();
    for (auto& [kind, stream] : streams_) {
      stream.lost += static_cast<std::uint32_t>(stream.expected.size());
      stream.expected.clear();
    }
    EXPECT_EQ(device_.read(spec::kRegLostMoments), lost_in_all(spec::kKindMoments));
    EXPECT_EQ(device_.read(spec::kRegLostImage), lost_in_all(spec::kKindImage));
    if ((device_.read(spec::kRegCapability) >> spec::kRegCapabilityCodesLsb & 1U) != 0) {
      EXPECT_EQ(device_.read(spec::kRegLostCodes), lost_in_all(spec::kKindCodes));
      EXPECT_EQ(device_.read(spec::kRegAbandoned), before_.abandoned + static_cast<std::uint32_t>(model_.abandoned()));
    }
    EXPECT_EQ(device_.read(spec::kRegFrames), static_cast<std::uint32_t>(before_.frames + model_.frames()));
    EXPECT_EQ(device_.read(spec::kRegBroken), before_.broken + static_cast<std::uint32_t>(model_.broken()));
    EXPECT_EQ(device_.read(spec::kRegStray), before_.stray + static_cast<std::uint32_t>(model_.stray()));
    EXPECT_EQ(device_.read(spec::kRegEncoder), encoder_);
    EXPECT_EQ(device_.read(spec::kRegEncoderErrors), 0U);
  }

  [[nodiscard]] std::uint64_t delivered(std::uint8_t kind) { return streams_[kind].delivered; }
  [[nodiscard]] std::uint64_t lost(std::uint8_t kind) { return streams_[kind].lost; }
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }
  // Header and status of the last packet of the kind that came out.
  [[nodiscard]] const PacketHeader& last_header(std::uint8_t kind) { return streams_[kind].last_header; }
  [[nodiscard]] std::uint32_t last_status(std::uint8_t kind) { return streams_[kind].last_status; }
  [[nodiscard]] const std::map<std::uint32_t, std::uint64_t>& by_status() const { return by_status_; }

 private:
  struct Stream {
    std::deque<BoardPacket> expected;
    std::uint32_t lost = 0;
    std::uint64_t delivered = 0;
    PacketHeader last_header;
    std::uint32_t last_status = 0;
  };

  void expect(BoardPacket&& packet) {
    packet.header.sequence += before_.frames;
    packet.header.time_stamp += before_.clocks;
    streams_[packet.header.kind].expected.push_back(std::move(packet));
  }

  // As the board counts it: with what was lost before the run.
  [[nodiscard]] std::uint32_t lost_in_all(std::uint8_t kind) { return before_.lost[kind] + streams_[kind].lost; }

  void before_clock(std::uint64_t clock) {
    if (clock != 0) {
      model_.idle(clock - 1);
    }
    // The levels of the first clocks after a reset are taken over without counting.
    if (encoder_period_ == 0 || clock < 16 || clock % static_cast<std::uint64_t>(encoder_period_) != 0) {
      return;
    }
    // 100 steps in one direction, 37 in the other.
    const bool forward = (encoder_steps_++ % 137 < 100) != encoder_back_;
    encoder_phase_ = (encoder_phase_ + (forward ? 1U : 3U)) % 4U;
    encoder_ += forward ? 1U : ~0U;
    constexpr std::array<std::pair<bool, bool>, 4> kLines = {
        {{false, false}, {true, false}, {true, true}, {false, true}}};
    device_.set_encoder(kLines[encoder_phase_].first, kLines[encoder_phase_].second);
  }

  void receive(std::span<const std::uint8_t> bytes) {
    PacketView view;
    const PacketError error = parse_packet(bytes, view);
    ASSERT_EQ(error, PacketError::none) << to_string(error) << ", " << bytes.size() << " bytes";
    ASSERT_EQ(view.size, bytes.size());
    Stream& stream = streams_[view.header.kind];
    const auto same = [&](const BoardPacket& p) {
      return p.header.sequence == view.header.sequence && p.header.first_line == view.header.first_line;
    };
    while (!stream.expected.empty() && !same(stream.expected.front())) {
      ++stream.lost;
      stream.expected.pop_front();
    }
    ASSERT_FALSE(stream.expected.empty()) << "packet of frame " << view.header.sequence << ", line "
                                          << view.header.first_line << " was not to be expected";
    BoardPacket packet = std::move(stream.expected.front());
    stream.expected.pop_front();
    packet.header.lost = lost_in_all(view.header.kind);
    want_.clear();
    append_packet(packet.header, packet.payload, packet.status, want_);
    if (!std::equal(want_.begin(), want_.end(), bytes.begin(), bytes.end())) {
      const auto at = std::mismatch(want_.begin(), want_.end(), bytes.begin(), bytes.end()).second - bytes.begin();
      FAIL() << "frame " << view.header.sequence << " (" << view.header.columns << " x " << view.header.rows
             << ", mode " << int{view.header.mode} << "), kind " << int{view.header.kind} << ", status " << view.status
             << " expected " << packet.status << ", size " << bytes.size() << " expected " << want_.size()
             << ": first difference at byte " << at << "; lost " << view.header.lost << " expected "
             << packet.header.lost;
    }
    ++stream.delivered;
    stream.last_header = view.header;
    stream.last_status = view.status;
    ++by_status_[view.status];
    bytes_ += bytes.size();
  }

  BoardDevice<Model> device_;
  bool median_built_;
  BoardModel model_;
  std::map<std::uint8_t, Stream> streams_;
  std::map<std::uint32_t, std::uint64_t> by_status_;
  std::vector<std::uint8_t> want_;
  std::uint64_t bytes_ = 0;

  bool on_frame_ = false;
  std::uint16_t pattern_ = 0;
  std::uint16_t last_pattern_ = 0;
  BoardCounts before_;
  int encoder_period_ = 0;
  bool encoder_back_ = false;
  std::uint64_t encoder_steps_ = 0;
  unsigned encoder_phase_ = 0;
  std::uint32_t encoder_ = 0;
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BOARD_SCOREBOARD_H
