// Tests waveforms for a window of frames.
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "Vboard.h"
#include "Vboard_traced.h"
#include "tests/rtl/board/frames.h"
#include "tests/rtl/board/scoreboard.h"

namespace selfproj::test {
namespace {

std::string scratch(const char* name) {
  return (std::filesystem::path(::testing::TempDir()) / (std::string("selfproj_trace_test_") + name)).string();
}

// Waveforms do not change the board's behaviour, and a longer window gives a larger file.
TEST(BoardTrace, WritesTheWindowAskedFor) {
  std::uintmax_t size[2] = {};
  for (int window = 0; window < 2; ++window) {
    const std::string file = scratch(window == 0 ? "short.fst" : "long.fst");
    std::filesystem::remove(file);
    Random random(1);
    Scoreboard<Vboard_traced> board({.trace_file = file});
    board.write({.columns = 64, .rows = 8, .threshold = 100});
    for (int frame = 0; frame < 20; ++frame) {
      if (frame == 5) {
        board.device().start_trace();
      }
      if (frame == (window == 0 ? 6 : 15)) {
        board.device().stop_trace();
      }
      board.device().send(random_image(random, 8, 64).view());
      board.play();
      board.device().run(100);
    }
    board.finish();
    EXPECT_EQ(board.delivered(spec::kKindMoments), 20U);
    ASSERT_TRUE(std::filesystem::exists(file));
    size[window] = std::filesystem::file_size(file);
    std::filesystem::remove(file);
  }
  EXPECT_GT(size[0], 1000U);
  EXPECT_GT(size[1], size[0]);
}

TEST(BoardTrace, AModelWithoutWaveformsSaysSo) {
  sim::BoardDevice<Vboard> device;
  EXPECT_THROW(device.start_trace(), std::logic_error);
}

TEST(BoardTrace, AFileThatCannotBeWrittenIsAnError) {
  sim::BoardDevice<Vboard_traced> device({.trace_file = "/nonexistent/selfproj/trace.fst"});
  EXPECT_THROW(device.start_trace(), std::runtime_error);
}

}  // namespace
}  // namespace selfproj::test
