// Test bench of column_runs_top() for an HLS tool's C simulation and co-simulation: random frames, every column
// compared with the definition. Returns 0 where all is right. C++14, nothing but the kernel's own header and the
// standard library.
#include <cstdint>
#include <cstdio>
#include <vector>

#include "hls/column_runs.h"

namespace {

namespace kernel = selfproj::hls;
namespace spec = selfproj::spec;

struct Run {
  std::uint64_t m0 = 0;
  std::uint64_t m1 = 0;
  std::uint64_t n = 0;
};

// A small generator of its own: the same frames on every machine.
std::uint32_t random_bits() {
  static std::uint64_t state = 1;
  state = state * 6364136223846793005U + 1442695040888963407U;
  return static_cast<std::uint32_t>(state >> 33U);
}

// The word of a column, by the definition; its pixels are `stride` apart.
std::uint64_t right_word(const std::uint8_t* pixels, unsigned stride, unsigned rows, unsigned mode, unsigned threshold,
                         unsigned gap) {
  Run run;
  Run best;
  std::uint64_t second = 0;
  std::uint64_t runs = 0;
  unsigned dark = 0;
  for (unsigned row = 1; row <= rows; ++row) {
    const unsigned pixel = pixels[(row - 1) * stride];
    if (pixel > threshold) {
      const unsigned weight = mode == 0 ? 1 : mode == 1 ? pixel : pixel - threshold;
      run.m0 += weight;
      run.m1 += std::uint64_t{weight} * row;
      ++run.n;
      dark = 0;
    } else {
      ++dark;
    }
    if (run.n != 0 && (dark > gap || row == rows)) {
      if (run.m0 > best.m0) {
        second = best.m0;
        best = run;
      } else if (run.m0 > second) {
        second = run.m0;
      }
      runs += runs < 3 ? 1 : 0;
      run = Run();
    }
  }
  const std::uint64_t share = best.m0 == 0 ? 0 : 16 * second / best.m0;
  if (mode == 0) {
    return runs << unsigned{spec::kBinaryRunRunsLsb} | best.m0 << unsigned{spec::kBinaryRunM0Lsb} |
           std::uint64_t{share >= 8} << unsigned{spec::kBinaryRunSecondLsb} | best.m1;
  }
  return share << unsigned{spec::kGreyRunSecondLsb} | runs << unsigned{spec::kGreyRunRunsLsb} |
         best.n << unsigned{spec::kGreyRunNLsb} | best.m0 << unsigned{spec::kGreyRunM0Lsb} | best.m1;
}

struct Bench {
  kernel::Stream<kernel::AxisBeat<32>> video;
  kernel::Stream<kernel::AxisBeat<128>> payload;
  int wrong = 0;
  int columns_compared = 0;

  // Pixels of few values, so that a column has several runs and equal ones.
  void frame(unsigned columns, unsigned rows, unsigned mode, unsigned threshold, unsigned gap) {
    std::vector<std::uint8_t> pixels(columns * rows);
    for (std::uint8_t& pixel : pixels) {
      pixel = static_cast<std::uint8_t>(random_bits() % 2 != 0 ? 0 : threshold + 1 + random_bits() % 2);
    }
    const unsigned beats = mode == 0 ? columns / 4 : columns / 2;
    unsigned calls = 0;
    for (std::size_t at = 0; at < pixels.size(); at += 4) {
      const std::uint32_t four = pixels[at] | std::uint32_t{pixels[at + 1]} << 8U |
                                 std::uint32_t{pixels[at + 2]} << 16U | std::uint32_t{pixels[at + 3]} << 24U;
      video.write(kernel::axis_beat<32>(four, at == 0, at % columns == columns - 4));
    }
    for (; calls < columns * rows / 4 + 2 * beats + 16; ++calls) {
      column_runs_top(video, columns, rows, mode, threshold, 1, gap, 0, 0, payload);
    }
    std::vector<std::uint64_t> words;  // 32 bits in mode binary, else 64
    kernel::AxisBeat<128> beat;
    unsigned taken = 0;
    while (payload.read_nb(beat)) {
      kernel::AxisData<128> data = beat.data;
      for (unsigned i = 0; i < (mode == 0 ? 4U : 2U); ++i) {
        words.push_back(mode == 0 ? data.to_uint() : data.to_uint64());
        data = data >> (mode == 0 ? 32 : 64);
      }
      ++taken;
      wrong += (beat.user != 0) != (taken == 1) || (beat.last != 0) != (taken == beats) ? 1 : 0;
    }
    if (words.size() != columns) {
      ++wrong;
      return;
    }
    for (unsigned column = 0; column < columns; ++column) {
      wrong += words[column] == right_word(pixels.data() + column, columns, rows, mode, threshold, gap) ? 0 : 1;
      ++columns_compared;
    }
  }
};

}  // namespace

int main() {
  Bench bench;
  for (unsigned mode = 0; mode < 3; ++mode) {
    for (unsigned gap = 0; gap < 4; ++gap) {
      bench.frame(4, 1, mode, 10, gap);
      bench.frame(4, 9, mode, 10, gap);
      bench.frame(8, 5, mode, 0, gap);
      bench.frame(64, 12, mode, 100, gap);
      bench.frame(128, 30, mode, 253, gap);
    }
  }
  std::printf("column_runs_tb: %d columns compared, %d wrong\n", bench.columns_compared, bench.wrong);
  return bench.wrong == 0 && bench.columns_compared == 12 * (4 + 4 + 8 + 64 + 128) ? 0 : 1;
}
