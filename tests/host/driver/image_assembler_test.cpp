// Tests how lines become images. An image that lacks a line is counted and never returned.
#include "selfproj/driver/image_assembler.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <stdexcept>
#include <vector>

#include "tests/host/driver/packets.h"

namespace selfproj::test {
namespace {

constexpr int kRows = 5;
constexpr int kColumns = 20;  // not a multiple of a beat: lines are filled up

struct Line {
  model::PacketHeader header;
  Bytes payload;
  std::uint32_t status = 0;
  [[nodiscard]] model::PacketView view() const { return {header, payload, status, 0}; }
};

// All lines of frame `sequence`, with random pixels.
std::vector<Line> frame(std::uint8_t kind, std::uint64_t sequence, int columns = kColumns) {
  std::vector<Line> lines;
  Random random(sequence + 1);
  for (int row = 1; row <= kRows; ++row) {
    Line line{moments_header(sequence, columns), {}, 0};
    line.header.kind = kind;
    line.header.rows = kRows;
    line.header.first_line = static_cast<std::uint16_t>(row);
    line.header.lines = 1;
    line.payload = random.bytes(kind == spec::kKindImage ? model::image_line_payload_bytes(columns)
                                                         : model::codes_line_payload_bytes(columns));
    line.header.payload_size = static_cast<std::uint32_t>(line.payload.size());
    lines.push_back(line);
  }
  return lines;
}

TEST(ImageAssembler, Images) {
  driver::ImageAssembler assembler(spec::kKindImage, 0);
  for (std::uint64_t sequence = 3; sequence < 6; ++sequence) {
    const auto lines = frame(spec::kKindImage, sequence);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      ASSERT_EQ(assembler.add(lines[i].view()), i + 1 == lines.size());
    }
    EXPECT_EQ(assembler.header().sequence, sequence);
    ASSERT_EQ(assembler.pixels().size(), std::size_t{kRows} * kColumns);
    for (std::size_t i = 0; i < assembler.pixels().size(); ++i) {
      ASSERT_EQ(assembler.pixels()[i], lines[i / kColumns].payload[i % kColumns]);
    }
  }
  EXPECT_EQ(assembler.complete(), 3U);
  EXPECT_EQ(assembler.incomplete(), 0U);
}

TEST(ImageAssembler, Codes) {
  driver::ImageAssembler assembler(spec::kKindCodes, 0);
  const auto lines = frame(spec::kKindCodes, 1);
  bool done = false;
  for (const Line& line : lines) {
    done = assembler.add(line.view());
  }
  ASSERT_TRUE(done);
  for (std::size_t i = 0; i < std::size_t{kRows} * kColumns; ++i) {
    const Bytes& payload = lines[i / kColumns].payload;
    ASSERT_EQ(assembler.codes()[i], payload[2 * (i % kColumns)] + 256 * payload[2 * (i % kColumns) + 1]);
  }
}

// Each line in a packet is filled up to whole beats.
TEST(ImageAssembler, SeveralLinesInAPacket) {
  for (const std::uint8_t kind : {spec::kKindImage, spec::kKindCodes}) {
    driver::ImageAssembler assembler(kind, 0);
    const auto lines = frame(kind, 1);
    Line all = lines.front();
    for (std::size_t i = 1; i < lines.size(); ++i) {
      append(all.payload, lines[i].payload);
    }
    all.header.lines = kRows;
    all.header.payload_size = static_cast<std::uint32_t>(all.payload.size());
    ASSERT_TRUE(assembler.add(all.view()));
    for (std::size_t i = 0; i < std::size_t{kRows} * kColumns; ++i) {
      const Bytes& payload = lines[i / kColumns].payload;
      const std::size_t at = i % kColumns;
      if (kind == spec::kKindImage) {
        ASSERT_EQ(assembler.pixels()[i], payload[at]) << i;
      } else {
        ASSERT_EQ(assembler.codes()[i], payload[2 * at] + 256 * payload[2 * at + 1]) << i;
      }
    }
  }
}

TEST(ImageAssembler, AnyMissingLine) {
  for (std::size_t missing = 0; missing < kRows; ++missing) {
    driver::ImageAssembler assembler(spec::kKindImage, 0);
    auto lines = frame(spec::kKindImage, 1);
    lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(missing));
    for (const Line& line : lines) {
      EXPECT_FALSE(assembler.add(line.view()));
    }
    bool done = false;
    for (const Line& line : frame(spec::kKindImage, 2)) {
      done = assembler.add(line.view());
    }
    EXPECT_TRUE(done) << "the next image is not complete";
    EXPECT_EQ(assembler.incomplete(), 1U);
    EXPECT_EQ(assembler.complete(), 1U);
  }
}

