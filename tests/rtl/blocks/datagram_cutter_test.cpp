// Tests the cutter of packets into datagrams: against its model, through sessions, silence and resets, and, over a bad
// network, with the host's driver.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "Vsp_datagram_cutter_jumbo_ports.h"
#include "Vsp_datagram_cutter_largest_ports.h"
#include "Vsp_datagram_cutter_ports.h"
#include "Vsp_datagram_cutter_small_ports.h"
#include "host/driver/datagram_assembler.h"
#include "model/datagram.h"
#include "tests/host/driver/packets.h"
#include "tests/rtl/blocks/datagram_cutter_bench.h"
#include "tests/rtl/blocks/streams_bench.h"
#include "tests/support/datagram_network.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

using streams::Eagerness;

// Sessions of random packets with stalls on both sides, and times without packets.
template <typename Cutter>
void expect_equals_model(std::size_t datagram_bytes, int max_beats, int cases) {
  for_cases(cases, [&](Random& random, std::uint64_t seed) {
    CutterBench<Cutter> bench(datagram_bytes);
    bench.set_seed(seed);
    for (int session = 0; session < 4; ++session) {
      bench.begin_session(static_cast<std::uint16_t>(random.bits()));
      Eagerness eagerness;
      for (int i = 0; i < 1500; ++i) {
        eagerness.maybe_change(random);
        if (bench.waiting() < 3 && random.chance(10)) {
          bench.queue(random_packet(random, max_beats));
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
      bench.queue(random_packet(random, max_beats));
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
  });
}
TEST(DatagramCutter, SessionsOfRandomPackets) { expect_equals_model<Vsp_datagram_cutter_small>(kSmallBytes, 14, 12); }
TEST(DatagramCutter, SessionsOfLongPackets) { expect_equals_model<Vsp_datagram_cutter>(model::kDatagramBytes, 250, 3); }
TEST(DatagramCutter, SessionsInJumboFrames) {
  expect_equals_model<Vsp_datagram_cutter_jumbo>(model::kJumboDatagramBytes, 1029, 2);
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
    pieces += model::datagrams_of(kBeatBytes * beats, model::datagram_piece(datagram_bytes));
  }
  bench.drain();
  ASSERT_FALSE(::testing::Test::HasFailure());
  EXPECT_GE(bench.datagrams().size(), pieces);
}
TEST(DatagramCutter, TheLongestPackets) { expect_longest_packets<Vsp_datagram_cutter_small>(kSmallBytes); }
TEST(DatagramCutter, TheLongestDatagrams) { expect_longest_packets<Vsp_datagram_cutter_largest>(65535); }

// The clocks at the head of the module.
TEST(DatagramCutter, LatencyAndNoGapBetweenDatagrams) {
  CutterBench<Vsp_datagram_cutter> bench(model::kDatagramBytes);
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
  EXPECT_EQ(left.front() - taken[90], kCutterLatency);
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
  EXPECT_EQ(found.front() - begins, kSmallIdle + kCutterLatency + 3);  // its last of four words
}

// Datagrams and packets are counted from 0 in a session of thousands, too, and from 0 again in the next one.
TEST(DatagramCutter, NumbersOfALongSession) {
  constexpr std::uint32_t kPackets = 4500;
  CutterBench<Vsp_datagram_cutter_small> bench(kSmallBytes);
  Random random(1);
  for (const std::uint16_t session : {std::uint16_t{1}, std::uint16_t{2}}) {
    bench.begin_session(session);
    for (std::uint32_t packet = 0; packet < kPackets; ++packet) {
      bench.queue(random_packet(random, packet % 100 == 0 ? 14 : 1));
    }
    bench.drain();
    ASSERT_FALSE(::testing::Test::HasFailure());
    const std::optional<model::DatagramHeader> last = model::read_datagram_header(bench.datagrams().back());
    ASSERT_TRUE(last);
    EXPECT_EQ(last->packet, kPackets - 1);
    EXPECT_GE(last->sequence, last->packet);
    bench->enable_i = 0;
    for (int i = 0; i < 2 * kSmallIdle; ++i) {
      bench.clock(0, 100);
    }
  }
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
  for (int i = 0; i < kCutterLatency; ++i) {
    EXPECT_FALSE(bench->m_valid_o) << i;
    bench.clock(100, 0);
  }
  EXPECT_TRUE(bench->m_valid_o);
}

// A reset at any moment of source and cutter together: nothing of before comes after it.
TEST(DatagramCutter, ResetWithinAPacket) {
  for_cases(20, [&](Random& random) {
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
  });
}

// The host's driver reads what the circuit sent over a network with faults: each packet is delivered or counted.
TEST(DatagramCutter, DriverDeliversOrCounts) {
  for_cases(4, [&](Random& random, std::uint64_t seed) {
    constexpr std::uint64_t kPackets = 150;
    CutterBench<Vsp_datagram_cutter> bench(model::kDatagramBytes);
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
    driver::Counters counters;
    driver::DatagramAssembler assembler(counters);
    model::PacketView packet;
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
  });
}

}  // namespace
}  // namespace selfproj::test
