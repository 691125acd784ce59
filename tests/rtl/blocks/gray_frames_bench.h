// Random sequences of frames for the bench of the Gray-code decoder.
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_GRAY_FRAMES_BENCH_H
#define SELFPROJ_TESTS_RTL_BLOCKS_GRAY_FRAMES_BENCH_H

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "model/gray_decoder.h"
#include "tests/rtl/blocks/gray_bench.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

// All m, changing settings, missing, repeated and wrong patterns, frames that break anywhere, gaps between beats and
// between frames, and also frames of one beat without any gap.
struct GrayCases {
  int max_columns = 40;
  int max_rows = 6;
  int max_bits = GrayDecoder::kMaxBits;
  int frames = 100;
};

template <typename Dut>
void play_gray_frames(GrayBench<Dut>& bench, const GrayCases& cases, Random& random) {
  GraySettings& settings = bench.settings;
  int trouble = 0;  // per mille
  int gaps = 0;     // per cent
  int spaced = 0;   // clocks
  int pattern = 0;
  std::uint32_t pending_break = 0;
  std::vector<std::uint8_t> positive;
  for (int frame = 0; frame < cases.frames && !::testing::Test::HasFatalFailure(); ++frame) {
    if (frame == 0 || random.chance(3)) {
      bench.decode = !random.chance(3);
      settings.bits = frame != 0 && random.chance(50) ? settings.bits : random.between(1, cases.max_bits);
      settings.threshold = random.chance(20) ? random.between(0, 255) : random.between(0, 12);
      settings.columns = 4 * random.between(1, random.chance(50) ? 2 : cases.max_columns / 4);
      settings.rows = random.between(1, random.chance(50) ? 2 : cases.max_rows);
      trouble = random.chance(50) ? 0 : random.between(0, 400 / settings.bits);
      gaps = random.chance(60) ? 0 : random.between(1, 60);
      spaced = random.chance(50) ? 0 : random.between(0, 12);
    }
    // A frame that does not take over the new settings has the old size; it is easier to wait.
    while (!bench.may_take()) {
      bench.clock(std::nullopt, 0, pending_break);
      pending_break = 0;
    }
    const auto size = static_cast<std::size_t>(settings.rows) * static_cast<std::size_t>(settings.columns);
    if (random.between(1, 1000) <= trouble) {
      pattern = random.between(0, 2 * settings.bits - 1);
    }
    pattern %= 2 * settings.bits;
    const int shown = random.between(1, 1000) > trouble ? pattern
                      : random.chance(50)               ? random.between(0, 40)
                                                        : random.between(0, 0xFFFF);
    pattern = (pattern + 1) % (2 * settings.bits);
    std::vector<std::uint8_t> pixels = random.bytes(size);
    if (shown % 2 == 1 && positive.size() == size) {
      for (std::size_t i = 0; i < size; ++i) {  // around the threshold, on both sides
        const int edge = (pixels[i] & 1) != 0 ? settings.threshold : -settings.threshold;
        const int near = positive[i] - edge + random.between(-2, 2);
        if (random.chance(60) && near >= 0 && near <= 255) {
          pixels[i] = static_cast<std::uint8_t>(near);
        }
      }
    }
    positive = pixels;
    const std::size_t beats = size / 4;
    const std::size_t cut =
        random.between(1, 1000) <= trouble ? static_cast<std::size_t>(random.bits() % beats) : beats;
    const auto groups = static_cast<std::size_t>(settings.columns / 4);
    for (std::size_t i = 0; i < beats && i <= cut; ++i) {
      GrayBeat beat;
      std::copy_n(pixels.begin() + static_cast<std::ptrdiff_t>(4 * i), 4, beat.pixels.begin());
      beat.start = i == 0;
      beat.line_start = i % groups == 0;
      beat.line_end = i % groups == groups - 1 && i != cut;
      beat.last_row = i / groups == static_cast<std::size_t>(settings.rows) - 1;
      bench.clock(beat, shown, pending_break);
      pending_break = 0;
      while (random.chance(gaps)) {
        bench.clock(std::nullopt, 0, 0);
      }
      if (::testing::Test::HasFatalFailure()) {
        return;
      }
    }
    if (cut < beats) {
      bench.idle(random.between(0, 3));
      pending_break =
          static_cast<std::uint32_t>(random.between(1, 7));  // with the next clock, or the next frame's start
      if (random.chance(50)) {
        bench.clock(std::nullopt, 0, std::exchange(pending_break, 0U));
      }
    }
    for (int i = spaced == 0 ? 0 : random.between(0, spaced); i > 0; --i) {
      bench.clock(std::nullopt, 0, std::exchange(pending_break, 0U));
    }
  }
  bench.clock(std::nullopt, 0, pending_break);
  bench.idle(20);
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_GRAY_FRAMES_BENCH_H
