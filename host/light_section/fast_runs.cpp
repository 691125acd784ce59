#include "host/light_section/fast_runs.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "host/light_section/fast_moments.h"
#include "model/cpu_clones.h"

// The compiler vectorizes the loops over columns below for each instruction set of SELFPROJ_CLONES.

namespace selfproj {
namespace {

// Columns that are processed at a time. What is kept of such a strip stays in the registers and the first-level cache.
constexpr int kRunColumns = 256;
constexpr int kRunRows = 32;  // after which the numbers of runs are limited, so that they fit in 8 bits

using RunStrip = std::array<std::uint8_t, kRunColumns>;

inline std::uint8_t narrow_run(int value) { return static_cast<std::uint8_t>(value); }

// Counts the runs of at most kRunColumns columns: 0, 1, or 2 where there are two or more. A run starts at a lit pixel
// above which there are more than `gap` dark rows. Without a gap, that is a lit pixel below a dark one. `columns` is
// strip.columns; if it is a constant, the loops need no remainder.
[[gnu::always_inline]] inline void count_without_gap(const ImageView& strip, int columns, std::uint8_t threshold,
                                                     RunStrip& runs) {
  alignas(64) RunStrip above{};  // 1: the pixel above is lit
  alignas(64) RunStrip count{};
  for (int row = 0; row < strip.rows; ++row) {
    const std::uint8_t* pixels = strip.pixels + row * strip.stride;
    for (int i = 0; i < columns; ++i) {
      const std::uint8_t lit = pixels[i] > threshold ? 1 : 0;
      count[i] = narrow_run(count[i] + (lit & ~above[i]));
      above[i] = lit;
    }
    if (row % kRunRows == kRunRows - 1) {
      for (int i = 0; i < columns; ++i) {
        count[i] = std::min<std::uint8_t>(count[i], 2);
      }
    }
  }
  for (int i = 0; i < columns; ++i) {
    runs[i] = std::min<std::uint8_t>(count[i], 2);
  }
}

[[gnu::always_inline]] inline void count_with_gap(const ImageView& strip, int columns, std::uint8_t threshold,
                                                  std::uint8_t gap, RunStrip& runs) {
  alignas(64) RunStrip dark;  // rows since the last lit pixel, kMaxGap + 1 at most
  alignas(64) RunStrip count{};
  dark.fill(kMaxGap + 1);
  for (int row = 0; row < strip.rows; ++row) {
    const std::uint8_t* pixels = strip.pixels + row * strip.stride;
    for (int i = 0; i < columns; ++i) {
      const bool lit = pixels[i] > threshold;
      const std::uint8_t start = dark[i] > gap ? 1 : 0;
      count[i] = narrow_run(count[i] + (lit ? start : 0));
      dark[i] = lit ? narrow_run(0) : std::min(narrow_run(dark[i] + 1), narrow_run(kMaxGap + 1));
    }
    if (row % kRunRows == kRunRows - 1) {
      for (int i = 0; i < columns; ++i) {
        count[i] = std::min<std::uint8_t>(count[i], 2);
      }
    }
  }
  for (int i = 0; i < columns; ++i) {
    runs[i] = std::min<std::uint8_t>(count[i], 2);
  }
}

SELFPROJ_CLONES void count_runs(const ImageView& strip, std::uint8_t threshold, std::uint8_t gap, RunStrip& runs) {
  if (gap > 0) {
    count_with_gap(strip, strip.columns, threshold, gap, runs);
  } else if (strip.columns == kRunColumns) {
    count_without_gap(strip, kRunColumns, threshold, runs);
  } else {
    count_without_gap(strip, strip.columns, threshold, runs);
  }
}

RunsView from_column(const RunsView& view, int first) {
  return {{view.moments.m0 + first, view.moments.m1 + first, view.moments.n + first},
          view.runs + first,
          view.second + first};
}

}  // namespace

void fast_column_runs(const ImageView& image, const Measure& measure, const RunsView& out) {
  check_column_runs(image, measure, out);
  const RowWindow& window = measure.window;
  const int above = std::min(std::max(window.first - 1, 0), image.rows);  // rows that do not count
  const int end = window.last == 0 ? image.rows : std::min(window.last, image.rows);
  if (end <= above) {
    column_runs(image, measure, out);  // nothing counts
    return;
  }
  const ImageView part = {image.pixels + above * image.stride, end - above, image.columns, image.stride};
  fast_column_moments(part, measure.mode, measure.threshold, out.moments);
  for (int i = 0; above > 0 && i < image.columns; ++i) {
    out.moments.m1[i] += static_cast<std::uint32_t>(above) * out.moments.m0[i];
  }
  std::fill_n(out.second, image.columns, std::uint8_t{0});
  alignas(64) RunStrip runs;
  for (int first = 0; first < image.columns; first += kRunColumns) {
    const int columns = std::min(kRunColumns, image.columns - first);
    count_runs({part.pixels + first, part.rows, columns, part.stride}, narrow_run(measure.threshold),
               narrow_run(measure.gap), runs);
    for (int i = 0; i < columns; ++i) {
      out.runs[first + i] = runs[static_cast<std::size_t>(i)];
      if (runs[static_cast<std::size_t>(i)] > 1) {
        column_runs({image.pixels + first + i, image.rows, 1, image.stride}, measure, from_column(out, first + i));
      }
    }
  }
}

void fast_measure_columns(const ImageView& image, const Measure& measure, const RunsView& out) {
  if (measure.select == Select::strongest) {
    fast_column_runs(image, measure, out);
  } else if (measure.window == RowWindow{}) {
    fast_column_moments(image, measure.mode, measure.threshold, out.moments);
  } else {
    column_moments(image, measure.mode, measure.threshold, out.moments, measure.window);
  }
}

}  // namespace selfproj
