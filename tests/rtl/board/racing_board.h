// The board while registers are written in the very clocks in which frames start, beside the model of the board.
//
// All of it follows from the clock r in which a write reaches the registers (sp_registers says when what happens):
// new values stand from clock r + 4 on, and a frame start in the clocks r + 3 to r + 5 takes no settings over, be the
// write accepted or refused. So it is known of each frame start which settings it must take, to the clock.
//
//     RacingBoard<Vboard_codes> board(seed);
//     board.write(spec::kRegSize, ...);          // the camera starts a frame somewhere around it
//     board.finish();                            // every packet was compared, every loss is counted
#ifndef SELFPROJ_TESTS_RTL_BOARD_RACING_BOARD_H
#define SELFPROJ_TESTS_RTL_BOARD_RACING_BOARD_H

#include <gtest/gtest.h>
#include <verilated.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "selfproj/model/board.h"
#include "sim/board/board_device.h"
#include "sim/board/packet_scoreboard.h"
#include "tests/rtl/board/frames.h"
#include "tests/rtl/inner_register.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

constexpr int kRaceBeats = 6;  // of a line: frames are small, so that they end soon after they started
constexpr int kRaceRows = 5;

// The pixels of a build with everything and 64 x 40 pixels.
struct RacePixels {
  int bits = spec::kPixelBits;  // or 12
  int lanes = spec::kPixelsPerBeat;
};

// The registers as they stand, of those that matter here.
struct RaceRegisters {
  RacePixels pixels = {};
  model::BoardSettings settings = {.run = false, .timeout = 15'120'000};  // after reset
  bool on_frame = false;
  bool sequencer = false;
  int last_pattern = 0;

  // What a write does; false if the board must refuse it.
  bool write(std::uint32_t address, std::uint32_t data);
  // Whether a write to this register asks for a take-over.
  static bool pends(std::uint32_t address) {
    return address == spec::kRegControl || address == spec::kRegSize || address == spec::kRegMeasure ||
           address == spec::kRegDecode;
  }
};

inline bool RaceRegisters::write(std::uint32_t address, std::uint32_t data) {
  const auto bits = [&](int lsb, int count) { return static_cast<int>(data >> lsb & ((1U << count) - 1U)); };
  switch (address) {
    case spec::kRegControl:
      settings.run = bits(spec::kRegControlRunLsb, 1) != 0;
      settings.hold = bits(spec::kRegControlHoldLsb, 1) != 0;
      settings.image = bits(spec::kRegControlImageLsb, 1) != 0;
      return true;
    case spec::kRegSize: {
      const int columns = bits(0, 16);
      const int rows = bits(16, 16);
      if (columns < pixels.lanes || columns % pixels.lanes != 0 || columns > 64 || rows < 1 || rows > 40) {
        return false;
      }
      settings.columns = columns;
      settings.rows = rows;
      return true;
    }
    case spec::kRegMeasure:
      if (bits(spec::kRegMeasureModeLsb, 2) > spec::kModeGreyOver) {
        return false;
      }
      settings.threshold = bits(spec::kRegMeasureThresholdLsb, 8);
      if (pixels.bits > spec::kPixelBits) {
        settings.threshold |= bits(spec::kRegMeasureThresholdHighLsb, spec::kRegMeasureThresholdHighBits) << 8;
      }
      settings.mode = static_cast<model::Mode>(bits(spec::kRegMeasureModeLsb, 2));
      settings.stream = bits(spec::kRegMeasureStreamLsb, 8);
      return true;
    case spec::kRegTimeout:
      settings.timeout = bits(0, 24);
      return true;
    case spec::kRegDecode: {
      const int code_bits = bits(spec::kRegDecodeBitsLsb, 4);
      if (code_bits < 1 || code_bits > 12) {
        return false;
      }
      settings.code_bits = code_bits;
      settings.code_threshold = bits(spec::kRegDecodeThresholdLsb, 8);
      settings.codes = bits(spec::kRegDecodeCodesLsb, 1) != 0;
      settings.median = bits(spec::kRegDecodeMedianLsb, 1) != 0;
      return true;
    }
    case spec::kRegTriggerControl: {
      const bool run = bits(spec::kRegTriggerControlRunLsb, 1) != 0;
      const bool frames = bits(spec::kRegTriggerControlOnFrameLsb, 1) != 0;
      if ((sequencer || on_frame) && (run || frames)) {
        return false;
      }
      sequencer = run;
      on_frame = frames;
      last_pattern = bits(spec::kRegTriggerControlLastPatternLsb, 8);
      return true;
    }
    case spec::kRegTriggerPeriod:
      return !sequencer && bits(0, 24) != 0;
    case spec::kRegTriggerCamera:
    case spec::kRegTriggerWidth:
      return !sequencer;
    default:
      return false;
  }
}

