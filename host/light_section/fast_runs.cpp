#include "host/light_section/fast_runs.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "host/light_section/fast_moments.h"
#include "model/cpu_clones.h"

namespace selfproj {
namespace {

// Columns that are processed at a time. What is kept of such a strip stays in the first-level cache.
constexpr int kRunColumns = 256;
// Rows after which the numbers of runs are limited, so that they fit in 8 bits.
constexpr int kLimitRows = 128;

using RunStrip = std::array<std::uint8_t, kRunColumns>;

inline std::uint8_t narrow_run(int value) { return static_cast<std::uint8_t>(value); }

[[gnu::always_inline]] inline void limit_to_two(RunStrip& count, int columns) {
  for (int i = 0; i < columns; ++i) {
    count[i] = std::min<std::uint8_t>(count[i], 2);
  }
}

// Whether a run starts in a block of Gap + 1 rows. Bit k of `lit` is row k of the block, from the top, and `before` is
// the same of the block above it. At most one run can start, at the first lit row, and only if the Gap + 1 rows above
// that are dark: those of this block are, and those of the block above are the bits of `before` from that of the row
// on.
template <int Gap>
[[gnu::always_inline]] inline std::uint8_t starts_in(std::uint8_t before, std::uint8_t lit) {
  if constexpr (Gap == 0) {
    return narrow_run(lit & ~before);
  } else {
    const std::uint8_t first = narrow_run(lit & -lit);
    return before < first ? 1 : 0;
  }
}

// Counts the runs of at most kRunColumns columns: 0, 1, or 2 where there are two or more. `columns` is strip.columns;
// if it is a constant, the loops need no remainder.
template <int Gap>
[[gnu::always_inline]] inline void count_strip(const ImageView& strip, int columns, std::uint8_t threshold,
                                               RunStrip& count) {
  constexpr int kRows = Gap + 1;                            // of a block
  constexpr int kBlocks = Gap == 0 ? 4 : Gap == 3 ? 1 : 2;  // that are processed at a time
  constexpr int kAllRows = kBlocks * kRows;
  static constexpr RunStrip kDark{};
  alignas(64) RunStrip above{};  // the last block of the rows above
  count.fill(0);
  int rows_to_limit = kLimitRows;
  for (int row = 0; row < strip.rows; row += kAllRows) {
    std::array<const std::uint8_t*, kAllRows> pixels{};
    for (int k = 0; k < kAllRows; ++k) {
      pixels[k] = row + k < strip.rows ? strip.pixels + (row + k) * strip.stride : kDark.data();
    }
    for (int i = 0; i < columns; ++i) {
      std::uint8_t before = above[i];
      std::uint8_t starts = 0;
      for (int block = 0; block < kBlocks; ++block) {
        std::uint8_t lit = 0;
        for (int k = 0; k < kRows; ++k) {
          lit |= pixels[block * kRows + k][i] > threshold ? narrow_run(1 << k) : narrow_run(0);
        }
        starts = narrow_run(starts + starts_in<Gap>(before, lit));
        before = lit;
      }
      count[i] = narrow_run(count[i] + starts);
      above[i] = before;
    }
    rows_to_limit -= kAllRows;
    if (rows_to_limit < kAllRows) {
      limit_to_two(count, columns);
      rows_to_limit = kLimitRows;
    }
  }
  limit_to_two(count, columns);
}

template <int Gap>
[[gnu::always_inline]] inline void count_either(const ImageView& strip, std::uint8_t threshold, RunStrip& count) {
  if (strip.columns == kRunColumns) {
    count_strip<Gap>(strip, kRunColumns, threshold, count);
  } else {
    count_strip<Gap>(strip, strip.columns, threshold, count);
  }
}

SELFPROJ_CLONES void count_runs(const ImageView& strip, std::uint8_t threshold, int gap, RunStrip& count) {
  static_assert(kMaxGap == 3);
  switch (gap) {
    case 0:
      return count_either<0>(strip, threshold, count);
    case 1:
      return count_either<1>(strip, threshold, count);
    case 2:
      return count_either<2>(strip, threshold, count);
    default:
      return count_either<3>(strip, threshold, count);
  }
}

// The first column from `from` on with two runs or more, or `columns`. Looks at eight columns at once.
int next_several(const std::uint8_t* runs, int from, int columns) {
  constexpr std::uint64_t kTwo = 0x0202020202020202;
  int i = from;
  for (std::uint64_t eight = 0; i + 8 <= columns; i += 8) {
    std::memcpy(&eight, runs + i, sizeof eight);
    if ((eight & kTwo) != 0) {
      break;
    }
  }
  while (i < columns && runs[i] < 2) {
    ++i;
  }
  return i;
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
  alignas(64) RunStrip count;
  for (int first = 0; first < image.columns; first += kRunColumns) {
    const int columns = std::min(kRunColumns, image.columns - first);
    count_runs({part.pixels + first, part.rows, columns, part.stride}, narrow_run(measure.threshold), measure.gap,
               count);
    std::copy_n(count.data(), columns, out.runs + first);
  }
  for (int i = next_several(out.runs, 0, image.columns); i < image.columns;
       i = next_several(out.runs, i + 1, image.columns)) {
    column_runs({image.pixels + i, image.rows, 1, image.stride}, measure, from_column(out, i));
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
