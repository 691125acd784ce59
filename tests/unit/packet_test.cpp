// Tests packets: what goes in comes out, and whatever is damaged on the way is refused.
#include "selfproj/model/packet.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "model/datagram.h"
#include "model/replay.h"
#include "tests/support/random_cases.h"
#include "tests/unit/packets.h"

namespace selfproj::test {
namespace {

// The packet with another value in `bytes` bytes at `offset`, and its check word corrected.
Bytes forged(Bytes packet, std::size_t offset, std::size_t bytes, std::uint64_t value) {
  for (std::size_t i = 0; i < bytes; ++i) {
    packet[offset + i] = static_cast<std::uint8_t>(value >> (8 * i));
  }
  model::seal_packet(packet);
  return packet;
}

TEST(Packet, RoundTrip) {
  for (const int columns : {4, 8, 12, 16, 20, 508, 512, spec::kMaxColumns, spec::kColumnLimit}) {
    for (const model::Mode mode : {model::Mode::binary, model::Mode::grey, model::Mode::grey_over}) {
      for (const std::uint8_t kind :
           {spec::kKindMoments, spec::kKindCodes, spec::kKindImage, spec::kKindCompact, spec::kKindVerdict}) {
        if (kind == spec::kKindCompact && mode == model::Mode::binary) {
          EXPECT_EQ(verdict(packet_of(header_of(kind, mode, columns))), model::PacketError::geometry);
          continue;
        }
        for (const std::uint32_t status : {std::uint32_t{0}, spec::kStatusLongLine | spec::kStatusIncomplete}) {
          model::PacketHeader header = header_of(kind, mode, columns);
          if (kind == spec::kKindCodes || kind == spec::kKindImage) {
            header.lines = 3;  // each is filled up to whole beats
          }
          const Bytes payload = Random(static_cast<std::uint64_t>(columns)).bytes(payload_bytes_of(header));
          Bytes bytes(5, 0xAB);  // a packet may begin at any address
          model::append_packet(header, payload, status, bytes);
          const std::size_t size = bytes.size() - 5;
          EXPECT_EQ(size % kBeat, 0U);
          EXPECT_EQ(size, spec::kHeaderBytes + payload.size() + spec::kTrailerBytes);
          bytes.insert(bytes.end(), 100, 0xCD);  // what follows does not matter
          model::PacketView view;
          ASSERT_EQ(model::parse_packet(std::span(bytes).subspan(5), view), model::PacketError::none);
          header.payload_size = static_cast<std::uint32_t>(payload.size());
          EXPECT_EQ(view.header, header);
          EXPECT_TRUE(std::equal(view.payload.begin(), view.payload.end(), payload.begin(), payload.end()));
          EXPECT_EQ(view.payload.data(), bytes.data() + 5 + spec::kHeaderBytes);
          EXPECT_EQ(view.status, status);
          EXPECT_EQ(view.size, size);
        }
      }
    }
  }
}

// Each field is at its own bytes and nowhere else, low byte first.
TEST(Packet, EveryFieldAtItsPlace) {
  const model::PacketHeader zero;
  Bytes base;
  model::append_packet(zero, {}, 0, base);
  const auto expect_at = [&](const model::PacketHeader& header, std::uint32_t status, std::size_t first,
                             std::size_t bytes) {
    Bytes packet;
    model::append_packet(header, {}, status, packet);
    ASSERT_EQ(packet.size(), base.size());
    for (std::size_t i = 0; i + 4 < packet.size(); ++i) {
      const std::size_t trailer_sequence = spec::kHeaderBytes + spec::kTrailerSequence;
      const std::size_t k = first == spec::kHeaderSequence && i >= trailer_sequence ? i - trailer_sequence : i - first;
      if (k < bytes) {
        EXPECT_EQ(packet[i], 0x10 * bytes + k) << "byte " << i;
      } else {
        EXPECT_EQ(packet[i], base[i]) << "byte " << i;
      }
    }
  };
  const auto expect_field = [&](auto model::PacketHeader::*field, std::size_t first) {
    model::PacketHeader header;
    using T = std::remove_reference_t<decltype(header.*field)>;
    for (std::size_t k = 0; k < sizeof(T); ++k) {  // bytes 0x10 n + k from the lowest, n the width
      header.*field = static_cast<T>(header.*field | static_cast<T>((0x10 * sizeof(T) + k) << (8 * k)));
    }
    expect_at(header, 0, first, sizeof(T));
  };
  expect_field(&model::PacketHeader::kind, spec::kHeaderKind);
  expect_field(&model::PacketHeader::stream, spec::kHeaderStream);
  expect_field(&model::PacketHeader::lost, spec::kHeaderLost);
  expect_field(&model::PacketHeader::sequence, spec::kHeaderSequence);
  expect_field(&model::PacketHeader::time_stamp, spec::kHeaderTimeStamp);
  expect_field(&model::PacketHeader::encoder, spec::kHeaderEncoder);
  expect_field(&model::PacketHeader::columns, spec::kHeaderColumns);
  expect_field(&model::PacketHeader::rows, spec::kHeaderRows);
  expect_field(&model::PacketHeader::pattern, spec::kHeaderPattern);
  expect_field(&model::PacketHeader::mode, spec::kHeaderMode);
  expect_at({.threshold = 0x10}, 0, spec::kHeaderThreshold, 1);
  expect_at({.pixel_bits = 9}, 0, spec::kHeaderPixel, 1);
  expect_field(&model::PacketHeader::first_line, spec::kHeaderFirstLine);
  expect_field(&model::PacketHeader::lines, spec::kHeaderLines);
  expect_field(&model::PacketHeader::flags, spec::kHeaderFlags);
  expect_at(zero, 0x43424140, spec::kHeaderBytes + spec::kTrailerStatus, 4);
  EXPECT_EQ(std::string(base.begin(), base.begin() + 4), "SLFP");
}

TEST(Packet, CheckWordIsThatOfTheSpecification) {
  for (const std::uint64_t seed : seeds(200)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const Bytes packet = random.bytes(kBeat * static_cast<std::size_t>(random.between(1, 300)));
    ASSERT_EQ(model::check_word(packet), plain_check_word(packet));
  }
  EXPECT_THROW(model::check_word({}), std::invalid_argument);
  EXPECT_THROW(model::check_word(Bytes(24)), std::invalid_argument);
}

// 32 bytes 0, 1, .. 31. The value was computed by code in another language, written only from the text of the
// specification.
TEST(Packet, CheckWordOfKnownBytes) {
  Bytes bytes;
  for (int i = 0; i < 32; ++i) {
    bytes.push_back(static_cast<std::uint8_t>(i));
  }
  EXPECT_EQ(model::check_word(bytes), 0xEEA3C738U);
}

TEST(Packet, EverySingleBitFlipIsSeen) {
  for (const Bytes& good : packets_of_all_kinds(512)) {
    ASSERT_EQ(verdict(good), model::PacketError::none);
    Bytes packet = good;
    for (std::size_t bit = 0; bit < 8 * packet.size(); ++bit) {
      packet[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
      ASSERT_NE(verdict(packet), model::PacketError::none) << "bit " << bit << " of " << 8 * packet.size();
      packet[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    }
  }
}

TEST(Packet, EverySwapOfBeatsIsSeen) {
  for (const Bytes& good : packets_of_all_kinds(64)) {
    const std::size_t beats = good.size() / kBeat;
    for (std::size_t i = 0; i < beats; ++i) {
      for (std::size_t j = i + 1; j < beats; ++j) {
        Bytes packet = good;
        const auto at = [&](std::size_t beat) { return packet.begin() + static_cast<std::ptrdiff_t>(beat * kBeat); };
        std::swap_ranges(at(i), at(i + 1), at(j));
        ASSERT_NE(verdict(packet), model::PacketError::none) << "beats " << i << " and " << j << " of " << beats;
      }
    }
  }
}

// Uses memory of exactly its size, so that the address sanitizer notices any access beyond.
TEST(Packet, CutAnywhereIsTooShort) {
  for (const Bytes& good : packets_of_all_kinds(32)) {
    for (std::size_t size = 0; size < good.size(); ++size) {
      const Bytes cut(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size));
      model::PacketView view;
      view.status = 0x1234;
      ASSERT_EQ(model::parse_packet(cut, view), model::PacketError::too_short)
          << size << " of " << good.size() << " bytes";
      ASSERT_EQ(view.status, 0x1234U);  // untouched
    }
  }
}

TEST(Packet, MissingOrDoubledBeatIsSeen) {
  for (const Bytes& good : packets_of_all_kinds(64)) {
    for (std::size_t beat = 0; beat < good.size() / kBeat; ++beat) {
      const auto begin = static_cast<std::ptrdiff_t>(beat * kBeat);
      Bytes without = good;
      without.erase(without.begin() + begin, without.begin() + begin + static_cast<std::ptrdiff_t>(kBeat));
      without.insert(without.end(), good.begin(), good.end());  // the next packet follows
      ASSERT_NE(verdict(without), model::PacketError::none) << "beat " << beat;
      Bytes twice = good;
      twice.insert(twice.begin() + begin, good.begin() + begin,
                   good.begin() + begin + static_cast<std::ptrdiff_t>(kBeat));
      if (beat + 1 < good.size() / kBeat) {
        ASSERT_NE(verdict(twice), model::PacketError::none) << "beat " << beat;
      } else {  // the packet is whole, and no other begins after it
        ASSERT_EQ(verdict(twice), model::PacketError::none);
        ASSERT_NE(verdict(Bytes(twice.begin() + static_cast<std::ptrdiff_t>(good.size()), twice.end())),
                  model::PacketError::none);
      }
    }
  }
}

// One field is wrong, but the check word is right, so the field itself must be checked.
TEST(Packet, NamesWhatIsWrong) {
  const Bytes moments = packet_of(header_of(spec::kKindMoments, model::Mode::grey, 32));
  const Bytes image = packet_of(header_of(spec::kKindImage, model::Mode::binary, 32));
  const std::size_t trailer = moments.size() - spec::kTrailerBytes;
  EXPECT_EQ(verdict(forged(moments, spec::kHeaderMagic, 4, spec::kMagic ^ 1)), model::PacketError::magic);
  EXPECT_EQ(verdict(forged(moments, spec::kHeaderSpecHash, 4, spec::kHash ^ 1)), model::PacketError::hash);
  EXPECT_EQ(verdict(forged(moments, spec::kHeaderVersion, 2, spec::kVersion + 1)), model::PacketError::version);
  for (const std::uint64_t kind : {0, 6, 255}) {
    EXPECT_EQ(verdict(forged(moments, spec::kHeaderKind, 1, kind)), model::PacketError::kind);
  }
  EXPECT_EQ(verdict(forged(moments, spec::kHeaderKind, 1, spec::kKindCompact)), model::PacketError::size);
  EXPECT_EQ(verdict(forged(moments, spec::kHeaderKind, 1, spec::kKindVerdict)), model::PacketError::size);
  EXPECT_EQ(verdict(forged(moments, spec::kHeaderFlags, 1, spec::kFlagVerdict)), model::PacketError::size);
  EXPECT_EQ(verdict(forged(moments, spec::kHeaderPixel, 1, 0x50)), model::PacketError::geometry);
  for (const Bytes& packet : {moments, image}) {
    EXPECT_EQ(verdict(forged(packet, spec::kHeaderMode, 1, 3)), model::PacketError::geometry);
    for (const std::uint64_t columns : {0, 2, 33, spec::kColumnLimit + 4, 65532}) {
      EXPECT_EQ(verdict(forged(packet, spec::kHeaderColumns, 2, columns)), model::PacketError::geometry);
    }
    for (const std::uint64_t rows : {0, spec::kMaxRows + 1, 65535}) {
      EXPECT_EQ(verdict(forged(packet, spec::kHeaderRows, 2, rows)), model::PacketError::geometry);
    }
  }
  EXPECT_EQ(verdict(forged(moments, spec::kHeaderSelect, 1, 2)), model::PacketError::geometry);
  EXPECT_EQ(verdict(forged(moments, spec::kHeaderGap, 1, 4)), model::PacketError::geometry);
  EXPECT_EQ(verdict(forged(moments, spec::kHeaderFirstRow, 2, spec::kRowLimit + 1)), model::PacketError::geometry);
  EXPECT_EQ(verdict(forged(moments, spec::kHeaderLastRow, 2, spec::kRowLimit + 1)), model::PacketError::geometry);
  EXPECT_EQ(verdict(forged(moments, spec::kHeaderLastRow, 2, spec::kRowLimit)), model::PacketError::none);
  EXPECT_EQ(verdict(forged(image, spec::kHeaderFirstLine, 2, 0)), model::PacketError::geometry);
  EXPECT_EQ(verdict(forged(image, spec::kHeaderFirstLine, 2, 96)), model::PacketError::none);
  EXPECT_EQ(verdict(forged(image, spec::kHeaderFirstLine, 2, 97)), model::PacketError::geometry);
  EXPECT_EQ(verdict(forged(image, spec::kHeaderLines, 2, 0)), model::PacketError::geometry);
  EXPECT_EQ(verdict(forged(image, spec::kHeaderLines, 2, 2)), model::PacketError::size);
  EXPECT_EQ(verdict(forged(image, spec::kHeaderLines, 2, 90)), model::PacketError::size);  // lines 7 to 96 of 96
  EXPECT_EQ(verdict(forged(image, spec::kHeaderLines, 2, 91)), model::PacketError::geometry);
  EXPECT_EQ(verdict(forged(image, spec::kHeaderLines, 2, 65535)), model::PacketError::geometry);
  const std::uint64_t right = moments.size() - spec::kHeaderBytes - spec::kTrailerBytes;
  for (const std::uint64_t size : {right - 16, right + 16, right + 1, std::uint64_t{1}, std::uint64_t{16},
                                   std::uint64_t{0x7FFFFFF0}, std::uint64_t{0xFFFFFFF0}, std::uint64_t{0xFFFFFFFF}}) {
    EXPECT_EQ(verdict(forged(moments, spec::kHeaderPayloadSize, 4, size)), model::PacketError::size) << size;
  }
  EXPECT_EQ(verdict(forged(moments, spec::kHeaderColumns, 2, 28)), model::PacketError::size);
  EXPECT_EQ(verdict(forged(moments, spec::kHeaderMode, 1, spec::kModeBinary)), model::PacketError::size);
  EXPECT_EQ(verdict(forged(moments, trailer + spec::kTrailerSequence, 8, 5)), model::PacketError::sequence);
  Bytes bad_check = moments;
  bad_check.back() ^= 1;
  EXPECT_EQ(verdict(bad_check), model::PacketError::check);
}

// Byte 59 has what pixels of more than 8 bits need, and words are then wide_grey or wide_grey_run.
TEST(Packet, PixelsOfMoreThanEightBits) {
  model::PacketHeader header = header_of(spec::kKindMoments, model::Mode::grey, 4);
  header.select = spec::kSelectAll;
  header.pixel_bits = 12;
  header.threshold = 0x9A5;
  std::array<std::uint32_t, 4> m0{4095 * 1023, 0, 1, 77};
  std::array<std::uint32_t, 4> m1{4095U * 1023U * 1024U / 2, 0, 1023, 5};
  std::array<std::uint32_t, 4> n{1023, 0, 1, 3};
  Bytes payload(model::columns_payload_bytes(header));
  model::pack_columns(header, {.moments = {m0.data(), m1.data(), n.data()}}, payload.data());
  Bytes packet;
  model::append_packet(header, payload, 0, packet);
  EXPECT_EQ(packet[15], 0xA5);
  EXPECT_EQ(packet[59], 0x49);
  model::PacketView view;
  ASSERT_EQ(model::parse_packet(packet, view), model::PacketError::none);
  EXPECT_EQ(view.header.pixel_bits, 12);
  EXPECT_EQ(view.header.threshold, 0x9A5);
  EXPECT_EQ(model::measure_of(view.header).bits, 12);
  model::Moments back;
  back.resize(4);
  model::unpack_columns(view.header, view.payload.data(), {.moments = back.view()});
  EXPECT_TRUE(std::ranges::equal(back.m0, m0) && std::ranges::equal(back.m1, m1) && std::ranges::equal(back.n, n));

  EXPECT_EQ(verdict(forged(packet, 59, 1, 0x39)), model::PacketError::geometry);  // 11 bits have no 0x9A5
  EXPECT_EQ(verdict(forged(packet, 59, 1, 0x37)), model::PacketError::none);
  EXPECT_EQ(verdict(forged(packet, 59, 1, 0x59)), model::PacketError::geometry);  // 13 bits
  EXPECT_EQ(verdict(forged(packet, spec::kHeaderSelect, 1, spec::kSelectStrongest)), model::PacketError::none);
  // The payload has no word of a verdict.
  EXPECT_EQ(verdict(forged(packet, spec::kHeaderKind, 1, spec::kKindVerdict)), model::PacketError::size);
  EXPECT_EQ(verdict(forged(packet, spec::kHeaderFlags, 1, spec::kFlagVerdict)), model::PacketError::size);
  header.flags = spec::kFlagVerdict;
  const Bytes judged = packet_of(header);
  ASSERT_EQ(model::parse_packet(judged, view), model::PacketError::none);
  EXPECT_EQ(view.header.pixel_bits, 12);
  EXPECT_EQ(view.payload.size(), 4 * 8 + 16);
  Bytes image = packet_of(header_of(spec::kKindImage, model::Mode::grey, 16));
  image = forged(image, spec::kHeaderSelect, 1, spec::kSelectStrongest);
  EXPECT_EQ(verdict(forged(image, 59, 1, 0x49)), model::PacketError::none);  // its upper eight bits
}

// Frames of more than 1,023 rows have words of their own, and bit 7 of byte 59 says so; a build for them sends these
// words of short frames, too.
TEST(Packet, FramesOfManyRows) {
  for (const int rows : {96, spec::kRowLimit}) {
    for (const int bits : {8, 10}) {
      for (const model::Mode mode : {model::Mode::binary, model::Mode::grey, model::Mode::grey_over}) {
        for (const model::Select select : {model::Select::all, model::Select::strongest}) {
          const auto most = static_cast<std::uint32_t>(mode == model::Mode::binary ? 1 : (1 << bits) - 1);
          model::PacketHeader header;
          header.kind = spec::kKindMoments;
          model::describe_frame(header, rows, 4, {.mode = mode, .threshold = 0, .select = select, .bits = bits});
          EXPECT_EQ(header.tall, rows > spec::kMaxRows);
          header.tall = true;
          const std::uint32_t n = select == model::Select::strongest && mode != model::Mode::binary ? 40 : 2047;
          model::Runs runs;
          runs.resize(select, 4);
          runs.moments = {
              .m0 = {most * 2047, 0, most, 3}, .m1 = {most * 2047 * 1024, 0, most * 2047, 3}, .n = {n, 0, 1, 3}};
          if (mode == model::Mode::binary) {
            runs.moments.n = runs.moments.m0;
          }
          if (select == model::Select::strongest) {
            runs.runs = {1, 0, 1, 1};
          }
          Bytes payload(model::columns_payload_bytes(header));
          model::pack_columns(header, runs.view(), payload.data());
          Bytes packet;
          model::append_packet(header, payload, 0, packet);
          EXPECT_EQ(packet[59], 0x80 + 16 * (bits - 8));
          model::PacketView view;
          ASSERT_EQ(model::parse_packet(packet, view), model::PacketError::none);
          EXPECT_TRUE(view.header.tall);
          EXPECT_EQ(view.header.rows, rows);
          model::Runs back;
          back.resize(select, 4);
          model::unpack_columns(view.header, view.payload.data(), back.view());
          EXPECT_EQ(back, runs);
          const bool tall = rows > spec::kMaxRows;
          EXPECT_EQ(verdict(forged(packet, 59, 1, packet[59] & 0x7FU)),
                    tall ? model::PacketError::geometry : model::PacketError::none);
          EXPECT_EQ(verdict(forged(packet, spec::kHeaderRows, 2, spec::kRowLimit + 1)), model::PacketError::geometry);
          EXPECT_EQ(verdict(forged(packet, 59, 1, 0x80 + 16 * 3)), model::PacketError::geometry);  // of 11 bits
          EXPECT_EQ(verdict(forged(packet, spec::kHeaderFlags, 1, spec::kFlagVerdict)), model::PacketError::geometry);
        }
      }
    }
  }
}

// A packet of version 1.0, as a program of that time wrote it: 4 columns of 6 rows, binary, sequence 2, two columns
// lit. It is read; what was reserved then must be 0, and version and hash belong together.
TEST(Packet, EarlierVersionIsRead) {
  Bytes packet(spec::kHeaderBytes + kBeat + spec::kTrailerBytes, 0);
  const auto put = [&](std::size_t at, std::initializer_list<int> bytes) {
    std::copy(bytes.begin(), bytes.end(), packet.begin() + static_cast<std::ptrdiff_t>(at));
  };
  put(0, {'S', 'L', 'F', 'P', 0x00, 0x1C, 0x69, 0x08, 0x00, 0x01, 1, 7});
  put(15, {128, 2});                                  // threshold, sequence
  put(40, {4, 0, 6, 0, 16, 0, 0, 0, 1, 0, 6, 0, 1});  // columns, rows, payload, first line, lines, flags
  put(spec::kHeaderBytes, {5, 0, 0x20, 0, 0, 0, 0, 0, 6, 0, 0x10});
  put(spec::kHeaderBytes + kBeat, {2});
  model::seal_packet(packet);
  model::PacketView view;
  ASSERT_EQ(model::parse_packet(packet, view), model::PacketError::none);
  EXPECT_EQ(view.header.columns, 4);
  EXPECT_EQ(view.header.flags, spec::kFlagStrayBefore);
  EXPECT_EQ(view.header.select, spec::kSelectAll);
  EXPECT_EQ(view.header.first_row, 0);
  EXPECT_EQ(view.header.last_row, 0);
  EXPECT_EQ(view.header.gap, 0);
  model::Moments moments;
  moments.resize(4);
  model::unpack_moments(model::Mode::binary, 4, view.payload.data(), moments.view());
  EXPECT_EQ(moments, (model::Moments{.m0 = {2, 0, 1, 0}, .m1 = {5, 0, 6, 0}, .n = {2, 0, 1, 0}}));
  for (std::size_t at = 53; at < spec::kHeaderBytes; ++at) {
    EXPECT_EQ(verdict(forged(packet, at, 1, 1)), model::PacketError::reserved) << at;
  }
  EXPECT_EQ(verdict(forged(packet, spec::kHeaderVersion, 2, spec::kVersion)), model::PacketError::version);
  const Bytes now = packet_of(header_of(spec::kKindMoments, model::Mode::binary, 4));
  EXPECT_EQ(verdict(forged(now, spec::kHeaderVersion, 2, 0x0100)), model::PacketError::version);
  EXPECT_EQ(verdict(forged(now, spec::kHeaderSpecHash, 4, 0x08691C00)), model::PacketError::version);
  // Version 1.1 had rows that count and runs, and no region.
  Bytes second = forged(forged(packet, spec::kHeaderVersion, 2, 0x0101), spec::kHeaderSpecHash, 4, 0xA3603834);
  second = forged(second, spec::kHeaderGap, 1, 2);
  ASSERT_EQ(model::parse_packet(second, view), model::PacketError::none);
  EXPECT_EQ(view.header.gap, 2);
  EXPECT_EQ(view.header.region_row, 0);
  for (std::size_t at = 59; at < spec::kHeaderBytes; ++at) {
    EXPECT_EQ(verdict(forged(second, at, 1, 1)), model::PacketError::reserved) << at;
  }
  // Today byte 59 tells of pixels of more than 8 bits; with 8 bits there is no threshold of 256 and more.
  EXPECT_EQ(verdict(forged(now, 59, 1, 1)), model::PacketError::geometry);
  EXPECT_EQ(verdict(forged(now, 60, 2, 0x8001)), model::PacketError::none);
}

// The packet of a frame that broke before its header left.
TEST(Packet, EmptyNeedsAStatus) {
  for (const std::uint8_t kind : {spec::kKindMoments, spec::kKindCodes, spec::kKindImage}) {
    model::PacketHeader header = header_of(kind, model::Mode::binary, 512);
    header.first_line = 0;
    header.lines = 0;
    Bytes good_status;
    model::append_packet(header, {}, 0, good_status);
    EXPECT_EQ(verdict(good_status), model::PacketError::empty);
    Bytes broken;
    model::append_packet(header, {}, spec::kStatusShortLine, broken);
    model::PacketView view;
    ASSERT_EQ(model::parse_packet(broken, view), model::PacketError::none);
    EXPECT_EQ(view.header, header);
    EXPECT_TRUE(view.payload.empty());
    EXPECT_EQ(view.status, spec::kStatusShortLine);
    EXPECT_EQ(view.size, spec::kHeaderBytes + spec::kTrailerBytes);
  }
}

// Arbitrary bytes, and packets damaged in many places: never good, and never an access outside (address sanitizer).
TEST(Packet, RandomBytesAndDamage) {
  const std::vector<Bytes> good = packets_of_all_kinds(16);
  for (const std::uint64_t seed : seeds(2000)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    ASSERT_NE(verdict(random.bytes(static_cast<std::size_t>(random.between(0, 300)))), model::PacketError::none);
    const Bytes& original = good[static_cast<std::size_t>(random.between(0, static_cast<int>(good.size()) - 1))];
    Bytes packet = original;
    const int last = static_cast<int>(packet.size()) - 1;
    for (int hits = random.between(1, 8); hits > 0; --hits) {
      packet[static_cast<std::size_t>(random.between(0, last))] = static_cast<std::uint8_t>(random.bits());
    }
    if (packet != original) {
      ASSERT_NE(verdict(packet), model::PacketError::none);
    }
  }
}

TEST(Packet, RefusesHalfBeats) {
  Bytes out = {1, 2, 3};
  EXPECT_THROW(model::append_packet({}, Bytes(8), 0, out), std::invalid_argument);
  EXPECT_EQ(out, (Bytes{1, 2, 3}));
}

// Boards, recordings and hosts of one version have one hash, and refuse another. A specification with another hash is
// another version; as long as this one is not released, it is another number here.
TEST(Specification, TheHashBelongsToTheVersion) {
  EXPECT_EQ(spec::kVersion, 0x0200);
  EXPECT_EQ(spec::kHash, 0x1A81A4C9U);
}

// The headers of datagrams, written out: the hash of the specification does not cover them, and nothing but these bytes
// tells whether the boards and hosts that there are still understand one another.
TEST(DatagramHeaders, EveryByteIsAsBoardsAndHostsHaveIt) {
  const Bytes of_packet = {'S',  'L',  0x02, 0x01, 0x06, 0x05, 0x04, 0x03,
                           0x0A, 0x09, 0x08, 0x07, 0x10, 0x0B, 0x20, 0x00};
  const model::DatagramHeader header{
      .session = 0x0102, .sequence = 0x03040506, .packet = 0x0708090A, .offset = 0x0B10, .length = 0x0020};
  Bytes written(of_packet.size());
  model::write_datagram_header(header, written.data());
  EXPECT_EQ(written, of_packet);
  written.resize(of_packet.size() + header.length);
  EXPECT_EQ(model::read_datagram_header(written), header);

  const Bytes of_replay = {'S',  'R',  0x02, 0x01, 0x06, 0x05, 0x04, 0x03, 0x0A, 0x09,
                           0x08, 0x07, 0x0C, 0x0B, 0x0E, 0x0D, 0x10, 0x0F, 0x00, 0x00};
  written.assign(of_replay.size(), 0xFF);
  model::write_replay_header({.session = 0x0102,
                              .frame = 0x03040506,
                              .offset = 0x0708090A,
                              .length = 0x0B0C,
                              .columns = 0x0D0E,
                              .rows = 0x0F10},
                             written.data());
  EXPECT_EQ(written, of_replay);
}

TEST(PacketErrorNames, AreDistinct) {
  std::map<std::string, int> names;
  for (int error = 0; error <= static_cast<int>(model::PacketError::empty); ++error) {
    ++names[model::to_string(static_cast<model::PacketError>(error))];
  }
  EXPECT_EQ(names.size(), 12U);
  EXPECT_EQ(names.count("unknown"), 0U);
  EXPECT_STREQ(model::to_string(static_cast<model::PacketError>(200)), "unknown");
}

}  // namespace
}  // namespace selfproj::test
