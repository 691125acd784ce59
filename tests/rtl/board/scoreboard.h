// The Verilated board beside its model. Every beat goes into both. Every packet of the board must equal the model's
// byte by byte, with the exact number of packets lost before it in its header.
#ifndef SELFPROJ_TESTS_RTL_BOARD_SCOREBOARD_H
#define SELFPROJ_TESTS_RTL_BOARD_SCOREBOARD_H

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "selfproj/model/board.h"
#include "selfproj/model/packet.h"
#include "sim/board/board_device.h"
#include "sim/board/packet_scoreboard.h"
#include "tests/rtl/board/frames.h"

namespace selfproj::test {

// The beats of a packet with this many bytes of payload.
inline std::size_t packet_beats(std::size_t payload_bytes) {
  return model::packet_bytes(payload_bytes) / spec::kPacketBeatBytes;
}

// The values of the board's counters before a run.
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
  // `median_built` and `tall`: see BoardModel; the former is ignored in a build without codes.
  explicit Scoreboard(const sim::BoardDeviceOptions& options = {}, bool median_built = true, bool tall = false)
      : device_(options),
        median_built_(median_built),
        pixel_bits_(options.pixel_bits),
        lanes_(options.lanes),
        tall_(tall),
        model_([this](model::BoardPacket&& packet) { expect(std::move(packet)); }, median_built, pixel_bits_, lanes_,
               tall) {
    device_.on_packet([this](std::span<const std::uint8_t> bytes) { receive(bytes); });
    device_.on_clock([this](std::uint64_t clock) { before_clock(clock); });
    device_.on_beat([this](std::uint64_t clock, const model::VideoBeat& beat) {
      model_.beat({.clock = clock, .encoder = encoder_, .pattern = pattern_}, beat);
      if (beat.start && on_frame_) {
        pattern_ = pattern_ == last_pattern_ ? 0 : static_cast<std::uint16_t>(pattern_ + 1);
      }
    });
  }

  sim::BoardDevice<Model>& device() { return device_; }
  model::BoardModel& model() { return model_; }

  // Writes settings for the next frame start. No frame may start during the register accesses.
  void write(const model::BoardSettings& settings) {
    device_.write(settings);
    model_.write(settings);
  }

  // Presets the board's counters this much above the model's. Call before the first frame.
  void counted_before(BoardCounts counts) {
    before_ = std::move(counts);
    for (const auto& [kind, count] : before_.lost) {
      scoreboard_.lost_before(kind, count);
    }
  }
  [[nodiscard]] const BoardCounts& counted_before() const { return before_; }

  // Resets both at any time.
  void reset() {
    before_ = {};
    device_.reset();
    model_ = model::BoardModel([this](model::BoardPacket&& packet) { expect(std::move(packet)); }, median_built_,
                               pixel_bits_, lanes_, tall_);
    scoreboard_ = {};
    on_frame_ = false;
    pattern_ = 0;
    encoder_ = 0;
  }

  // Sends the image, in this share of calls with a fault; with faults, there may be pauses anywhere.
  void send(Random& random, const TestImage& image, int fault_percent) {
    std::vector<model::VideoBeat> beats = beats_with_faults(random, image, fault_percent, lanes_);
    if (pixel_bits_ > spec::kPixelBits) {
      append_bits(random, pixel_bits_ - spec::kPixelBits, beats);
    }
    for (const model::VideoBeat& beat : beats) {
      device_.send(beat);
      if (fault_percent != 0 && random.chance(1)) {
        device_.gap(static_cast<std::uint32_t>(random.between(1, 250)));
      }
    }
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

  // The encoder turns one step every `clocks_a_step` clocks (at least 4), in changing directions, first forward or
  // back; 0 stops it.
  void turn_encoder(int clocks_a_step, bool back = false) {
    encoder_period_ = clocks_a_step;
    encoder_back_ = back;
  }

  // Runs until everything is out. Packets that did not come were lost, and the counters of the board must say so.
  void finish() {
    turn_encoder(0);
    device_.drain(spec::kColumnLimit);  // longer than the words of a frame wait
    scoreboard_.finish();
    // A frame that is still open may be lost already.
    EXPECT_LE(device_.read(spec::kRegLostMoments) - scoreboard_.lost_in_all(spec::kKindMoments),
              model_.frame_open() ? 1U : 0U);
    EXPECT_EQ(device_.read(spec::kRegLostImage), scoreboard_.lost_in_all(spec::kKindImage));
    if ((device_.read(spec::kRegCapability) >> spec::kRegCapabilityCodesLsb & 1U) != 0) {
      EXPECT_EQ(device_.read(spec::kRegLostCodes), scoreboard_.lost_in_all(spec::kKindCodes));
      EXPECT_EQ(device_.read(spec::kRegAbandoned), before_.abandoned + static_cast<std::uint32_t>(model_.abandoned()));
    }
    EXPECT_EQ(device_.read(spec::kRegFrames), static_cast<std::uint32_t>(before_.frames + model_.frames()));
    EXPECT_EQ(device_.read(spec::kRegBroken), before_.broken + static_cast<std::uint32_t>(model_.broken()));
    EXPECT_EQ(device_.read(spec::kRegStray), before_.stray + static_cast<std::uint32_t>(model_.stray()));
    EXPECT_EQ(device_.read(spec::kRegEncoder), encoder_);
    EXPECT_EQ(device_.read(spec::kRegEncoderErrors), 0U);
  }

  [[nodiscard]] std::uint64_t delivered(std::uint8_t kind) const { return scoreboard_.of(kind).matched; }
  [[nodiscard]] std::uint64_t lost(std::uint8_t kind) const { return scoreboard_.of(kind).lost; }
  [[nodiscard]] std::uint64_t bytes() const { return scoreboard_.matched_bytes(); }
  // Header and status of the last packet of the kind that came out.
  [[nodiscard]] const model::PacketHeader& last_header(std::uint8_t kind) const {
    return scoreboard_.of(kind).last_header;
  }
  [[nodiscard]] std::uint32_t last_status(std::uint8_t kind) const { return scoreboard_.of(kind).last_status; }
  [[nodiscard]] const std::map<std::uint32_t, std::uint64_t>& by_status() const { return scoreboard_.by_status(); }

 private:
  void expect(model::BoardPacket&& packet) {
    packet.header.sequence += before_.frames;
    packet.header.time_stamp += before_.clocks;
    scoreboard_.expect(std::move(packet));
  }

  void before_clock(std::uint64_t clock) {
    if (clock != 0) {
      model_.idle(clock - 1);
    }
    // The encoder takes over the levels of the first clocks after a reset without counting.
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
    const std::uint64_t before = scoreboard_.mismatches();
    ASSERT_TRUE(scoreboard_.compare(bytes))
        << (before == 0 ? scoreboard_.first_mismatch() : "the next mismatch after the first");
  }

  sim::BoardDevice<Model> device_;
  bool median_built_;
  int pixel_bits_;
  int lanes_;
  bool tall_;
  model::BoardModel model_;
  sim::PacketScoreboard scoreboard_;

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
