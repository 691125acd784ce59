// What the test benches for HLS tools share. They feed random frames to a kernel and compare every result with the
// definition, in the tool's C simulation and co-simulation. C++14, nothing but the kernels' own headers and the
// standard library.
#ifndef SELFPROJ_HLS_VITIS_BENCH_H
#define SELFPROJ_HLS_VITIS_BENCH_H

#include <cstddef>
#include <cstdint>
#include <vector>

#include "hls/types.h"

namespace bench {

namespace kernel = selfproj::hls;

// A small generator of its own: the same frames on every machine.
inline std::uint32_t random_bits() {
  static std::uint64_t state = 1;
  state = state * 6364136223846793005U + 1442695040888963407U;
  return static_cast<std::uint32_t>(state >> 33U);
}

// An image as AXI4-Stream video.
inline void send(const std::vector<std::uint8_t>& pixels, unsigned columns,
                 kernel::Stream<kernel::AxisBeat<32>>& video) {
  for (std::size_t at = 0; at < pixels.size(); at += 4) {
    const std::uint32_t four = pixels[at] | std::uint32_t{pixels[at + 1]} << 8U | std::uint32_t{pixels[at + 2]} << 16U |
                               std::uint32_t{pixels[at + 3]} << 24U;
    video.write(kernel::axis_beat<32>(four, at == 0, at % columns == columns - 4));
  }
}

// How often a kernel of moments is to be called for a frame, until its last beat has left.
inline unsigned calls_of_frame(unsigned columns, unsigned rows, unsigned mode) {
  return columns * rows / 4 + (mode == 0 ? columns / 2 : columns) + 16;
}

// The words of a frame's columns, 32 bits in mode binary, else 64. Empty where their number or the marks of the first
// and the last beat are wrong.
inline std::vector<std::uint64_t> receive(unsigned columns, unsigned mode,
                                          kernel::Stream<kernel::AxisBeat<128>>& payload) {
  const unsigned words_of_beat = mode == 0 ? 4 : 2;
  std::vector<std::uint64_t> words;
  bool marked = true;
  kernel::AxisBeat<128> beat;
  while (payload.read_nb(beat)) {
    kernel::AxisData<128> data = beat.data;
    marked = marked && (beat.user != 0) == words.empty();
    for (unsigned i = 0; i < words_of_beat; ++i) {
      words.push_back(mode == 0 ? data.to_uint() : data.to_uint64());
      data = data >> (mode == 0 ? 32 : 64);
    }
    marked = marked && (beat.last != 0) == (words.size() == columns);
  }
  return marked && words.size() == columns ? words : std::vector<std::uint64_t>();
}

// How many words are not those of `right(column)`; all, where there are not as many.
template <class Right>
int wrong_words(const std::vector<std::uint64_t>& words, unsigned columns, const Right& right) {
  int wrong = static_cast<int>(columns - words.size());
  for (unsigned column = 0; column < words.size(); ++column) {
    wrong += words[column] == right(column) ? 0 : 1;
  }
  return wrong;
}

}  // namespace bench

#endif  // SELFPROJ_HLS_VITIS_BENCH_H
