#include "selfproj/light_section/fast_moments.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

#include "model/cpu_clones.h"
#include "selfproj/model/generated/selfproj_spec.h"

namespace selfproj::light_section {

// The compiler vectorizes the loops over columns below for each instruction set of SELFPROJ_CLONES.

namespace {

// How the sums are computed. With the running sum S(ξ) = Σ_{k <= ξ} w(k) of a column of L rows, a weight w(k) is in S
// from row k to row L. It thus enters the sum P of all S exactly L + 1 - k times:
//
//     P = Σ_ξ S(ξ) = Σ_k (L + 1 - k) w(k) = (L + 1) M0 - M1        so        M1 = (L + 1) M0 - P
//
// This needs additions only: S += w and P += S for each row. The rows are cut into blocks of L <= kBlockRows rows. A
// block below `above` other rows adds S to M0 and (above + L + 1) S - P to M1.
//
// P is at most w_max · L (L + 1) / 2. With L <= 22 this is 253 for w = 1 and 64,515 for w = 255. So lanes as wide as a
// pixel are enough in mode binary, and lanes twice as wide in the grey modes. The sums are widened once for each block.
// Pixels of up to 12 bits lie in words of 16, for which the same holds for L <= 361; there are fewer rows in a block,
// so that its share of M1 in mode binary fits in 16 bits.
template <typename Pixel>
struct Lanes;
template <>
struct Lanes<std::uint8_t> {
  using Wide = std::uint16_t;  // twice as wide
  static constexpr int kBlockRows = 22;
  static constexpr int kBrightest = 255;
};
template <>
struct Lanes<std::uint16_t> {
  using Wide = std::uint32_t;
  static constexpr int kBlockRows = 32;
  static constexpr int kBrightest = (1 << model::kMaxPixelBits) - 1;
};
template <typename Pixel>
using Wide = typename Lanes<Pixel>::Wide;

template <typename Pixel>
constexpr bool lanes_hold() {
  using L = Lanes<Pixel>;
  constexpr int kPairs = L::kBlockRows * (L::kBlockRows + 1) / 2;
  return kPairs <= std::numeric_limits<Pixel>::max() && sizeof(Wide<Pixel>) == 2 * sizeof(Pixel) &&
         std::int64_t{L::kBrightest} * kPairs <= std::numeric_limits<Wide<Pixel>>::max() &&
         L::kBlockRows * spec::kRowLimit <= std::numeric_limits<std::uint16_t>::max();
}
static_assert(lanes_hold<std::uint8_t>() && lanes_hold<std::uint16_t>());

// How memory is read. A strip is as wide as a cache line. So the sums of a block stay in registers: 2 of the 32
// registers of AVX-512 in mode binary and 5 in the grey modes, 10 of the 16 of AVX2. The block of one strip is followed
// by the same rows of the next strip. A band of kBandStrips strips is as wide as the usual image, whose rows follow
// one another in memory; wider images are read band after band. Each pixel is read once, but for up to 63 columns of
// the last strip where the width is no multiple of 64.
//
// Memory answers late, and these loops do not load far enough ahead by themselves: so they reach 25 % of the speed at
// which one core can read it in one stream. Therefore each cache line is asked for, into the second-level cache, kAhead
// rows before it is needed. It is asked for several times, because a processor may drop such a request while too many
// are under way: when it was chosen (an EPYC of Zen 4), one request reached 63 % in mode binary, two 77 % and three 87
// %, and in the grey modes 78, 87 and 92 %. In cache, where nobody needs them, they cost a third of the speed in mode
// binary. Frames mostly follow one another, so the requests run on below the last row into the next frame. They are
// hints, which read nothing and never fault.
constexpr int kStripColumns = 64;
constexpr int kNarrowColumns = 16;  // of a strip in an image narrower than that
constexpr int kBandStrips = 8;
constexpr std::array kAhead = {48, 32, 16};

template <typename Pixel>
[[gnu::always_inline]] inline void prefetch_below(const Pixel* pixels, std::ptrdiff_t stride) {
  constexpr int kSecondLevel = 2;
  for (const int rows : kAhead) {
    for (int line = 0; line < static_cast<int>(sizeof(Pixel)); ++line) {
      __builtin_prefetch(pixels + rows * stride + line * kStripColumns / static_cast<int>(sizeof(Pixel)), 0,
                         kSecondLevel);
    }
  }
}

// Two neighbours as one word, the first one in its lower half.
template <typename Pixel>
[[gnu::always_inline]] inline Wide<Pixel> pair_at(const Pixel* pixels) {
  if constexpr (std::endian::native == std::endian::little) {
    Wide<Pixel> pair;
    std::memcpy(&pair, pixels, sizeof pair);
    return pair;
  } else {
    return static_cast<Wide<Pixel>>(pixels[0] | Wide<Pixel>{pixels[1]} << 8 * sizeof(Pixel));
  }
}

// Some rows of a strip, and the number of rows above them.
template <typename Pixel>
struct Block {
  const Pixel* pixels;
  std::ptrdiff_t stride;
  int above;
  int rows;
};

// The sums of a strip in mode binary. M0 and the share of a block in M1 fit in 16 bits.
template <int Columns>
struct BinarySums {
  static constexpr int kColumns = Columns;
  alignas(64) std::array<std::uint16_t, Columns> m0{};
  alignas(64) std::array<std::uint32_t, Columns> m1{};
};

// Adds a block in mode binary. Three operations a vector of pixels.
template <typename Pixel, int Columns>
[[gnu::always_inline]] inline void add_block(const Block<Pixel>& block, Pixel threshold, Pixel /*offset*/,
                                             BinarySums<Columns>& out) {
  alignas(64) std::array<Pixel, Columns> sum{};     // S
  alignas(64) std::array<Pixel, Columns> prefix{};  // P
  alignas(64) std::array<std::uint16_t, Columns> share;
  const Pixel* pixels = block.pixels;
  for (int row = 0; row < block.rows; ++row, pixels += block.stride) {
    prefetch_below(pixels, block.stride);
    for (int i = 0; i < Columns; ++i) {
      sum[i] = static_cast<Pixel>(sum[i] + (pixels[i] > threshold ? 1 : 0));
      prefix[i] = static_cast<Pixel>(prefix[i] + sum[i]);
    }
  }
  const auto factor = static_cast<std::uint16_t>(block.above + block.rows + 1);
  for (int i = 0; i < Columns; ++i) {
    share[i] = static_cast<std::uint16_t>(factor * sum[i] - prefix[i]);
    out.m0[i] = static_cast<std::uint16_t>(out.m0[i] + sum[i]);
  }
  for (int i = 0; i < Columns; ++i) {
    out.m1[i] += share[i];
  }
}

template <int Columns>
[[gnu::always_inline]] inline void write(const BinarySums<Columns>& sums, const model::MomentsView& out) {
  std::copy_n(sums.m0.data(), Columns, out.m0);
  std::copy_n(sums.m1.data(), Columns, out.m1);
  std::copy_n(sums.m0.data(), Columns, out.n);
}

// The sums of a strip in a grey mode. M0 and M1 have the even columns first and then the odd ones.
template <int Columns>
struct GreySums {
  static constexpr int kColumns = Columns;
  alignas(64) std::array<std::uint32_t, Columns> m0{};
  alignas(64) std::array<std::uint32_t, Columns> m1{};
  alignas(64) std::array<std::uint16_t, Columns> n{};
};

// Adds a block in a grey mode: a lit pixel weighs its value less `offset`, which is at most the threshold.
//
// Two neighbouring weights are one word: the even column's plus 2^8 times the odd one's. The sum of such words, and the
// sum of the odd columns alone, give that of the even columns modulo 2^16; so only one of the two must be widened, by a
// shift. Eight operations a vector of pixels. (With pixels in 16 bits: 2^16 and 2^32.)
template <typename Pixel, int Columns>
[[gnu::always_inline]] inline void add_block(const Block<Pixel>& block, Pixel threshold, Pixel offset,
                                             GreySums<Columns>& out) {
  using Word = Wide<Pixel>;
  constexpr int kPairs = Columns / 2;
  constexpr int kPixelBits = 8 * sizeof(Pixel);
  alignas(64) std::array<Pixel, Columns> weight;   // w
  alignas(64) std::array<Pixel, Columns> count{};  // lit pixels
  alignas(64) std::array<Word, kPairs> sum{};      // S of both
  alignas(64) std::array<Word, kPairs> sum_odd{};  // S of the odd columns
  alignas(64) std::array<Word, kPairs> prefix{};   // P likewise
  alignas(64) std::array<Word, kPairs> prefix_odd{};
  const Pixel* pixels = block.pixels;
  for (int row = 0; row < block.rows; ++row, pixels += block.stride) {
    prefetch_below(pixels, block.stride);
    for (int i = 0; i < Columns; ++i) {
      const Pixel pixel = pixels[i];
      count[i] = static_cast<Pixel>(count[i] + (pixel > threshold ? 1 : 0));
      weight[i] = static_cast<Pixel>(pixel > threshold ? pixel - offset : 0);
    }
    for (int i = 0; i < kPairs; ++i) {
      const Word pair = pair_at(&weight[2 * i]);
      sum[i] = static_cast<Word>(sum[i] + pair);
      sum_odd[i] = static_cast<Word>(sum_odd[i] + (pair >> kPixelBits));
      prefix[i] = static_cast<Word>(prefix[i] + sum[i]);
      prefix_odd[i] = static_cast<Word>(prefix_odd[i] + sum_odd[i]);
    }
  }
  const auto factor = static_cast<std::uint32_t>(block.above + block.rows + 1);
  for (int i = 0; i < kPairs; ++i) {
    const auto sum_even = static_cast<Word>(sum[i] - (sum_odd[i] << kPixelBits));
    const auto prefix_even = static_cast<Word>(prefix[i] - (prefix_odd[i] << kPixelBits));
    out.m0[i] += sum_even;
    out.m1[i] += factor * sum_even - prefix_even;
  }
  for (int i = 0; i < kPairs; ++i) {
    out.m0[kPairs + i] += sum_odd[i];
    out.m1[kPairs + i] += factor * sum_odd[i] - prefix_odd[i];
  }
  for (int i = 0; i < Columns; ++i) {
    out.n[i] = static_cast<std::uint16_t>(out.n[i] + count[i]);
  }
}

template <int Columns>
[[gnu::always_inline]] inline void write(const GreySums<Columns>& sums, const model::MomentsView& out) {
  constexpr int kPairs = Columns / 2;
  for (int i = 0; i < kPairs; ++i) {
    out.m0[2 * i] = sums.m0[i];
    out.m0[2 * i + 1] = sums.m0[kPairs + i];
  }
  for (int i = 0; i < kPairs; ++i) {
    out.m1[2 * i] = sums.m1[i];
    out.m1[2 * i + 1] = sums.m1[kPairs + i];
  }
  std::copy_n(sums.n.data(), Columns, out.n);
}

model::MomentsView from_column(const model::MomentsView& view, int first) {
  return {view.m0 + first, view.m1 + first, view.n + first};
}

// The moments of an image of at least Sums::kColumns columns. Where its width is no multiple of that, the last strip
// overlaps the one before it, and both give the same results.
template <typename Sums, typename Pixel>
[[gnu::always_inline]] inline void add_up(const model::PixelView<Pixel>& image, Pixel threshold, Pixel offset,
                                          const model::MomentsView& out) {
  constexpr int kColumns = Sums::kColumns;
  constexpr int kBlockRows = Lanes<Pixel>::kBlockRows;
  const int strips = (image.columns + kColumns - 1) / kColumns;
  const auto first_column = [&](int strip) { return std::min(strip * kColumns, image.columns - kColumns); };
  for (int band = 0; band < strips; band += kBandStrips) {
    const int count = std::min(kBandStrips, strips - band);
    std::array<Sums, kBandStrips> sums{};
    for (int above = 0; above < image.rows; above += kBlockRows) {
      const int rows = std::min(kBlockRows, image.rows - above);
      for (int i = 0; i < count; ++i) {
        const Pixel* pixels = image.pixels + above * image.stride + first_column(band + i);
        add_block(Block<Pixel>{pixels, image.stride, above, rows}, threshold, offset, sums[i]);
      }
    }
    for (int i = 0; i < count; ++i) {
      write(sums[i], from_column(out, first_column(band + i)));
    }
  }
}

template <template <int> typename Sums, typename Pixel>
[[gnu::always_inline]] inline void add_up_either(const model::PixelView<Pixel>& image, Pixel threshold, Pixel offset,
                                                 const model::MomentsView& out) {
  if (image.columns >= kStripColumns) {
    add_up<Sums<kStripColumns>>(image, threshold, offset, out);
  } else {
    add_up<Sums<kNarrowColumns>>(image, threshold, offset, out);
  }
}

SELFPROJ_CLONES void add_up_binary(const model::ImageView& image, std::uint8_t threshold,
                                   const model::MomentsView& out) {
  add_up_either<BinarySums>(image, threshold, std::uint8_t{0}, out);
}

SELFPROJ_CLONES void add_up_grey(const model::ImageView& image, std::uint8_t threshold, std::uint8_t offset,
                                 const model::MomentsView& out) {
  add_up_either<GreySums>(image, threshold, offset, out);
}

SELFPROJ_CLONES void add_up_wide_binary(const model::WideImageView& image, std::uint16_t threshold,
                                        const model::MomentsView& out) {
  add_up_either<BinarySums>(image, threshold, std::uint16_t{0}, out);
}

SELFPROJ_CLONES void add_up_wide_grey(const model::WideImageView& image, std::uint16_t threshold, std::uint16_t offset,
                                      const model::MomentsView& out) {
  add_up_either<GreySums>(image, threshold, offset, out);
}

}  // namespace

void fast_column_moments(const model::ImageView& image, model::Mode mode, int threshold,
                         const model::MomentsView& out) {
  model::check_column_moments(image, mode, threshold, out);
  const auto level = static_cast<std::uint8_t>(threshold);
  if (image.columns < kNarrowColumns) {
    model::column_moments(image, mode, threshold, out);
  } else if (mode == model::Mode::binary) {
    add_up_binary(image, level, out);
  } else {
    add_up_grey(image, level, mode == model::Mode::grey_over ? level : std::uint8_t{0}, out);
  }
}

void fast_column_moments(const model::WideImageView& image, int bits, model::Mode mode, int threshold,
                         const model::MomentsView& out) {
  model::check_column_moments(image, bits, mode, threshold, out);
  const auto level = static_cast<std::uint16_t>(threshold);
  if (image.columns < kNarrowColumns) {
    model::column_moments(image, bits, mode, threshold, out);
  } else if (mode == model::Mode::binary) {
    add_up_wide_binary(image, level, out);
  } else {
    add_up_wide_grey(image, level, mode == model::Mode::grey_over ? level : std::uint16_t{0}, out);
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
//
// Reads the image a second time, after the moments, strip after strip and some rows of a strip at once. An image that
// fits in the second-level cache comes from there, so nothing is asked for ahead.
template <int Gap, typename Pixel>
[[gnu::always_inline]] inline void count_strip(const model::PixelView<Pixel>& strip, int columns, Pixel threshold,
                                               RunStrip& count) {
  constexpr int kRows = Gap + 1;                            // of a block
  constexpr int kBlocks = Gap == 0 ? 4 : Gap == 3 ? 1 : 2;  // that are processed at a time
  constexpr int kAllRows = kBlocks * kRows;
  static constexpr std::array<Pixel, kRunColumns> kDark{};
  alignas(64) RunStrip above{};  // the last block of the rows above
  count.fill(0);
  int rows_to_limit = kLimitRows;
  for (int row = 0; row < strip.rows; row += kAllRows) {
    std::array<const Pixel*, kAllRows> pixels{};
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

template <int Gap, typename Pixel>
[[gnu::always_inline]] inline void count_either(const model::PixelView<Pixel>& strip, Pixel threshold,
                                                RunStrip& count) {
  if (strip.columns == kRunColumns) {
    count_strip<Gap>(strip, kRunColumns, threshold, count);
  } else {
    count_strip<Gap>(strip, strip.columns, threshold, count);
  }
}

template <typename Pixel>
[[gnu::always_inline]] inline void count_gaps(const model::PixelView<Pixel>& strip, Pixel threshold, int gap,
                                              RunStrip& count) {
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

SELFPROJ_CLONES void count_runs(const model::ImageView& strip, std::uint8_t threshold, int gap, RunStrip& count) {
  count_gaps(strip, threshold, gap, count);
}

SELFPROJ_CLONES void count_runs(const model::WideImageView& strip, std::uint16_t threshold, int gap, RunStrip& count) {
  count_gaps(strip, threshold, gap, count);
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
  return {from_column(view.moments, first), view.runs + first, view.second + first};
}

// The moments of all lit pixels
void all_moments(const model::ImageView& image, const model::Measure& measure, const model::MomentsView& out) {
  fast_column_moments(image, measure.mode, measure.threshold, out);
}
void all_moments(const model::WideImageView& image, const model::Measure& measure, const model::MomentsView& out) {
  fast_column_moments(image, measure.bits, measure.mode, measure.threshold, out);
}

template <typename Pixel>
void find_runs(const model::PixelView<Pixel>& image, const model::Measure& measure, const model::RunsView& out) {
  model::check_column_runs(image, measure, out);
  const model::RowWindow& window = measure.window;
  const int above = std::min(std::max(window.first - 1, 0), image.rows);  // rows that do not count
  const int end = window.last == 0 ? image.rows : std::min(window.last, image.rows);
  if (end <= above) {
    model::column_runs(image, measure, out);  // nothing counts
    return;
  }
  const model::PixelView<Pixel> part = {image.pixels + above * image.stride, end - above, image.columns, image.stride};
  all_moments(part, measure, out.moments);
  for (int i = 0; above > 0 && i < image.columns; ++i) {
    out.moments.m1[i] += static_cast<std::uint32_t>(above) * out.moments.m0[i];
  }
  std::fill_n(out.second, image.columns, std::uint8_t{0});
  alignas(64) RunStrip count;
  for (int first = 0; first < image.columns; first += kRunColumns) {
    const int columns = std::min(kRunColumns, image.columns - first);
    count_runs(model::PixelView<Pixel>{part.pixels + first, part.rows, columns, part.stride},
               static_cast<Pixel>(measure.threshold), measure.gap, count);
    std::copy_n(count.data(), columns, out.runs + first);
  }
  for (int i = next_several(out.runs, 0, image.columns); i < image.columns;
       i = next_several(out.runs, i + 1, image.columns)) {
    model::column_runs(model::PixelView<Pixel>{image.pixels + i, image.rows, 1, image.stride}, measure,
                       from_column(out, i));
  }
}

}  // namespace

void fast_column_runs(const model::ImageView& image, const model::Measure& measure, const model::RunsView& out) {
  find_runs(image, measure, out);
}

void fast_column_runs(const model::WideImageView& image, const model::Measure& measure, const model::RunsView& out) {
  find_runs(image, measure, out);
}

void fast_measure_columns(const model::ImageView& image, const model::Measure& measure, const model::RunsView& out) {
  if (measure.bits != spec::kPixelBits) {
    model::measure_columns(image, measure, out);  // throws
  } else if (measure.select == model::Select::strongest) {
    fast_column_runs(image, measure, out);
  } else if (measure.window == model::RowWindow{}) {
    fast_column_moments(image, measure.mode, measure.threshold, out.moments);
  } else {
    model::column_moments(image, measure.mode, measure.threshold, out.moments, measure.window);
  }
}

void fast_measure_columns(const model::WideImageView& image, const model::Measure& measure,
                          const model::RunsView& out) {
  if (measure.select == model::Select::strongest) {
    fast_column_runs(image, measure, out);
  } else if (measure.window == model::RowWindow{}) {
    fast_column_moments(image, measure.bits, measure.mode, measure.threshold, out.moments);
  } else {
    model::measure_columns(image, measure, out);
  }
}

}  // namespace selfproj::light_section
