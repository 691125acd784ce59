// Tests what the headers say about packets that never came.
#include "host/driver/packet_tally.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <set>
#include <stdexcept>
#include <string>

#include "tests/host/driver/packets.h"

namespace selfproj::test {
namespace {

PacketHeader header_of(std::uint64_t sequence, std::uint32_t lost, int stream = 0,
                       std::uint8_t kind = spec::kKindMoments) {
  PacketHeader header = moments_header(sequence);
  header.lost = lost;
  header.stream = static_cast<std::uint8_t>(stream);
  header.kind = kind;
  return header;
}

TEST(PacketTally, NothingIsKnownBeforeTheFirst) {
  Counters counters;
  PacketTally tally(counters);
  EXPECT_TRUE(tally.accept(header_of(1000, 77)));
  EXPECT_TRUE(tally.accept(header_of(1001, 77)));
  EXPECT_EQ(counters, Counters{});
}

TEST(PacketTally, LossesAndGapsOfEachStreamAndKind) {
  Counters counters;
  PacketTally tally(counters);
  for (int stream : {0, 255}) {
    tally.accept(header_of(0, 0, stream));
    tally.accept(header_of(0, 5, stream, spec::kKindImage));
  }
  tally.accept(header_of(3, 2));  // two frames lost
  tally.accept(header_of(4, 2));
  tally.accept(header_of(7, 6, 0, spec::kKindImage));  // one line
  tally.accept(header_of(2, 0, 255));                  // one frame is missing, not on the board
  EXPECT_EQ(counters.lost_board, 3U);
  EXPECT_EQ(counters.missing, 3U);
  EXPECT_EQ(counters.restarts, 0U);
}

TEST(PacketTally, LostWraps) {
  Counters counters;
  PacketTally tally(counters);
  tally.accept(header_of(10, 0xFFFFFFFE));
  tally.accept(header_of(15, 3));
  EXPECT_EQ(counters.lost_board, 5U);
  EXPECT_EQ(counters.missing, 4U);
}

TEST(PacketTally, DoubledPacket) {
  Counters counters;
  PacketTally tally(counters);
  EXPECT_TRUE(tally.accept(header_of(10, 0)));
  EXPECT_FALSE(tally.accept(header_of(10, 0)));
  EXPECT_TRUE(tally.accept(header_of(11, 0)));
  EXPECT_EQ(counters.repeated, 1U);
  EXPECT_EQ(counters.missing, 0U);
}

TEST(PacketTally, LinesOfAFrameAreNoRepetition) {
  Counters counters;
  PacketTally tally(counters);
  PacketHeader header = header_of(10, 0, 0, spec::kKindImage);
  for (std::uint16_t line = 1; line <= 96; ++line) {
    header.first_line = line;
    EXPECT_TRUE(tally.accept(header));
  }
  EXPECT_FALSE(tally.accept(header));
  header.first_line = 50;
  EXPECT_FALSE(tally.accept(header));
  EXPECT_EQ(counters.repeated, 2U);
}

TEST(PacketTally, Restart) {
  Counters counters;
  PacketTally tally(counters);
  tally.accept(header_of(100, 9));
  tally.accept(header_of(100, 3, 0, spec::kKindImage));
  EXPECT_TRUE(tally.accept(header_of(2, 1)));  // 0 and 1 never came; one of them was lost on the board
  EXPECT_TRUE(tally.accept(header_of(2, 4, 0, spec::kKindImage)));
  EXPECT_TRUE(tally.accept(header_of(3, 1)));
  EXPECT_EQ(counters.restarts, 1U);
  EXPECT_EQ(counters.lost_board, 5U);
  EXPECT_EQ(counters.missing, 2U);
}

// The reader was away for longer than the board's first life, and the board's new sequence is ahead of the old one.
TEST(PacketTally, RestartBehindTheReadersBack) {
  Counters counters;
  PacketTally tally(counters);
  tally.accept(header_of(5, 900));
  PacketHeader header = header_of(50, 2);
  tally.accept(header);
  EXPECT_EQ(counters.restarts, 1U);
  EXPECT_EQ(counters.lost_board, 2U);
}

TEST(PacketTally, SameSequenceAtAnotherTimeIsARestart) {
  Counters counters;
  PacketTally tally(counters);
  tally.accept(header_of(0, 0));
  PacketHeader header = header_of(0, 0);
  header.time_stamp += 5;
  EXPECT_TRUE(tally.accept(header));
  EXPECT_EQ(counters.restarts, 1U);
  EXPECT_EQ(counters.repeated, 0U);
}

TEST(Counters, EachHasOneNameOfItsOwn) {
  Counters counters;
  std::set<std::string> keys;
  std::set<std::string> labels;
  for (const CounterName& name : kCounterNames) {
    ++(counters.*name.field);
    keys.insert(name.key);
    labels.insert(name.label);
    EXPECT_EQ(&name_of(name.field), &name);
  }
  EXPECT_EQ(keys.size(), kCounterNames.size());
  EXPECT_EQ(labels.size(), kCounterNames.size());
  EXPECT_EQ(counters, (Counters{1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1}));
  EXPECT_EQ(counters_text({.lost_board = 3, .missing = 4}, {&Counters::missing, &Counters::lost_board}),
            "missing frames 4, lost on the board 3");
  EXPECT_THROW(name_of(nullptr), std::invalid_argument);
}

}  // namespace
}  // namespace selfproj::test
