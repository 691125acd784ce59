// Replay between a network and a board's video input: datagrams in, frames out, beside its model.
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_REPLAY_BENCH_H
#define SELFPROJ_TESTS_RTL_BLOCKS_REPLAY_BENCH_H

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "Vsp_replay_ports.h"
#include "model/little_endian.h"
#include "model/replay.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

using ReplayBytes = std::vector<std::uint8_t>;

// What CMakeLists.txt builds.
inline constexpr ReplaySize kReplayBuild = {.columns = 40, .rows = 9};
inline constexpr std::uint32_t kReplayHost = 0xC0A80101;

inline ReplayBytes replay_datagram(ReplayHeader header, const ReplayBytes& piece) {
  ReplayBytes bytes(spec::kReplayHeaderBytes);
  write_replay_header(header, bytes.data());
  bytes.insert(bytes.end(), piece.begin(), piece.end());
  return bytes;
}

class ReplayBench {
 public:
  ReplayBench(std::uint64_t seed, const TwoClocks& clocks) : random_(seed), clocks_(clocks), model_(kReplayBuild) {
    for (const char* port : {"m_data_o", "m_start_o", "m_end_o"}) {
      replay_.valid_when(port, [this] { return replay_->m_valid_o != 0; });
    }
    replay_->bus_clk_i = 0;
    replay_->clk_i = 0;
    replay_->s_valid_i = 0;
    replay_->begin_i = 0;
    replay_->session_i = 0;
    replay_->enable_i = 1;
    replay_->host_i = kReplayHost;
    replay_->bus_rst_i = 1;
    replay_->rst_i = 1;
    for (int bus = 0, video = 0; bus < 5 || video < 5;) {
      const TwoClocks::Rises rises = step();
      bus += rises.a ? 1 : 0;
      video += rises.b ? 1 : 0;
    }
    replay_->bus_rst_i = 0;
    replay_->rst_i = 0;
    replay_.outputs_are_known();
    known_ = true;
  }

  struct Sent {
    std::uint32_t from = kReplayHost;
    std::optional<std::size_t> bytes = {};  // as UDP says; else all
    bool damaged = false;
    std::size_t filling = 0;  // words behind the datagram
    int pauses = 10;          // percent of the clocks
  };

  // Sends a datagram of whole words, to the model as well.
  void send(const ReplayBytes& datagram, const Sent& how) {
    ReplayBytes words = datagram;
    words.resize((datagram.size() + 3) / 4 * 4 + 4 * how.filling, 0xA5);
    const std::size_t bytes = how.bytes.value_or(datagram.size());
    constexpr std::size_t kJudged = spec::kReplayHeaderBytes;  // first word behind the header
    judged_ = false;
    for (std::size_t at = 0; at < words.size(); at += 4) {
      while (random_.chance(how.pauses)) {
        bus_clock();
      }
      replay_->s_valid_i = 1;
      replay_->s_last_i = at + 4 == words.size();
      replay_->s_error_i = at + 4 == words.size() ? how.damaged : random_.chance(50);
      replay_->s_data_i = load_little_endian<std::uint32_t>(words.data() + at);
      replay_->s_bytes_i = static_cast<SData>(bytes);
      replay_->s_from_i = how.from;
      bus_clock();
      replay_->s_valid_i = 0;
      judge_next_ = at == kJudged;
    }
    bus_clock();  // the judge's, if the datagram has one word behind its header
    const bool may_send = how.from == replay_->host_i && replay_->enable_i != 0;
    if (std::optional<ReplayFrame> whole =
            model_.datagram({.came = words, .bytes = bytes, .damaged = how.damaged, .may_send = may_send})) {
      due_.push_back(*std::move(whole));
    }
    judged_ = false;
    if (left_late_) {
      left_late_ = false;
      model_.left();
    }
    idle(4);
    expect_counts();
  }

  // Sends a datagram without pauses, in whose clock `when`, from 0, a session begins, or no host has it any more.
  void interrupt(const ReplayBytes& datagram, int when, bool disable) {
    const int words = static_cast<int>(datagram.size() / 4);
    const int taken = words + 2;  // the last clock in which it can be ignored is the one before this
    const auto interrupts = [&] {
      if (disable) {
        model_.forget();
      } else {
        model_.begin(0);
      }
    };
    for (int clock = 0; clock <= taken + 4; ++clock) {
      replay_->s_valid_i = clock < words;
      replay_->s_last_i = clock + 1 == words;
      replay_->s_error_i = 0;
      replay_->s_data_i =
          clock < words ? load_little_endian<std::uint32_t>(datagram.data() + 4 * static_cast<std::size_t>(clock)) : 0;
      replay_->s_bytes_i = static_cast<SData>(datagram.size());
      replay_->s_from_i = kReplayHost;
      replay_->begin_i = clock == when && !disable;
      replay_->enable_i = clock != when || !disable;
      bus_clock();
    }
    if (when < taken) {
      interrupts();
    }
    // The first word counts a clock after it came.
    if (std::optional<ReplayFrame> whole =
            model_.datagram({.came = datagram, .bytes = datagram.size(), .may_send = when == 0 || when >= taken})) {
      due_.push_back(*std::move(whole));
    }
    if (when >= taken) {
      interrupts();
    }
    expect_counts();
  }