// Counts of all runs together.
struct RaceCounts {
  std::uint64_t frames = 0;   // accepted frame starts
  std::uint64_t racing = 0;   // frame starts in a clock in which a write decides what they take
  std::uint64_t writes = 0;   // register writes
  std::uint64_t refused = 0;  // of these
  std::uint64_t broken = 0;
  std::uint64_t delivered = 0;  // packets of all kinds
  std::uint64_t lost = 0;       // likewise
  // Frame starts so many clocks after a write reached the registers, by the register's word
  static constexpr int kOffsets = 10;
  std::array<std::array<std::uint64_t, kOffsets>, 32> hits{};
};

template <class Model>
class RacingBoard {
 public:
  explicit RacingBoard(std::uint64_t seed, const RacePixels& pixels = {})
      : random_(seed),
        device_(random_board_clocks(random_, seed, pixels.bits, pixels.lanes)),
        model_([this](model::BoardPacket&& packet) { scoreboard_.expect(std::move(packet)); }, true, pixels.bits,
               pixels.lanes),
        registers_{.pixels = pixels} {
    Verilated::threadContextp(device_.model().contextp());
    request_.emplace("TOP.sp_board.u_bridge.request_o");
    device_.on_packet([this](std::span<const std::uint8_t> bytes) {
      ASSERT_TRUE(scoreboard_.compare(bytes)) << scoreboard_.first_mismatch();
    });
    device_.on_clock([this](std::uint64_t clock) { before_clock(clock); });
    device_.on_beat([this](std::uint64_t clock, const model::VideoBeat& beat) { at_beat(clock, beat); });
    const std::uint32_t size =
        static_cast<std::uint32_t>(pixels.lanes) << spec::kRegSizeColumnsLsb | 1U << spec::kRegSizeRowsLsb;
    write(spec::kRegSize, size);
    write(spec::kRegControl, 1U << spec::kRegControlRunLsb);
    camera_works_ = true;
    device_.run(60);  // the first take-over, before which hold would keep frames out
  }

  Random& random() { return random_; }
  sim::BoardDevice<Model>& device() { return device_; }
  [[nodiscard]] const RaceRegisters& registers() const { return registers_; }

  // Writes the register while a frame may start; the board must accept it or refuse it as the model says.
  void write(std::uint32_t address, std::uint32_t data) {
    access_ = {.write = true, .address = address, .data = data};
    const bool refused = device_.access(true, address, data).error;
    EXPECT_EQ(refused, !access_.good) << std::hex << "write " << data << " to " << address;
    ++counts_.writes;
    counts_.refused += refused ? 1 : 0;
  }

  // status.pending is 1 exactly from a write of settings to the frame start that takes them over.
  void check_pending() {
    access_ = {.write = false, .address = spec::kRegStatus};
    const std::uint32_t status = device_.read(spec::kRegStatus);
    EXPECT_EQ(status >> spec::kRegStatusPendingLsb & 1U, access_.pending ? 1U : 0U) << "clock " << device_.clock();
  }

