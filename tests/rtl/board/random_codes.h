// Random sequences of Gray-code frames through the board: the body of the random tests of its decoder.
#ifndef SELFPROJ_TESTS_RTL_BOARD_RANDOM_CODES_H
#define SELFPROJ_TESTS_RTL_BOARD_RANDOM_CODES_H

#include <cstdint>
#include <functional>
#include <map>

#include "tests/rtl/board/frames.h"
#include "tests/rtl/board/scoreboard.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

struct CodeCounts {
  std::uint64_t frames = 0;
  std::uint64_t delivered = 0;  // lines of codes
  std::uint64_t lost = 0;
  std::uint64_t abandoned = 0;
  std::map<std::uint32_t, std::uint64_t> by_status;
};

// The maxima of the smallest board with a decoder.
inline constexpr int kMaxCodeColumns = 64;
inline constexpr int kMaxCodeRows = 40;

// Plays sequences of frames of random size, m and content with changing settings, gaps, faults, and stalls on the bus.
// Every packet of every kind is compared with the model's; missing packets must be counted. `begin` is called first and
// may preset the board's counters; `end` is called at the end.
template <class Model>
void play_random_sequences(std::uint64_t seed, bool full_build, int fault_percent, CodeCounts& counts,
                           const std::function<void(Scoreboard<Model>&, Random&)>& begin = {},
                           const std::function<void(Scoreboard<Model>&)>& end = {}, int pixel_bits = spec::kPixelBits,
                           int lanes = spec::kPixelsPerBeat) {
  Random random(seed);
  Scoreboard<Model> board(random_board_clocks(random, seed, pixel_bits, lanes), full_build);
  if (begin) {
    begin(board, random);
  }
  const int bits = random.between(1, 3);
  board.count_patterns_on_frames(random.chance(90) ? 2 * bits - 1 : random.between(0, 255));
  board.turn_encoder(random.between(4, 40), random.chance(50));
  model::BoardSettings settings;
  for (int change = 0; change < 40 && !::testing::Test::HasFailure(); ++change) {
    if (change == 0 || random.chance(60)) {
      settings.columns = lanes * random.between(1, random.chance(50) ? 6 : kMaxCodeColumns / lanes);
      settings.rows = random.between(1, random.chance(60) ? 4 : kMaxCodeRows / 4);
    }
    settings.image = full_build && random.chance(30);
    settings.mode = full_build ? static_cast<model::Mode>(random.between(0, 2)) : model::Mode::binary;
    settings.threshold = random.between(0, (1 << pixel_bits) - 1);
    settings.stream = random.between(0, 255);
    settings.select = settings.stream % 2 == 0 ? model::Select::strongest : model::Select::all;
    settings.gap = settings.stream / 2 % 4;
    settings.region_row = 257 * settings.stream;
    settings.region_column = 65535 - settings.region_row;
    settings.timeout = random.chance(70) ? 0 : random.between(20, 200);
    settings.codes = random.chance(95);
    settings.median = full_build && random.chance(60);
    settings.code_bits = random.chance(90) ? bits : random.between(1, 8);
    settings.code_threshold = random.between(0, random.chance(80) ? 60 : 255);
    board.write(settings);
    board.device().set_video_gap_percent(random.chance(40) ? 0 : random.between(0, 60));
    board.device().set_bus_stall_percent(random.chance(60) ? 0 : random.between(0, 95));
    const bool spaced = random.chance(70);
    for (int i = random.between(1, 20); i > 0; --i) {
      const TestImage image = random_image(random, settings.rows, settings.columns);
      board.send(random, image, fault_percent);
      if (spaced) {
        board.device().gap(static_cast<std::uint32_t>(random.between(0, random.chance(50) ? 12 : 120)));
      }
    }
    board.play();
  }
  board.finish();
  if (end) {
    end(board);
  }
  counts.frames += board.model().frames();
  counts.delivered += board.delivered(spec::kKindCodes);
  counts.lost += board.lost(spec::kKindCodes);
  counts.abandoned += board.model().abandoned();
  for (const auto& [status, count] : board.by_status()) {
    counts.by_status[status] += count;
  }
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BOARD_RANDOM_CODES_H
