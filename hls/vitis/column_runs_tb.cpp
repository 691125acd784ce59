// Test bench of column_runs_top(): random frames, every column compared with the definition. Returns 0 where all is
// right.
#include <cstdint>
#include <cstdio>
#include <vector>

#include "hls/column_runs.h"
#include "hls/vitis/bench.h"

namespace {

namespace kernel = selfproj::hls;
namespace spec = selfproj::spec;

kernel::Stream<kernel::AxisBeat<32>> g_video;
kernel::Stream<kernel::AxisBeat<128>> g_payload;

struct Run {
  std::uint64_t m0 = 0;
  std::uint64_t m1 = 0;
  std::uint64_t n = 0;
};

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

// Returns how many columns are wrong. The pixels have few values, so that a column has several runs and equal ones.
int frame(unsigned columns, unsigned rows, unsigned mode, unsigned threshold, unsigned gap) {
  std::vector<std::uint8_t> pixels(columns * rows);
  for (std::uint8_t& pixel : pixels) {
    pixel = static_cast<std::uint8_t>(bench::random_bits() % 2 != 0 ? 0 : threshold + 1 + bench::random_bits() % 2);
  }
  bench::send(pixels, columns, g_video);
  for (unsigned call = 0; call < bench::calls_of_frame(columns, rows, mode); ++call) {
    column_runs_top(g_video, columns, rows, mode, threshold, 1, gap, 0, 0, g_payload);
  }
  return bench::wrong_words(bench::receive(columns, mode, g_payload), columns, [&](unsigned column) {
    return right_word(pixels.data() + column, columns, rows, mode, threshold, gap);
  });
}

}  // namespace

int main() {
  int wrong = 0;
  for (unsigned mode = 0; mode < 3; ++mode) {
    for (unsigned gap = 0; gap < 4; ++gap) {
      wrong += frame(4, 1, mode, 10, gap);
      wrong += frame(4, 9, mode, 10, gap);
      wrong += frame(8, 5, mode, 0, gap);
      wrong += frame(64, 12, mode, 100, gap);
      wrong += frame(128, 30, mode, 253, gap);
    }
  }
  std::printf("column_runs_tb: %d columns are wrong\n", wrong);
  return wrong == 0 ? 0 : 1;
}
