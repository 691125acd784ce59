// Tests the cutter of packets into datagrams: against its model, through sessions, silence and resets, and, over a bad
// network, with the host's driver.
#include "model/datagram_cutter.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "Vsp_datagram_cutter_jumbo_ports.h"
#include "Vsp_datagram_cutter_largest_ports.h"
#include "Vsp_datagram_cutter_ports.h"
#include "Vsp_datagram_cutter_small_ports.h"
#include "host/driver/datagram_assembler.h"
#include "model/datagram.h"
#include "model/little_endian.h"
#include "tests/host/driver/packets.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/rtl/blocks/streams_bench.h"
#include "tests/rtl/inner_register.h"
#include "tests/support/datagram_network.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

using streams::Eagerness;

constexpr std::size_t kBeatBytes = spec::kPacketBeatBytes;
constexpr std::size_t kSmallBytes = 80;  // of Vsp_datagram_cutter_small: four beats a piece, eight in the ring
constexpr int kSmallIdle = 40;           // its IdleClocks
constexpr int kLatency = 4;              // from the last beat of a piece to the first word of its datagram

// A cutter between a source of packets and a network. Each datagram that comes out must be the next one of the model.
template <typename Cutter>
class CutterBench {
 public:
  explicit CutterBench(std::size_t datagram_bytes) : datagram_bytes_(datagram_bytes) {
    for (const char* port : {"m_data_o", "m_last_o", "m_bytes_o"}) {
      cutter_.valid_when(port, [this] { return cutter_->m_valid_o != 0; });
    }
    cutter_->enable_i = 0;
    reset();
  }

  // Ends everything that is under way, on both sides.
  void reset() {
    cutter_->s_valid_i = 0;
    cutter_->m_ready_i = 0;
    cutter_.reset();
    packets_.clear();
    taken_.clear();
    due_.clear();
    arriving_.clear();
    shown_.reset();
    at_ = 0;
    ahead_ = false;
    offered_ = false;
    cutter_->enable_i = 0;
  }

  // Begins a session in the next clock. None is open.
  void begin_session(std::uint16_t number) {
    session_ = number;
    model_.emplace(number, datagram_bytes_);
    cutter_->enable_i = 1;
    cutter_->session_i = number;
    clock(0, 100);
    cutter_->session_i = static_cast<SData>(~number);
  }

  // The session goes on as if so many datagrams and packets of it had come.
  void go_on_after(std::uint32_t datagrams, std::uint32_t packets) {
    model_.emplace(session_, datagram_bytes_, datagrams, packets);
    Verilated::threadContextp(cutter_->contextp());
    InnerRegister("TOP.sp_datagram_cutter.sequence_q").set(datagrams);
    InnerRegister("TOP.sp_datagram_cutter.packet_q").set(packets);
  }

  // One clock, with inputs that come with these chances in percent. Returns whether a word left.
  bool clock(int in, int out) {
    offered_ = offered_ || (!packets_.empty() && in > 0 && (in == 100 || random_.chance(in)));
    cutter_->s_valid_i = offered_;
    if (offered_) {
      const Bytes& packet = packets_.front();
      Word128 beat{};
      for (std::size_t i = 0; i < beat.size(); ++i) {
        beat[i] = load_little_endian<std::uint32_t>(packet.data() + at_ + 4 * i);
      }
      set128(cutter_->s_data_i, beat);
      cutter_->s_last_i = at_ + kBeatBytes == packet.size();
    }
    cutter_->m_ready_i = out == 100 || random_.chance(out);
    cutter_.settle();
    EXPECT_TRUE(cutter_->m_valid_o || arriving_.empty()) << "a gap within a datagram, clock " << cutter_.clock();
    const bool left = cutter_->m_valid_o && cutter_->m_ready_i;
    if (cutter_->m_valid_o) {
      see_word(left);
    }
    took_ = offered_ && cutter_->s_ready_o;
    if (took_) {
      offered_ = false;
      at_ += kBeatBytes;
      if (at_ == packets_.front().size()) {
        taken_.push_back(packets_.front());
        packets_.pop_front();
        at_ = 0;
      }
    }
    cutter_.rise();
    return left;
  }

  // Clocks until everything has left and the silence is due once more.
  void drain() {
    for (int i = 0; i < 1000000 && (!packets_.empty() || !taken_.empty() || !due_.empty() || !arriving_.empty()); ++i) {
      clock(100, 100);
    }
    EXPECT_TRUE(taken_.empty() && due_.empty());
  }

