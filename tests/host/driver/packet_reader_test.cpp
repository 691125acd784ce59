// Finds packets in damaged streams: each fault is counted, and the frame after it is right.
#include "selfproj/driver/packet_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "selfproj/model/packet.h"
#include "tests/host/driver/packets.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

using Sequences = std::vector<std::uint64_t>;

// The results of a reader.
struct Outcome {
  driver::Counters counters;
  Sequences given;
  std::size_t bytes = 0;  // of the packets given
  bool intact = true;
};

// Feeds the stream in pieces of 1..largest_piece bytes (0: as much as there is room for).
Outcome run(const Bytes& stream, Random& random, int largest_piece = 0, std::size_t capacity = 1) {
  Outcome result;
  driver::PacketStreamReader reader(result.counters, capacity);
  model::PacketView packet;
  const auto drain = [&] {
    while (reader.next(packet)) {
      result.given.push_back(packet.header.sequence);
      result.bytes += packet.size;
      result.intact = result.intact && is_intact(packet);
    }
  };
  for (std::size_t at = 0; at < stream.size();) {
    const auto room = reader.room();
    EXPECT_FALSE(room.empty());
    std::size_t piece = std::min(room.size(), stream.size() - at);
    if (largest_piece > 0) {
      piece = std::min(piece, static_cast<std::size_t>(random.between(1, largest_piece)));
    }
    std::copy_n(stream.begin() + static_cast<std::ptrdiff_t>(at), piece, room.begin());
    reader.added(piece);
    at += piece;
    drain();
  }
  reader.finish();
  drain();
  EXPECT_EQ(reader.held(), 0U);
  return result;
}

Outcome run(const Bytes& stream) {
  Random random(1);
  return run(stream, random);
}

Sequences range(std::uint64_t first, std::uint64_t last) {
  Sequences all;
  for (std::uint64_t i = first; i <= last; ++i) {
    all.push_back(i);
  }
  return all;
}

// The counts of this reader: bad, resynchronized, bytes_discarded.
struct Counts {
  std::uint64_t bad, resynchronized, discarded;
  bool operator==(const Counts&) const = default;
};
Counts counts(const Outcome& run) {
  return {run.counters.bad, run.counters.resynchronized, run.counters.bytes_discarded};
}

TEST(PacketStreamReader, WholeStreamInPiecesOfAnySize) {
  const Bytes stream = moments_stream(0, 200);
  for (const std::uint64_t seed : seeds(20)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const Outcome result =
        run(stream, random, random.between(1, 2000), static_cast<std::size_t>(random.between(1, 100000)));
    EXPECT_EQ(result.given, range(0, 199));
    EXPECT_TRUE(result.intact);
    EXPECT_EQ(result.counters, driver::Counters{});
  }
}

TEST(PacketStreamReader, LargestPacketFits) {
  Bytes stream;
  for (std::uint64_t sequence = 0; sequence < 5; ++sequence) {
    append(stream, largest_packet(sequence));
  }
  EXPECT_EQ(stream.size(), 5 * model::kLargestPacketBytes);
  for (const int largest_piece : {0, 5000}) {  // in the second case it is there in part before it is there
    Random random(1);
    const Outcome result = run(stream, random, largest_piece);
    EXPECT_EQ(result.given, range(0, 4)) << largest_piece;
    EXPECT_TRUE(result.intact);
    EXPECT_EQ(result.counters, driver::Counters{}) << largest_piece;
  }
}

TEST(PacketStreamReader, StartInTheMiddleOfAPacket) {
  const Bytes stream = moments_stream(0, 4);
  const std::size_t size = stream.size() / 4;
  for (std::size_t cut = 1; cut <= size; ++cut) {
    const Outcome result = run(Bytes(stream.begin() + static_cast<std::ptrdiff_t>(cut), stream.end()));
    EXPECT_EQ(result.given, range(1, 3)) << cut;
    EXPECT_TRUE(result.intact);
    EXPECT_EQ(counts(result), (Counts{0, cut < size ? 1U : 0U, size - cut})) << cut;
  }
}

