// Random small frames through the board: the body of the random tests and of the soak.
#ifndef SELFPROJ_TESTS_RTL_BOARD_RANDOM_FRAMES_H
#define SELFPROJ_TESTS_RTL_BOARD_RANDOM_FRAMES_H

#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/rtl/board/frames.h"
#include "tests/rtl/board/scoreboard.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

// The abilities of the build under test, and how much of them to try.
struct RandomFrames {
  int max_columns = 64;
  int max_rows = 40;  // more than spec::kMaxRows: of a build for them
  int pixel_bits = spec::kPixelBits;
  int lanes = spec::kPixelsPerBeat;  // pixels in a beat
  bool grey = true;                  // modes grey and grey_over
  bool image = true;                 // raw images
  bool runs = false;                 // the strongest run of a column
  bool region = true;                // the register region
  bool compact = false;              // compact columns
  int fault_percent = 0;             // share of frames with faults
  int changes = 100;                 // number of changes of the settings, each followed by 1 to 12 frames
  // gets every image that is sent, without its faults
  std::function<void(const TestImage&, const model::BoardSettings&)> also = nullptr;
};

// Counts over many runs.
struct FrameCounts {
  std::uint64_t frames = 0;
  std::uint64_t delivered = 0;
  std::uint64_t lost = 0;
  std::uint64_t image_delivered = 0;
  std::uint64_t image_lost = 0;
  std::uint64_t bytes = 0;
  std::map<std::uint32_t, std::uint64_t> by_status;
};

// Of a soak without mismatches, for report_soak.
inline nlohmann::ordered_json figures_of(const FrameCounts& counts) {
  return {{"frames", counts.frames}, {"packets", counts.delivered}, {"image_lines", counts.image_delivered},
          {"bytes", counts.bytes},   {"lost_counted", counts.lost}, {"mismatches", 0}};
}

// Plays frames of random size, mode, threshold and content, with or without gaps between beats and between frames,
// stalls on the bus, and a turning encoder. Every packet is compared with the model's; missing packets must be counted.
template <class Model>
void play_random_frames(std::uint64_t seed, const RandomFrames& limits, FrameCounts& counts) {
  Random random(seed);
  Scoreboard<Model> board(random_board_clocks(random, seed, limits.pixel_bits, limits.lanes), true,
                          limits.max_rows > spec::kMaxRows);
  const int largest = (1 << limits.pixel_bits) - 1;
  board.turn_encoder(random.between(4, 40));
  board.count_patterns_on_frames(random.between(0, 23));
  int last_rows = 1;
  int last_columns = limits.lanes;
  for (int change = 0; change < limits.changes && !::testing::Test::HasFailure(); ++change) {
    const int rows = random.between(1, random.chance(70) ? 6 : limits.max_rows);
    const bool strongest = limits.runs && random.chance(75);
    const model::BoardSettings settings = {
        .image = limits.image && random.chance(30),
        .columns = limits.lanes * random.between(1, random.chance(70) ? 8 : limits.max_columns / limits.lanes),
        .rows = rows,
        .mode = limits.grey ? static_cast<model::Mode>(random.between(0, 2)) : model::Mode::binary,
        .threshold = random.chance(20) ? largest * random.between(0, 1) : random.between(0, largest),
        .select = strongest ? model::Select::strongest : model::Select::all,
        .gap = limits.runs ? random.between(0, 3) : 0,
        .window = {.first = random.chance(70) ? 0 : random.between(0, rows),
                   .last = random.chance(70) ? 0 : random.between(0, rows)},
        .stream = random.between(0, 255),
        .region_row = limits.region ? random.between(0, 65535) : 0,
        .region_column = limits.region ? random.between(0, 65535) : 0,
        .compact = limits.compact && random.chance(60),
        .timeout = random.chance(50) ? 0 : random.between(1, 200)};
    board.write(settings);
    last_rows = rows;
    last_columns = settings.columns;
    board.device().set_video_gap_percent(random.chance(40) ? 0 : random.between(0, 60));
    board.device().set_bus_stall_percent(random.chance(40) ? 0 : random.between(0, 95));
    const int burst = random.between(1, 12);
    const bool spaced = random.chance(60);
    for (int i = 0; i < burst; ++i) {
      const TestImage image = limits.runs && random.chance(75)
                                  ? random_runs_image(random, settings.rows, settings.columns,
                                                      settings.threshold >> (limits.pixel_bits - spec::kPixelBits))
                                  : random_image(random, settings.rows, settings.columns);
      if (limits.also) {
        limits.also(image, settings);
      }
      board.send(random, image, limits.fault_percent);
      if (spaced) {
        board.device().gap(static_cast<std::uint32_t>(random.between(0, 3 * settings.columns + 60)));
      }
    }
    // Packets may still be on their way when the settings change.
    board.play();
  }
  // The last frame may have been cut in its last row: the board may have counted it as lost, but whether it has ended,
  // and what its packet would be, only the next start tells.
  if (board.model().frame_open()) {
    for (const auto& line : lines_of(constant_image(last_rows, last_columns, 0), limits.lanes)) {
      for (const model::VideoBeat& beat : line) {
        board.device().send(beat);
      }
    }
    board.play();
  }
  board.finish();
  EXPECT_EQ(board.delivered(spec::kKindMoments) + board.lost(spec::kKindMoments), board.model().frames());
  counts.frames += board.model().frames();
  counts.delivered += board.delivered(spec::kKindMoments);
  counts.lost += board.lost(spec::kKindMoments);
  counts.image_delivered += board.delivered(spec::kKindImage);
  counts.image_lost += board.lost(spec::kKindImage);
  counts.bytes += board.bytes();
  for (const auto& [status, count] : board.by_status()) {
    counts.by_status[status] += count;
  }
}

// The same with many seeds: one in `min_delivered` frames must arrive, and losses must occur.
template <class Model>
FrameCounts play_all_random_frames(int cases, const RandomFrames& limits, std::uint64_t min_delivered = 2) {
  FrameCounts counts;
  for_cases(cases, [&](std::uint64_t seed) { play_random_frames<Model>(seed, limits, counts); });
  if (runs_all_cases()) {
    EXPECT_GT(counts.delivered, counts.frames / min_delivered) << "too little of the board was observed";
    EXPECT_GT(counts.lost, 0U) << "there were no losses";
  }
  return counts;
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BOARD_RANDOM_FRAMES_H