  Cutter* operator->() { return cutter_.operator->(); }
  void queue(Bytes packet) { packets_.push_back(std::move(packet)); }
  void set_seed(std::uint64_t seed) { random_ = Random(seed); }
  [[nodiscard]] bool took() const { return took_; }       // a beat, in the last clock
  [[nodiscard]] bool inside() const { return at_ != 0; }  // a packet has begun to come
  [[nodiscard]] std::size_t waiting() const { return packets_.size(); }
  [[nodiscard]] std::int64_t now() const { return cutter_.clock(); }
  [[nodiscard]] const std::vector<Bytes>& datagrams() const { return datagrams_; }

 private:
  void see_word(bool left) {
    const std::uint32_t word = cutter_->m_data_o;
    const std::uint32_t bytes = cutter_->m_bytes_o;
    if (shown_) {
      EXPECT_EQ(word, *shown_) << "a word that waits has changed";
    }
    shown_ = left ? std::nullopt : std::optional(word);
    EXPECT_EQ(cutter_->m_last_o != 0, arriving_.size() + 4 == bytes);
    if (!left) {
      return;
    }
    arriving_.resize(arriving_.size() + 4);
    store_little_endian(arriving_.data() + arriving_.size() - 4, word);
    if (cutter_->m_last_o) {
      judge();
      datagrams_.push_back(arriving_);
      arriving_.clear();
    }
  }

  void judge() {
    const auto keep = [this](std::span<const std::uint8_t> one) { due_.emplace_back(one.begin(), one.end()); };
    const std::optional<DatagramHeader> header = read_datagram_header(arriving_);
    ASSERT_TRUE(header.has_value());
    if (header->length == 0) {
      ASSERT_TRUE(due_.empty()) << "silence within a packet";
      model_->idle(keep);
    } else if (due_.empty()) {
      // A piece may leave before the end of its packet has come.
      ASSERT_TRUE(!taken_.empty() || inside());
      const Bytes& packet = taken_.empty() ? packets_.front() : taken_.front();
      model_->packet(packet, keep);
      ahead_ = taken_.empty();
      if (!ahead_) {
        taken_.pop_front();
      }
    }
    ASSERT_EQ(arriving_, due_.front());
    due_.pop_front();
    if (ahead_ && !taken_.empty()) {
      taken_.pop_front();
      ahead_ = false;
    }
    ASSERT_FALSE(ahead_ && due_.empty()) << "the end of a packet before it has come";
  }

  std::size_t datagram_bytes_;
  std::uint16_t session_ = 0;
  Clocked<Cutter> cutter_;
  Random random_{1};
  std::optional<DatagramCutter> model_;
  std::deque<Bytes> packets_;  // to come
  std::size_t at_ = 0;         // bytes of the first of them that have come
  std::deque<Bytes> taken_;    // have come, and no datagram of theirs has left
  std::deque<Bytes> due_;      // datagrams of the packet that leaves
  bool ahead_ = false;         // its end has not come yet
  bool offered_ = false;
  bool took_ = false;
  Bytes arriving_;
  std::optional<std::uint32_t> shown_;
  std::vector<Bytes> datagrams_;
};

Bytes random_packet(Random& random, int most_beats) {
  return random.bytes(kBeatBytes * static_cast<std::size_t>(random.between(1, most_beats)));
}

// Sessions of random packets with stalls on both sides, and times without packets.
template <typename Cutter>
void expect_equals_model(std::size_t datagram_bytes, int most_beats, int cases) {
  for (const std::uint64_t seed : seeds(cases)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    CutterBench<Cutter> bench(datagram_bytes);
    bench.set_seed(seed);
    for (int session = 0; session < 4; ++session) {
      bench.begin_session(static_cast<std::uint16_t>(random.bits()));
      Eagerness eagerness;
      for (int i = 0; i < 1500; ++i) {
        eagerness.maybe_change(random);
        if (bench.waiting() < 3 && random.chance(10)) {
          bench.queue(random_packet(random, most_beats));
        }
        // Within a packet a short end is none.
        bench->enable_i = !bench.inside() || random.chance(90);
        bench.clock(eagerness.in, eagerness.out);
        ASSERT_FALSE(::testing::Test::HasFailure()) << "clock " << bench.now();
      }
      // The packet that has begun comes to its end, and no other begins.
      bench->enable_i = 0;
      while (bench.inside()) {
        bench.clock(100, 50);
      }
      bench.clock(0, 50);
      bench.queue(random_packet(random, most_beats));
      for (int i = 0; i < 20; ++i) {
        bench.clock(100, 50);
        ASSERT_FALSE(bench.took());
      }
      for (int i = 0; i < 8000; ++i) {
        bench.clock(0, 100);
      }
      ASSERT_FALSE(::testing::Test::HasFailure()) << "clock " << bench.now();
    }
    bench.begin_session(0);
    bench.drain();
    EXPECT_GT(bench.datagrams().size(), 12U);
  }
}
TEST(DatagramCutter, SessionsOfRandomPackets) { expect_equals_model<Vsp_datagram_cutter_small>(kSmallBytes, 14, 12); }
TEST(DatagramCutter, SessionsOfLongPackets) { expect_equals_model<Vsp_datagram_cutter>(kDatagramBytes, 250, 3); }
TEST(DatagramCutter, SessionsInJumboFrames) {
  expect_equals_model<Vsp_datagram_cutter_jumbo>(kJumboDatagramBytes, 1029, 2);
}

