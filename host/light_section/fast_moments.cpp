#include "selfproj/light_section/fast_moments.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "model/cpu_clones.h"
#include "selfproj/model/generated/selfproj_spec.h"

namespace selfproj::light_section {

// The compiler vectorizes the loops over columns below for each instruction set of SELFPROJ_CLONES.

namespace {

// How the sums are computed. With the running sum S(ξ) = Σ_{k <= ξ} w(k) of a column of R rows, a weight w(k) is in S
// from row k to row R. It thus enters the sum of all S exactly R + 1 - k times:
//
//     Σ_ξ S(ξ) = Σ_k (R + 1 - k) w(k) = (R + 1) M0 - M1        so        M1 = (R + 1) M0 - Σ_ξ S(ξ)
//
// This needs additions only. The rows are cut into blocks of L <= kBlockRows rows. Within a block the running sum s
// starts from 0 again. With B = M0 of all rows above the block, S = B + s, and the block contributes
//
//     Σ S = L B + P,        P = Σ s,        s += w and P += s for each row
//
// P is at most w_max · L (L + 1) / 2. With L <= 22 this is 253 for w = 1 and 64,515 for w = 255. So sums of 8 bits are
// enough in mode binary, and sums of 16 bits in the grey modes; one AVX-512 instruction adds 64 or 32 columns. The sums
// are widened once for each block.
constexpr int kBlockRows = 22;
static_assert(kBlockRows * (kBlockRows + 1) / 2 <= 255, "the prefix sums of a block must fit in 8 bits");
static_assert(255 * kBlockRows * (kBlockRows + 1) / 2 <= 65535, "and those of grey weights in 16 bits");
// In mode binary the contribution L B + P of a block and M0 itself have 16 bits.
static_assert(kBlockRows * spec::kMaxRows + 255 <= 65535, "the share of a block must fit in 16 bits");

// Columns that are processed at a time. The sums of such a strip stay in the first-level cache.
constexpr int kStripColumns = 512;

template <typename T>
using Strip = std::array<T, kStripColumns>;

struct StripSums {
  alignas(64) Strip<std::uint32_t> m0;
  alignas(64) Strip<std::uint32_t> m1;
  alignas(64) Strip<std::uint32_t> n;
};

inline std::uint8_t narrow8(int value) { return static_cast<std::uint8_t>(value); }
inline std::uint16_t narrow16(int value) { return static_cast<std::uint16_t>(value); }

// Prefetches a row a little before it is needed. The processor's own prefetch follows one row well, but stops at the
// end of a page and pauses while the sums are widened.
[[gnu::always_inline]] inline void prefetch_row(const model::ImageView& strip, int columns, int row) {
  constexpr int kAhead = 8;
  constexpr int kCacheLine = 64;
  if (row + kAhead < strip.rows) {
    const std::uint8_t* pixels = strip.pixels + (row + kAhead) * strip.stride;
    for (int i = 0; i < columns; i += kCacheLine) {
      __builtin_prefetch(pixels + i);
    }
  }
}

// The moments of at most kStripColumns columns in mode binary; does not touch n.
//
// `columns` is strip.columns. If it is a constant, the compiler keeps the sums of a block in registers, which is twice
// as fast. Below there is therefore one copy for a full strip and one for any other.
[[gnu::always_inline]] inline void add_up_binary(const model::ImageView& strip, int columns, std::uint8_t threshold,
                                                 StripSums& out) {
  alignas(64) Strip<std::uint8_t> sum;          // s
  alignas(64) Strip<std::uint8_t> prefix;       // P
  alignas(64) Strip<std::uint16_t> share;       // L B + P
  alignas(64) Strip<std::uint16_t> m0{};        // B
  alignas(64) Strip<std::uint32_t> all_sums{};  // Σ S
  for (int above = 0; above < strip.rows; above += kBlockRows) {
    const int rows = std::min(kBlockRows, strip.rows - above);
    sum.fill(0);
    prefix.fill(0);
    for (int row = above; row < above + rows; ++row) {
      prefetch_row(strip, columns, row);
      const std::uint8_t* pixels = strip.pixels + row * strip.stride;
      for (int i = 0; i < columns; ++i) {
        sum[i] = narrow8(sum[i] + (pixels[i] > threshold ? 1 : 0));
        prefix[i] = narrow8(prefix[i] + sum[i]);
      }
    }
    const std::uint16_t factor = narrow16(rows);
    for (int i = 0; i < columns; ++i) {
      share[i] = narrow16(factor * m0[i] + prefix[i]);
      m0[i] = narrow16(m0[i] + sum[i]);
    }
    for (int i = 0; i < columns; ++i) {
      all_sums[i] += share[i];
    }
  }
  const auto factor = static_cast<std::uint32_t>(strip.rows + 1);
  for (int i = 0; i < columns; ++i) {
    out.m0[i] = m0[i];
    out.m1[i] = factor * m0[i] - all_sums[i];
  }
}

// The moments of at most kStripColumns columns in a grey mode: a lit pixel weighs its value less `offset`, which is at
// most the threshold. Loops that mix sums of 8 and 16 bits do not vectorize well, so there is one loop for each width.
[[gnu::always_inline]] inline void add_up_grey(const model::ImageView& strip, int columns, std::uint8_t threshold,
                                               std::uint8_t offset, StripSums& out) {
  alignas(64) Strip<std::uint8_t> weight;       // w
  alignas(64) Strip<std::uint8_t> count;        // lit pixels in the block
  alignas(64) Strip<std::uint16_t> sum;         // s
  alignas(64) Strip<std::uint16_t> prefix;      // P
  alignas(64) Strip<std::uint32_t> m0{};        // B
  alignas(64) Strip<std::uint32_t> all_sums{};  // Σ S
  alignas(64) Strip<std::uint16_t> n{};
  for (int above = 0; above < strip.rows; above += kBlockRows) {
    const int rows = std::min(kBlockRows, strip.rows - above);
    count.fill(0);
    sum.fill(0);
    prefix.fill(0);
    for (int row = above; row < above + rows; ++row) {
      prefetch_row(strip, columns, row);
      const std::uint8_t* pixels = strip.pixels + row * strip.stride;
      for (int i = 0; i < columns; ++i) {
        const std::uint8_t pixel = pixels[i];
        count[i] = narrow8(count[i] + (pixel > threshold ? 1 : 0));
        weight[i] = pixel > threshold ? narrow8(pixel - offset) : narrow8(0);
      }
      for (int i = 0; i < columns; ++i) {
        sum[i] = narrow16(sum[i] + weight[i]);
        prefix[i] = narrow16(prefix[i] + sum[i]);
      }
    }
    const auto factor = static_cast<std::uint32_t>(rows);
    for (int i = 0; i < columns; ++i) {
      all_sums[i] += factor * m0[i] + prefix[i];
      m0[i] += sum[i];
    }
    for (int i = 0; i < columns; ++i) {
      n[i] = narrow16(n[i] + count[i]);
    }
  }
  const auto factor = static_cast<std::uint32_t>(strip.rows + 1);
  for (int i = 0; i < columns; ++i) {
    out.m0[i] = m0[i];
    out.m1[i] = factor * m0[i] - all_sums[i];
    out.n[i] = n[i];
  }
}

SELFPROJ_CLONES void strip_binary(const model::ImageView& strip, std::uint8_t threshold, StripSums& out) {
  if (strip.columns == kStripColumns) {
    add_up_binary(strip, kStripColumns, threshold, out);
  } else {
    add_up_binary(strip, strip.columns, threshold, out);
  }
}

SELFPROJ_CLONES void strip_grey(const model::ImageView& strip, std::uint8_t threshold, std::uint8_t offset,
                                StripSums& out) {
  if (strip.columns == kStripColumns) {
    add_up_grey(strip, kStripColumns, threshold, offset, out);
  } else {
    add_up_grey(strip, strip.columns, threshold, offset, out);
  }
}

}  // namespace

void fast_column_moments(const model::ImageView& image, model::Mode mode, int threshold,
                         const model::MomentsView& out) {
  model::check_column_moments(image, mode, threshold, out);
  const std::uint8_t level = narrow8(threshold);
  for (int first = 0; first < image.columns; first += kStripColumns) {
    const int columns = std::min(kStripColumns, image.columns - first);
    const model::ImageView strip = {image.pixels + first, image.rows, columns, image.stride};
    StripSums sums;  // filled below as far as it is read
    if (mode == model::Mode::binary) {
      strip_binary(strip, level, sums);
      std::copy_n(sums.m0.data(), columns, out.n + first);
    } else {
      strip_grey(strip, level, mode == model::Mode::grey_over ? level : narrow8(0), sums);
      std::copy_n(sums.n.data(), columns, out.n + first);
    }
    std::copy_n(sums.m0.data(), columns, out.m0 + first);
    std::copy_n(sums.m1.data(), columns, out.m1 + first);
  }
}

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
[[gnu::always_inline]] inline void count_strip(const model::ImageView& strip, int columns, std::uint8_t threshold,
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
[[gnu::always_inline]] inline void count_either(const model::ImageView& strip, std::uint8_t threshold,
                                                RunStrip& count) {
  if (strip.columns == kRunColumns) {
    count_strip<Gap>(strip, kRunColumns, threshold, count);
  } else {
    count_strip<Gap>(strip, strip.columns, threshold, count);
  }
}

SELFPROJ_CLONES void count_runs(const model::ImageView& strip, std::uint8_t threshold, int gap, RunStrip& count) {
  static_assert(model::kMaxGap == 3);
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

model::RunsView from_column(const model::RunsView& view, int first) {
  return {{view.moments.m0 + first, view.moments.m1 + first, view.moments.n + first},
          view.runs + first,
          view.second + first};
}

}  // namespace

void fast_column_runs(const model::ImageView& image, const model::Measure& measure, const model::RunsView& out) {
  model::check_column_runs(image, measure, out);
  const model::RowWindow& window = measure.window;
  const int above = std::min(std::max(window.first - 1, 0), image.rows);  // rows that do not count
  const int end = window.last == 0 ? image.rows : std::min(window.last, image.rows);
  if (end <= above) {
    model::column_runs(image, measure, out);  // nothing counts
    return;
  }
  const model::ImageView part = {image.pixels + above * image.stride, end - above, image.columns, image.stride};
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
    model::column_runs({image.pixels + i, image.rows, 1, image.stride}, measure, from_column(out, i));
  }
}

void fast_measure_columns(const model::ImageView& image, const model::Measure& measure, const model::RunsView& out) {
  if (measure.select == model::Select::strongest) {
    fast_column_runs(image, measure, out);
  } else if (measure.window == model::RowWindow{}) {
    fast_column_moments(image, measure.mode, measure.threshold, out.moments);
  } else {
    model::column_moments(image, measure.mode, measure.threshold, out.moments, measure.window);
  }
}

}  // namespace selfproj::light_section