TEST(PacketStreamReader, CutPacket) {
  const Bytes cut = moments_packet(1);
  for (std::size_t left = 1; left < cut.size(); ++left) {
    Bytes stream = moments_packet(0);
    stream.insert(stream.end(), cut.begin(), cut.begin() + static_cast<std::ptrdiff_t>(left));
    append(stream, moments_stream(2, 3));
    const Outcome result = run(stream);
    EXPECT_EQ(result.given, (Sequences{0, 2, 3, 4})) << left;
    EXPECT_TRUE(result.intact);
    EXPECT_EQ(counts(result), (Counts{1, 1, left})) << left;
  }
}

TEST(PacketStreamReader, CutAtTheBeginning) {
  const Bytes cut = moments_packet(1);
  for (std::size_t gone = 1; gone < cut.size(); ++gone) {
    Bytes stream = moments_packet(0);
    stream.insert(stream.end(), cut.begin() + static_cast<std::ptrdiff_t>(gone), cut.end());
    append(stream, moments_stream(2, 3));
    const Outcome result = run(stream);
    EXPECT_EQ(result.given, (Sequences{0, 2, 3, 4})) << gone;
    EXPECT_EQ(counts(result), (Counts{1, 1, cut.size() - gone})) << gone;
  }
}

TEST(PacketStreamReader, ShiftedStream) {
  for (const std::uint64_t seed : seeds(20)) {
    SCOPED_TRACE(how_to_repeat(seed));
    for (std::size_t shift = 1; shift <= 64; ++shift) {
      Bytes stream = moments_stream(0, 2);
      append(stream, Random(seed * 1000 + shift).bytes(shift));
      append(stream, moments_stream(2, 2));
      const Outcome result = run(stream);
      EXPECT_EQ(result.given, range(0, 3)) << shift;
      EXPECT_TRUE(result.intact);
      EXPECT_EQ(counts(result), (Counts{1, 1, shift})) << shift;
    }
  }
}

