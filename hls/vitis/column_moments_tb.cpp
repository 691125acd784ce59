// Test bench of column_moments_top() for an HLS tool's C simulation and co-simulation: random frames, every column
// compared with the definition. Returns 0 where all is right. C++14, nothing but the kernel's own header and the
// standard library.
#include <cstdint>
#include <cstdio>
#include <vector>

#include "hls/column_moments.h"

namespace {

namespace kernel = selfproj::hls;
namespace spec = selfproj::spec;

// A small generator of its own: the same frames on every machine.
std::uint32_t random_bits() {
  static std::uint64_t state = 1;
  state = state * 6364136223846793005U + 1442695040888963407U;
  return static_cast<std::uint32_t>(state >> 33U);
}

struct Bench {
  kernel::Stream<kernel::AxisBeat<32>> video;
  kernel::Stream<kernel::AxisBeat<128>> payload;
  int wrong = 0;
  int columns_compared = 0;

  void frame(unsigned columns, unsigned rows, unsigned mode, unsigned threshold) {
    std::vector<std::uint8_t> pixels(columns * rows);
    for (std::uint8_t& pixel : pixels) {
      pixel = static_cast<std::uint8_t>(random_bits());
    }
    const unsigned beats = mode == 0 ? columns / 4 : columns / 2;
    unsigned calls = 0;
    for (std::size_t at = 0; at < pixels.size(); at += 4) {
      const std::uint32_t four = pixels[at] | std::uint32_t{pixels[at + 1]} << 8U |
                                 std::uint32_t{pixels[at + 2]} << 16U | std::uint32_t{pixels[at + 3]} << 24U;
      video.write(kernel::axis_beat<32>(four, at == 0, at % columns == columns - 4));
    }
    for (; calls < columns * rows / 4 + 2 * beats + 16; ++calls) {
      column_moments_top(video, columns, rows, mode, threshold, 0, 0, payload);
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
      std::uint64_t m0 = 0;
      std::uint64_t m1 = 0;
      std::uint64_t n = 0;
      for (unsigned row = 1; row <= rows; ++row) {
        const unsigned pixel = pixels[(row - 1) * columns + column];
        if (pixel > threshold) {
          const unsigned weight = mode == 0 ? 1 : mode == 1 ? pixel : pixel - threshold;
          m0 += weight;
          m1 += std::uint64_t{weight} * row;
          ++n;
        }
      }
      const std::uint64_t right = mode == 0 ? m0 << unsigned{spec::kBinaryM0Lsb} | m1
                                            : n << unsigned{spec::kGreyNLsb} | m0 << unsigned{spec::kGreyM0Lsb} | m1;
      wrong += words[column] == right ? 0 : 1;
      ++columns_compared;
    }
  }
};

}  // namespace

int main() {
  Bench bench;
  for (unsigned mode = 0; mode < 3; ++mode) {
    bench.frame(4, 1, mode, 10);
    bench.frame(4, 9, mode, 10);
    bench.frame(8, 5, mode, 0);
    bench.frame(64, 12, mode, 100);
    bench.frame(128, 3, mode, 254);
  }
  std::printf("column_moments_tb: %d columns compared, %d wrong\n", bench.columns_compared, bench.wrong);
  return bench.wrong == 0 && bench.columns_compared == 3 * (4 + 4 + 8 + 64 + 128) ? 0 : 1;
}
