// Tests which packets the scoreboard accepts and which it does not.
#include "sim/board/packet_scoreboard.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "selfproj/model/packet.h"

namespace selfproj::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint8_t kMoments = spec::kKindMoments;
constexpr std::uint8_t kCodes = spec::kKindCodes;
constexpr std::uint8_t kImage = spec::kKindImage;

// A packet of 8 columns with 32 bytes of payload, as the model gives it, and as a board sends it after losing `lost`.
model::BoardPacket expected(std::uint64_t sequence, std::uint8_t kind = kMoments, std::uint32_t status = 0) {
  model::BoardPacket packet;
  packet.header.kind = kind;
  packet.header.columns = kind == kMoments ? 8 : kind == kCodes ? 16 : 32;
  packet.header.rows = 4;
  packet.header.payload_size = 32;
  packet.header.first_line = 1;
  packet.header.lines = 1;
  packet.header.sequence = sequence;
  packet.payload.assign(32, 3);
  packet.status = status;
  return packet;
}
Bytes sent(const model::BoardPacket& packet, std::uint32_t lost) {
  model::PacketHeader header = packet.header;
  header.lost = lost;
  Bytes bytes;
  model::append_packet(header, packet.payload, packet.status, bytes);
  return bytes;
}
Bytes sent(std::uint64_t sequence, std::uint32_t lost) { return sent(expected(sequence), lost); }

sim::PacketScoreboard expecting(std::uint64_t count) {
  sim::PacketScoreboard scoreboard;
  for (std::uint64_t sequence = 0; sequence < count; ++sequence) {
    scoreboard.expect(expected(sequence));
  }
  return scoreboard;
}

TEST(PacketScoreboard, FindsEveryChangedByte) {
  const Bytes right = sent(0, 0);
  EXPECT_TRUE(expecting(1).compare(right));
  for (std::size_t i = 0; i < right.size(); ++i) {
    Bytes wrong = right;
    wrong[i] ^= 1U;
    EXPECT_FALSE(expecting(1).compare(wrong)) << "byte " << i;
  }
  Bytes longer = right;
  longer.push_back(0);
  EXPECT_FALSE(expecting(1).compare(longer));
  EXPECT_FALSE(expecting(1).compare({}));
}

TEST(PacketScoreboard, RefusesARightPacketThatIsNotTheModels) {
  model::BoardPacket other = expected(0);
  other.header.encoder = 1;
  sim::PacketScoreboard scoreboard = expecting(1);
  EXPECT_FALSE(scoreboard.compare(sent(other, 0)));
  EXPECT_NE(scoreboard.first_mismatch().find("frame 1"), std::string::npos);
  EXPECT_FALSE(scoreboard.compare(sent(5, 0)));
  EXPECT_NE(scoreboard.first_mismatch().find("frame 1"), std::string::npos) << "the first one is kept";
  EXPECT_EQ(scoreboard.mismatches(), 2U);
  EXPECT_EQ(scoreboard.matched(), 0U);
}

TEST(PacketScoreboard, CountsWhatIsMissing) {
  sim::PacketScoreboard scoreboard = expecting(4);
  EXPECT_TRUE(scoreboard.compare(sent(1, 1)));
  EXPECT_FALSE(scoreboard.compare(sent(2, 0)));  // lost, and not counted
  EXPECT_FALSE(scoreboard.compare(sent(2, 1)));  // once more
  scoreboard.finish();
  EXPECT_EQ(scoreboard.matched(), 1U);
  EXPECT_EQ(scoreboard.matched_columns(), 8U);
  EXPECT_EQ(scoreboard.matched_bytes(), sent(1, 1).size());
  EXPECT_EQ(scoreboard.mismatches(), 2U);
  EXPECT_EQ(scoreboard.lost(), 2U);
  EXPECT_EQ(scoreboard.of(kMoments).lost, 2U);
  EXPECT_EQ(scoreboard.lost_in_all(kMoments), 2U);
}

TEST(PacketScoreboard, CountsEachKindByItself) {
  sim::PacketScoreboard scoreboard;
  scoreboard.lost_before(kImage, 0xFFFFFFFF);  // its counter is about to wrap
  for (std::uint64_t sequence = 0; sequence < 3; ++sequence) {
    for (const std::uint8_t kind : {kMoments, kCodes, kImage}) {
      scoreboard.expect(expected(sequence, kind, sequence == 2 ? spec::kStatusLongLine : 0));
    }
  }
  EXPECT_TRUE(scoreboard.compare(sent(expected(0, kImage), 0xFFFFFFFF)));
  EXPECT_TRUE(scoreboard.compare(sent(expected(1, kMoments), 1)));
  EXPECT_TRUE(scoreboard.compare(sent(expected(1, kCodes), 1)));
  EXPECT_TRUE(scoreboard.compare(sent(expected(2, kImage, spec::kStatusLongLine), 0))) << scoreboard.first_mismatch();
  scoreboard.finish();
  EXPECT_EQ(scoreboard.mismatches(), 0U);
  EXPECT_EQ(scoreboard.matched(), 4U);
  EXPECT_EQ(scoreboard.lost(), 5U);
  EXPECT_EQ(scoreboard.of(kMoments).lost, 2U);
  EXPECT_EQ(scoreboard.of(kCodes).lost, 2U);
  EXPECT_EQ(scoreboard.of(kImage).lost, 1U);
  EXPECT_EQ(scoreboard.lost_in_all(kImage), 0U);
  EXPECT_EQ(scoreboard.of(kImage).matched, 2U);
  EXPECT_EQ(scoreboard.of(kImage).last_header.sequence, 2U);
  EXPECT_EQ(scoreboard.of(kImage).last_status, spec::kStatusLongLine);
  EXPECT_EQ(scoreboard.matched_codes(), 16U);
  EXPECT_EQ(scoreboard.by_status().at(0), 3U);
  EXPECT_EQ(scoreboard.by_status().at(spec::kStatusLongLine), 1U);
}

}  // namespace
}  // namespace selfproj::test