TEST(PacketStreamReader, AnyFlippedBit) {
  const Bytes before = moments_packet(0);
  const Bytes packet = moments_packet(1);
  for (std::size_t bit = 0; bit < 8 * packet.size(); ++bit) {
    Bytes stream = before;
    append(stream, packet);
    stream[before.size() + bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    append(stream, moments_stream(2, 2));
    const Outcome result = run(stream);
    ASSERT_EQ(result.given, (Sequences{0, 2, 3})) << "bit " << bit;
    ASSERT_EQ(counts(result), (Counts{1, 1, packet.size()})) << "bit " << bit;
  }
}

TEST(PacketStreamReader, AnyDamagedPayloadLength) {
  const Bytes before = moments_packet(0);
  for (const std::uint32_t size : {0U, 1U, 16U, 112U, 144U, 4096U, 16384U, 16400U, 0x7FFFFFFFU, 0xFFFFFFFFU}) {
    Bytes stream = before;
    Bytes damaged = moments_packet(1);
    model::PacketHeader header = moments_header(1);
    header.payload_size = size;
    model::replace_header(damaged, header);
    append(stream, damaged);
    append(stream, moments_stream(2, 2));
    const Outcome result = run(stream);
    EXPECT_EQ(result.given, (Sequences{0, 2, 3})) << size;
    EXPECT_EQ(counts(result), (Counts{1, 1, before.size()})) << size;
  }
}

// The format allows many lines in one packet, but no board sends them. A damaged number of lines must not make the
// reader wait for megabytes.
TEST(PacketStreamReader, PacketThatNoBoardSends) {
  model::PacketHeader header = moments_header(1, 2048);
  header.kind = spec::kKindImage;
  header.first_line = 1;
  header.lines = 96;
  Bytes large;
  model::append_packet(header, Bytes(std::size_t{96} * 2048), 0, large);
  Bytes stream = moments_packet(0);
  stream.insert(stream.end(), large.begin(), large.begin() + 64);
  append(stream, moments_packet(2));
  driver::Counters counters;
  driver::PacketStreamReader reader(counters);
  std::copy(stream.begin(), stream.end(), reader.room().begin());
  reader.added(stream.size());
  model::PacketView packet;
  ASSERT_TRUE(reader.next(packet));
  ASSERT_TRUE(reader.next(packet)) << "waits for more bytes";
  EXPECT_EQ(packet.header.sequence, 2U);
  EXPECT_EQ(counters.bad, 1U);
}

TEST(PacketStreamReader, WholePacketInsideADamagedOne) {
  // A payload that is itself a packet must not be given while the packet around it is good ...
  const Bytes inner = moments_packet(7, 4);
  model::PacketHeader header = moments_header(1, 16);
  Bytes payload(model::moments_payload_bytes(model::Mode::grey_over, 16));
  ASSERT_LE(inner.size(), payload.size());
  std::copy(inner.begin(), inner.end(), payload.begin());
  Bytes outer;
  model::append_packet(header, payload, 0, outer);
  Bytes stream = moments_packet(0);
  append(stream, outer);
  append(stream, moments_packet(2));
  EXPECT_EQ(run(stream).given, (Sequences{0, 1, 2}));
}

TEST(PacketStreamReader, AnotherSpecification) {
  Bytes stream = moments_packet(0);
  Bytes other = moments_packet(1);
  model::replace_header(other, moments_header(1), spec::kHash ^ 0x55);
  append(stream, other);
  append(stream, moments_packet(2));
  model::replace_header(other, moments_header(1), spec::kHash, spec::kVersion + 1);
  append(stream, other);
  append(stream, moments_packet(3));
  const Outcome result = run(stream);
  EXPECT_EQ(result.given, (Sequences{0, 2, 3}));
  EXPECT_EQ(result.counters.other_spec, 2U);
  EXPECT_EQ(result.counters.bad, 2U);
}

TEST(PacketStreamReader, RestartDiscardsWhatWasBegun) {
  driver::Counters counters;
  driver::PacketStreamReader reader(counters);
  const Bytes packet = moments_packet(0);
  std::copy_n(packet.begin(), 100, reader.room().begin());
  reader.added(100);
  model::PacketView view;
  EXPECT_FALSE(reader.next(view));
  reader.restart();
  std::copy(packet.begin(), packet.end(), reader.room().begin());
  reader.added(packet.size());
  ASSERT_TRUE(reader.next(view));
  EXPECT_TRUE(is_intact(view));
  EXPECT_EQ(counters.bytes_discarded, 100U);
  EXPECT_EQ(counters.resynchronized, 1U);
}

void feed(driver::PacketStreamReader& reader, const Bytes& bytes) {
  std::copy(bytes.begin(), bytes.end(), reader.room().begin());
  reader.added(bytes.size());
}

// A restart with nothing begun discards nothing, and forgets neither what was discarded before nor that bytes may come.
TEST(PacketStreamReader, RestartAtAPacketsEnd) {
  driver::Counters counters;
  driver::PacketStreamReader reader(counters);
  model::PacketView view;
  feed(reader, moments_packet(0));
  ASSERT_TRUE(reader.next(view));
  reader.restart();
  feed(reader, moments_packet(1));
  ASSERT_TRUE(reader.next(view));
  EXPECT_EQ(counters, driver::Counters{});
  feed(reader, Bytes(7));
  ASSERT_FALSE(reader.next(view));
  reader.restart();
  feed(reader, moments_packet(2));
  ASSERT_TRUE(reader.next(view));
  EXPECT_EQ(counters, (driver::Counters{.bad = 1, .resynchronized = 1, .bytes_discarded = 7}));
}

// A stream that had ended and begins anew waits for the rest of a packet again.
TEST(PacketStreamReader, RestartAfterTheEnd) {
  driver::Counters counters;
  driver::PacketStreamReader reader(counters);
  model::PacketView view;
  reader.finish();
  reader.restart();
  const Bytes packet = moments_packet(0);
  feed(reader, Bytes(packet.begin(), packet.begin() + 100));
  EXPECT_FALSE(reader.next(view));
  EXPECT_EQ(reader.held(), 100U);
  feed(reader, Bytes(packet.begin() + 100, packet.end()));
  EXPECT_TRUE(reader.next(view));
  EXPECT_EQ(counters, driver::Counters{});
}

// Units of zeros behind a good packet count nowhere, also where the stream ends; other zeros are bytes like any.
TEST(PacketStreamReader, ZerosThatFillUp) {
  driver::Counters counters;
  driver::PacketStreamReader reader(counters, 1, 16);
  model::PacketView view;
  feed(reader, Bytes(32));
  feed(reader, moments_packet(0));
  feed(reader, Bytes(16));
  ASSERT_TRUE(reader.next(view));
  EXPECT_EQ(counters, (driver::Counters{.resynchronized = 1, .bytes_discarded = 32})) << "before the first packet";
  ASSERT_FALSE(reader.next(view));
  EXPECT_EQ(reader.held(), 0U);
  feed(reader, Bytes(48));
  feed(reader, moments_packet(1));
  ASSERT_TRUE(reader.next(view));
  EXPECT_EQ(counters.bytes_discarded, 32U);
  Bytes other = Bytes(16);
  other.back() = 1;
  feed(reader, other);
  EXPECT_FALSE(reader.next(view));
  EXPECT_EQ(counters, (driver::Counters{.bad = 1, .resynchronized = 1, .bytes_discarded = 48}));
}

// At the end a packet has begun if its whole magic number is there.
TEST(PacketStreamReader, TheEndInTheFirstBytes) {
  const Bytes packet = moments_packet(0);
  for (std::size_t left = 1; left < 6; ++left) {
    driver::Counters counters;
    driver::PacketStreamReader reader(counters);
    model::PacketView view;
    feed(reader, Bytes(packet.begin(), packet.begin() + static_cast<std::ptrdiff_t>(left)));
    EXPECT_FALSE(reader.next(view));
    EXPECT_EQ(counters, driver::Counters{}) << left;
    reader.finish();
    EXPECT_FALSE(reader.next(view));
    EXPECT_EQ(counters, (driver::Counters{.bad = left < 4 ? 0U : 1U, .bytes_discarded = left})) << left;
  }
}

TEST(PacketStreamReader, RoomForTwoOfTheLargest) {
  driver::Counters counters;
  for (const std::size_t capacity :
       {std::size_t{0}, 2 * model::kLargestPacketBytes, 2 * model::kLargestPacketBytes + 1, std::size_t{1} << 20U}) {
    driver::PacketStreamReader reader(counters, capacity);
    EXPECT_EQ(reader.room().size(), std::max(capacity, 2 * model::kLargestPacketBytes));
  }
}

// Random faults, one after another, between good frames: everything that was not touched is given, and nothing else.
TEST(PacketStreamReader, RandomFaults) {
  for (const std::uint64_t seed : seeds(200)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    Bytes stream;
    Sequences right;
    std::uint64_t faults = 0;
    for (std::uint64_t sequence = 0; sequence < 100; ++sequence) {
      Bytes packet = moments_packet(sequence, 4 * random.between(1, 12));
      if (random.chance(80)) {
        right.push_back(sequence);
      } else {
        ++faults;
        const auto at = random.between(0, static_cast<int>(packet.size()) - 1);
        switch (random.between(0, 3)) {
          case 0:
            packet[static_cast<std::size_t>(at)] ^= static_cast<std::uint8_t>(random.between(1, 255));
            break;
          case 1:
            packet.resize(static_cast<std::size_t>(at));
            break;
          case 2:
            packet.erase(packet.begin() + at);
            break;
          default:
            packet.insert(packet.begin() + at + 1, static_cast<std::uint8_t>(random.bits()));
            // A byte between the packets leaves the packet itself good.
            if (at == static_cast<int>(packet.size()) - 2) {
              right.push_back(sequence);
            }
        }
      }
      append(stream, packet);
    }
    const Outcome result = run(stream, random, random.chance(50) ? random.between(1, 500) : 0);
    EXPECT_EQ(result.given, right);
    EXPECT_TRUE(result.intact);
    EXPECT_LE(result.counters.resynchronized, faults);
    EXPECT_GE(result.counters.bad + 1, result.counters.resynchronized);
    EXPECT_EQ(result.counters.bytes_discarded, stream.size() - result.bytes);
  }
}

// Enters a stream 10^4 times at a random byte: the first thing given is always a whole frame, the next one.
TEST(PacketStreamReader, TenThousandStarts) {
  constexpr int kFrames = 50;
  const Bytes stream = moments_stream(0, kFrames);
  const std::size_t size = stream.size() / kFrames;
  driver::Counters counters;
  driver::PacketStreamReader reader(counters);
  Random random(1);
  for (int i = 0; i < 10000; ++i) {
    reader.restart();
    const auto begin = static_cast<std::size_t>(random.between(0, static_cast<int>(stream.size() - 2 * size)));
    const auto bytes = static_cast<std::size_t>(random.between(static_cast<int>(2 * size), static_cast<int>(8 * size)));
    const std::size_t end = std::min(begin + bytes, stream.size());
    std::copy(stream.begin() + static_cast<std::ptrdiff_t>(begin), stream.begin() + static_cast<std::ptrdiff_t>(end),
              reader.room().begin());
    reader.added(end - begin);
    model::PacketView packet;
    for (std::size_t expected = (begin + size - 1) / size; (expected + 1) * size <= end; ++expected) {
      ASSERT_TRUE(reader.next(packet)) << "start " << i;
      ASSERT_EQ(packet.header.sequence, expected) << "start " << i;
      ASSERT_TRUE(is_intact(packet)) << "start " << i;
    }
    ASSERT_FALSE(reader.next(packet));
  }
  EXPECT_EQ(counters.bad, 0U);
}

model::PacketHeader header_of(std::uint64_t sequence, std::uint32_t lost, int stream = 0,
                              std::uint8_t kind = spec::kKindMoments) {
  model::PacketHeader header = moments_header(sequence);
  header.lost = lost;
  header.stream = static_cast<std::uint8_t>(stream);
  header.kind = kind;
  return header;
}

TEST(PacketTally, NothingIsKnownBeforeTheFirst) {
  driver::Counters counters;
  driver::PacketTally tally(counters);
  EXPECT_TRUE(tally.accept(header_of(1000, 77)));
  EXPECT_TRUE(tally.accept(header_of(1001, 77)));
  EXPECT_EQ(counters, driver::Counters{});
}

TEST(PacketTally, LossesAndGapsOfEachStreamAndKind) {
  driver::Counters counters;
  driver::PacketTally tally(counters);
  for (int stream : {0, 255}) {
    tally.accept(header_of(0, 0, stream));
    tally.accept(header_of(0, 5, stream, spec::kKindImage));
  }
  tally.accept(header_of(3, 2));  // two frames lost
  tally.accept(header_of(4, 2));
  tally.accept(header_of(7, 6, 0, spec::kKindImage));  // one line
  tally.accept(header_of(2, 0, 255));                  // one frame is missing, not on the board
  EXPECT_EQ(counters, (driver::Counters{.lost_board = 3, .missing = 3}));
}

// The verdict alone, compact and exact columns take each other's place; stream 255 is the last one.
TEST(PacketTally, OneForAFrame) {
  driver::Counters counters;
  driver::PacketTally tally(counters);
  for (int stream : {0, 254, 255}) {
    tally.accept(header_of(0, 0, stream, spec::kKindVerdict));
    tally.accept(header_of(0, 0, stream, spec::kKindCodes));
    tally.accept(header_of(2, 1, stream, spec::kKindVerdict));  // one frame lost
    EXPECT_FALSE(tally.accept(header_of(2, 1, stream, spec::kKindVerdict)));
    tally.accept(header_of(4, 2, stream, spec::kKindCompact));  // and one
    tally.accept(header_of(6, 3, stream));                      // and one
  }
  EXPECT_EQ(counters, (driver::Counters{.lost_board = 9, .missing = 9, .repeated = 3}));
}

TEST(PacketTally, LostWraps) {
  driver::Counters counters;
  driver::PacketTally tally(counters);
  tally.accept(header_of(10, 0xFFFFFFFE));
  tally.accept(header_of(15, 3));
  EXPECT_EQ(counters, (driver::Counters{.lost_board = 5, .missing = 4}));
}

TEST(PacketTally, DoubledPacket) {
  driver::Counters counters;
  driver::PacketTally tally(counters);
  EXPECT_TRUE(tally.accept(header_of(10, 0)));
  EXPECT_FALSE(tally.accept(header_of(10, 0)));
  EXPECT_TRUE(tally.accept(header_of(11, 0)));
  EXPECT_EQ(counters, (driver::Counters{.repeated = 1}));
}

TEST(PacketTally, LinesOfAFrameAreNoRepetition) {
  driver::Counters counters;
  driver::PacketTally tally(counters);
  model::PacketHeader header = header_of(10, 0, 0, spec::kKindImage);
  for (std::uint16_t line = 1; line <= 96; ++line) {
    header.first_line = line;
    EXPECT_TRUE(tally.accept(header));
  }
  EXPECT_FALSE(tally.accept(header));
  header.first_line = 50;
  EXPECT_FALSE(tally.accept(header));
  EXPECT_EQ(counters, (driver::Counters{.repeated = 2}));
}

TEST(PacketTally, Restart) {
  driver::Counters counters;
  driver::PacketTally tally(counters);
  tally.accept(header_of(100, 9));
  tally.accept(header_of(100, 3, 0, spec::kKindImage));
  EXPECT_TRUE(tally.accept(header_of(2, 1)));  // 0 and 1 never came; one of them was lost on the board
  EXPECT_TRUE(tally.accept(header_of(2, 4, 0, spec::kKindImage)));
  EXPECT_TRUE(tally.accept(header_of(3, 1)));
  EXPECT_EQ(counters, (driver::Counters{.lost_board = 5, .missing = 2, .restarts = 1}));
}

// The reader was away for longer than the board's first life, and the board's new sequence is ahead of the old one.
TEST(PacketTally, RestartBehindTheReadersBack) {
  driver::Counters counters;
  driver::PacketTally tally(counters);
  tally.accept(header_of(5, 900));
  model::PacketHeader header = header_of(50, 2);
  tally.accept(header);
  EXPECT_EQ(counters.restarts, 1U);
  EXPECT_EQ(counters.lost_board, 2U);
}

TEST(PacketTally, SameSequenceAtAnotherTimeIsARestart) {
  driver::Counters counters;
  driver::PacketTally tally(counters);
  tally.accept(header_of(0, 0));
  model::PacketHeader header = header_of(0, 0);
  header.time_stamp += 5;
  EXPECT_TRUE(tally.accept(header));
  EXPECT_EQ(counters, (driver::Counters{.restarts = 1}));
}

// The clock goes back although the sequence goes on.
TEST(PacketTally, TheClockGoesBack) {
  driver::Counters counters;
  driver::PacketTally tally(counters);
  tally.accept(header_of(5, 3));
  model::PacketHeader header = header_of(9, 4);
  header.time_stamp = header_of(5, 3).time_stamp - 1;
  EXPECT_TRUE(tally.accept(header));
  EXPECT_EQ(counters, (driver::Counters{.lost_board = 4, .missing = 9, .restarts = 1}));
}

TEST(PacketTally, ARestartOfOneStreamIsNoneOfTheOthers) {
  driver::Counters counters;
  driver::PacketTally tally(counters);
  tally.accept(header_of(100, 9));
  tally.accept(header_of(100, 9, 1));
  tally.accept(header_of(0, 0));
  EXPECT_TRUE(tally.accept(header_of(103, 10, 1)));
  EXPECT_EQ(counters, (driver::Counters{.lost_board = 1, .missing = 2, .restarts = 1}));
}

// A count that is less than half of its 32 bits ahead has gone on; sequences have 64 bits.
TEST(PacketTally, TheLongestLossAndTheLongestGap) {
  for (const bool too_far : {false, true}) {
    driver::Counters counters;
    driver::PacketTally tally(counters);
    const std::uint32_t lost = 0x7FFF'FFFFU + (too_far ? 1U : 0U);
    tally.accept(header_of(1, 0));
    tally.accept(header_of((std::uint64_t{1} << 33U) + 2, lost));
    const std::uint64_t missing = (std::uint64_t{1} << 33U) + (too_far ? 2 : 0);
    EXPECT_EQ(counters, (driver::Counters{.lost_board = lost, .missing = missing, .restarts = too_far ? 1U : 0U}));
  }
}

// Lines of a raw image and of codes go their own ways, and so do their losses.
TEST(PacketTally, CodesAndImagesAreKindsOfTheirOwn) {
  driver::Counters counters;
  driver::PacketTally tally(counters);
  for (const std::uint8_t kind : {spec::kKindImage, spec::kKindCodes}) {
    model::PacketHeader header = header_of(10, kind, 0, kind);
    header.first_line = 5;
    EXPECT_TRUE(tally.accept(header));
    EXPECT_FALSE(tally.accept(header));
  }
  EXPECT_EQ(counters, (driver::Counters{.repeated = 2}));
}

// Of each stream and kind, the first packet of a new writer is none that has come before; the next one can be.
TEST(PacketTally, ANewWriterMayBeginWithAnything) {
  driver::Counters counters;
  driver::PacketTally tally(counters);
  const std::vector<model::PacketHeader> headers = {header_of(10, 0), header_of(10, 0, 255),
                                                    header_of(10, 0, 254, spec::kKindImage)};
  for (const model::PacketHeader& header : headers) {
    tally.accept(header);
  }
  tally.accept(header_of(10, 0, 7));
  tally.begin_anew();
  EXPECT_TRUE(tally.accept(header_of(11, 0, 7)));
  EXPECT_FALSE(tally.accept(header_of(11, 0, 7)));
  EXPECT_TRUE(tally.accept(headers[0]));
  EXPECT_FALSE(tally.accept(headers[0]));
  EXPECT_TRUE(tally.accept(headers[1]));
  EXPECT_TRUE(tally.accept(headers[2]));
  EXPECT_FALSE(tally.accept(headers[2]));
  EXPECT_EQ(counters, (driver::Counters{.missing = 20, .repeated = 3, .restarts = 3}));
}

TEST(PacketTally, EveryStatusIsAFlag) {
  driver::Counters counters;
  driver::PacketTally tally(counters);
  std::uint64_t sequence = 0;
  for (const std::uint32_t status : {0U, 1U, 2U, 16U, 0x8000'0000U}) {
    EXPECT_TRUE(tally.deliver({header_of(sequence++, 0), {}, status, 0}));
  }
  EXPECT_FALSE(tally.deliver({header_of(4, 0), {}, 1, 0}));
  EXPECT_EQ(counters, (driver::Counters{.delivered = 5, .flagged = 4, .repeated = 1}));
}

TEST(Counters, EachHasOneNameOfItsOwn) {
  driver::Counters counters;
  std::set<std::string> keys;
  std::set<std::string> labels;
  for (const driver::CounterName& name : driver::kCounterNames) {
    ++(counters.*name.field);
    keys.insert(name.key);
    labels.insert(name.label);
    EXPECT_EQ(&driver::name_of(name.field), &name);
  }
  EXPECT_EQ(keys.size(), driver::kCounterNames.size());
  EXPECT_EQ(labels.size(), driver::kCounterNames.size());
  EXPECT_EQ(counters, (driver::Counters{1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1}));
  EXPECT_EQ(driver::counters_text({.lost_board = 3, .missing = 4},
                                  {&driver::Counters::missing, &driver::Counters::lost_board}),
            "missing frames 4, lost on the board 3");
  EXPECT_THROW(driver::name_of(nullptr), std::invalid_argument);
}

}  // namespace
}  // namespace selfproj::test