// The longest packets that a header can tell of, in the shortest datagrams and in the longest.
template <typename Cutter>
void expect_longest_packets(std::size_t datagram_bytes) {
  CutterBench<Cutter> bench(datagram_bytes);
  bench.begin_session(5);
  Random random(1);
  std::size_t pieces = 0;
  for (const std::size_t beats : {4095U, 4094U, 2048U, 4095U, 1U}) {
    bench.queue(random.bytes(kBeatBytes * beats));
    pieces += datagrams_of(kBeatBytes * beats, datagram_piece(datagram_bytes));
  }
  bench.drain();
  ASSERT_FALSE(::testing::Test::HasFailure());
  EXPECT_GE(bench.datagrams().size(), pieces);
}
TEST(DatagramCutter, TheLongestPackets) { expect_longest_packets<Vsp_datagram_cutter_small>(kSmallBytes); }
TEST(DatagramCutter, TheLongestDatagrams) { expect_longest_packets<Vsp_datagram_cutter_largest>(65535); }

// Days later: the numbers of datagrams and of packets carry and wrap.
TEST(DatagramCutter, NumbersCarryAndWrapInALongSession) {
  Random random(1);
  for (const std::uint32_t place : {0U, 0x8000'0000U, 0x0100'0000U, 0x5A5A'0000U}) {
    SCOPED_TRACE(place);
    CutterBench<Vsp_datagram_cutter_small> bench(kSmallBytes);
    bench.begin_session(static_cast<std::uint16_t>(random.bits()));
    bench.clock(0, 100);
    bench.go_on_after(place - 20, place - 6);
    bench.clock(0, 100);
    for (int packet = 0; packet < 12; ++packet) {
      bench.queue(random_packet(random, 14));
    }
    bench.drain();
    for (int i = 0; i < 10 * kSmallIdle; ++i) {
      bench.clock(0, 100);
    }
    ASSERT_FALSE(::testing::Test::HasFailure());
    const std::optional<DatagramHeader> last = read_datagram_header(bench.datagrams().back());
    ASSERT_TRUE(last);
    EXPECT_EQ(last->packet, place + 6);
    EXPECT_LT(last->sequence - place, 60U) << "beyond the carry";
  }
}

// The clocks at the head of the module.
TEST(DatagramCutter, LatencyAndNoGapBetweenDatagrams) {
  CutterBench<Vsp_datagram_cutter> bench(kDatagramBytes);
  bench.begin_session(7);
  const std::size_t beats = 5 * 91 + 3;  // five whole pieces, and a short one
  bench.queue(Random(1).bytes(beats * kBeatBytes));
  std::vector<std::int64_t> taken;
  std::vector<std::int64_t> left;
  while (left.size() < (beats + 6) * 4) {
    const std::int64_t now = bench.now();
    if (bench.clock(100, 100)) {
      left.push_back(now);
    }
    if (bench.took()) {
      taken.push_back(now);
    }
    ASSERT_LT(now, 10000);
  }
  EXPECT_EQ(taken[91] - taken[0], 92) << "a piece takes one clock more than it has beats";
  EXPECT_EQ(left.front() - taken[90], kLatency);
  EXPECT_EQ(left.back() - left.front() + 1, static_cast<std::int64_t>(left.size()));
}

// A datagram without a piece after each IdleClocks, and only while a session is open.
TEST(DatagramCutter, SilenceIsTold) {
  CutterBench<Vsp_datagram_cutter_small> bench(kSmallBytes);
  const auto ends = [&](int clocks) {
    std::vector<std::int64_t> found;
    for (int i = 0; i < clocks; ++i) {
      const std::size_t before = bench.datagrams().size();
      bench.clock(100, 100);
      if (bench.datagrams().size() > before) {
        found.push_back(bench.now());
      }
    }
    return found;
  };
  EXPECT_TRUE(ends(5 * kSmallIdle).empty());
  bench.begin_session(1);
  bench.queue(Bytes(80));
  std::vector<std::int64_t> found = ends(5 * kSmallIdle);
  ASSERT_EQ(found.size(), 2U + 4U);
  for (std::size_t i = 3; i < found.size(); ++i) {
    EXPECT_EQ(found[i] - found[i - 1], kSmallIdle + 1);  // one clock to write the datagram
  }
  bench->enable_i = 0;
  ends(10);
  EXPECT_TRUE(ends(5 * kSmallIdle).empty());
  // The time before a session does not count.
  bench.begin_session(2);
  const std::int64_t begins = bench.now();
  found = ends(2 * kSmallIdle);
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found.front() - begins, kSmallIdle + kLatency + 3);  // its last of four words
}