  void begin(std::uint16_t session) {
    replay_->session_i = session;
    replay_->begin_i = 1;
    bus_clock();
    replay_->begin_i = 0;
    model_.begin(session);
    idle(4);
    expect_counts();
  }

  void enable(bool on) {
    replay_->enable_i = on;
    if (!on) {
      model_.forget();
    }
    idle(2);
    expect_counts();
  }

  void set_host(std::uint32_t host) { replay_->host_i = host; }

  void idle(int bus_clocks) {
    for (int i = 0; i < bus_clocks; ++i) {
      bus_clock();
    }
  }

  // Until no frame is leaving. Every frame that the model made whole has left then.
  void drain() {
    for (int i = 0; model_.leaving() && i < 20000; ++i) {
      bus_clock();
    }
    idle(4);
    EXPECT_FALSE(model_.leaving()) << "a frame does not leave";
    EXPECT_EQ(frames_.size(), due_.size());
    EXPECT_TRUE(frame_.pixels.empty());
    EXPECT_TRUE(frames_ == due_);
    expect_counts();
  }

  // What the registers of the RTL say.
  [[nodiscard]] ReplayCounts counts() {
    return {.frame = replay_->frame_o,
            .offset = replay_->offset_o,
            .frames = replay_->frames_o,
            .dropped = replay_->dropped_o,
            .ignored = replay_->ignored_o};
  }
  [[nodiscard]] bool leaving() const { return model_.leaving(); }
  [[nodiscard]] const std::vector<ReplayFrame>& frames() const { return frames_; }

 private:
  // Looks whether the frame has left. For a datagram that was judged before, it had not yet.
  void note_left() {
    if (replay_->frames_o != model_.counts().frames && !left_late_) {
      if (judged_) {
        left_late_ = true;
      } else {
        model_.left();
      }
    }
  }

  void expect_counts() {
    note_left();
    const ReplayCounts rtl = counts();
    const ReplayCounts model = model_.counts();
    EXPECT_EQ(rtl.frame, model.frame);
    EXPECT_EQ(rtl.offset, model.offset);
    EXPECT_EQ(rtl.frames, model.frames);
    EXPECT_EQ(rtl.dropped, model.dropped);
    EXPECT_EQ(rtl.ignored, model.ignored);
  }

  void bus_clock() {
    while (!step().a) {
    }
  }

  TwoClocks::Rises step() {
    const TwoClocks::Rises rises = clocks_.next();
    if (rises.a) {
      replay_->bus_clk_i = 0;
    }
    if (rises.b) {
      replay_->clk_i = 0;
    }
    replay_.eval();
    if (rises.a && known_) {
      note_left();
      judged_ = judged_ || std::exchange(judge_next_, false);
    }
    if (rises.b && known_) {
      take_beat();
    }
    replay_->bus_clk_i = rises.a ? 1 : replay_->bus_clk_i;
    replay_->clk_i = rises.b ? 1 : replay_->clk_i;
    replay_.eval();
    return rises;
  }

  void take_beat() {
    if (!replay_->m_valid_o) {
      EXPECT_TRUE(frame_.pixels.empty()) << "a gap within a frame";
      return;
    }
    EXPECT_EQ(replay_->m_start_o != 0, frame_.pixels.empty());
    frame_.pixels.resize(frame_.pixels.size() + 4);
    store_little_endian(frame_.pixels.data() + frame_.pixels.size() - 4, std::uint32_t{replay_->m_data_o});
    ++beats_;
    if (replay_->m_end_o) {
      EXPECT_TRUE(frame_.rows == 0 || frame_.columns == 4 * beats_) << "rows of different lengths";
      frame_.columns = 4 * beats_;
      ++frame_.rows;
      beats_ = 0;
    }
    ASSERT_LT(frames_.size(), due_.size()) << "video of a frame that is not whole";
    if (frame_.pixels.size() == due_[frames_.size()].pixels.size()) {
      EXPECT_TRUE(frame_ == due_[frames_.size()]) << "frame " << frames_.size();
      frames_.push_back(std::exchange(frame_, {}));
      beats_ = 0;
    }
  }

  Random random_;
  TwoClocks clocks_;
  ReplayModel model_;
  Model<Vsp_replay> replay_;
  bool known_ = false;
  bool judge_next_ = false;  // the receiver judges the datagram in the next clock
  bool judged_ = false;      // it has judged the datagram that comes
  bool left_late_ = false;   // a frame has left after that
  std::vector<ReplayFrame> due_;
  std::vector<ReplayFrame> frames_;
  ReplayFrame frame_;  // that is coming
  int beats_ = 0;      // of its row
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_REPLAY_BENCH_H