  // All that was sent is out; what has not come was lost, and the counters of the board say so.
  void finish(RaceCounts& sum) {
    camera_works_ = false;
    device_.set_bus_stall_percent(0);
    device_.run(1000);
    device_.drain();
    scoreboard_.finish();
    const auto low = [](std::uint64_t count) { return static_cast<std::uint32_t>(count); };
    EXPECT_EQ(device_.read(spec::kRegFrames), low(model_.frames()));
    EXPECT_EQ(device_.read(spec::kRegBroken), low(model_.broken()));
    EXPECT_EQ(device_.read(spec::kRegStray), low(model_.stray()));
    EXPECT_EQ(device_.read(spec::kRegAbandoned), low(model_.abandoned()));
    EXPECT_EQ(device_.read(spec::kRegLostMoments), scoreboard_.lost_in_all(spec::kKindMoments));
    EXPECT_EQ(device_.read(spec::kRegLostImage), scoreboard_.lost_in_all(spec::kKindImage));
    EXPECT_EQ(device_.read(spec::kRegLostCodes), scoreboard_.lost_in_all(spec::kKindCodes));
    const auto& moments = scoreboard_.of(spec::kKindMoments);
    EXPECT_EQ(moments.matched + moments.lost + (model_.frame_open() ? 1U : 0U), model_.frames());
    sum.frames += model_.frames();
    sum.racing += counts_.racing;
    sum.writes += counts_.writes;
    sum.refused += counts_.refused;
    sum.broken += model_.broken();
    sum.delivered += scoreboard_.matched();
    sum.lost += scoreboard_.lost();
    for (std::size_t word = 0; word < sum.hits.size(); ++word) {
      for (std::size_t offset = 0; offset < RaceCounts::kOffsets; ++offset) {
        sum.hits.at(word).at(offset) += counts_.hits.at(word).at(offset);
      }
    }
  }

 private:
  // Clocks by which the model follows the board: by then it is known what the board saw beside a beat.
  static constexpr std::uint64_t kLag = 6;
  static constexpr std::uint64_t kNever = ~std::uint64_t{0};

  struct Access {
    bool write = false;
    std::uint32_t address = 0;
    std::uint32_t data = 0;
    std::uint64_t request = kNever;  // clock in which it reaches the registers
    bool good = false;               // what the registers must answer
    bool pending = false;            // what status.pending must say
  };
  struct Beat {
    std::uint64_t clock;
    model::VideoBeat beat;
    std::uint32_t encoder;
    model::BoardSettings settings;  // as written, with run and hold as they count for this beat
  };
  // What was so many clocks ago; [0] is now.
  struct Past {
    bool run = false;
    bool hold = false;
    bool on_frame = false;
    bool accepted = false;  // a frame started
    bool took = false;      // and took the settings over
    int pattern = 0;        // index of the trigger
    int last_pattern = 0;
  };
  Past& past(std::uint64_t clocks) { return past_.at((clock_ - clocks) % past_.size()); }

  void before_clock(std::uint64_t clock) {
    clock_ = clock;
    past(0) = {};
    follow_access();
    past(0).run = registers_.settings.run;
    past(0).hold = registers_.settings.hold;
    past(0).on_frame = registers_.on_frame && !registers_.sequencer;
    past(0).last_pattern = registers_.last_pattern;
    follow_pattern();
    turn_encoder();
    if (clock > kLag + 1) {
      follow_beats(clock - kLag);
    }
    if (camera_works_ && device_.queued() == 0 && may_start_now()) {
      send_frame();
    }
  }

  // The access that is under way, if it has reached the registers
  void follow_access() {
    if (access_.request == kNever && request_->get() != 0) {
      access_.request = clock_;
      if (access_.write) {
        start_at_ = clock_ + static_cast<std::uint64_t>(random_.between(0, RaceCounts::kOffsets - 1));
      }
    }
    if (past(2).took) {
      pending_ = false;
    }
    if (access_.write && clock_ == access_.request + 4) {
      access_.good = registers_.write(access_.address, access_.data);
      pending_ = pending_ || (access_.good && RaceRegisters::pends(access_.address));
    }
    if (!access_.write && clock_ == access_.request + 2) {
      access_.pending = pending_;
    }
  }