// A silence that is due while the ring is full goes into it as soon as there is room.
TEST(DatagramCutter, SilenceWaitsForRoom) {
  CutterBench<Vsp_datagram_cutter_small> bench(kSmallBytes);
  bench.begin_session(4);
  bench.queue(Bytes(4 * kBeatBytes));
  bench.queue(Bytes(2 * kBeatBytes));
  for (int i = 0; i < 3 * kSmallIdle; ++i) {
    bench.clock(100, 0);
  }
  ASSERT_EQ(bench.waiting(), 0U);
  for (int word = 0; word < 4 * (5 + 3 + 1); ++word) {
    EXPECT_TRUE(bench.clock(0, 100)) << word;
  }
  EXPECT_EQ(bench.datagrams().size(), 3U);
}

TEST(DatagramCutter, OffersADatagramThoughNobodyIsReady) {
  CutterBench<Vsp_datagram_cutter_small> bench(kSmallBytes);
  bench.begin_session(3);
  bench.queue(Bytes(kBeatBytes));
  for (int i = 0; i < kLatency; ++i) {
    EXPECT_FALSE(bench->m_valid_o) << i;
    bench.clock(100, 0);
  }
  EXPECT_TRUE(bench->m_valid_o);
}

// A reset at any moment of source and cutter together: nothing of before comes after it.
TEST(DatagramCutter, ResetWithinAPacket) {
  for (const std::uint64_t seed : seeds(20)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    CutterBench<Vsp_datagram_cutter_small> bench(kSmallBytes);
    for (int session = 0; session < 6; ++session) {
      bench.begin_session(static_cast<std::uint16_t>(session));
      bench.queue(random_packet(random, 14));
      for (int clocks = random.between(1, 70); clocks > 0; --clocks) {
        bench.clock(80, 80);
      }
      bench.reset();
    }
    bench.begin_session(9);
    bench.queue(random_packet(random, 14));
    bench.drain();
    ASSERT_FALSE(::testing::Test::HasFailure());
  }
}

// The host's driver reads what the circuit sent over a network with faults: each packet is delivered or counted.
TEST(DatagramCutter, DriverDeliversOrCounts) {
  for (const std::uint64_t seed : seeds(4)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    constexpr std::uint64_t kPackets = 150;
    CutterBench<Vsp_datagram_cutter> bench(kDatagramBytes);
    bench.begin_session(static_cast<std::uint16_t>(seed));
    for (std::uint64_t i = 0; i < kPackets; ++i) {
      bench.queue(moments_packet(i, i % 3 == 0 ? 16 : 512));
    }
    bench.drain();
    for (int i = 0; i < 5000; ++i) {
      bench.clock(0, 100);
    }
    const int percent = seed == 1 ? 0 : 2;
    std::vector<Bytes> sent = bench.datagrams();
    const Bytes last = sent.back();  // a datagram is known as lost only if a later one comes
    sent.pop_back();
    Network network(sent, {.dropped = percent, .doubled = percent, .reordered = percent, .cut = percent}, random);
    network.datagrams.push_back(last);
    Counters counters;
    DatagramAssembler assembler(counters);
    PacketView packet;
    std::uint64_t delivered = 0;
    const auto take_all = [&] {
      while (assembler.next(packet)) {
        EXPECT_TRUE(is_intact(packet));
        ++delivered;
      }
    };
    for (const Bytes& datagram : network.datagrams) {
      do {
        take_all();
      } while (!assembler.add(datagram));
    }
    assembler.flush();
    take_all();
    EXPECT_EQ(delivered + counters.lost_network, kPackets);
    EXPECT_EQ(counters.bad, 0U);
    EXPECT_EQ(counters.datagrams_lost, network.dropped + network.cut);
    EXPECT_EQ(counters.datagrams_doubled, network.doubled);
    EXPECT_EQ(counters.lost_network > 0, percent > 0);
  }
}

}  // namespace
}  // namespace selfproj::test
