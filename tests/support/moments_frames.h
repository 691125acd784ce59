// Random frames for whatever computes column moments and strongest runs.
#ifndef SELFPROJ_TESTS_SUPPORT_MOMENTS_FRAMES_H
#define SELFPROJ_TESTS_SUPPORT_MOMENTS_FRAMES_H

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "selfproj/model/column_moments.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/packet.h"
#include "selfproj/model/packet_payload.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

inline const std::vector<model::Mode> kModes{model::Mode::binary, model::Mode::grey, model::Mode::grey_over};

struct MomentsFrame {
  int columns = 4;
  int rows = 1;
  model::Mode mode = model::Mode::binary;
  int threshold = 0;
  int bits = 8;                                 // of a pixel
  std::vector<std::uint8_t> pixels = {};        // row by row
  std::vector<std::uint16_t> wide_pixels = {};  // instead, where there are more than 8 bits
  model::Select select = model::Select::all;
  int gap = 0;
  model::RowWindow window = {};
};

// The payload of its packet, by the model.
inline std::vector<std::uint8_t> payload_of_moments(const MomentsFrame& frame) {
  std::vector<std::uint8_t> payload(model::moments_payload_bytes(frame.mode, frame.columns));
  model::Runs runs;
  runs.resize(frame.select, frame.columns);
  const model::Measure measure{.mode = frame.mode,
                               .threshold = frame.threshold,
                               .select = frame.select,
                               .gap = frame.gap,
                               .window = frame.window,
                               .bits = frame.bits};
  model::PacketHeader header;
  header.kind = spec::kKindMoments;
  model::describe_frame(header, frame.rows, frame.columns, measure);
  const auto measure_image = [&]<typename Pixel>(const std::vector<Pixel>& pixels) {
    model::measure_columns(model::PixelView<Pixel>{pixels.data(), frame.rows, frame.columns, frame.columns}, measure,
                           runs.view());
  };
  if (frame.bits > 8) {
    measure_image(frame.wide_pixels);
  } else {
    measure_image(frame.pixels);
  }
  model::pack_columns(header, runs.view(), payload.data());
  return payload;
}

// Gives a frame pixels and a threshold of more than 8 bits. Those of its 8 are their upper bits.
inline void widen(Random& random, int bits, MomentsFrame& frame) {
  const int shift = bits - 8;
  const auto wide = [&](int value) {
    const int low = random.between(0, (1 << shift) - 1);
    return (value << shift) + (value == 255 && random.chance(70) ? (1 << shift) - 1 : value == 0 ? 0 : low);
  };
  frame.bits = bits;
  frame.threshold = wide(frame.threshold);
  for (const std::uint8_t pixel : frame.pixels) {
    frame.wide_pixels.push_back(static_cast<std::uint16_t>(wide(pixel)));
  }
  frame.pixels.clear();
}

// Pixels of few values or dark stretches, so that columns have several runs and equal ones.
inline void fill_with_runs(Random& random, int threshold, std::vector<std::uint8_t>& pixels) {
  const int dark_percent = random.between(10, 90);
  const int values = random.chance(50) ? random.between(1, 3) : 255;
  for (std::uint8_t& pixel : pixels) {
    const int lit = std::min(threshold + random.between(1, values), 255);
    pixel = static_cast<std::uint8_t>(random.chance(dark_percent) ? random.between(0, threshold) : lit);
  }
}

// `runs`: the frame mostly asks for the strongest runs, and has several of them in a column.
inline MomentsFrame random_moments_frame(Random& random, int columns, int rows, model::Mode mode, bool runs = false) {
  MomentsFrame frame;
  frame.columns = columns;
  frame.rows = rows;
  frame.mode = mode;
  frame.threshold = random.chance(20) ? 0 : random.chance(10) ? 255 : random.between(0, 255);
  frame.pixels = random.bytes(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  if (random.chance(15)) {  // all pixels have one value, mostly an extreme one
    std::fill(frame.pixels.begin(), frame.pixels.end(),
              static_cast<std::uint8_t>(random.chance(70) ? 255 : random.between(0, 255)));
  } else if (runs && random.chance(85)) {
    frame.threshold = random.chance(50) ? 0 : random.between(0, 254);
    fill_with_runs(random, frame.threshold, frame.pixels);
  }
  if (runs) {
    frame.select = random.chance(75) ? model::Select::strongest : model::Select::all;
    frame.gap = random.between(0, 3);
  }
  if (random.chance(30)) {
    frame.window = {.first = random.between(0, rows), .last = random.chance(30) ? 0 : random.between(0, rows)};
  }
  return frame;
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_SUPPORT_MOMENTS_FRAMES_H
