// Test bench of column_moments_top(): random frames, every column compared with the definition. Returns 0 where all is
// right.
#include <cstdint>
#include <cstdio>
#include <vector>

#include "hls/column_moments.h"
#include "hls/vitis/bench.h"

namespace {

namespace kernel = selfproj::hls;
namespace spec = selfproj::spec;

kernel::Stream<kernel::AxisBeat<32>> g_video;
kernel::Stream<kernel::AxisBeat<128>> g_payload;

// The word of a column, by the definition; its pixels are `stride` apart.
std::uint64_t right_word(const std::uint8_t* pixels, unsigned stride, unsigned rows, unsigned mode,
                         unsigned threshold) {
  std::uint64_t m0 = 0;
  std::uint64_t m1 = 0;
  std::uint64_t n = 0;
  for (unsigned row = 1; row <= rows; ++row) {
    const unsigned pixel = pixels[(row - 1) * stride];
    if (pixel > threshold) {
      const unsigned weight = mode == 0 ? 1 : mode == 1 ? pixel : pixel - threshold;
      m0 += weight;
      m1 += std::uint64_t{weight} * row;
      ++n;
    }
  }
  return mode == 0 ? m0 << unsigned{spec::kBinaryM0Lsb} | m1
                   : n << unsigned{spec::kGreyNLsb} | m0 << unsigned{spec::kGreyM0Lsb} | m1;
}

// Returns how many columns are wrong.
int frame(unsigned columns, unsigned rows, unsigned mode, unsigned threshold) {
  std::vector<std::uint8_t> pixels(columns * rows);
  for (std::uint8_t& pixel : pixels) {
    pixel = static_cast<std::uint8_t>(bench::random_bits());
  }
  bench::send(pixels, columns, g_video);
  for (unsigned call = 0; call < bench::calls_of_frame(columns, rows, mode); ++call) {
    column_moments_top(g_video, columns, rows, mode, threshold, 0, 0, g_payload);
  }
  return bench::wrong_words(bench::receive(columns, mode, g_payload), columns, [&](unsigned column) {
    return right_word(pixels.data() + column, columns, rows, mode, threshold);
  });
}

}  // namespace

int main() {
  int wrong = 0;
  for (unsigned mode = 0; mode < 3; ++mode) {
    wrong += frame(4, 1, mode, 10);
    wrong += frame(4, 9, mode, 10);
    wrong += frame(8, 5, mode, 0);
    wrong += frame(64, 12, mode, 100);
    wrong += frame(128, 3, mode, 254);
  }
  std::printf("column_moments_tb: %d columns are wrong\n", wrong);
  return wrong == 0 ? 0 : 1;
}
