// Tests the header fields of a frame. Each must be valid from the clock of its header beat until the next frame
// replaces it.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "Vsp_frame_info_ports.h"
#include "selfproj/model/generated/selfproj_spec.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

constexpr int kTakeDistance = 7;  // sp_frame_tracker: smallest number of clocks from one take-over to the next
constexpr int kTrackerDelay = 2;  // from a frame's first beat at the video input to frame_start_i
constexpr int kEncoderDelay = 7;  // from a change of the encoder's lines to encoder_i

struct Settings {
  int stream, mode, threshold, columns, rows, gap, strongest, first_row, last_row, region_row, region_column, compact,
      verdict;
};

// A frame as frame_start_i announced it.
struct StartedFrame {
  std::int64_t start;  // clock of frame_start_i
  std::uint64_t sequence;
  bool stray_before;
  Settings settings;
  std::uint16_t pattern = 0;
  std::uint32_t encoder = 0;
};

// The field of `bytes` bytes at this byte of the header.
template <typename Wide>
std::uint64_t field(const Wide& info, std::size_t at, std::size_t bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) {
    value |= std::uint64_t{info[(at + i) / 4] >> (8 * ((at + i) % 4)) & 0xFFU} << (8 * i);
  }
  return value;
}

// shown(beat) is the frame whose fields of this header beat are valid now, or null.
template <typename Wide, typename Shown>
void expect_fields(const Wide& info, const Shown& shown) {
  struct Field {
    const char* name;
    std::size_t at;
    std::size_t bytes;
    std::uint64_t (*of)(const StartedFrame&);
    std::size_t early = 0;  // clocks before its beat
  };
  static constexpr std::array<Field, 18> kFields = {
      {{"kind", spec::kHeaderKind, 1,
        [](const StartedFrame& f) {
          const bool compact = f.settings.compact != 0 && f.settings.mode != spec::kModeBinary;
          return std::uint64_t{(f.settings.verdict & 2) != 0 ? spec::kKindVerdict
                               : compact                     ? spec::kKindCompact
                                                             : spec::kKindMoments};
        }},
       {"stream", spec::kHeaderStream, 1,
        [](const StartedFrame& f) { return static_cast<std::uint64_t>(f.settings.stream); }},
       {"mode", spec::kHeaderMode, 1,
        [](const StartedFrame& f) { return static_cast<std::uint64_t>(f.settings.mode); }},
       {"threshold", spec::kHeaderThreshold, 1,
        [](const StartedFrame& f) { return static_cast<std::uint64_t>(f.settings.threshold); }},
       {"columns", spec::kHeaderColumns, 2,
        [](const StartedFrame& f) { return static_cast<std::uint64_t>(f.settings.columns); }},
       {"rows", spec::kHeaderRows, 2,
        [](const StartedFrame& f) { return static_cast<std::uint64_t>(f.settings.rows); }},
       {"lines", spec::kHeaderLines, 2,
        [](const StartedFrame& f) { return static_cast<std::uint64_t>(f.settings.rows); }},
       {"select", spec::kHeaderSelect, 1,
        [](const StartedFrame& f) { return static_cast<std::uint64_t>(f.settings.strongest); }},
       {"first row", spec::kHeaderFirstRow, 2,
        [](const StartedFrame& f) { return static_cast<std::uint64_t>(f.settings.first_row); }},
       {"last row", spec::kHeaderLastRow, 2,
        [](const StartedFrame& f) { return static_cast<std::uint64_t>(f.settings.last_row); }},
       {"region row", spec::kHeaderRegionRow, 2,
        [](const StartedFrame& f) { return static_cast<std::uint64_t>(f.settings.region_row); }},
       {"region column", spec::kHeaderRegionColumn, 2,
        [](const StartedFrame& f) { return static_cast<std::uint64_t>(f.settings.region_column); }},
       {"gap", spec::kHeaderGap, 1, [](const StartedFrame& f) { return static_cast<std::uint64_t>(f.settings.gap); }},
       {"pattern", spec::kHeaderPattern, 2, [](const StartedFrame& f) { return std::uint64_t{f.pattern}; }},
       {"sequence", spec::kHeaderSequence, 8, [](const StartedFrame& f) { return f.sequence; }, 1},
       {"time stamp", spec::kHeaderTimeStamp, 8,
        [](const StartedFrame& f) { return static_cast<std::uint64_t>(f.start - kTrackerDelay); }},
       {"encoder", spec::kHeaderEncoder, 4, [](const StartedFrame& f) { return std::uint64_t{f.encoder}; }},
       {"flags", spec::kHeaderFlags, 1, [](const StartedFrame& f) {
          return std::uint64_t{f.stray_before ? spec::kFlagStrayBefore : std::uint8_t{0}} |
                 ((f.settings.verdict & 1) != 0 ? spec::kFlagVerdict : std::uint8_t{0});
        }}}};
  for (const Field& entry : kFields) {
    if (const StartedFrame* frame = shown(entry.at / spec::kPacketBeatBytes - entry.early); frame != nullptr) {
      EXPECT_EQ(field(info, entry.at, entry.bytes), entry.of(*frame)) << entry.name;
    }
  }
}