TEST(ImageAssembler, FlaggedLine) {
  driver::ImageAssembler assembler(spec::kKindImage, 0);
  auto lines = frame(spec::kKindImage, 1);
  lines.back().status = spec::kStatusShortLine;
  for (const Line& line : lines) {
    EXPECT_FALSE(assembler.add(line.view()));
  }
  EXPECT_EQ(assembler.incomplete(), 1U);
}

TEST(ImageAssembler, FrameThatBrokeBeforeItsFirstLine) {
  driver::ImageAssembler assembler(spec::kKindImage, 0);
  Line line = frame(spec::kKindImage, 1).front();
  line.payload.clear();
  line.header.first_line = 0;
  line.header.lines = 0;
  line.header.payload_size = 0;
  line.status = spec::kStatusStartInFrame;
  EXPECT_FALSE(assembler.add(line.view()));
  EXPECT_EQ(assembler.incomplete(), 1U);
}

TEST(ImageAssembler, OtherStreamsAndKindsArePassedOver) {
  driver::ImageAssembler assembler(spec::kKindImage, 1);
  for (const Line& line : frame(spec::kKindImage, 1)) {
    EXPECT_FALSE(assembler.add(line.view()));
  }
  driver::ImageAssembler codes(spec::kKindCodes, 0);
  for (const Line& line : frame(spec::kKindImage, 1)) {
    EXPECT_FALSE(codes.add(line.view()));
  }
  EXPECT_EQ(assembler.complete() + assembler.incomplete() + codes.complete() + codes.incomplete(), 0U);
}

// Of lines that stand between those of another kind nothing is missing.
TEST(ImageAssembler, KindsInTurn) {
  driver::ImageAssembler assembler(spec::kKindImage, 0);
  const auto lines = frame(spec::kKindImage, 1);
  const auto codes = frame(spec::kKindCodes, 1);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    EXPECT_EQ(assembler.add(lines[i].view()), i + 1 == lines.size());
    EXPECT_FALSE(assembler.add(codes[i].view()));
  }
  EXPECT_EQ(assembler.complete(), 1U);
  EXPECT_EQ(assembler.incomplete(), 0U);
}

// Whatever is wrong with a line in the middle, its frame counts once, and the next one is whole.
TEST(ImageAssembler, AWrongLineInTheMiddle) {
  const std::vector<void (*)(Line&)> wrongs = {
      [](Line& line) { line.status = spec::kStatusIncomplete; }, [](Line& line) { line.header.first_line -= 1; },
      [](Line& line) { line.header.first_line += 1; }, [](Line& line) { line.header.columns -= 4; },
      [](Line& line) { line.header.rows -= 1; }};
  for (std::size_t i = 0; i < wrongs.size(); ++i) {
    SCOPED_TRACE(i);
    driver::ImageAssembler assembler(spec::kKindImage, 0);
    auto lines = frame(spec::kKindImage, 1);
    wrongs[i](lines[2]);
    for (const Line& line : lines) {
      EXPECT_FALSE(assembler.add(line.view()));
    }
    EXPECT_EQ(assembler.incomplete(), 1U);
    bool done = false;
    for (const Line& line : frame(spec::kKindImage, 2)) {
      done = assembler.add(line.view());
    }
    EXPECT_TRUE(done);
    EXPECT_EQ(assembler.complete(), 1U);
    EXPECT_EQ(assembler.incomplete(), 1U);
  }
}

