// Tests reading and writing parts of whole packets.
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <vector>

#include "model/packet.h"
#include "tests/support/random_cases.h"
#include "tests/unit/packets.h"

namespace selfproj::test {
namespace {

// A stamped packet equals one that was built with the stamp.
TEST(Packet, StampsAndHeadersAreWrittenAnew) {
  for (Bytes packet : packets_of_all_kinds(24)) {
    PacketView view;
    ASSERT_EQ(parse_packet(packet, view), PacketError::none);
    PacketHeader header = view.header;
    header.sequence = 0x0102030405060708;
    header.time_stamp = 0x1112131415161718;
    header.encoder = 0x21222324;
    header.lost = 0x31;
    Bytes want;
    append_packet(header, view.payload, view.status, want);
    Bytes got = packet;
    stamp_packet(
        got,
        {.sequence = header.sequence, .time_stamp = header.time_stamp, .encoder = header.encoder, .lost = header.lost});
    EXPECT_EQ(got, want);

    header.sequence = view.header.sequence;  // the trailer's sequence stays
    header.threshold = 9;
    want.clear();
    append_packet(header, view.payload, view.status, want);
    got = packet;
    replace_header(got, header);
    EXPECT_EQ(got, want);
    replace_header(got, header, spec::kHash + 1);
    EXPECT_EQ(verdict(got), PacketError::hash);
    EXPECT_EQ(check_word(got), plain_check_word(got));
  }
  Bytes short_one(packet_bytes(0) - spec::kPacketBeatBytes);
  EXPECT_THROW(stamp_packet(short_one, {}), std::invalid_argument);
  EXPECT_THROW(replace_header(short_one, {}), std::invalid_argument);
  EXPECT_THROW(payload_of(short_one), std::invalid_argument);
}

TEST(Packet, WholeAndItsParts) {
  for (const Bytes& packet : packets_of_all_kinds(24)) {
    Bytes stream(11, std::uint8_t{'S'});
    stream.insert(stream.end(), packet.begin(), packet.end());
    const std::span<const std::uint8_t> all(stream);
    EXPECT_EQ(find_packet_start(all, 0), 11U);
    EXPECT_EQ(find_packet_start(all, 11), 11U);
    EXPECT_EQ(find_packet_start(all.first(11 + 3), 10), 11U) << "the beginning of a magic number counts";
    EXPECT_EQ(find_packet_start(all.first(9), 9), 9U);
    EXPECT_EQ(find_packet_start(all.first(9), 3), 8U);
    EXPECT_FALSE(begins_like_packet(all.subspan(10)));
    EXPECT_TRUE(begins_like_packet(all.subspan(11)));
    EXPECT_TRUE(begins_like_packet({}));

    EXPECT_EQ(announced_packet_bytes(all.subspan(11)), packet.size());
    EXPECT_EQ(announced_packet_bytes(all.subspan(11, spec::kHeaderBytes)), packet.size());
    EXPECT_EQ(announced_packet_bytes(all.subspan(11, spec::kHeaderBytes - 1)), std::nullopt);

    PacketView view;
    ASSERT_EQ(parse_packet(all.subspan(11), view), PacketError::none);
    EXPECT_EQ(view.bytes().data(), stream.data() + 11);
    EXPECT_EQ(view.bytes().size(), packet.size());
    const auto payload = payload_of(view.bytes());
    EXPECT_EQ(payload.data(), view.payload.data());
    EXPECT_EQ(payload.size(), view.payload.size());
    EXPECT_EQ(packet_bytes(payload.size()), packet.size());
  }
}

TEST(Packet, FrameIsSequenceAndTime) {
  const PacketHeader header = header_of(spec::kKindMoments, Mode::grey, 8);
  PacketHeader other = header;
  other.kind = spec::kKindImage;
  EXPECT_TRUE(header.same_frame(other));
  ++other.sequence;
  EXPECT_FALSE(header.same_frame(other));
  other = header;
  ++other.time_stamp;
  EXPECT_FALSE(header.same_frame(other));
}

}  // namespace
}  // namespace selfproj::test