  // Frames count from the captured_i of the third clock after on_frame_i on (sp_trigger); that is four clocks after
  // the start. The index goes back to 0 two clocks after on_frame_i falls, and counts to the old last one until then.
  void follow_pattern() {
    if (clock_ < kLag) {
      return;
    }
    past(0).pattern = past(1).pattern;
    if (!past(2).on_frame || !past(3).on_frame || !past(4).on_frame) {
      past(0).pattern = 0;
    } else if (past(5).on_frame && past(6).accepted) {
      past(0).pattern = past(1).pattern == past(2).last_pattern ? 0 : past(1).pattern + 1;
    }
  }

  void turn_encoder() {
    if (clock_ < 16 || clock_ % 7 != 0) {
      return;
    }
    ++encoder_;
    device_.set_encoder((encoder_ & 3U) == 1 || (encoder_ & 3U) == 2, (encoder_ & 3U) >= 2);
  }

  // Settings stand still for a frame start in this clock.
  [[nodiscard]] bool held() {
    const bool beside_write =
        access_.write && access_.request != kNever && clock_ >= access_.request + 3 && clock_ <= access_.request + 5;
    return beside_write || past(2).hold;
  }

  void at_beat(std::uint64_t clock, const model::VideoBeat& beat) {
    Beat late = {.clock = clock, .beat = beat, .encoder = encoder_, .settings = registers_.settings};
    late.settings.hold = held();
    if (beat.start) {
      late.settings.run = past(1).run;
      past(0).accepted = past(1).run;
      if (past(0).accepted && !late.settings.hold &&
          (!taken_ || clock >= last_take_ + model::BoardModel::kTakeDistance)) {
        past(0).took = true;
        taken_ = true;
        last_take_ = clock;
        in_force_ = registers_.settings;
      }
      if (access_.write && access_.request != kNever && clock - access_.request < RaceCounts::kOffsets) {
        ++counts_.hits.at(access_.address / 4).at(clock - access_.request);
        counts_.racing += clock > access_.request && clock <= access_.request + 6 ? 1 : 0;
      }
    }
    late_.push_back(late);
  }

  // The model is given what the board was given in this clock.
  void follow_beats(std::uint64_t clock) {
    model_.idle(clock - 1);
    if (late_.empty() || late_.front().clock != clock) {
      return;
    }
    Beat late = late_.front();
    late_.pop_front();
    const bool runs_then = past(kLag - 1).run;  // a beat counts as stray if the board runs one clock after it
    const model::BoardInputs inputs = {
        .clock = clock, .encoder = late.encoder, .pattern = static_cast<std::uint16_t>(past(kLag - 5).pattern)};
    const bool start = late.beat.start;
    if (!start) {
      late.settings.run = runs_then;
    }
    model_.write(late.settings);
    model_.beat(inputs, late.beat);
    if (start && !late.settings.run && runs_then) {
      late.settings.run = true;
      model_.write(late.settings);
      late.beat.start = false;
      model_.beat(inputs, late.beat);
    }
  }

  [[nodiscard]] bool may_start_now() {
    if (start_at_ != kNever && start_at_ >= clock_) {
      return start_at_ == clock_;
    }
    return random_.chance(8);
  }

  // A frame, mostly of the size that it must have if it starts now.
  void send_frame() {
    const bool takes = !held() && clock_ >= last_take_ + model::BoardModel::kTakeDistance;
    const model::BoardSettings& settings = takes ? registers_.settings : in_force_;
    const bool fits = random_.chance(90);
    const int rows = fits ? settings.rows : random_.between(1, kRaceRows);
    const RacePixels& pixels = registers_.pixels;
    const int columns = fits ? settings.columns : pixels.lanes * random_.between(1, kRaceBeats);
    std::vector<model::VideoBeat> beats =
        beats_with_faults(random_, random_image(random_, rows, columns), 4, pixels.lanes);
    if (pixels.bits > spec::kPixelBits) {
      append_bits(random_, pixels.bits - spec::kPixelBits, beats);
    }
    for (const model::VideoBeat& beat : beats) {
      device_.send(beat);
    }
  }