// A board that was reset counts from the same number, at another time.
TEST(ImageAssembler, TheSameNumberAtAnotherTimeIsAnotherFrame) {
  driver::ImageAssembler assembler(spec::kKindImage, 0);
  auto lines = frame(spec::kKindImage, 1);
  EXPECT_FALSE(assembler.add(lines[0].view()));
  EXPECT_FALSE(assembler.add(lines[1].view()));
  EXPECT_EQ(assembler.incomplete(), 0U) << "it may still come";
  bool done = false;
  for (Line& line : lines) {
    line.header.time_stamp += 7;
    done = assembler.add(line.view());
  }
  EXPECT_TRUE(done);
  EXPECT_EQ(assembler.header().time_stamp, lines[0].header.time_stamp);
  EXPECT_EQ(assembler.header().first_line, 1);
  EXPECT_EQ(assembler.incomplete(), 1U);
}

// A frame whose number and time are 0 is one like any.
TEST(ImageAssembler, TheVeryFirstFrame) {
  driver::ImageAssembler assembler(spec::kKindImage, 0);
  bool done = false;
  auto lines = frame(spec::kKindImage, 0);
  for (Line& line : lines) {
    line.header.time_stamp = 0;
    done = assembler.add(line.view());
  }
  EXPECT_TRUE(done);
}

TEST(ImageAssembler, SizesMayChange) {
  for (const std::uint8_t kind : {spec::kKindImage, spec::kKindCodes}) {
    driver::ImageAssembler assembler(kind, 0);
    std::uint64_t sequence = 0;
    for (const int columns : {kColumns, kColumns - 8, kColumns + 4}) {
      bool done = false;
      for (const Line& line : frame(kind, sequence++, columns)) {
        done = assembler.add(line.view());
      }
      EXPECT_TRUE(done);
      const auto size = static_cast<std::size_t>(kRows * columns);
      EXPECT_EQ(assembler.pixels().size(), kind == spec::kKindImage ? size : 0U);
      EXPECT_EQ(assembler.codes().size(), kind == spec::kKindCodes ? size : 0U);
      EXPECT_EQ(assembler.header().columns, columns);
    }
  }
}

TEST(ImageAssembler, TooLarge) {
  driver::ImageAssembler assembler(spec::kKindImage, 0, kRows, kColumns - 4);
  for (const Line& line : frame(spec::kKindImage, 1)) {
    EXPECT_FALSE(assembler.add(line.view()));
  }
  EXPECT_EQ(assembler.too_large(), 1U);
  EXPECT_EQ(assembler.incomplete(), 0U);
}

TEST(ImageAssembler, UpToItsSize) {
  const auto whole = [](driver::ImageAssembler& assembler) {
    bool done = false;
    for (const Line& line : frame(spec::kKindImage, 1)) {
      done = assembler.add(line.view());
    }
    return done;
  };
  driver::ImageAssembler fits(spec::kKindImage, 0, kRows, kColumns);
  EXPECT_TRUE(whole(fits));
  EXPECT_EQ(fits.too_large(), 0U);
  driver::ImageAssembler low(spec::kKindImage, 0, kRows - 1, kColumns);
  EXPECT_FALSE(whole(low));
  EXPECT_EQ(low.too_large(), 1U);
}

TEST(ImageAssembler, BadArguments) {
  EXPECT_THROW(driver::ImageAssembler(spec::kKindMoments, 0), std::invalid_argument);
  EXPECT_THROW(driver::ImageAssembler(spec::kKindImage, 256), std::invalid_argument);
  EXPECT_THROW(driver::ImageAssembler(spec::kKindImage, -1), std::invalid_argument);
  EXPECT_THROW(driver::ImageAssembler(spec::kKindImage, 0, 0), std::invalid_argument);
  EXPECT_THROW(driver::ImageAssembler(spec::kKindImage, 0, 1, 0), std::invalid_argument);
  EXPECT_NO_THROW(driver::ImageAssembler(spec::kKindCodes, 255, 1, 1));
}

}  // namespace
}  // namespace selfproj::test
