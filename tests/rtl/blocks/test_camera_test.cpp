// Tests the camera inside the FPGA against its model: line, patterns, triggers.
#include "model/test_camera.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "Vsp_test_camera_ports.h"
#include "Vsp_test_camera_tight_ports.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/model/little_endian.h"
#include "tests/rtl/blocks/camera_beats.h"
#include "tests/rtl/blocks/clocked.h"

namespace selfproj::test {
namespace {

Frame beats_of(const std::vector<std::uint8_t>& pixels, int columns) {
  Frame frame;
  for (std::size_t at = 0; at < pixels.size(); at += 4) {
    frame.push_back({model::load_little_endian<std::uint32_t>(pixels.data() + at), at == 0,
                     (at + 4) % static_cast<std::size_t>(columns) == 0});
  }
  return frame;
}

Frame model_frame(int columns, int rows, std::uint32_t number) {
  return beats_of(model::test_camera_frame(columns, rows, number), columns);
}

// Two runs: one of many frames, and one that ends in the middle of a frame. `gap`: clocks between two frames.
template <typename Camera>
void expect_frames_of_the_model(int columns, int rows, int gap) {
  Clocked<Camera> camera;
  name_ports(camera);
  camera->run_i = 0;
  camera->trigger_i = 0;
  camera->patterns_i = 0;
  camera.reset();
  const auto clock = [&] {
    camera.settle();
    const bool valid = camera->m_valid_o != 0;
    camera.rise();
    return valid;
  };
  const auto quiet = [&](int clocks) {
    for (int i = 0; i < clocks; ++i) {
      EXPECT_FALSE(clock()) << "clock " << camera.clock();
    }
  };
  quiet(5);
  for (const std::uint32_t frames : {70U, 3U}) {
    camera->run_i = 1;
    quiet(2);
    for (std::uint32_t number = 0; number < frames; ++number) {
      for (const Beat& due : model_frame(columns, rows, number)) {
        camera->run_i = number + 1 < frames;
        camera.settle();
        ASSERT_TRUE(camera->m_valid_o) << "a gap in frame " << number;
        ASSERT_EQ(beat_of(camera), due) << "frame " << number << ", clock " << camera.clock();
        camera.rise();
      }
      quiet(number + 1 < frames ? gap : 50);
    }
  }
}
TEST(TestCamera, FramesOfTheModel) { expect_frames_of_the_model<Vsp_test_camera>(64, 13, 240 - 64 / 4 * 13); }
TEST(TestCamera, FramesWithoutAGap) { expect_frames_of_the_model<Vsp_test_camera_tight>(16, 9, 0); }

// Frames by triggers, one of them while a frame is under way, and free again after a pause.
TEST(TestCamera, FramesByTriggers) {
  constexpr int kFrameClocks = 240;
  constexpr int kPause = 1024;
  Clocked<Vsp_test_camera> camera;
  camera->run_i = 1;
  camera->trigger_i = 0;
  camera->patterns_i = 0;
  camera.reset();
  std::vector<std::int64_t> starts;
  std::uint32_t number = 0;
  const auto clocks = [&](int count) {
    for (int i = 0; i < count; ++i) {
      camera.settle();
      if (camera->m_valid_o && camera->m_start_o) {
        EXPECT_EQ(beat_of(camera), model_frame(64, 13, number++).front());
        starts.push_back(camera.clock());
      }
      camera.rise();
    }
  };
  clocks(3 * kFrameClocks);
  EXPECT_EQ(starts.size(), 3U);
  std::vector<std::int64_t> due = starts;
  for (const int distance : {350, 290, 60, 700}) {  // to the next; the last comes while the frame before is under way
    if (distance != 700) {
      due.push_back(camera.clock() + 2);
    }
    camera->trigger_i = 1;
    clocks(5);
    camera->trigger_i = 0;
    clocks(distance - 5);
  }
  EXPECT_EQ(starts, due);
  clocks(kPause - 700 + 1);
  EXPECT_EQ(starts.size(), due.size());
  clocks(kFrameClocks);
  EXPECT_EQ(starts.size(), due.size() + 1);
}

// Patterns in the order of the triggers, also of those that are missed, from 0 again after a pause, and the line again.
TEST(TestCamera, PatternsByTriggers) {
  constexpr int kColumns = 64;
  constexpr int kRows = 13;
  constexpr int kBits = 5;
  Clocked<Vsp_test_camera> camera;
  name_ports(camera);
  camera->run_i = 1;
  camera->trigger_i = 0;
  camera->patterns_i = 1;
  camera.reset();
  Frame frame;
  std::vector<Frame> came;
  const auto clocks = [&](int count) {
    for (int i = 0; i < count; ++i) {
      camera.settle();
      if (camera->m_valid_o) {
        frame.push_back(beat_of(camera));
        if (frame.size() == std::size_t{kColumns / 4 * kRows}) {
          came.push_back(std::exchange(frame, {}));
        }
      }
      camera.rise();
    }
  };
  const auto trigger = [&](int distance) {
    camera->trigger_i = 1;
    clocks(3);
    camera->trigger_i = 0;
    clocks(distance - 3);
  };
  std::vector<Frame> due;
  const auto expect = [&](int index) {
    due.push_back(beats_of(model::test_camera_pattern(kColumns, kRows, kBits, index), kColumns));
  };
  clocks(2000);
  EXPECT_TRUE(came.empty()) << "a frame without a trigger";
  for (int i = 0; i < 3 * kBits * 2 + 3; ++i) {
    trigger(300);
    expect(i % (2 * kBits));
  }
  trigger(100);  // pattern 3, while whose frame is under way comes the next trigger
  expect(3);
  trigger(300);
  trigger(300);
  expect(5);
  clocks(1200);  // a pause
  trigger(300);
  trigger(300);
  expect(0);
  expect(1);
  camera->patterns_i = 0;
  clocks(3);
  camera->patterns_i = 1;
  trigger(300);
  expect(0);
  ASSERT_EQ(came.size(), due.size());
  for (std::size_t i = 0; i < due.size(); ++i) {
    EXPECT_TRUE(came[i] == due[i]) << "frame " << i;
  }
  camera->patterns_i = 0;
  trigger(300);
  ASSERT_EQ(came.size(), due.size() + 1);
  bool line = false;
  for (std::uint32_t number = 0; number < 100; ++number) {
    line = line || came.back() == model_frame(kColumns, kRows, number);
  }
  EXPECT_TRUE(line);
}

// The decoder finds the codes that the head of the module promises.
TEST(TestCamera, CodesAreKnown) {
  for (const int bits : {1, 4, 8, 12}) {
    constexpr int kColumns = 512;
    constexpr int kRows = 96;
    model::GrayDecoder decoder({.rows = kRows, .columns = kColumns, .bits = bits, .threshold = 5});
    std::vector<std::uint16_t> codes(std::size_t{kColumns} * kRows);
    for (int index = 0; index < 2 * bits; ++index) {
      const std::vector<std::uint8_t> pixels = model::test_camera_pattern(kColumns, kRows, bits, index);
      const bool done = decoder.add_frame(
          {.pixels = pixels.data(), .rows = kRows, .columns = kColumns, .stride = kColumns}, index, true, codes.data());
      EXPECT_EQ(done, index + 1 == 2 * bits);
    }
    for (unsigned y = 0; y < kRows; ++y) {
      for (unsigned x = 0; x < kColumns; ++x) {
        const std::uint16_t word = codes[y * std::size_t{kColumns} + x];
        ASSERT_EQ(model::is_measurable(word), y + 1 < kRows || bits == 1)
            << bits << " bits, column " << x << ", row " << y;
        if (y + 1 < kRows) {
          ASSERT_EQ(model::code_of(word), (x + y) % (1U << static_cast<unsigned>(bits)));
        }
      }
    }
  }
}

// The moments that the head of the module promises, from its words alone: binary, threshold 128.
TEST(TestCamera, MomentsAreKnown) {
  constexpr int kColumns = 512;
  constexpr int kRows = 96;
  for (const std::uint32_t number : {0U, 1U, 91U, 92U, 93U, 1000U}) {
    const std::vector<std::uint8_t> pixels = model::test_camera_frame(kColumns, kRows, number);
    model::Moments moments;
    moments.resize(kColumns);
    model::column_moments({.pixels = pixels.data(), .rows = kRows, .columns = kColumns, .stride = kColumns},
                          model::Mode::binary, 128, moments.view());
    for (std::uint32_t x = 0; x < kColumns; ++x) {
      const std::uint32_t first = (number + x / 8) % (kRows - 3);
      const std::uint32_t weight = (x + number) % 64;
      const std::uint32_t lit = 4 - (weight == 0 ? 1U : 0U) - (weight == 63 ? 1U : 0U);
      // Rows count from 1.
      const std::uint32_t sum = 4 * first + 10 - (weight == 0 ? first + 1 : 0) - (weight == 63 ? first + 4 : 0);
      ASSERT_EQ(moments.m0[x], lit) << "frame " << number << ", column " << x;
      ASSERT_EQ(moments.m1[x], sum) << "frame " << number << ", column " << x;
    }
  }
}

}  // namespace
}  // namespace selfproj::test