  Random random_;
  sim::BoardDevice<Model> device_;
  sim::PacketScoreboard scoreboard_;
  model::BoardModel model_;
  std::optional<InnerRegister> request_;

  std::uint64_t clock_ = 0;
  RaceRegisters registers_;  // as they stand in this clock
  Access access_;            // the last one, or the one under way
  std::array<Past, 8> past_{};
  std::deque<Beat> late_;  // beats that the model has not been given
  bool pending_ = true;
  bool taken_ = false;
  std::uint64_t last_take_ = 0;
  model::BoardSettings in_force_;
  std::uint32_t encoder_ = 0;
  bool camera_works_ = false;
  std::uint64_t start_at_ = kNever;  // when the camera starts its next frame, if it is ready
  RaceCounts counts_;
};

// Writes of every register with values that are good or not, among frames that start beside them.
template <class Model>
void play_races(std::uint64_t seed, int writes, RaceCounts& counts, const RacePixels& pixels = {}) {
  RacingBoard<Model> board(seed, pixels);
  Random& random = board.random();
  const auto number = [&](int low, int high) { return static_cast<std::uint32_t>(random.between(low, high)); };
  for (int i = 0; i < writes && !::testing::Test::HasFailure(); ++i) {
    if (i % 32 == 0) {
      board.device().set_bus_stall_percent(random.chance(60) ? 0 : random.between(0, 95));
      board.device().set_video_gap_percent(random.chance(60) ? 0 : random.between(0, 50));
    }
    const bool spoil = random.chance(10);
    switch (random.between(0, 11)) {
      case 0:
      case 1:
        board.write(spec::kRegSize, (static_cast<unsigned>(pixels.lanes) * number(1, kRaceBeats) + (spoil ? 1U : 0U)) |
                                        number(1, kRaceRows) << spec::kRegSizeRowsLsb);
        break;
      case 2:
      case 3:
        board.write(spec::kRegMeasure, number(0, 255) << spec::kRegMeasureThresholdLsb |
                                           number(0, (1 << (pixels.bits - spec::kPixelBits)) - 1)
                                               << spec::kRegMeasureThresholdHighLsb |
                                           (spoil ? 3U : number(0, 2)) << spec::kRegMeasureModeLsb |
                                           number(0, 255) << spec::kRegMeasureStreamLsb);
        break;
      case 4:
        board.write(spec::kRegTimeout, spoil ? 0 : number(1, 60));
        break;
      case 5:
      case 6:
        board.write(spec::kRegDecode, number(0, 60) << spec::kRegDecodeThresholdLsb |
                                          (spoil ? 0 : number(1, 3)) << spec::kRegDecodeBitsLsb |
                                          (random.chance(80) ? 1U : 0U) << spec::kRegDecodeCodesLsb |
                                          number(0, 1) << spec::kRegDecodeMedianLsb);
        break;
      case 7:
      case 8:
      case 9:
        board.write(spec::kRegControl, (random.chance(85) ? 1U : 0U) << spec::kRegControlRunLsb |
                                           (random.chance(30) ? 1U : 0U) << spec::kRegControlHoldLsb |
                                           (random.chance(30) ? 1U : 0U) << spec::kRegControlImageLsb);
        break;
      case 10:
        board.write(spec::kRegTriggerControl, number(0, 1) << spec::kRegTriggerControlOnFrameLsb |
                                                  number(0, 6) << spec::kRegTriggerControlLastPatternLsb);
        break;
      default:
        // refused: read-only, none, and 0 as a period
        board.write(random.chance(50) ? spec::kRegFrames : random.chance(50) ? 0x7C : spec::kRegTriggerPeriod, 0);
    }
    if (random.chance(50)) {
      board.check_pending();
    }
    board.device().run(number(0, 20));
  }
  board.finish(counts);
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BOARD_RACING_BOARD_H
