// Test bench of gray_decoder_top(): random pairs of patterns, every code compared with the definition. Returns 0 where
// all is right.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "hls/gray_decoder.h"
#include "hls/vitis/bench.h"

namespace {

namespace kernel = selfproj::hls;
using Image = std::vector<std::uint8_t>;
using Codes = std::vector<unsigned>;

// The code of a pixel out of the whole history, images 2p and 2p + 1 being the pair p of all.
unsigned code_of(const std::vector<Image>& history, std::size_t pixel, unsigned bits, int threshold) {
  const std::size_t pairs = history.size() / 2;
  unsigned word = 0;
  unsigned ambiguous = 0;
  for (std::size_t pair = pairs - bits; pair < pairs; ++pair) {
    const std::size_t plane = pair % bits;
    bool bit = false;
    for (std::size_t k = pair - plane; k <= pair; ++k) {
      bit = bit != (history[2 * k][pixel] - history[2 * k + 1][pixel] > threshold);
    }
    const int difference = history[2 * pair][pixel] - history[2 * pair + 1][pixel];
    ambiguous += difference <= threshold && difference >= -threshold ? 1 : 0;
    word |= bit ? 1U << (bits - 1 - plane) : 0U;
  }
  return word | (ambiguous <= 1 ? 0x8000U : 0U);
}

Codes median(const Codes& codes, int rows, int columns) {
  Codes out;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      Codes found;
      std::size_t existing = 0;
      for (int r = std::max(row - 1, 0); r <= std::min(row + 1, rows - 1); ++r) {
        for (int c = std::max(column - 1, 0); c <= std::min(column + 1, columns - 1); ++c) {
          const unsigned word = codes[static_cast<std::size_t>(r * columns + c)];
          ++existing;
          if (word >= 0x8000U) {
            found.push_back(word);
          }
        }
      }
      std::sort(found.begin(), found.end());
      out.push_back(2 * found.size() > existing ? found[(found.size() + 1) / 2 - 1] : 0);
    }
  }
  return out;
}

int g_wrong = 0;
int g_compared = 0;

void sequence(unsigned columns, unsigned rows, unsigned bits, unsigned threshold, bool filtered) {
  kernel::Stream<kernel::AxisBeat<32>> video;
  kernel::Stream<kernel::AxisBeat<64>> codes;
  std::vector<Image> history;
  for (unsigned frame = 0; frame < 4 * bits + 2; ++frame) {
    Image image(columns * rows);
    for (std::size_t i = 0; i < image.size(); ++i) {
      const unsigned near =
          frame % 2 == 0 ? bench::random_bits() : history.back()[i] + bench::random_bits() % (3 * threshold + 8);
      image[i] = static_cast<std::uint8_t>(near);
    }
    history.push_back(image);
    bench::send(image, columns, video);
    for (unsigned call = 0; call < columns * rows / 4 + columns / 4 + 16; ++call) {
      gray_decoder_top(video, columns, rows, bits, threshold, filtered ? 1 : 0, frame % (2 * bits), codes);
    }
    Codes found;
    kernel::AxisBeat<64> beat;
    while (codes.read_nb(beat)) {
      const std::uint64_t words = beat.data.to_uint64();
      for (unsigned i = 0; i < 4; ++i) {
        found.push_back(static_cast<unsigned>(words >> (16 * i) & 0xFFFFU));
      }
    }
    Codes right;
    if (frame % 2 == 1 && history.size() / 2 >= bits) {
      for (std::size_t i = 0; i < image.size(); ++i) {
        right.push_back(code_of(history, i, bits, static_cast<int>(threshold)));
      }
      right = filtered ? median(right, static_cast<int>(rows), static_cast<int>(columns)) : right;
    }
    g_wrong += found == right ? 0 : 1;
    g_compared += static_cast<int>(right.size());
  }
}

}  // namespace

int main() {
  sequence(4, 1, 1, 5, false);
  sequence(8, 3, 2, 5, true);
  sequence(16, 6, 12, 3, false);
  sequence(32, 8, 4, 10, true);
  std::printf("gray_decoder_tb: %d codes compared, %d images wrong\n", g_compared, g_wrong);
  return g_wrong == 0 && g_compared > 2500 ? 0 : 1;
}
