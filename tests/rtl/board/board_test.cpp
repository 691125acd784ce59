// The whole board against the model, packet by packet and byte by byte.
#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "Vboard.h"
#include "Vboard_original.h"
#include "tests/rtl/board/scoreboard.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// An image of random content: noise, or a line as a camera would see it, or an extreme.
std::vector<std::uint8_t> random_image(Random& random, int rows, int columns) {
  const auto size = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  switch (random.between(0, 5)) {
    case 0:
      return std::vector<std::uint8_t>(size, 0);
    case 1:
      return std::vector<std::uint8_t>(size, 255);
    case 2: {
      std::vector<std::uint8_t> image(size, 0);
      image[static_cast<std::size_t>(random.between(0, static_cast<int>(size) - 1))] = 255;
      return image;
    }
    default:
      return random.bytes(size);
  }
}

ImageView view_of(const std::vector<std::uint8_t>& image, int rows, int columns) {
  return {.pixels = image.data(), .rows = rows, .columns = columns, .stride = columns};
}

TEST(Board, TakesOneFrame) {
  Scoreboard<Vboard> board;
  board.write({.columns = 8, .rows = 3, .mode = Mode::binary, .threshold = 100});
  Random random(1);
  const auto image = random.bytes(24);
  board.device().send(view_of(image, 3, 8));
  board.finish();
  EXPECT_EQ(board.delivered(spec::kKindMoments), 1U);
  EXPECT_EQ(board.lost(spec::kKindMoments), 0U);
}

// Small frames of every size, mode and threshold, with random gaps in the video and stalls on the bus; raw images in
// some.
template <class Model>
void random_small_frames(std::uint64_t seed, int changes, int max_columns, int max_rows, bool grey, bool image,
                         std::uint64_t& frames) {
  Random random(seed);
  Scoreboard<Model> board({.seed = seed,
                           .video_period_ps = static_cast<std::uint64_t>(random.between(5000, 9000)),
                           .bus_period_ps = static_cast<std::uint64_t>(random.between(3000, 12000)),
                           .bus_phase_ps = static_cast<std::uint64_t>(random.between(0, 5000))});
  board.turn_encoder(random.between(4, 40));
  board.count_patterns_on_frames(random.between(0, 23));
  for (int change = 0; change < changes; ++change) {
    const BoardSettings settings = {
        .image = image && random.chance(30),
        .columns = 4 * random.between(1, random.chance(70) ? 8 : max_columns / 4),
        .rows = random.between(1, random.chance(70) ? 6 : max_rows),
        .mode = grey ? static_cast<Mode>(random.between(0, 2)) : Mode::binary,
        .threshold = random.chance(20) ? 255 * random.between(0, 1) : random.between(0, 255),
        .stream = random.between(0, 255)};
    board.write(settings);
    board.device().set_video_gap_percent(random.chance(40) ? 0 : random.between(0, 60));
    board.device().set_bus_stall_percent(random.chance(40) ? 0 : random.between(0, 95));
    const int burst = random.between(1, 12);
    const bool spaced = random.chance(60);
    for (int i = 0; i < burst; ++i) {
      const auto pixels = random_image(random, settings.rows, settings.columns);
      board.device().send(view_of(pixels, settings.rows, settings.columns));
      if (spaced) {
        board.device().gap(static_cast<std::uint32_t>(random.between(0, 3 * settings.columns + 60)));
      }
    }
    // Until the beats are in; packets may still be on their way when the settings change.
    while (board.device().queued() != 0) {
      board.device().run(1);
    }
    if (::testing::Test::HasFatalFailure() || ::testing::Test::HasNonfatalFailure()) {
      return;
    }
  }
  board.finish();
  frames += board.model().frames();
  EXPECT_EQ(board.delivered(spec::kKindMoments) + board.lost(spec::kKindMoments), board.model().frames());
}

TEST(Board, RandomSmallFramesEqualTheModel) {
  std::uint64_t frames = 0;
  for (const std::uint64_t seed : seeds(40)) {
    SCOPED_TRACE(how_to_repeat(seed));
    random_small_frames<Vboard>(seed, 100, 64, 40, true, true, frames);
    if (HasFailure()) {
      return;
    }
  }
  RecordProperty("frames", std::to_string(frames));
  std::printf("%llu frames\n", static_cast<unsigned long long>(frames));
}

TEST(OriginalBoard, RandomSmallFramesEqualTheModel) {
  std::uint64_t frames = 0;
  for (const std::uint64_t seed : seeds(40)) {
    SCOPED_TRACE(how_to_repeat(seed));
    random_small_frames<Vboard_original>(seed, 100, 64, 40, false, false, frames);
    if (HasFailure()) {
      return;
    }
  }
  std::printf("%llu frames\n", static_cast<unsigned long long>(frames));
}

}  // namespace
}  // namespace selfproj::test