TEST(FrameInfo, EachFieldStandsFromItsClockToTheNextFrames) {
  for_cases(100, [&](Random& random) {
    Clocked<Vsp_frame_info> info;
    std::vector<StartedFrame> frames;
    info.valid_when({"info_o"}, [&] { return !frames.empty() && info.clock() > frames.front().start + 7; });
    info.valid_when({"pattern_o"}, [&] { return !frames.empty() && info.clock() > frames.front().start + 4; });
    info->frame_start_i = 0;
    info->take_i = 0;
    info.reset();
    const int often = random.between(1, 100);
    Settings settings{};
    std::int64_t last_take = -100;
    for (int i = 0; i < 1500; ++i) {
      const std::int64_t now = info.clock();
      const bool start = now >= kTrackerDelay && random.chance(often);
      const bool take = start && now - last_take >= kTakeDistance && (frames.empty() || random.chance(80));
      if (take) {
        last_take = now;
        settings = {random.between(0, 255),   random.between(0, 2),     random.between(0, 255),
                    random.between(0, 4095),  random.between(0, 1023),  random.between(0, 3),
                    random.between(0, 1),     random.between(0, 1023),  random.between(0, 1023),
                    random.between(0, 65535), random.between(0, 65535), random.between(0, 1),
                    random.between(0, 7)};
      }
      info->frame_start_i = start;
      info->take_i = take;
      info->stray_before_i = random.chance(50);
      info->stream_i = static_cast<CData>(settings.stream);
      info->mode_i = static_cast<CData>(settings.mode);
      info->threshold_i = static_cast<CData>(settings.threshold);
      info->columns_i = static_cast<SData>(settings.columns);
      info->rows_i = static_cast<SData>(settings.rows);
      info->select_i = static_cast<IData>(settings.gap | settings.strongest << 2 | settings.first_row << 3 |
                                          settings.last_row << 13);
      info->compact_i = static_cast<CData>(settings.compact);
      info->verdict_i = static_cast<CData>(settings.verdict);
      info->region_i = static_cast<IData>(settings.region_row) | static_cast<IData>(settings.region_column) << 16;
      info->encoder_i = static_cast<std::uint32_t>(random.bits());
      info->pattern_i = static_cast<std::uint16_t>(random.bits());
      if (start) {
        frames.push_back({now, frames.size(), info->stray_before_i != 0, settings});
      }
      info.settle();
      SCOPED_TRACE(::testing::Message() << "clock " << now);
      bool captured = false;
      for (auto frame = frames.rbegin(); frame != frames.rend() && frame->start > now - 12; ++frame) {
        captured = captured || frame->start + 2 == now;
        if (frame->start + 3 == now) {  // the index in the clock after captured_o counts
          frame->pattern = info->pattern_i;
        }
        if (frame->start - kTrackerDelay + kEncoderDelay == now) {
          frame->encoder = info->encoder_i;
        }
      }
      ASSERT_EQ(info->captured_o, captured ? 1 : 0);
      ASSERT_EQ(info->time_o, static_cast<std::uint64_t>(std::max<std::int64_t>(now, 1) - 6));

      // the frame whose fields of header beat `beat` are valid now
      const auto shown = [&](std::size_t beat) -> const StartedFrame* {
        for (auto frame = frames.rbegin(); frame != frames.rend(); ++frame) {
          if (frame->start + 4 + static_cast<std::int64_t>(beat) <= now) {
            return &*frame;
          }
        }
        return nullptr;
      };
      expect_fields(info->info_o, shown);
      const StartedFrame* first = shown(0);
      ASSERT_EQ(info->frames_o, first == nullptr ? 0 : first->sequence + 1);
      if (first != nullptr) {
        ASSERT_EQ(info->pattern_o, first->pattern);
      }
      ASSERT_FALSE(::testing::Test::HasFailure());
      info.rise();
    }
  });
}

// Runs for enough clocks and frames to use two chains of the counters, and 21 bits.
TEST(FrameInfo, CountsOn) {
  constexpr std::uint64_t kLate = spec::kHeaderSequence / spec::kPacketBeatBytes - 1;  // clocks after frames_o
  Clocked<Vsp_frame_info> info;
  info->frame_start_i = 0;
  info->take_i = 0;
  info.reset();
  info->frame_start_i = 1;
  for (std::uint64_t clock = 0; clock < 1'100'000; ++clock) {
    info.settle();
    const std::uint64_t frames = clock < 4 ? 0 : clock - 3;
    const std::uint64_t sequence = field(info->info_o, spec::kHeaderSequence, 8);
    if (info->time_o != (clock == 0 ? 1 : clock) - 6 || info->frames_o != frames ||
        (frames > kLate && sequence != frames - 1 - kLate)) {
      FAIL() << "time " << info->time_o << ", sequence " << sequence << ", clock " << clock;
    }
    info.rise();
  }
}

}  // namespace
}  // namespace selfproj::test
