// Frames for the tests of the board: images, and beats that break the rules.
#ifndef SELFPROJ_TESTS_RTL_BOARD_FRAMES_H
#define SELFPROJ_TESTS_RTL_BOARD_FRAMES_H

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "selfproj/model/board.h"
#include "selfproj/model/column_moments.h"
#include "sim/board/board_device.h"
#include "tests/support/moments_frames.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

// An image with its pixels, row after row.
struct TestImage {
  int rows = 0;
  int columns = 0;
  std::vector<std::uint8_t> pixels;

  [[nodiscard]] model::ImageView view() const {
    return {.pixels = pixels.data(), .rows = rows, .columns = columns, .stride = columns};
  }
};

inline TestImage constant_image(int rows, int columns, std::uint8_t value) {
  return {rows, columns,
          std::vector<std::uint8_t>(static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns), value)};
}

// Mostly noise; sometimes all dark, all bright, or one bright pixel.
inline TestImage random_image(Random& random, int rows, int columns) {
  TestImage image = constant_image(rows, columns, 0);
  switch (random.between(0, 7)) {
    case 0:
      break;
    case 1:
      image = constant_image(rows, columns, 255);
      break;
    case 2:
      image.pixels[static_cast<std::size_t>(random.between(0, static_cast<int>(image.pixels.size()) - 1))] = 255;
      break;
    default:
      image.pixels = random.bytes(image.pixels.size());
  }
  return image;
}

// An image for the strongest runs: pixels of few values, so that columns have several runs and equal ones.
inline TestImage random_runs_image(Random& random, int rows, int columns, int threshold) {
  TestImage image = constant_image(rows, columns, 0);
  fill_with_runs(random, threshold, image.pixels);
  return image;
}

// The frame as beats of this many pixels, line by line.
using Lines = std::vector<std::vector<model::VideoBeat>>;
inline Lines lines_of(const TestImage& image, int lanes = spec::kPixelsPerBeat) {
  Lines lines(static_cast<std::size_t>(image.rows));
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.columns; column += lanes) {
      model::VideoBeat beat;
      std::copy_n(image.pixels.data() + static_cast<std::ptrdiff_t>(row) * image.columns + column, lanes,
                  beat.pixels.begin());
      beat.start = row == 0 && column == 0;
      beat.line_end = column + lanes == image.columns;
      lines[static_cast<std::size_t>(row)].push_back(beat);
    }
  }
  return lines;
}

// The faults that a frame can have.
enum class Fault : std::uint8_t {
  none,
  short_line,      // beats are missing at the end of a line
  long_line,       // a line has too many beats
  missing_line,    // a whole line is missing
  doubled_line,    // a line comes twice
  missing_start,   // no beat carries the start
  start_in_frame,  // a beat in the middle carries the start
  cut,             // the frame ends early
};
inline constexpr int kFaults = 8;

// Puts the fault into the line `row` at the beat `group`.
inline std::vector<model::VideoBeat> with_fault(Lines lines, Fault fault, int row, int group) {
  auto& line = lines[static_cast<std::size_t>(row)];
  switch (fault) {
    case Fault::none:
      break;
    case Fault::short_line:
      line.resize(static_cast<std::size_t>(group) + 1);
      line.back().line_end = true;
      break;
    case Fault::long_line:
      line.back().line_end = false;
      line.push_back({.pixels = {9, 8, 7, 6}, .start = false, .line_end = true});
      break;
    case Fault::missing_line:
      lines.erase(lines.begin() + row);
      break;
    case Fault::doubled_line: {
      auto copy = line;
      copy.front().start = false;
      lines.insert(lines.begin() + row + 1, copy);
      break;
    }
    case Fault::missing_start:
      lines.front().front().start = false;
      break;
    case Fault::start_in_frame:
      line[static_cast<std::size_t>(group)].start = true;
      break;
    case Fault::cut:
      line.resize(static_cast<std::size_t>(group) + 1);
      line.back().line_end = line.back().line_end && row + 1 == static_cast<int>(lines.size());
      lines.resize(static_cast<std::size_t>(row) + 1);
      break;
  }
  std::vector<model::VideoBeat> beats;
  for (const auto& each : lines) {
    beats.insert(beats.end(), each.begin(), each.end());
  }
  return beats;
}

// The beats of the image, in this share of calls with a fault of any kind at any place.
inline std::vector<model::VideoBeat> beats_with_faults(Random& random, const TestImage& image, int fault_percent,
                                                       int lanes) {
  const Fault fault = random.chance(fault_percent) ? static_cast<Fault>(random.between(0, kFaults - 1)) : Fault::none;
  return with_fault(lines_of(image, lanes), fault, random.between(0, image.rows - 1),
                    random.between(0, image.columns / lanes - 1));
}

// Gives the pixels of 8 bits `below` more, all 0, all 1, or any.
inline void append_bits(Random& random, int below, std::vector<model::VideoBeat>& beats) {
  const int ones = (1 << below) - 1;
  const int all = random.between(-1, 2);  // 0 or 1: all bits are that
  for (model::VideoBeat& beat : beats) {
    for (std::uint16_t& pixel : beat.pixels) {
      const int more = all == 0 ? 0 : all == 1 ? ones : random.between(0, ones);
      pixel = static_cast<std::uint16_t>(pixel << below | more);
    }
  }
}

// Clocks of any periods and phase.
inline sim::BoardDeviceOptions random_board_clocks(Random& random, std::uint64_t seed,
                                                   int pixel_bits = spec::kPixelBits,
                                                   int lanes = spec::kPixelsPerBeat) {
  return {.seed = seed,
          .video_period_ps = static_cast<std::uint64_t>(random.between(5000, 9000)),
          .bus_period_ps = static_cast<std::uint64_t>(random.between(3000, 12000)),
          .bus_phase_ps = static_cast<std::uint64_t>(random.between(0, 5000)),
          .pixel_bits = pixel_bits,
          .lanes = lanes};
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BOARD_FRAMES_H
