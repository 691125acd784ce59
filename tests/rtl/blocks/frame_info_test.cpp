// The header fields of a frame: each from the clock its header states on, until the next frame's.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "Vsp_frame_info_ports.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

constexpr int kTakeDistance = 7;  // sp_frame_tracker: clocks from a take-over to the next, at least
constexpr int kTrackerDelay = 2;  // from a frame's first beat at the video input to frame_start_i
constexpr int kEncoderDelay = 7;  // from a change of the encoder's lines to encoder_i

struct Settings {
  int stream, mode, threshold, columns, rows;
};

struct Frame {
  std::int64_t start;  // clock of frame_start_i
  std::uint64_t sequence;
  bool stray_before;
  Settings settings;
  std::uint16_t pattern = 0;
  std::uint32_t encoder = 0;
};

TEST(FrameInfo, EachFieldStandsFromItsClockToTheNextFrames) {
  for (const std::uint64_t seed : seeds(100)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    Clocked<Vsp_frame_info> info;
    std::vector<Frame> frames;
    const auto some_frame = [&](int beat) {
      return [&, beat] { return !frames.empty() && info.clock() > frames.front().start + 4 + beat; };
    };
    for (const char* port : {"stream_o", "mode_o", "threshold_o", "pattern_o", "sequence_o"}) {
      info.valid_when(port, some_frame(0));
    }
    info.valid_when("time_stamp_o", some_frame(1));
    for (const char* port : {"encoder_o", "columns_o", "rows_o"}) {
      info.valid_when(port, some_frame(2));
    }
    for (const char* port : {"lines_o", "stray_before_o"}) {
      info.valid_when(port, some_frame(3));
    }
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
        settings = {random.between(0, 255), random.between(0, 2), random.between(0, 255), random.between(0, 4095),
                    random.between(0, 1023)};
      }
      info->frame_start_i = start;
      info->take_i = take;
      info->stray_before_i = random.chance(50);
      info->stream_i = static_cast<CData>(settings.stream);
      info->mode_i = static_cast<CData>(settings.mode);
      info->threshold_i = static_cast<CData>(settings.threshold);
      info->columns_i = static_cast<SData>(settings.columns);
      info->rows_i = static_cast<SData>(settings.rows);
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
        if (frame->start + 3 == now) {  // the index counts that stands in the clock after captured_o
          frame->pattern = info->pattern_i;
        }
        if (frame->start - kTrackerDelay + kEncoderDelay == now) {
          frame->encoder = info->encoder_i;
        }
      }
      ASSERT_EQ(info->captured_o, captured ? 1 : 0);
      ASSERT_EQ(info->time_o, static_cast<std::uint64_t>(std::max<std::int64_t>(now, 1) - 6));

      // the frame whose fields of header beat `beat` stand now
      const auto shown = [&](int beat) -> const Frame* {
        for (auto frame = frames.rbegin(); frame != frames.rend(); ++frame) {
          if (frame->start + 4 + beat <= now) {
            return &*frame;
          }
        }
        return nullptr;
      };
      if (const Frame* frame = shown(0); frame != nullptr) {
        ASSERT_EQ(info->sequence_o, frame->sequence);
        ASSERT_EQ(info->frames_o, frame->sequence + 1);
        ASSERT_EQ(info->stream_o, frame->settings.stream);
        ASSERT_EQ(info->mode_o, frame->settings.mode);
        ASSERT_EQ(info->threshold_o, frame->settings.threshold);
        ASSERT_EQ(info->pattern_o, frame->pattern);
      } else {
        ASSERT_EQ(info->frames_o, 0U);
      }
      if (const Frame* frame = shown(1); frame != nullptr) {
        ASSERT_EQ(info->time_stamp_o, static_cast<std::uint64_t>(frame->start - kTrackerDelay));
      }
      if (const Frame* frame = shown(2); frame != nullptr) {
        ASSERT_EQ(info->encoder_o, frame->encoder);
        ASSERT_EQ(info->columns_o, frame->settings.columns);
        ASSERT_EQ(info->rows_o, frame->settings.rows);
      }
      if (const Frame* frame = shown(3); frame != nullptr) {
        ASSERT_EQ(info->lines_o, frame->settings.rows);
        ASSERT_EQ(info->stray_before_o, frame->stray_before);
      }
      info.rise();
    }
  }
}

// As many clocks and frames as need more than one chain of the counters.
TEST(FrameInfo, CountsOn) {
  Clocked<Vsp_frame_info> info;
  info->frame_start_i = 0;
  info->take_i = 0;
  info.reset();
  info->frame_start_i = 1;
  for (std::uint64_t clock = 0; clock < 200'000; ++clock) {
    info.settle();
    const std::uint64_t frames = clock < 4 ? 0 : clock - 3;
    if (info->time_o != (clock == 0 ? 1 : clock) - 6 || info->frames_o != frames ||
        (frames != 0 && info->sequence_o != frames - 1)) {
      FAIL() << "time " << info->time_o << ", sequence " << info->sequence_o << ", clock " << clock;
    }
    info.rise();
  }
}

}  // namespace
}  // namespace selfproj::test
