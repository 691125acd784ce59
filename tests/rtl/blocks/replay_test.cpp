// Tests replay against its model: a host that repeats what is missing, over a network that loses, doubles, reorders,
#include "model/replay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "Vsp_replay_ports.h"
#include "Vsp_video_switch_ports.h"
#include "selfproj/model/little_endian.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

using ReplayBytes = std::vector<std::uint8_t>;

// What CMakeLists.txt builds.
constexpr model::ReplaySize kReplayBuild = {.columns = 40, .rows = 9};
constexpr std::uint32_t kReplayHost = 0xC0A80101;

ReplayBytes replay_datagram(model::ReplayHeader header, const ReplayBytes& piece) {
  ReplayBytes bytes(spec::kReplayHeaderBytes);
  model::write_replay_header(header, bytes.data());
  bytes.insert(bytes.end(), piece.begin(), piece.end());
  return bytes;
}

class ReplayBench {
 public:
  ReplayBench(std::uint64_t seed, const TwoClocks& clocks) : random_(seed), clocks_(clocks), model_(kReplayBuild) {
    replay_.valid_when({"m_data_o", "m_start_o", "m_end_o"}, [this] { return replay_->m_valid_o != 0; });
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
    constexpr std::size_t kChecked = spec::kReplayHeaderBytes;  // first word behind the header
    checked_ = false;
    for (std::size_t at = 0; at < words.size(); at += 4) {
      while (random_.chance(how.pauses)) {
        bus_clock();
      }
      replay_->s_valid_i = 1;
      replay_->s_last_i = at + 4 == words.size();
      replay_->s_error_i = at + 4 == words.size() ? how.damaged : random_.chance(50);
      replay_->s_data_i = model::load_little_endian<std::uint32_t>(words.data() + at);
      replay_->s_bytes_i = static_cast<SData>(bytes);
      replay_->s_from_i = how.from;
      bus_clock();
      replay_->s_valid_i = 0;
      check_next_ = at == kChecked;
    }
    bus_clock();  // in which the receiver checks it, if the datagram has one word behind its header
    const bool may_send = how.from == replay_->host_i && replay_->enable_i != 0;
    if (std::optional<model::ReplayFrame> whole =
            model_.datagram({.came = words, .bytes = bytes, .damaged = how.damaged, .may_send = may_send})) {
      due_.push_back(*std::move(whole));
    }
    checked_ = false;
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
          clock < words
              ? model::load_little_endian<std::uint32_t>(datagram.data() + 4 * static_cast<std::size_t>(clock))
              : 0;
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
    if (std::optional<model::ReplayFrame> whole =
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
  [[nodiscard]] model::ReplayCounts counts() {
    return {.frame = replay_->frame_o,
            .offset = replay_->offset_o,
            .frames = replay_->frames_o,
            .dropped = replay_->dropped_o,
            .ignored = replay_->ignored_o};
  }
  [[nodiscard]] bool leaving() const { return model_.leaving(); }
  [[nodiscard]] const std::vector<model::ReplayFrame>& frames() const { return frames_; }

 private:
  // Looks whether the frame has left. For a datagram that was checked before, it had not yet.
  void note_left() {
    if (replay_->frames_o != model_.counts().frames && !left_late_) {
      if (checked_) {
        left_late_ = true;
      } else {
        model_.left();
      }
    }
  }

  void expect_counts() {
    note_left();
    const model::ReplayCounts rtl = counts();
    const model::ReplayCounts model = model_.counts();
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
    step_clocks(
        replay_, replay_->bus_clk_i, replay_->clk_i, rises, [] {},
        [&] {
          if (rises.a && known_) {
            note_left();
            checked_ = checked_ || std::exchange(check_next_, false);
          }
          if (rises.b && known_) {
            take_beat();
          }
        });
    return rises;
  }

  void take_beat() {
    if (!replay_->m_valid_o) {
      EXPECT_TRUE(frame_.pixels.empty()) << "a gap within a frame";
      return;
    }
    EXPECT_EQ(replay_->m_start_o != 0, frame_.pixels.empty());
    frame_.pixels.resize(frame_.pixels.size() + 4);
    model::store_little_endian(frame_.pixels.data() + frame_.pixels.size() - 4, std::uint32_t{replay_->m_data_o});
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
  model::ReplayModel model_;
  Model<Vsp_replay> replay_;
  bool known_ = false;
  bool check_next_ = false;  // the receiver checks the datagram in the next clock
  bool checked_ = false;     // it has checked the datagram that comes
  bool left_late_ = false;   // a frame has left after that
  std::vector<model::ReplayFrame> due_;
  std::vector<model::ReplayFrame> frames_;
  model::ReplayFrame frame_;  // that is coming
  int beats_ = 0;             // of its row
};

// --- Tests ---

model::ReplayFrame random_frame(Random& random) {
  model::ReplayFrame frame{.columns = 4 * random.between(1, kReplayBuild.columns / 4),
                           .rows = random.between(1, kReplayBuild.rows)};
  frame.pixels = random.bytes(static_cast<std::size_t>(frame.columns) * static_cast<std::size_t>(frame.rows));
  return frame;
}

// The datagrams of a frame from its byte `from` on.
std::vector<ReplayBytes> datagrams_of(const model::ReplayFrame& frame, std::uint16_t session, std::uint32_t number,
                                      std::size_t from, std::size_t piece) {
  std::vector<ReplayBytes> all;
  for (std::size_t at = from; at < frame.pixels.size(); at += piece) {
    const std::size_t end = std::min(at + piece, frame.pixels.size());
    all.push_back(replay_datagram({.session = session,
                                   .frame = number,
                                   .offset = static_cast<std::uint32_t>(at),
                                   .length = static_cast<std::uint16_t>(end - at),
                                   .columns = static_cast<std::uint16_t>(frame.columns),
                                   .rows = static_cast<std::uint16_t>(frame.rows)},
                                  {frame.pixels.begin() + static_cast<std::ptrdiff_t>(at),
                                   frame.pixels.begin() + static_cast<std::ptrdiff_t>(end)}));
  }
  return all;
}

// A network with faults of every kind between a host and the board.
class Faults {
 public:
  Faults(ReplayBench& bench, Random& random) : bench_(bench), random_(random) {}

  void pass(const ReplayBytes& datagram) {
    if (random_.chance(10)) {
      return;  // lost
    }
    if (random_.chance(10)) {
      late_.push_back(datagram);  // doubled, or later than the next ones
      if (random_.chance(50)) {
        return;
      }
    }
    arrive(datagram);
    while (!late_.empty() && random_.chance(30)) {
      const auto which = static_cast<std::size_t>(random_.between(0, static_cast<int>(late_.size()) - 1));
      arrive(late_[which]);
      late_.erase(late_.begin() + static_cast<std::ptrdiff_t>(which));
    }
  }

 private:
  void arrive(ReplayBytes datagram) {
    ReplayBench::Sent how{.damaged = random_.chance(5), .pauses = random_.chance(50) ? 0 : 30};
    if (how.damaged) {
      datagram[static_cast<std::size_t>(random_.between(0, static_cast<int>(datagram.size()) - 1))] ^=
          static_cast<std::uint8_t>(random_.between(1, 255));
    }
    how.filling = datagram.size() < 32 ? static_cast<std::size_t>(random_.between(0, 4)) : 0;
    if (random_.chance(5)) {  // cut, whatever its header says
      how.filling = 0;
      how.bytes = datagram.size();
      datagram.resize(4 * static_cast<std::size_t>(random_.between(1, static_cast<int>(datagram.size() / 4))));
    }
    bench_.send(datagram, how);
  }

  ReplayBench& bench_;
  Random& random_;
  std::vector<ReplayBytes> late_;
};

// All frames of a host that repeats from where the board is leave once, in order, and as they were sent.
TEST(Replay, EveryFrameOverABadNetwork) {
  for_cases(20, [&](Random& random, std::uint64_t seed) {
    ReplayBench bench(seed, random_clocks(random));
    Faults network(bench, random);
    std::vector<model::ReplayFrame> sent;
    std::uint32_t number = 0;
    auto session = static_cast<std::uint16_t>(random.bits());
    bench.begin(session);
    for (int i = 0; i < 15; ++i, ++number) {
      if (random.chance(10)) {  // with datagrams of the old session on their way
        session = static_cast<std::uint16_t>(session + random.between(1, 9));
        bench.begin(session);
        number = 0;
      }
      sent.push_back(random_frame(random));
      const auto piece = static_cast<std::size_t>(4 * random.between(1, 40));
      for (int tries = 0; bench.counts().frame == number; ++tries) {
        ASSERT_LT(tries, 1000) << "no progress";
        for (const ReplayBytes& datagram : datagrams_of(sent.back(), session, number, bench.counts().offset, piece)) {
          network.pass(datagram);
        }
        bench.idle(random.chance(50) ? 0 : random.between(0, 400));
        ASSERT_FALSE(HasFailure());
      }
      ASSERT_EQ(bench.counts().frame, number + 1);
      ASSERT_EQ(bench.counts().dropped, 0U);
      if (random.chance(20)) {  // what comes while the frame leaves is ignored
        const ReplayBytes next = datagrams_of(sent.back(), session, number + 1, 0, piece).front();
        while (bench.leaving() && random.chance(80)) {
          network.pass(next);
        }
        bench.drain();
        if (bench.frames().size() > sent.size()) {  // one came when it had left, and is a whole frame
          sent.push_back(sent.back());
        }
        session = static_cast<std::uint16_t>(session + 1);
        bench.begin(session);
        number = static_cast<std::uint32_t>(-1);
      } else if (random.chance(70)) {
        bench.drain();
      }
      ASSERT_FALSE(HasFailure());
    }
    bench.drain();
    EXPECT_TRUE(bench.frames() == sent);
  });
}

// A host that never repeats: frames are whole or dropped, and delivered plus dropped plus the rest is what was sent.
TEST(Replay, FramesThatAreNotWholeAreDroppedAndCounted) {
  std::uint32_t whole = 0;
  std::uint32_t dropped = 0;
  for_cases(20, [&](Random& random, std::uint64_t seed) {
    ReplayBench bench(seed, random_clocks(random));
    for (std::uint32_t number = 0; number < 40; ++number) {
      for (const ReplayBytes& datagram : datagrams_of(random_frame(random), 0, number, 0, 100)) {
        if (!random.chance(15)) {
          bench.send(datagram, {.damaged = random.chance(5)});
        }
      }
      if (random.chance(80)) {
        bench.drain();
      }
      ASSERT_FALSE(HasFailure());
      const model::ReplayCounts counts = bench.counts();
      EXPECT_EQ(counts.frames + (bench.leaving() ? 1U : 0U) + counts.dropped, counts.frame);
    }
    bench.drain();
    whole += bench.counts().frames;
    dropped += bench.counts().dropped;
  });
  if (runs_all_cases()) {
    EXPECT_GT(whole, 200U);
    EXPECT_GT(dropped, 100U);
  }
}

// Any words in the header: the board does what the model does.
TEST(Replay, DatagramsOfAnyKind) {
  std::size_t frames = 0;
  for_cases(30, [&](Random& random, std::uint64_t seed) {
    ReplayBench bench(seed, random_clocks(random));
    const auto number16 = [&](int likely) {
      return static_cast<std::uint16_t>(random.chance(95) ? likely : random.chance(50) ? likely + 1 : random.bits());
    };
    model::ReplayHeader size{.columns = 8, .rows = 2};
    const auto host = static_cast<std::uint32_t>(random.bits());
    const auto session = static_cast<std::uint16_t>(random.bits());
    bench.set_host(host);
    bench.begin(session);
    for (int i = 0; i < 400; ++i) {
      if (random.chance(5)) {
        size.columns = static_cast<std::uint16_t>(random.between(0, kReplayBuild.columns + 4));
        size.rows = static_cast<std::uint16_t>(random.between(0, kReplayBuild.rows + 2));
      }
      const model::ReplayCounts at = bench.counts();
      model::ReplayHeader header{
          .session = number16(session), .columns = number16(size.columns), .rows = number16(size.rows)};
      header.frame = at.frame + static_cast<std::uint32_t>(random.chance(80)   ? 0
                                                           : random.chance(80) ? random.between(-3, 3)
                                                                               : static_cast<int>(random.bits()));
      header.offset = at.offset;
      if (random.chance(20)) {
        header.offset = random.chance(50) ? 0 : static_cast<std::uint32_t>(random.bits() % 500);
      }
      if (random.chance(2)) {
        header.offset ^= 1U << random.between(0, 31);
      }
      const int rest = std::clamp(size.columns * size.rows - static_cast<int>(header.offset % 4096), 0, 400);
      header.length =
          std::min<std::uint16_t>(number16(random.chance(50) ? rest : 4 * random.between(0, rest / 4)), 60000);
      ReplayBytes datagram = replay_datagram(header, random.bytes(header.length));
      if (random.chance(3)) {
        datagram[static_cast<std::size_t>(random.between(0, 1))] ^= 0x10;
      }
      ReplayBench::Sent how{.from = host, .damaged = random.chance(5), .filling = random.chance(20) ? 3U : 0U};
      if (random.chance(5)) {
        how.bytes = datagram.size() + static_cast<std::size_t>(random.between(-8, 8));
      }
      if (random.chance(5)) {
        how.from ^= 1U << random.between(0, 31);
      }
      bench.send(datagram, how);
      if (random.chance(30)) {
        bench.drain();
      }
      if (random.chance(2)) {
        bench.enable(false);
        bench.enable(random.chance(90));
      } else {
        bench.enable(true);
      }
      ASSERT_FALSE(HasFailure()) << "datagram " << i;
    }
    bench.drain();
    frames += bench.frames().size();
  });
  if (runs_all_cases()) {
    EXPECT_GT(frames, 300U);
  }
}

// A session that begins, or a host that goes, while a datagram comes: that datagram is ignored.
TEST(Replay, ASessionEndsWithinADatagram) {
  for (const bool disable : {false, true}) {
    for (int when = 0; when < 12; ++when) {
      ReplayBench bench(1, TwoClocks(1000, 1000, 300));
      Random random(1);
      model::ReplayFrame frame{.columns = 8, .rows = 2, .pixels = random.bytes(16)};
      bench.interrupt(datagrams_of(frame, 0, 0, 0, 16).front(), when, disable);
      bench.drain();
      ASSERT_FALSE(HasFailure()) << "clock " << when;
      const std::size_t taken = when == 0 || when == 11 ? 1 : 0;
      EXPECT_EQ(bench.frames().size(), taken) << "clock " << when;
      // The next one is taken again.
      for (const ReplayBytes& datagram : datagrams_of(frame, 0, bench.counts().frame, 0, 8)) {
        bench.send(datagram, {});
      }
      bench.drain();
      EXPECT_EQ(bench.frames().size(), taken + 1);
    }
  }
}

// --- The switch ---

constexpr unsigned kSources = 3;

// A product with kMix, modulo 2^32, moves all bits; that with kUnmix takes it back.
constexpr std::uint32_t kMix = 0x9E37'79B1;
constexpr std::uint32_t kUnmix = 0x0E8B'2F51;
static_assert(kMix * kUnmix == 1);

// Sources that send frames of random lengths with pauses, each beat with its source, frame and place, mixed.
class Sources {
 public:
  void clock(Random& random, Vsp_video_switch& dut) {
    unsigned valid = 0;
    unsigned start = 0;
    unsigned end = 0;
    for (unsigned i = 0; i < kSources; ++i) {
      dut.s_data_i[i] = (i << 28U | frame_[i] << 8U | place_[i]) * kMix;
      if (random.chance(70)) {
        valid |= 1U << i;
        start |= (place_[i] == 0 ? 1U : 0U) << i;
        end |= (place_[i] + 1 == length_[i] ? 1U : 0U) << i;
        if (++place_[i] == length_[i]) {
          place_[i] = 0;
          ++frame_[i];
          length_[i] = static_cast<unsigned>(random.between(1, 30));
        }
      }
    }
    dut.s_valid_i = static_cast<CData>(valid);
    dut.s_start_i = static_cast<CData>(start);
    dut.s_end_i = static_cast<CData>(end);
  }

 private:
  std::array<unsigned, kSources> frame_{};
  std::array<unsigned, kSources> place_{};
  std::array<unsigned, kSources> length_{9, 9, 9};
};

// What leaves are frames of one source from their beginning on, and whole unless the source changed.
TEST(VideoSwitch, BeatsOfTwoSourcesNeverMakeOneFrame) {
  std::size_t whole = 0;
  std::size_t cut = 0;
  for_cases(10, [&](Random& random) {
    Clocked<Vsp_video_switch> dut;
    dut.valid_when({"m_data_o", "m_start_o", "m_end_o"}, [&dut] { return dut->m_valid_o != 0; });
    dut->select_i = 1;
    dut->s_valid_i = 0;
    dut.reset();
    Sources sources;
    unsigned selected = 0;
    int changed = 0;
    std::uint32_t last = 0;  // the beat that left last, if its frame goes on
    bool open = false;
    bool begun = false;  // a frame of the selected source has begun since it counts
    bool due = false;    // a beat of it has come
    for (int clock = 0; clock < 3000; ++clock) {
      if (random.chance(1)) {
        const auto one = static_cast<unsigned>(random.between(0, kSources - 1));
        dut->select_i = static_cast<CData>(1U << one);
        if (one != selected) {
          selected = one;
          changed = clock;
        }
      } else if (random.chance(1)) {
        dut->select_i = random.chance(50) ? 0 : 7;  // neither counts
      } else if (clock - changed > 6) {
        dut->select_i = static_cast<CData>(1U << selected);
      }
      sources.clock(random, dut.dut());
      dut.settle();
      if (begun) {
        ASSERT_EQ(dut->m_valid_o != 0, due) << "clock " << clock;
      }
      const bool counts = clock - changed > 6;
      due = (dut->s_valid_i >> selected & 1U) != 0;
      begun = counts && (begun || (due && (dut->s_start_i >> selected & 1U) != 0));
      if (dut->m_valid_o) {
        const std::uint32_t data = dut->m_data_o * kUnmix;
        ASSERT_EQ(dut->m_start_o != 0, (data & 0xFF) == 0);
        if (counts) {
          ASSERT_EQ(data >> 28U, selected) << "clock " << clock;
        }
        if (dut->m_start_o) {
          cut += open ? 1 : 0;
        } else {
          ASSERT_TRUE(open);
          ASSERT_EQ(data, last + 1) << "beats of two frames";
        }
        open = !dut->m_end_o;
        whole += dut->m_end_o ? 1 : 0;
        last = data;
      }
      dut.rise();
    }
  });
  if (runs_all_cases()) {
    EXPECT_GT(whole, 500U);
    EXPECT_GT(cut, 20U);
  }
}

}  // namespace

}  // namespace selfproj::test
