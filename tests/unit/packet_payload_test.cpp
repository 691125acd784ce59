// Tests payloads: words have their fields at the right bits, in both directions.
#include "selfproj/model/packet_payload.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <vector>

#include "selfproj/model/packet.h"
#include "tests/support/random_cases.h"
#include "tests/unit/packets.h"

namespace selfproj::test {
namespace {

TEST(PayloadWords, Sizes) {
  EXPECT_EQ(model::moments_payload_bytes(model::Mode::binary, 512), 2048U);
  EXPECT_EQ(model::moments_payload_bytes(model::Mode::grey, 512), 4096U);
  EXPECT_EQ(model::moments_payload_bytes(model::Mode::grey_over, 4), 32U);
  EXPECT_EQ(model::moments_payload_bytes(model::Mode::binary, 5), 32U);
  EXPECT_EQ(model::image_line_payload_bytes(512), 512U);
  EXPECT_EQ(model::image_line_payload_bytes(4), 16U);
  EXPECT_EQ(model::image_line_payload_bytes(20), 32U);
  EXPECT_EQ(model::codes_line_payload_bytes(512), 1024U);
  EXPECT_EQ(model::codes_line_payload_bytes(12), 32U);
  EXPECT_EQ(model::moments_payload_bytes(model::Mode::binary, 0), 0U);
  EXPECT_THROW(model::moments_payload_bytes(model::Mode::binary, -1), std::invalid_argument);
  EXPECT_THROW(model::moments_payload_bytes(static_cast<model::Mode>(3), 4), std::invalid_argument);
  EXPECT_THROW(model::image_line_payload_bytes(-1), std::invalid_argument);
  EXPECT_THROW(model::codes_line_payload_bytes(-1), std::invalid_argument);
}

TEST(PayloadWords, RoundTripUpToTheLargest) {
  for (const model::Mode mode : {model::Mode::binary, model::Mode::grey, model::Mode::grey_over}) {
    const bool binary = mode == model::Mode::binary;
    for (const std::uint64_t seed : seeds(50)) {
      SCOPED_TRACE(how_to_repeat(seed));
      Random random(seed);
      const int columns = random.between(1, 600);
      model::Moments moments;
      moments.resize(columns);
      const auto fill = [&](std::vector<std::uint32_t>& values, std::uint64_t largest) {
        for (std::uint32_t& value : values) {
          value = static_cast<std::uint32_t>(random.chance(20) ? largest : random.bits() % (largest + 1));
        }
      };
      fill(moments.m0, binary ? spec::kBinaryM0Max : spec::kGreyM0Max);
      fill(moments.m1, binary ? spec::kBinaryM1Max : spec::kGreyM1Max);
      fill(moments.n, spec::kGreyNMax);
      if (binary) {
        moments.n = moments.m0;
      }
      Bytes payload(model::moments_payload_bytes(mode, columns) + 16, 0xEE);
      model::pack_moments(mode, columns, moments.view(), payload.data() + 1);  // at any address
      EXPECT_EQ(payload.front(), 0xEE);
      EXPECT_TRUE(std::all_of(payload.end() - 15, payload.end(), [](std::uint8_t b) { return b == 0xEE; }));
      const std::size_t word = (binary ? spec::kBinaryWordBits : spec::kGreyWordBits) / 8;
      EXPECT_TRUE(std::all_of(payload.begin() + 1 + static_cast<std::ptrdiff_t>(word) * columns, payload.end() - 15,
                              [](std::uint8_t b) { return b == 0; }));
      model::Moments found;
      found.resize(columns);
      model::unpack_moments(mode, columns, payload.data() + 1, found.view());
      ASSERT_EQ(found, moments);
    }
  }
}

// One column each with a single field at its largest value: compares the words with the specification, byte for byte.
TEST(PayloadWords, FieldsAtTheirBits) {
  const auto word_of = [](model::Mode mode, std::uint32_t m0, std::uint32_t m1, std::uint32_t n) {
    std::array<std::uint8_t, kBeat> bytes{};
    model::pack_moments(mode, 1, {&m0, &m1, &n}, bytes.data());
    std::uint64_t word = 0;
    for (std::size_t i = 0; i < 8; ++i) {
      word |= static_cast<std::uint64_t>(bytes[i]) << (8 * i);
    }
    return word;
  };
  EXPECT_EQ(word_of(model::Mode::binary, 0, 0xFFFFF, 0), 0x00000000000FFFFFU);
  EXPECT_EQ(word_of(model::Mode::binary, 0xFFF, 0, 0), 0x00000000FFF00000U);
  EXPECT_EQ(word_of(model::Mode::grey, 0, 0x7FFFFFF, 0), 0x0000000007FFFFFFU);
  EXPECT_EQ(word_of(model::Mode::grey, 0x3FFFF, 0, 0), 0x00001FFFF8000000U);
  EXPECT_EQ(word_of(model::Mode::grey_over, 0, 0, 0x3FF), 0x007FE00000000000U);
  // A value too wide for its field does not spill into the next.
  EXPECT_EQ(word_of(model::Mode::binary, 0, 0xFFFFFFFF, 0), 0x00000000000FFFFFU);
  EXPECT_EQ(word_of(model::Mode::grey, 0xFFFFFFFF, 0, 0), 0x00001FFFF8000000U);
  EXPECT_EQ(word_of(model::Mode::grey, 0, 0, 0xFFFFFFFF), 0x007FE00000000000U);
}

// The same for pixels of more than 8 bits; mode binary has the words of 8 bits.
TEST(PayloadWords, WideFieldsAtTheirBits) {
  const auto word_of = [](model::Mode mode, std::uint32_t m0, std::uint32_t m1, std::uint32_t n) {
    std::array<std::uint8_t, kBeat> bytes{};
    bytes.fill(0xEE);
    const model::ColumnWord wide = model::column_word(model::Select::all, mode, true);
    model::pack_columns(wide, 1, {.moments = {&m0, &m1, &n}}, bytes.data());
    EXPECT_TRUE(std::all_of(bytes.begin() + 8, bytes.end(), [](std::uint8_t b) { return b == 0; }));
    std::uint32_t found_m0 = 0;
    std::uint32_t found_m1 = 0;
    std::uint32_t found_n = 0;
    model::unpack_columns(wide, 1, bytes.data(), {.moments = {&found_m0, &found_m1, &found_n}});
    EXPECT_EQ(found_m1, mode == model::Mode::binary ? m1 & 0xFFFFF : m1 & 0x7FFFFFFF);
    EXPECT_EQ(found_m0, mode == model::Mode::binary ? m0 & 0xFFF : m0 & 0x3FFFFF);
    EXPECT_EQ(found_n, mode == model::Mode::binary ? found_m0 : n & 0x7FF);
    return model::load_little_endian<std::uint64_t>(bytes.data());
  };
  EXPECT_EQ(word_of(model::Mode::grey, 0, 0x7FFFFFFF, 0), 0x000000007FFFFFFFU);
  EXPECT_EQ(word_of(model::Mode::grey_over, 0x3FFFFF, 0, 0), 0x001FFFFF80000000U);
  EXPECT_EQ(word_of(model::Mode::grey, 0, 0, 0x7FF), 0xFFE0000000000000U);
  EXPECT_EQ(word_of(model::Mode::grey, 0xFFFFFFFF, 0, 0), 0x001FFFFF80000000U);
  EXPECT_EQ(word_of(model::Mode::grey, 0, 0xFFFFFFFF, 0), 0x000000007FFFFFFFU);
  EXPECT_EQ(word_of(model::Mode::binary, 0xFFF, 0xFFFFF, 0), 0x00000000FFFFFFFFU);
}

// The strongest run of pixels of more than 8 bits: N ends at 63, and runs are told by the second one alone.
TEST(PayloadWords, WideRunsAtTheirBits) {
  const auto word_of = [](model::Mode mode, std::uint32_t m0, std::uint32_t m1, std::uint32_t n, std::uint8_t runs,
                          std::uint8_t second) {
    std::array<std::uint8_t, kBeat> bytes{};
    bytes.fill(0xEE);
    const model::ColumnWord wide = model::column_word(model::Select::strongest, mode, true);
    model::pack_columns(wide, 1, {{&m0, &m1, &n}, &runs, &second}, bytes.data());
    EXPECT_TRUE(std::all_of(bytes.begin() + 8, bytes.end(), [](std::uint8_t b) { return b == 0; }));
    std::uint32_t found_m0 = 0;
    std::uint32_t found_m1 = 0;
    std::uint32_t found_n = 0;
    std::uint8_t found_runs = 9;
    std::uint8_t found_second = 99;
    model::unpack_columns(wide, 1, bytes.data(), {{&found_m0, &found_m1, &found_n}, &found_runs, &found_second});
    if (mode != model::Mode::binary) {
      EXPECT_EQ(found_m1, m1 & 0x7FFFFFFF);
      EXPECT_EQ(found_m0, m0 & 0x3FFFFF);
      EXPECT_EQ(found_n, std::min(n, 63U));
      EXPECT_EQ(found_second, second & 31);
      EXPECT_EQ(found_runs, (found_m0 == 0 ? 0 : 1) + (found_second == 0 ? 0 : 1));
    }
    return model::load_little_endian<std::uint64_t>(bytes.data());
  };
  EXPECT_EQ(word_of(model::Mode::grey, 0, 0x7FFFFFFF, 0, 0, 0), 0x000000007FFFFFFFU);
  EXPECT_EQ(word_of(model::Mode::grey_over, 0x3FFFFF, 0, 0, 1, 0), 0x001FFFFF80000000U);
  EXPECT_EQ(word_of(model::Mode::grey, 0, 0, 62, 1, 0), 0x07C0000000000000U);
  EXPECT_EQ(word_of(model::Mode::grey, 0, 0, 1023, 1, 0), 0x07E0000000000000U);
  EXPECT_EQ(word_of(model::Mode::grey, 1, 0, 0, 3, 16), 0x8000000080000000U);
  EXPECT_EQ(word_of(model::Mode::grey, 0xFFFFFFFF, 0, 0, 3, 0), 0x001FFFFF80000000U);
  // Mode binary has the words of 8 bits: m1 19, half, m0 10, runs 2.
  EXPECT_EQ(word_of(model::Mode::binary, 5, 3, 5, 2, 9), (2U << 30) | (5U << 20) | (1U << 19) | 3U);
}

// What an image can give, at its corners: the centroid is the nearest multiple of 1/512, halves up, and so within half
// of one of M1 / M0; no field overflows.
TEST(PayloadWords, CompactColumnsAreBounded) {
  const auto check = [](std::uint32_t m0, std::uint32_t m1, std::uint32_t n) {
    const std::uint32_t word = model::compact_word(model::Select::all, m0, m1, n, 0, 0);
    const std::int64_t centroid = word & 0xFFFFFU;
    const std::int64_t twice = 2 * (centroid * m0 - std::int64_t{512} * m1);  // of the error, times 512 M0
    ASSERT_LE(twice, m0) << m0 << " " << m1;
    ASSERT_GT(twice, -std::int64_t{m0}) << m0 << " " << m1;
    ASSERT_GE(centroid, 512);
    ASSERT_LE(centroid, 512 * spec::kMaxRows);
    ASSERT_EQ(word >> 20U & 63U, std::min(n, 63U));
    ASSERT_EQ(word >> 26U, m0 / (4 * n));
    ASSERT_LT(m0 / (4 * n), 64U);
  };
  // All M0 of up to three lit pixels, at the first and the last row and between; and of all numbers of lit pixels the
  // least and the greatest.
  for (std::uint32_t n = 1; n <= spec::kMaxRows; ++n) {
    for (std::uint32_t m0 = n; m0 <= 255 * n; m0 += n <= 3 ? 1 : 254 * n) {
      for (const std::uint32_t row : {1U, 2U, 511U, 1022U, 1023U}) {
        for (const std::uint32_t more : {0U, 1U, m0 / 2, m0 - 1}) {
          const std::uint64_t m1 = std::uint64_t{row} * m0 + more;
          if (m1 <= std::uint64_t{spec::kMaxRows} * m0) {
            check(m0, static_cast<std::uint32_t>(m1), n);
          }
        }
      }
    }
  }
  EXPECT_EQ(model::compact_word(model::Select::all, 0, 0, 0, 0, 0), 0U);
  // Halves are rounded up: 1/1024 rows over row 1.
  EXPECT_EQ(model::compact_word(model::Select::all, 1024, 1025, 5, 0, 0) & 0xFFFFFU, 513U);
  EXPECT_EQ(model::compact_word(model::Select::strongest, 10, 20, 2, 3, 16) >> 26U, 3U << 4U | 15U);
  EXPECT_EQ(model::compact_word(model::Select::strongest, 10, 20, 2, 2, 14) >> 26U, 2U << 4U | 14U);
}

TEST(PayloadWords, CompactColumnsAndBack) {
  constexpr int kColumns = 6;  // two beats
  for (const model::Select select : {model::Select::all, model::Select::strongest}) {
    model::Runs runs;
    runs.resize(select, kColumns);
    runs.moments.m0 = {0, 500, 255 * 70, 3, 1, 2};
    runs.moments.m1 = {0, 5250, 255 * 70 * 1023U, 3, 1023, 5};
    runs.moments.n = {0, 2, 70, 3, 1, 2};
    if (select == model::Select::strongest) {
      runs.runs = {0, 1, 2, 3, 1, 1};
      runs.second = {0, 0, 16, 14, 0, 0};
    }
    Bytes payload(model::compact_payload_bytes(kColumns) + 1, 0xEE);
    ASSERT_EQ(payload.size(), 33U);
    model::pack_compact(select, kColumns, runs.view(), payload.data());
    EXPECT_EQ(payload.back(), 0xEE);
    model::Runs back;
    back.resize(select, kColumns);
    model::unpack_columns(
        select == model::Select::strongest ? model::ColumnWord::compact_run : model::ColumnWord::compact, kColumns,
        payload.data(), back.view());
    EXPECT_THROW(model::pack_columns(model::ColumnWord::compact, kColumns, runs.view(), payload.data()),
                 std::invalid_argument);
    EXPECT_EQ(back.moments.m0, (std::vector<std::uint32_t>{0, 512, 512, 512, 512, 512}));
    EXPECT_EQ(back.moments.m1, (std::vector<std::uint32_t>{0, 5376, 523776, 512, 523776, 1280}));
    EXPECT_EQ(back.moments.n, (std::vector<std::uint32_t>{0, 2, 63, 3, 1, 2}));
    if (select == model::Select::strongest) {
      EXPECT_EQ(back.runs, runs.runs);
      EXPECT_EQ(back.second, (std::vector<std::uint8_t>{0, 0, 15, 14, 0, 0}));
    }
  }
}

TEST(PayloadWords, RunsAtTheirBitsAndBack) {
  const auto word_of = [](model::Mode mode, std::uint32_t m0, std::uint32_t m1, std::uint32_t n, int runs, int second) {
    model::Runs all{.moments = {.m0 = {m0}, .m1 = {m1}, .n = {n}},
                    .runs = {static_cast<std::uint8_t>(runs)},
                    .second = {static_cast<std::uint8_t>(second)}};
    std::array<std::uint8_t, kBeat + 1> bytes{};
    bytes.back() = 0xEE;
    const model::ColumnWord run = model::column_word(model::Select::strongest, mode);
    model::pack_columns(run, 1, all.view(), bytes.data());
    model::Runs back;
    back.resize(model::Select::strongest, 1);
    model::unpack_columns(run, 1, bytes.data(), back.view());
    all.second[0] = mode == model::Mode::binary ? second >= 8 ? 8 : 0 : all.second[0];
    if (mode == model::Mode::binary) {
      all.moments.n = all.moments.m0;
    }
    EXPECT_EQ(back, all);
    EXPECT_EQ(bytes.back(), 0xEE);
    std::uint64_t word = 0;
    for (std::size_t i = 0; i < 8; ++i) {
      word |= static_cast<std::uint64_t>(bytes[i]) << (8 * i);
    }
    return word;
  };
  EXPECT_EQ(word_of(model::Mode::binary, 0, 0x7FFFF, 0, 0, 0), 0x000000000007FFFFU);
  EXPECT_EQ(word_of(model::Mode::binary, 0, 0, 0, 0, 7), 0U);
  EXPECT_EQ(word_of(model::Mode::binary, 0, 0, 0, 0, 8), 0x0000000000080000U);
  EXPECT_EQ(word_of(model::Mode::binary, 0x3FF, 0, 0, 0, 0), 0x000000003FF00000U);
  EXPECT_EQ(word_of(model::Mode::binary, 0, 0, 0, 3, 16), 0x00000000C0080000U);
  EXPECT_EQ(word_of(model::Mode::grey, 0, 0x7FFFFFF, 0, 0, 0), 0x0000000007FFFFFFU);
  EXPECT_EQ(word_of(model::Mode::grey_over, 0x3FFFF, 0, 0, 0, 0), 0x00001FFFF8000000U);
  EXPECT_EQ(word_of(model::Mode::grey, 0, 0, 0x3FF, 0, 0), 0x007FE00000000000U);
  EXPECT_EQ(word_of(model::Mode::grey_over, 0, 0, 0, 3, 0), 0x0180000000000000U);
  EXPECT_EQ(word_of(model::Mode::grey, 0, 0, 0, 0, 16), 0x2000000000000000U);
}

TEST(PayloadWords, CodesAreWordsOfTwoBytesLowByteFirst) {
  const std::vector<std::uint16_t> codes = {0x8123, 0x0456, 0xFFFF, 0x0001, 0x8FFE};
  Bytes payload(model::codes_line_payload_bytes(4) + 2, 0xEE);
  model::pack_codes(5, codes.data(), payload.data());
  EXPECT_EQ(payload, (Bytes{0x23, 0x81, 0x56, 0x04, 0xFF, 0xFF, 0x01, 0x00, 0xFE, 0x8F, 0xEE, 0xEE, 0xEE, 0xEE, 0xEE,
                            0xEE, 0xEE, 0xEE}));
  std::vector<std::uint16_t> back(6, 7);
  model::unpack_codes(5, payload.data(), back.data());
  EXPECT_EQ(back, (std::vector<std::uint16_t>{0x8123, 0x0456, 0xFFFF, 0x0001, 0x8FFE, 7}));
  EXPECT_THROW(model::pack_codes(-1, codes.data(), payload.data()), std::invalid_argument);
  EXPECT_THROW(model::unpack_codes(-1, payload.data(), back.data()), std::invalid_argument);
}

// A stamped packet equals one that was built with the stamp.
TEST(Packet, StampsAndHeadersAreWrittenAnew) {
  for (Bytes packet : packets_of_all_kinds(24)) {
    model::PacketView view;
    ASSERT_EQ(model::parse_packet(packet, view), model::PacketError::none);
    model::PacketHeader header = view.header;
    header.sequence = 0x0102030405060708;
    header.time_stamp = 0x1112131415161718;
    header.encoder = 0x21222324;
    header.lost = 0x31;
    Bytes want;
    model::append_packet(header, view.payload, view.status, want);
    Bytes got = packet;
    model::stamp_packet(
        got,
        {.sequence = header.sequence, .time_stamp = header.time_stamp, .encoder = header.encoder, .lost = header.lost});
    EXPECT_EQ(got, want);

    header.sequence = view.header.sequence;  // the trailer's sequence stays
    header.threshold = 9;
    want.clear();
    model::append_packet(header, view.payload, view.status, want);
    got = packet;
    model::replace_header(got, header);
    EXPECT_EQ(got, want);
    model::replace_header(got, header, spec::kHash + 1);
    EXPECT_EQ(verdict(got), model::PacketError::hash);
    EXPECT_EQ(model::check_word(got), plain_check_word(got));
  }
  Bytes short_one(model::packet_bytes(0) - spec::kPacketBeatBytes);
  EXPECT_THROW(model::stamp_packet(short_one, {}), std::invalid_argument);
  EXPECT_THROW(model::replace_header(short_one, {}), std::invalid_argument);
  EXPECT_THROW(model::payload_of(short_one), std::invalid_argument);
}

TEST(Packet, WholeAndItsParts) {
  for (const Bytes& packet : packets_of_all_kinds(24)) {
    Bytes stream(11, std::uint8_t{'S'});
    stream.insert(stream.end(), packet.begin(), packet.end());
    const std::span<const std::uint8_t> all(stream);
    EXPECT_EQ(model::find_packet_start(all, 0), 11U);
    EXPECT_EQ(model::find_packet_start(all, 11), 11U);
    EXPECT_EQ(model::find_packet_start(all.first(11 + 3), 10), 11U) << "the beginning of a magic number counts";
    EXPECT_EQ(model::find_packet_start(all.first(9), 9), 9U);
    EXPECT_EQ(model::find_packet_start(all.first(9), 3), 8U);
    EXPECT_FALSE(model::begins_like_packet(all.subspan(10)));
    EXPECT_TRUE(model::begins_like_packet(all.subspan(11)));
    EXPECT_TRUE(model::begins_like_packet({}));

    EXPECT_EQ(model::announced_packet_bytes(all.subspan(11)), packet.size());
    EXPECT_EQ(model::announced_packet_bytes(all.subspan(11, spec::kHeaderBytes)), packet.size());
    EXPECT_EQ(model::announced_packet_bytes(all.subspan(11, spec::kHeaderBytes - 1)), std::nullopt);

    model::PacketView view;
    ASSERT_EQ(model::parse_packet(all.subspan(11), view), model::PacketError::none);
    EXPECT_EQ(view.bytes().data(), stream.data() + 11);
    EXPECT_EQ(view.bytes().size(), packet.size());
    const auto payload = model::payload_of(view.bytes());
    EXPECT_EQ(payload.data(), view.payload.data());
    EXPECT_EQ(payload.size(), view.payload.size());
    EXPECT_EQ(model::packet_bytes(payload.size()), packet.size());
  }
}

TEST(Packet, FrameIsSequenceAndTime) {
  const model::PacketHeader header = header_of(spec::kKindMoments, model::Mode::grey, 8);
  model::PacketHeader other = header;
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
