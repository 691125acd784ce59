// Tests packets in datagrams: lost, doubled, reordered, cut and foreign ones, and boards that go and come back.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "host/driver/clock.h"
#include "host/driver/datagram_assembler.h"
#include "host/driver/udp_socket.h"
#include "host/files/file_descriptor.h"
#include "model/datagram.h"
#include "selfproj/driver/device.h"
#include "selfproj/files/user_error.h"
#include "sim/board/udp_sender.h"
#include "tests/host/driver/datagram_accounts.h"
#include "tests/host/driver/packets.h"
#include "tests/support/datagram_network.h"
#include "tests/support/error_of.h"
#include "tests/support/network_board.h"

namespace selfproj::test {
namespace {

using std::chrono::milliseconds;

// The datagrams of packets first..first + count - 1, which are of different sizes, and of the idle sender at the end.
std::vector<Bytes> cut_up(model::DatagramCutter& cutter, std::uint64_t first, int count) {
  std::vector<Bytes> datagrams;
  const auto keep = [&](std::span<const std::uint8_t> datagram) {
    datagrams.emplace_back(datagram.begin(), datagram.end());
  };
  for (int i = 0; i < count; ++i) {
    const std::uint64_t sequence = first + static_cast<std::uint64_t>(i);
    cutter.packet(moments_packet(sequence, sequence % 3 == 0 ? 16 : 512), keep);
  }
  for (int i = 0; i < 3; ++i) {
    cutter.idle(keep);
  }
  return datagrams;
}

// Gives the datagrams to the assembler, and two silences. All packets given must be intact, in order, and given once.
std::vector<std::uint64_t> assemble(driver::DatagramAssembler& assembler, const std::vector<Bytes>& datagrams) {
  std::vector<std::uint64_t> sequences;
  model::PacketView packet;
  const auto drain = [&] {
    while (assembler.next(packet)) {
      EXPECT_TRUE(is_intact(packet));
      EXPECT_TRUE(sequences.empty() || packet.header.sequence > sequences.back());
      sequences.push_back(packet.header.sequence);
    }
  };
  for (const Bytes& datagram : datagrams) {
    do {
      drain();
    } while (!assembler.add(datagram));
  }
  drain();
  for (int silence = 0; silence < 2; ++silence) {
    assembler.flush();
    drain();
  }
  return sequences;
}

TEST(Datagrams, GoodNetwork) {
  for (const std::size_t size : {model::kDatagramBytes, model::kJumboDatagramBytes}) {
    driver::Counters counters;
    driver::DatagramAssembler assembler(counters);
    model::DatagramCutter cutter(7, size);
    EXPECT_EQ(assemble(assembler, cut_up(cutter, 0, 300)).size(), 300U);
    EXPECT_EQ(counters, driver::Counters{});
  }
}

TEST(Datagrams, TheLargestPacket) {
  for (const std::size_t size : {model::kDatagramBytes, model::kJumboDatagramBytes}) {
    driver::Counters counters;
    driver::DatagramAssembler assembler(counters);
    model::DatagramCutter cutter(7, size);
    std::vector<Bytes> datagrams;
    cutter.packet(largest_packet(5), [&](std::span<const std::uint8_t> datagram) {
      datagrams.emplace_back(datagram.begin(), datagram.end());
    });
    EXPECT_EQ(assemble(assembler, datagrams), std::vector<std::uint64_t>{5});
    EXPECT_EQ(counters, driver::Counters{});
  }
}

TEST(Datagrams, DeliveredAndCountedIsSent) {
  for (const std::uint64_t seed : seeds(12)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const int kind = static_cast<int>(seed % 6);
    const Faults faults{.dropped = kind == 0 || kind > 3 ? 1 : 0,
                        .doubled = kind == 1 || kind > 3 ? 1 : 0,
                        .reordered = kind == 2 || kind > 3 ? (kind == 5 ? 20 : 1) : 0,
                        .cut = kind == 3 || kind > 3 ? 1 : 0};
    model::DatagramCutter cutter(static_cast<std::uint16_t>(seed));
    const std::vector<Bytes> sent = cut_up(cutter, 0, 400);
    const Network network(sent, faults, random);
    driver::Counters counters;
    driver::DatagramAssembler assembler(counters);
    const std::vector<std::uint64_t> got = assemble(assembler, network.datagrams);
    EXPECT_EQ(got.size() + counters.lost_network, 400U);
    EXPECT_EQ(counters.bad, 0U);
    EXPECT_EQ(counters.datagrams_refused, network.cut);
    EXPECT_EQ(counters.datagrams_lost, network.dropped + network.cut);
    EXPECT_EQ(counters.datagrams_doubled, network.doubled);
    EXPECT_EQ(counters.datagrams_reordered > 0, faults.reordered > 0);
    EXPECT_EQ(counters.lost_network > 0, network.dropped + network.cut > 0);
  }
}

TEST(Datagrams, NumbersWrapAndAReaderComesLate) {
  driver::Counters counters;
  driver::DatagramAssembler assembler(counters);
  model::DatagramCutter cutter(9);
  std::vector<Bytes> sent = cut_up(cutter, 0, 20);
  for (Bytes& datagram : sent) {  // as after 2^32 - 9 packets
    model::DatagramHeader header = *model::read_datagram_header(datagram);
    header.sequence -= 20;
    header.packet -= 9;
    model::write_datagram_header(header, datagram.data());
  }
  sent.erase(sent.begin() + 1, sent.begin() + 3);  // begins in packet 1, which has three pieces
  sent.erase(sent.begin());
  EXPECT_EQ(assemble(assembler, sent).size(), 18U);
  EXPECT_EQ(counters.lost_network + counters.datagrams_lost, 0U);
  EXPECT_EQ(counters.bytes_discarded, sent.front().size() - spec::kDatagramHeaderBytes);
}

// No silence and no burst of losses is needed to stay in step: at each wrap and half-wrap of either number.
TEST(Datagrams, WrapsAndHalfWraps) {
  constexpr std::uint32_t kHalf = std::uint32_t{1} << 31U;
  for (const std::uint32_t packets : {0U, kHalf, kHalf + kHalf}) {
    for (const std::uint32_t datagrams : {0U, kHalf, kHalf + kHalf}) {
      expect_all_accounted(datagrams - 20'000, packets - 10'000, 40'000);
    }
  }
}

// So many that each number passes both from every start.
TEST(Datagrams, WrapsAndHalfWrapsForLong) {
  constexpr std::uint32_t kHalf = std::uint32_t{1} << 31U;
  constexpr std::uint32_t kBefore = std::uint32_t{1} << 21U;
  for (const std::uint32_t start : {0U, kHalf - kBefore, kHalf + kHalf - kBefore}) {
    expect_all_accounted(start, start, std::uint64_t{1} << 22U);
    expect_all_accounted(start - 12345, start, std::uint64_t{1} << 22U);
  }
}

// What a false datagram says of its place.
struct False {
  std::uint16_t session = 0;
  std::uint32_t sequence = 0;
  std::uint32_t packet = 0;
};

// One false datagram, or two alike, anywhere in a stream: nothing of the stream is lost, except where there is too
// little to tell the false from the true.
TEST(Datagrams, AFalseDatagramChangesNothing) {
  constexpr std::uint32_t kHalf = std::uint32_t{1} << 31U;
  const std::vector<False> kinds = {{.packet = kHalf - 1},
                                    {.packet = kHalf},
                                    {.packet = 1'000'000},
                                    {.packet = 200},
                                    {.sequence = kHalf - 1},
                                    {.sequence = kHalf},
                                    {.sequence = 100'000},
                                    {.sequence = 0U - 100'000},
                                    {.session = 1},
                                    {.session = 0xFFFFU},
                                    {.sequence = 5'000'000, .packet = 3'000'000}};
  for (const False& kind : kinds) {
    for (const std::uint64_t first : {std::uint64_t{0}, std::uint64_t{100'000}}) {
      for (const std::size_t place : {std::size_t{0}, std::size_t{7}, std::size_t{300}, std::size_t{590}}) {
        for (const std::size_t count : {std::size_t{1}, std::size_t{2}}) {
          SCOPED_TRACE(testing::Message()
                       << "session +" << kind.session << ", datagram +" << kind.sequence << ", packet +" << kind.packet
                       << ", from " << first << ", at " << place << ", " << count << " times");
          model::DatagramCutter cutter(7, model::kDatagramBytes, static_cast<std::uint32_t>(2 * first),
                                       static_cast<std::uint32_t>(first));
          std::vector<Bytes> all = cut_up(cutter, 0, 300);
          model::DatagramHeader header = *model::read_datagram_header(all[place]);
          header.session = static_cast<std::uint16_t>(header.session + kind.session);
          header.sequence += kind.sequence;
          header.packet += kind.packet;
          Bytes wrong = all[place];
          model::write_datagram_header(header, wrong.data());
          wrong.back() ^= 1U;  // it is no packet of the board
          all.insert(all.begin() + static_cast<std::ptrdiff_t>(place), count, wrong);
          driver::Counters counters;
          driver::DatagramAssembler assembler(counters);
          const std::vector<std::uint64_t> got = assemble(assembler, all);
          EXPECT_EQ(got.size(), 300U);
          EXPECT_EQ(counters.lost_network, 0U);
          EXPECT_LE(counters.datagrams_refused + counters.datagrams_doubled, count);
        }
      }
    }
  }
}

// A stream of false datagrams is followed, for it looks like a sender that was restarted. Afterwards the receiver
// returns to the true stream; what that sent meanwhile is counted.
TEST(Datagrams, AMisledReceiverReturns) {
  constexpr std::uint32_t kHalf = std::uint32_t{1} << 31U;
  for (const False& kind : {False{.sequence = kHalf - 1000, .packet = kHalf - 1000}, False{.session = 9},
                            False{.session = 9, .sequence = 90, .packet = 1'000'000}}) {
    model::DatagramCutter cutter(7, model::kDatagramBytes, 200'000, 100'000);
    std::vector<Bytes> all = cut_up(cutter, 0, 600);
    std::vector<Bytes> wrong(all.begin() + 400, all.begin() + 440);
    for (Bytes& datagram : wrong) {
      model::DatagramHeader header = *model::read_datagram_header(datagram);
      header.session = static_cast<std::uint16_t>(header.session + kind.session);
      header.sequence += kind.sequence;
      header.packet += kind.packet;
      header.offset = header.offset == 0 && header.length != 0 ? 1024 : header.offset;  // never whole
      model::write_datagram_header(header, datagram.data());
    }
    all.insert(all.begin() + 500, wrong.begin(), wrong.end());
    driver::Counters counters;
    driver::DatagramAssembler assembler(counters);
    const std::vector<std::uint64_t> got = assemble(assembler, all);
    EXPECT_GE(got.size(), 598U);
    EXPECT_EQ(got.back(), 599U);
    EXPECT_LE(counters.lost_network, 40U);  // of the false stream, too
  }
}

// The network was away: for any time, in one session or over the start of the next one.
TEST(Datagrams, Interruptions) {
  for (const std::uint32_t away : {70U, 1'300U, 1'000'000U, 1'000'000'000U}) {
    model::DatagramCutter before(7, model::kDatagramBytes, 40'000, 20'000);
    std::vector<Bytes> all = cut_up(before, 0, 300);
    model::DatagramCutter after(7, model::kDatagramBytes, before.datagrams() + 2 * away, 20'300 + away);
    std::vector<Bytes> more = cut_up(after, 300, 300);
    std::rotate(more.begin(), more.begin() + 1, more.begin() + 3);  // the first one comes as the third
    all.insert(all.end(), more.begin(), more.end());
    driver::Counters counters;
    driver::DatagramAssembler assembler(counters);
    EXPECT_EQ(assemble(assembler, all).size(), 600U);
    EXPECT_EQ(counters.lost_network, away);
    EXPECT_EQ(counters.datagrams_lost, 2 * std::uint64_t{away});
  }
  for (const std::size_t lost : {std::size_t{3}, std::size_t{900}, std::size_t{1'500}, std::size_t{2'500}}) {
    model::DatagramCutter first(7);
    std::vector<Bytes> all = cut_up(first, 0, 10);
    model::DatagramCutter second(8);
    const std::vector<Bytes> more = cut_up(second, 100, 1'500);
    all.insert(all.end(), more.begin() + static_cast<std::ptrdiff_t>(lost), more.end());
    driver::Counters counters;
    driver::DatagramAssembler assembler(counters);
    EXPECT_EQ(assemble(assembler, all).size() + counters.lost_network, 1'510U) << lost;
    EXPECT_EQ(counters.datagrams_lost, lost);
  }
}

// A sender that was restarted can draw the session that it had.
TEST(Datagrams, ARestartInTheSameSession) {
  model::DatagramCutter first(7, model::kDatagramBytes, 200'000, 100'000);
  std::vector<Bytes> all = cut_up(first, 0, 100);
  model::DatagramCutter second(7);
  const std::vector<Bytes> more = cut_up(second, 1'000, 500);
  all.insert(all.end(), more.begin(), more.end());
  driver::Counters counters;
  driver::DatagramAssembler assembler(counters);
  EXPECT_EQ(assemble(assembler, all).size() + counters.lost_network, 600U);
  EXPECT_EQ(counters.reattached, 1U);
  EXPECT_LE(counters.lost_network, 64U);
}

// A sender draws its sessions: each can be above or below those before it.
TEST(Datagrams, RestartsInSessionsOfAnyNumber) {
  std::vector<Bytes> all;
  std::uint64_t packets = 0;
  for (const int session : {500, 20, 300, 4, 0xFFFF, 301}) {
    model::DatagramCutter cutter(static_cast<std::uint16_t>(session));
    const std::vector<Bytes> more = cut_up(cutter, packets, 10);
    all.insert(all.end(), more.begin(), more.end());
    packets += 10;
  }
  driver::Counters counters;
  driver::DatagramAssembler assembler(counters);
  EXPECT_EQ(assemble(assembler, all).size(), packets);
  EXPECT_EQ(counters, (driver::Counters{.reattached = 5}));
}

// A frame of Ethernet can be too short for the header alone.
TEST(Datagrams, WithoutAPieceTheyMayBeFilledUp) {
  Bytes idle;
  model::DatagramCutter(1).idle(
      [&](std::span<const std::uint8_t> datagram) { idle.assign(datagram.begin(), datagram.end()); });
  for (const std::size_t filling : {std::size_t{0}, std::size_t{4}, std::size_t{16}, std::size_t{17}}) {
    Bytes datagram = idle;
    datagram.resize(idle.size() + filling);
    EXPECT_EQ(model::read_datagram_header(datagram).has_value(), filling <= 16) << filling;
  }
}

TEST(Datagrams, NewSessionAndALateOneOfTheOld) {
  driver::Counters counters;
  driver::DatagramAssembler assembler(counters);
  model::DatagramCutter first(1);
  std::vector<Bytes> all = cut_up(first, 0, 9);
  all.resize(all.size() - 4);  // it was cut off in its last packet
  const Bytes late = all.back();
  model::DatagramCutter second(2);
  const std::vector<Bytes> more = cut_up(second, 100, 10);
  all.insert(all.end(), more.begin(), more.end());
  all.insert(all.end() - 5, late);
  const std::vector<std::uint64_t> got = assemble(assembler, all);
  EXPECT_EQ(got.size() + counters.lost_network, 19U);
  EXPECT_EQ(counters.lost_network, 1U);
  EXPECT_EQ(got.back(), 109U);
  EXPECT_EQ(counters.reattached, 1U);
  EXPECT_EQ(counters.datagrams_refused, 1U);
}

// The datagrams of each packet, all of the same size.
std::vector<std::vector<Bytes>> cut_alike(model::DatagramCutter& cutter, std::uint64_t first, int count, int columns) {
  std::vector<std::vector<Bytes>> packets(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < packets.size(); ++i) {
    cutter.packet(moments_packet(first + i, columns), [&](std::span<const std::uint8_t> datagram) {
      packets[i].emplace_back(datagram.begin(), datagram.end());
    });
  }
  return packets;
}

std::vector<Bytes> joined(const std::vector<std::vector<Bytes>>& packets) {
  std::vector<Bytes> all;
  for (const std::vector<Bytes>& packet : packets) {
    all.insert(all.end(), packet.begin(), packet.end());
  }
  return all;
}

// A packet that is overtaken by as many as are in assembly beside it is given in its place; by one more, it is lost.
TEST(Datagrams, OvertakenByPackets) {
  for (const std::size_t by : {driver::DatagramAssembler::kPackets - 1, driver::DatagramAssembler::kPackets}) {
    model::DatagramCutter cutter(7);
    std::vector<Bytes> all = joined(cut_alike(cutter, 0, 200, 16));
    std::rotate(all.begin() + 50, all.begin() + 51, all.begin() + 51 + static_cast<std::ptrdiff_t>(by));
    driver::Counters counters;
    driver::DatagramAssembler assembler(counters);
    const std::size_t lost = by == driver::DatagramAssembler::kPackets ? 1 : 0;
    EXPECT_EQ(assemble(assembler, all).size(), 200 - lost);
    EXPECT_EQ(counters, (driver::Counters{.lost_network = lost, .datagrams_reordered = 1})) << by;
  }
}

// What is whole but wrong is bad, and not lost; what begins like no packet is refused.
TEST(Datagrams, WholeButWrong) {
  model::DatagramCutter cutter(7);
  std::vector<Bytes> all;
  const auto keep = [&](std::span<const std::uint8_t> datagram) { all.emplace_back(datagram.begin(), datagram.end()); };
  cutter.packet(moments_packet(0), keep);
  Bytes packet = moments_packet(1);
  packet.back() ^= 1U;
  cutter.packet(packet, keep);
  model::replace_header(packet, moments_header(1), spec::kHash ^ 1U);
  cutter.packet(packet, keep);
  packet = moments_packet(1);
  packet.resize(packet.size() + spec::kPacketBeatBytes);  // more than it announces
  cutter.packet(packet, keep);
  cutter.packet(moments_packet(2), keep);
  Bytes less = all.back();
  model::DatagramHeader header = *model::read_datagram_header(less);
  header.length = spec::kHeaderBytes - spec::kPacketBeatBytes;
  model::write_datagram_header(header, less.data());
  less.resize(spec::kDatagramHeaderBytes + header.length);
  all.push_back(less);
  Bytes far = all.front();
  header = *model::read_datagram_header(far);
  header.offset = static_cast<std::uint16_t>(model::kLargestPacketBytes - header.length + spec::kPacketBeatBytes);
  model::write_datagram_header(header, far.data());
  all.push_back(far);
  cutter.packet(moments_packet(3), keep);
  driver::Counters counters;
  driver::DatagramAssembler assembler(counters);
  EXPECT_EQ(assemble(assembler, all), (std::vector<std::uint64_t>{0, 2, 3}));
  EXPECT_EQ(counters, (driver::Counters{.bad = 3, .other_spec = 1, .datagrams_refused = 2}));
}

// Without its first piece a packet is lost, whatever a packet before it has left in its place.
TEST(Datagrams, WithoutTheFirstPiece) {
  model::DatagramCutter cutter(7);
  std::vector<Bytes> all = joined(cut_alike(cutter, 0, static_cast<int>(driver::DatagramAssembler::kPackets), 16));
  std::vector<std::vector<Bytes>> large = cut_alike(cutter, driver::DatagramAssembler::kPackets, 3, 512);
  large[0].erase(large[0].begin());
  const std::vector<Bytes> more = joined(large);
  all.insert(all.end(), more.begin(), more.end());
  driver::Counters counters;
  driver::DatagramAssembler assembler(counters);
  EXPECT_EQ(assemble(assembler, all).size(), driver::DatagramAssembler::kPackets + 2);
  EXPECT_EQ(counters, (driver::Counters{.lost_network = 1, .datagrams_lost = 1}));
}

// The last packet before a pause did not come at all; the idle sender says that it was sent.
TEST(Datagrams, TheLastPacketIsMissed) {
  model::DatagramCutter cutter(7);
  std::vector<Bytes> all = joined(cut_alike(cutter, 0, 5, 512));
  all.resize(all.size() - 3);
  cutter.idle([&](std::span<const std::uint8_t> datagram) { all.emplace_back(datagram.begin(), datagram.end()); });
  driver::Counters counters;
  driver::DatagramAssembler assembler(counters);
  EXPECT_EQ(assemble(assembler, all).size(), 4U);
  EXPECT_EQ(counters, (driver::Counters{.lost_network = 1, .datagrams_lost = 3}));
}

// A stream that never rests tells its loss all the same.
TEST(Datagrams, AnInterruptionIsCountedWithoutASilence) {
  model::DatagramCutter before(7);
  std::vector<Bytes> all = joined(cut_alike(before, 0, 100, 16));
  model::DatagramCutter after(7, model::kDatagramBytes, 5'100, 5'100);
  const std::vector<Bytes> more = joined(cut_alike(after, 5'100, 1'100, 16));
  all.insert(all.end(), more.begin(), more.end());
  driver::Counters counters;
  driver::DatagramAssembler assembler(counters);
  model::PacketView packet;
  std::uint64_t given = 0;
  for (const Bytes& datagram : all) {
    do {
      while (assembler.next(packet)) {
        ++given;
      }
    } while (!assembler.add(datagram));
  }
  EXPECT_EQ(given, 1'199U);
  EXPECT_EQ(counters, (driver::Counters{.lost_network = 5'000, .datagrams_lost = 5'000}));
}

// A first piece has at least the header of its packet, and may have no more.
TEST(Datagrams, PiecesAsLongAsAHeader) {
  driver::Counters counters;
  driver::DatagramAssembler assembler(counters);
  model::DatagramCutter cutter(7, spec::kDatagramHeaderBytes + spec::kHeaderBytes);
  EXPECT_EQ(assemble(assembler, joined(cut_alike(cutter, 0, 20, 16))).size(), 20U);
  EXPECT_EQ(counters, driver::Counters{});
}

// A reader that comes among the first datagrams has missed those before; one that comes later begins where it is.
TEST(Datagrams, TheFirstSessionIsTakenFromItsBeginning) {
  for (const int begin : {1, 1'023, 1'024}) {
    model::DatagramCutter cutter(7);
    const std::vector<Bytes> all = joined(cut_alike(cutter, 0, 1'100, 16));
    driver::Counters counters;
    driver::DatagramAssembler assembler(counters);
    EXPECT_EQ(assemble(assembler, {all.begin() + begin, all.end()}).size(), static_cast<std::size_t>(1'100 - begin));
    const std::uint64_t missing = begin < 1'024 ? static_cast<std::uint64_t>(begin) : 0;
    EXPECT_EQ(counters, (driver::Counters{.lost_network = missing, .datagrams_lost = missing})) << begin;
  }
}

// The beginning of a session that began while the receiver listened is not forgotten: all that is missing was lost.
TEST(Datagrams, TheBeginningOfASessionIsMissed) {
  for (const int lost : {0, 1, 62, 63, 64, 65, 1'023, 1'024, 1'025}) {
    model::DatagramCutter first(7);
    std::vector<Bytes> all = joined(cut_alike(first, 0, 10, 16));
    model::DatagramCutter second(8);
    const std::vector<Bytes> more = joined(cut_alike(second, 10, 1'100, 16));
    all.insert(all.end(), more.begin() + lost, more.end());
    driver::Counters counters;
    driver::DatagramAssembler assembler(counters);
    const auto missing = static_cast<std::uint64_t>(lost);
    EXPECT_EQ(assemble(assembler, all).size(), 1'110 - missing) << lost;
    EXPECT_EQ(counters, (driver::Counters{.reattached = 1, .lost_network = missing, .datagrams_lost = missing}))
        << lost;
  }
}

// Of the sessions before, each can go on; what is missing since then was lost.
TEST(Datagrams, EarlierSessionsGoOn) {
  std::vector<model::DatagramCutter> cutters;
  for (std::uint16_t session = 1; session <= 5; ++session) {
    cutters.emplace_back(session, model::kDatagramBytes, 5'000'000U * session, 3'000'000U * session);
  }
  driver::Counters counters;
  driver::DatagramAssembler assembler(counters);
  std::uint64_t sequence = 0;
  std::uint64_t missing = 0;
  for (const std::size_t which : {0U, 1U, 2U, 3U, 4U, 0U, 2U, 3U, 4U}) {
    if (sequence >= 50) {  // it was there before
      static_cast<void>(cut_alike(cutters[which], 0, 5, 16));
      missing += 5;
    }
    EXPECT_EQ(assemble(assembler, joined(cut_alike(cutters[which], sequence, 10, 16))).size(), 10U);
    sequence += 10;
    EXPECT_EQ(counters.lost_network, missing) << sequence;
    EXPECT_EQ(counters.datagrams_lost, missing) << sequence;
  }
  EXPECT_EQ(counters.reattached, 8U);
  EXPECT_EQ(counters.datagrams_refused + counters.bad, 0U);
}

// Old datagrams of the session do not lead it back, unless they are more than any network delays.
TEST(Datagrams, OldDatagramsOfTheSession) {
  for (const std::size_t count : {std::size_t{3}, std::size_t{63}}) {
    model::DatagramCutter old(7, model::kDatagramBytes, 1'000, 1'000);
    const std::vector<Bytes> late = joined(cut_alike(old, 0, static_cast<int>(count), 16));
    model::DatagramCutter cutter(7, model::kDatagramBytes, 200'000, 100'000);
    std::vector<Bytes> all = joined(cut_alike(cutter, 0, 100, 16));
    all.insert(all.begin() + 50, late.begin(), late.end());
    driver::Counters counters;
    driver::DatagramAssembler assembler(counters);
    EXPECT_EQ(assemble(assembler, all).size(), 100U);
    EXPECT_EQ(counters, (driver::Counters{.datagrams_refused = count}));
  }
}

// Bytes of any kind neither break it nor become a packet.
TEST(Datagrams, RandomBytes) {
  for (const std::uint64_t seed : seeds(4)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    driver::Counters counters;
    driver::DatagramAssembler assembler(counters);
    model::DatagramCutter cutter(3);
    std::vector<Bytes> all = cut_up(cutter, 0, 100);
    for (Bytes& datagram : all) {
      for (int flips = random.between(0, 3); flips > 0; --flips) {
        const int most =
            random.chance(80) ? static_cast<int>(spec::kDatagramHeaderBytes) : static_cast<int>(datagram.size());
        datagram[static_cast<std::size_t>(random.between(2, most - 1))] ^=
            static_cast<std::uint8_t>(random.between(1, 255));
      }
      if (random.chance(5)) {
        datagram = random.bytes(static_cast<std::size_t>(random.between(0, 3000)));
      }
    }
    model::PacketView packet;
    for (const Bytes& datagram : all) {
      int steps = 0;
      do {
        while (assembler.next(packet)) {
          EXPECT_TRUE(is_intact(packet));
        }
        ASSERT_LT(++steps, 10);
      } while (!assembler.add(datagram));
    }
  }
}

// --- sockets on loopback: boards are at 127.0.0.2, the host at 127.0.0.1 ---

constexpr int kFirstPort = 20000;

class UdpDevice : public ::testing::Test {
 protected:
  void SetUp() override {
    port_ = std::to_string(kFirstPort + getpid() % kFirstPort);
    device_ = driver::open_device("udp:127.0.0.2:" + port_);
  }

  [[nodiscard]] sim::UdpSender board(const std::string& from = "127.0.0.2") const {
    return {"127.0.0.1:" + port_, from, false};
  }

  std::uint64_t read(std::uint64_t most) {
    model::PacketView packet;
    std::uint64_t count = 0;
    while (count < most && device_->next(packet, milliseconds(300)) == driver::Next::packet) {
      EXPECT_TRUE(is_intact(packet));
      device_->release();
      ++count;
    }
    return count;
  }

  std::string port_;
  std::unique_ptr<driver::Device> device_;
};

TEST_F(UdpDevice, PacketsOfOneBoardOnly) {
  sim::UdpSender sender = board();
  sim::UdpSender stranger = board("127.0.0.3");
  for (std::uint64_t i = 0; i < 50; ++i) {
    sender.send(moments_packet(i, 512));
    stranger.send(moments_packet(1000 + i, 512));
  }
  sender.finish();
  stranger.finish();
  EXPECT_EQ(read(1000), 50U);
  EXPECT_EQ(device_->counters(), (driver::Counters{.delivered = 50}));
  EXPECT_EQ(device_->uri(), "udp:127.0.0.2:" + port_);
}

TEST_F(UdpDevice, UnpluggedAndBack) {
  {
    sim::UdpSender sender = board();
    for (std::uint64_t i = 0; i < 20; ++i) {
      sender.send(moments_packet(i, 512));
    }
    EXPECT_EQ(read(20), 20U);
  }
  EXPECT_EQ(read(1), 0U);  // nothing comes, and that is no end
  sim::UdpSender sender = board();
  for (std::uint64_t i = 30; i < 50; ++i) {
    sender.send(moments_packet(i, 512));
  }
  EXPECT_EQ(read(20), 20U);
  EXPECT_EQ(device_->counters(), (driver::Counters{.delivered = 40, .missing = 10, .reattached = 1}));
}

// The socket's buffer is full: what did not fit is known, and what comes later is whole.
TEST_F(UdpDevice, ASlowReader) {
  sim::UdpSender sender = board();
  std::uint64_t sent = 0;
  for (; sent < 6000; ++sent) {
    sender.send(moments_packet(sent, 2048));
  }
  const std::uint64_t first = read(100000);
  for (std::uint64_t i = 0; i < 10; ++i) {
    sender.send(moments_packet(sent++, 512));
  }
  EXPECT_EQ(read(100), 10U);
  const driver::Counters counters = device_->counters();
  EXPECT_EQ(first + 10 + counters.lost_network, sent);
  EXPECT_EQ(counters.datagrams_overflow, counters.datagrams_lost);
  EXPECT_GT(counters.datagrams_overflow, 0U);
}

// The board sends a packet twice, in datagrams of their own.
TEST_F(UdpDevice, ARepeatedPacket) {
  sim::UdpSender sender = board();
  const std::int64_t before = driver::now_ns();
  for (const std::uint64_t sequence : {0U, 1U, 1U, 2U}) {
    sender.send(moments_packet(sequence, 512));
  }
  EXPECT_EQ(read(3), 3U);
  EXPECT_EQ(device_->counters(), (driver::Counters{.delivered = 3, .repeated = 1}));
  EXPECT_GE(device_->arrival_ns(), before);
  EXPECT_LE(device_->arrival_ns(), driver::now_ns());
}

TEST_F(UdpDevice, JumboFrames) {
  sim::UdpSender sender("127.0.0.1:" + port_, "127.0.0.2", true);
  for (std::uint64_t i = 0; i < 5; ++i) {
    sender.send(largest_packet(i));
  }
  EXPECT_EQ(read(5), 5U);
  EXPECT_EQ(device_->counters(), (driver::Counters{.delivered = 5}));
}

// A datagram that does not come costs its packet, and no other.
TEST_F(UdpDevice, ALostDatagramCostsItsPacketAlone) {
  const BoardSocket socket("127.0.0.2", static_cast<std::uint16_t>(std::stoi(port_)));
  model::DatagramCutter cutter(7);
  constexpr std::uint64_t kPackets = 100;
  std::vector<Bytes> datagrams = cut_up(cutter, 0, kPackets);
  datagrams.erase(datagrams.begin() + 41);
  const sockaddr_in host = driver::udp_address("", {.host = "127.0.0.1", .port = socket.port()});
  for (const Bytes& datagram : datagrams) {
    socket.send({host, datagram});
  }
  EXPECT_EQ(read(kPackets), kPackets - 1);
  EXPECT_EQ(device_->counters(),
            (driver::Counters{.delivered = kPackets - 1, .missing = 1, .lost_network = 1, .datagrams_lost = 1}));
}

// After a silence the packet of which a datagram did not come counts as lost, without another packet.
TEST_F(UdpDevice, IncompleteBeforeASilence) {
  const BoardSocket socket("127.0.0.2", static_cast<std::uint16_t>(std::stoi(port_)));
  model::DatagramCutter cutter(7);
  std::vector<Bytes> datagrams = cut_up(cutter, 0, 2);
  datagrams.resize(datagrams.size() - 4);  // without the last piece, and what the idle sender says
  const sockaddr_in host = driver::udp_address("", {.host = "127.0.0.1", .port = socket.port()});
  for (const Bytes& datagram : datagrams) {
    socket.send({host, datagram});
  }
  model::PacketView packet;
  EXPECT_EQ(device_->next(packet, milliseconds(300)), driver::Next::packet);
  EXPECT_EQ(device_->next(packet, milliseconds(60)), driver::Next::timeout);
  EXPECT_EQ(device_->counters(), (driver::Counters{.delivered = 1, .lost_network = 1}));
}

// A packet behind an incomplete one comes after the silence, however long the reader would wait.
TEST_F(UdpDevice, TheSilenceWakesAReaderThatSleeps) {
  const BoardSocket socket("127.0.0.2", static_cast<std::uint16_t>(std::stoi(port_)));
  const sockaddr_in host = driver::udp_address("", {.host = "127.0.0.1", .port = socket.port()});
  model::DatagramCutter cutter(7);
  for (std::uint64_t sequence = 0; sequence < 3; ++sequence) {
    bool lost = sequence == 1;  // its first datagram
    cutter.packet(moments_packet(sequence, 512), [&](std::span<const std::uint8_t> datagram) {
      if (!lost) {
        socket.send({host, Bytes(datagram.begin(), datagram.end())});
      }
      lost = false;
    });
  }
  model::PacketView packet;
  for (const std::uint64_t sequence : {0U, 2U}) {
    ASSERT_EQ(device_->next(packet, std::chrono::hours(1)), driver::Next::packet);
    EXPECT_EQ(packet.header.sequence, sequence);
    device_->release();
  }
  EXPECT_EQ(device_->counters().lost_network, 1U);
}

// It would wait for ever.
TEST_F(UdpDevice, APortThatAnotherProgramHas) {
  try {
    static_cast<void>(driver::open_device("udp:127.0.0.2:" + port_));
    FAIL();
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find("another program receives at UDP port " + port_), std::string::npos);
  }
}

TEST(UdpPlace, HostAndPort) {
  const auto place = [](const std::string& text) {
    const driver::UdpPlace found = driver::udp_place("x", text, 7);
    return found.host + " " + std::to_string(found.port);
  };
  EXPECT_EQ(place("board"), "board 7");
  EXPECT_EQ(place("127.0.0.2:1"), "127.0.0.2 1");
  EXPECT_EQ(place("board:65535"), "board 65535");
  for (const std::string text : {"board:", "board:0", "board:65536", "board:-1", "board: 5", "board:5:6"}) {
    EXPECT_EQ(error_of([&] { place(text); }), "x: '" + text.substr(6) + "' is not a port, 1 to 65535");
  }
  EXPECT_EQ(error_of([&] { place(":5"); }), "x: the name of the host is missing");
}

// For answers any port will do if another program has that of the board.
TEST(UdpPlace, ASocketOfAnyPort) {
  const BoardSocket other("127.0.0.1");
  const driver::UdpPlace place{.host = "127.0.0.2", .port = other.port()};
  const files::FileDescriptor socket(driver::open_udp_socket("x", place));
  EXPECT_GE(socket.number(), 0);
  EXPECT_NE(error_of([&] { driver::open_udp_socket("x", place, true); }).find("another program receives at UDP port"),
            std::string::npos);
}

TEST(UdpPlace, WhatIsNoPlace) {
  const auto error = [](const std::string& uri) {
    try {
      driver::open_device(uri);
    } catch (const UserError& problem) {
      return std::string(problem.what());
    }
    return std::string();
  };
  EXPECT_EQ(error("udp:"), "udp:: the name of the host is missing");
  EXPECT_EQ(error("udp:127.0.0.2:0"), "udp:127.0.0.2:0: '0' is not a port, 1 to 65535");
  EXPECT_EQ(error("udp:127.0.0.2:1x"), "udp:127.0.0.2:1x: '1x' is not a port, 1 to 65535");
  EXPECT_NE(error("udp:no.such.host.invalid").find("is not known"), std::string::npos);
}

}  // namespace
}  // namespace selfproj::test
