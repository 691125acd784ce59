#include "selfproj/structured_light/fast_decoder.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "host/structured_light/check.h"
#include "model/cpu_clones.h"

// The compiler vectorizes the loops over pixels below. All their values have the width of a code, so that one vector
// instruction handles 64 pixels (AVX-512, m <= 8). Steps that change the width are separate loops.

namespace selfproj::structured_light {
namespace {

// --- decoder ---

// Decodes a pair of plane p for pixels first..last-1. `bit` is the plane's weight in the code. `above` is the same if
// there is a previous plane, else 0.
//
// With the saturated differences d+ = max(I+ - I-, 0) and d- = max(I- - I+, 0): G = d+ > T, ambiguous = both <= T
// (4.15).
template <class T>
struct Pair {
  const std::uint8_t* __restrict positive;
  const std::uint8_t* __restrict negative;
  T* __restrict codes;
  T* __restrict ambiguous;
  std::uint8_t threshold;
  T bit;
  T above;
};

template <class T>
[[gnu::always_inline]] inline void update_one(const Pair<T>& p, std::ptrdiff_t i) {
  const std::uint8_t a = p.positive[i];
  const std::uint8_t b = p.negative[i];
  const std::uint8_t high = std::max(a, b);
  const auto up = static_cast<std::uint8_t>(high - b);
  const auto down = static_cast<std::uint8_t>(high - a);
  const T lit = up > p.threshold ? static_cast<T>(~T{0}) : T{0};
  const T clear = down > p.threshold ? T{0} : static_cast<T>(~T{0});
  const T code = p.codes[i];
  // B_p = B_{p-1} xor G (4.17): the previous plane is one bit higher in the code.
  const T value = static_cast<T>((code >> 1U) & p.above) ^ lit;
  p.codes[i] = static_cast<T>((code & ~p.bit) | (value & p.bit));
  p.ambiguous[i] = static_cast<T>((p.ambiguous[i] & ~p.bit) | (clear & ~lit & p.bit));
}

template <class T>
[[gnu::always_inline]] inline void update(const Pair<T>& pair, std::ptrdiff_t count) {
  const Pair<T> p = pair;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    update_one(p, i);
  }
}

SELFPROJ_CLONES void update_bytes(const Pair<std::uint8_t>& pair, std::ptrdiff_t count) { update(pair, count); }
SELFPROJ_CLONES void update_words(const Pair<std::uint16_t>& pair, std::ptrdiff_t count) { update(pair, count); }
void update_run(const Pair<std::uint8_t>& pair, std::ptrdiff_t count) { update_bytes(pair, count); }
void update_run(const Pair<std::uint16_t>& pair, std::ptrdiff_t count) { update_words(pair, count); }

// Rows that follow each other without a gap are processed as one long row. Every update runs against the direction of
// the one before, so that it first meets what the cache still holds.
template <class T>
void update_image(const model::ImageView& positive, const model::ImageView& negative, Pair<T> pair, bool downwards) {
  constexpr std::ptrdiff_t kRun = 1 << 14;  // pixels
  const std::ptrdiff_t columns = negative.columns;
  const bool whole = positive.stride == columns && negative.stride == columns;
  const std::ptrdiff_t total = columns * negative.rows;
  const std::ptrdiff_t run = whole ? std::min(kRun, total) : columns;
  const std::ptrdiff_t runs = (total + run - 1) / run;
  T* const codes = pair.codes;
  T* const ambiguous = pair.ambiguous;
  for (std::ptrdiff_t k = 0; k < runs; ++k) {
    const std::ptrdiff_t at = downwards ? k : runs - 1 - k;
    const std::ptrdiff_t first = at * run;
    pair.positive = positive.pixels + (whole ? first : at * positive.stride);
    pair.negative = negative.pixels + (whole ? first : at * negative.stride);
    pair.codes = codes + first;
    pair.ambiguous = ambiguous + first;
    update_run(pair, std::min(run, total - first));
  }
}

// --- words ---

template <class T>
[[gnu::always_inline]] inline void words(const T* __restrict codes, const T* __restrict ambiguous, std::ptrdiff_t count,
                                         std::uint16_t* __restrict out) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const std::uint16_t a = ambiguous[i];
    const bool measurable = static_cast<std::uint16_t>(a & (a - 1U)) == 0;
    out[i] = static_cast<std::uint16_t>(codes[i] | (measurable ? model::GrayDecoder::kMeasurable : 0U));
  }
}

SELFPROJ_CLONES void words_of_bytes(const std::uint8_t* codes, const std::uint8_t* ambiguous, std::ptrdiff_t count,
                                    std::uint16_t* out) {
  words(codes, ambiguous, count, out);
}
SELFPROJ_CLONES void words_of_words(const std::uint16_t* codes, const std::uint16_t* ambiguous, std::ptrdiff_t count,
                                    std::uint16_t* out) {
  words(codes, ambiguous, count, out);
}

// --- median ---

// How the median works. A code that is not measurable becomes the greatest value of its type. In ascending order the
// measurable ones of the nine values are then the first k (a measurable code of that value is the same number), and
// their lower median is number (k - 1) / 2 from 0. The three values of each column of the neighbourhood are sorted once
// for the three pixels that use them, l <= m <= h. Sorting the three l, the three m and the three h gives a square
//
//     l0 <= l1 <= l2
//     ^     ^     ^          (columns ascend too)
//     m0 <= m1 <= m2
//     h0 <= h1 <= h2
//
// In it, with p = max(l1, m0) and s0 <= s1 <= s2 the sorted p, l2, h0, the smallest values are
//
//     number 0: l0     1: min(l1, m0)     2: s0     3: min(s1, m1)     4: median of l2, m1, h0
//
// Number 2: each value that remains without l0 and min(l1, m0) is one of p, l2, h0 or has one of them below it. Number
// 3: the same with s0 taken away, because m1 >= p, m2 >= l2, m1, and h1 >= h0, m1.

template <class T>
[[gnu::always_inline]] inline T lesser(T a, T b) {
  return a < b ? a : b;
}
template <class T>
[[gnu::always_inline]] inline T greater(T a, T b) {
  return a < b ? b : a;
}
template <class T>
[[gnu::always_inline]] inline T least_of(T a, T b, T c) {
  return lesser(lesser(a, b), c);
}
template <class T>
[[gnu::always_inline]] inline T greatest_of(T a, T b, T c) {
  return greater(greater(a, b), c);
}
template <class T>
[[gnu::always_inline]] inline T middle_of(T a, T b, T c) {
  return greater(lesser(a, b), lesser(greater(a, b), c));
}

// `a` if `first`, else `b`. A branch would keep the compiler from vectorizing.
template <class T>
[[gnu::always_inline]] inline T choose(bool first, T a, T b) {
  const auto mask = static_cast<T>(-static_cast<int>(first));
  return static_cast<T>((a & mask) | (b & static_cast<T>(~mask)));
}

// The lines of scratch memory. All have one more value on either side.
template <class T>
struct Lines {
  std::array<T*, 3> keys;   // code, or greatest value, of three rows
  std::array<T*, 3> flags;  // 1 if measurable
  T* low;                   // sorted by columns
  T* middle;
  T* high;
  T* count;  // measurable values in a column
  T* result;
  T* total;  // measurable values in the neighbourhood
};
constexpr std::ptrdiff_t kLines = 12;
constexpr std::ptrdiff_t kMargin = 64;  // entries before and after a line

template <class T>
[[gnu::always_inline]] inline void make_keys(const T* __restrict codes, const T* __restrict ambiguous,
                                             std::ptrdiff_t columns, T* __restrict keys, T* __restrict flags) {
  for (std::ptrdiff_t c = 0; c < columns; ++c) {
    const T a = ambiguous[c];
    const bool measurable = static_cast<T>(a & static_cast<T>(a - 1)) == 0;
    keys[c] = measurable ? codes[c] : std::numeric_limits<T>::max();
    flags[c] = measurable ? T{1} : T{0};
  }
}

// Three loops: if one loop made all four results, the compiler could not prove that no two arrays overlap.
template <class T>
[[gnu::always_inline]] inline void sort_columns(const Lines<T>& lines, std::ptrdiff_t columns) {
  const T* __restrict k0 = lines.keys[0];
  const T* __restrict k1 = lines.keys[1];
  const T* __restrict k2 = lines.keys[2];
  const T* __restrict f0 = lines.flags[0];
  const T* __restrict f1 = lines.flags[1];
  const T* __restrict f2 = lines.flags[2];
  T* __restrict low = lines.low;
  T* __restrict middle = lines.middle;
  T* __restrict high = lines.high;
  T* __restrict count = lines.count;
  for (std::ptrdiff_t c = 0; c < columns; ++c) {
    const T a = k0[c];
    const T b = k1[c];
    const T d = k2[c];
    low[c] = least_of(a, b, d);
    high[c] = greatest_of(a, b, d);
  }
  for (std::ptrdiff_t c = 0; c < columns; ++c) {
    middle[c] = middle_of(k0[c], k1[c], k2[c]);
  }
  for (std::ptrdiff_t c = 0; c < columns; ++c) {
    count[c] = static_cast<T>(f0[c] + f1[c] + f2[c]);
  }
}

template <class T>
[[gnu::always_inline]] inline void select(const Lines<T>& lines, std::ptrdiff_t columns) {
  const T* __restrict low = lines.low;
  const T* __restrict middle = lines.middle;
  const T* __restrict high = lines.high;
  const T* __restrict count = lines.count;
  T* __restrict result = lines.result;
  T* __restrict total = lines.total;
  for (std::ptrdiff_t c = 0; c < columns; ++c) {
    const T l0 = least_of(low[c - 1], low[c], low[c + 1]);
    const T l1 = middle_of(low[c - 1], low[c], low[c + 1]);
    const T l2 = greatest_of(low[c - 1], low[c], low[c + 1]);
    const T m0 = least_of(middle[c - 1], middle[c], middle[c + 1]);
    const T m1 = middle_of(middle[c - 1], middle[c], middle[c + 1]);
    const T h0 = least_of(high[c - 1], high[c], high[c + 1]);
    const T p = greater(l1, m0);
    const T s0 = least_of(p, l2, h0);
    const T s1 = middle_of(p, l2, h0);
    const T nine = middle_of(l2, m1, h0);
    const T k = static_cast<T>(count[c - 1] + count[c] + count[c + 1]);
    T value = choose(k > T{2}, lesser(l1, m0), l0);
    value = choose(k > T{4}, s0, value);
    value = choose(k > T{6}, lesser(s1, m1), value);
    value = choose(k > T{8}, nine, value);
    result[c] = value;
    total[c] = k;
  }
}

template <class T>
[[gnu::always_inline]] inline void emit(const Lines<T>& lines, std::ptrdiff_t columns, T least,
                                        std::uint16_t* __restrict out) {
  const T* __restrict result = lines.result;
  const T* __restrict total = lines.total;
  for (std::ptrdiff_t c = 0; c < columns; ++c) {
    const auto value = static_cast<std::uint16_t>(result[c] | model::GrayDecoder::kMeasurable);
    out[c] = total[c] >= least ? value : std::uint16_t{0};
  }
}

template <class T>
[[gnu::always_inline]] inline void filter_image(const T* codes, const T* ambiguous, int rows, int columns, T* scratch,
                                                std::uint16_t* out) {
  const std::ptrdiff_t width = columns;
  const std::ptrdiff_t pitch = width + 2 * kMargin;
  std::array<T*, kLines> line{};
  for (std::ptrdiff_t i = 0; i < kLines; ++i) {
    line[static_cast<std::size_t>(i)] = scratch + i * pitch + kMargin;
  }
  Lines<T> lines{
      {line[0], line[1], line[2]}, {line[3], line[4], line[5]}, line[6], line[7], line[8], line[9], line[10], line[11]};
  constexpr T kNone = std::numeric_limits<T>::max();
  const auto leave_out = [&](T* keys, T* flags) {
    std::fill_n(keys, width, kNone);
    std::fill_n(flags, width, T{0});
  };
  for (T* sorted : {lines.low, lines.middle, lines.high}) {
    sorted[-1] = sorted[width] = kNone;
  }
  lines.count[-1] = lines.count[width] = 0;

  leave_out(lines.keys[1], lines.flags[1]);
  make_keys(codes, ambiguous, width, lines.keys[2], lines.flags[2]);
  for (std::ptrdiff_t r = 0; r < rows; ++r) {
    std::rotate(lines.keys.begin(), lines.keys.begin() + 1, lines.keys.end());
    std::rotate(lines.flags.begin(), lines.flags.begin() + 1, lines.flags.end());
    if (r + 1 < rows) {
      make_keys(codes + (r + 1) * width, ambiguous + (r + 1) * width, width, lines.keys[2], lines.flags[2]);
    } else {
      leave_out(lines.keys[2], lines.flags[2]);
    }
    sort_columns(lines, width);
    select(lines, width);
    // More than half of the existing neighbours must be measurable.
    const int existing_rows = 1 + (r > 0 ? 1 : 0) + (r + 1 < rows ? 1 : 0);
    const auto least = [&](int existing_columns) { return static_cast<T>(existing_rows * existing_columns / 2 + 1); };
    std::uint16_t* out_row = out + r * width;
    emit(lines, width, least(3), out_row);
    for (const std::ptrdiff_t c : {std::ptrdiff_t{0}, width - 1}) {
      const bool valid = lines.total[c] >= least(width == 1 ? 1 : 2);
      out_row[c] =
          valid ? static_cast<std::uint16_t>(lines.result[c] | model::GrayDecoder::kMeasurable) : std::uint16_t{0};
    }
  }
}

SELFPROJ_CLONES void filter_bytes(const CodeImageView& image, std::uint8_t* scratch, std::uint16_t* out) {
  filter_image(image.codes8, image.ambiguous8, image.rows, image.columns, scratch, out);
}
SELFPROJ_CLONES void filter_words(const CodeImageView& image, std::uint16_t* scratch, std::uint16_t* out) {
  filter_image(image.codes16, image.ambiguous16, image.rows, image.columns, scratch, out);
}

// Takes kMeasurable from the words of all pixels with an ambiguous pair. No branch: the loop is to be vectorized.
template <class T>
[[gnu::always_inline]] inline void leave_out_ambiguous(const T* ambiguous, std::ptrdiff_t count, std::uint16_t* out) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const int kept = ambiguous[i] == 0 ? 0xFFFF : 0xFFFF & ~model::GrayDecoder::kMeasurable;
    out[i] = static_cast<std::uint16_t>(out[i] & kept);
  }
}

SELFPROJ_CLONES void leave_out_bytes(const std::uint8_t* ambiguous, std::ptrdiff_t count, std::uint16_t* out) {
  leave_out_ambiguous(ambiguous, count, out);
}
SELFPROJ_CLONES void leave_out_words(const std::uint16_t* ambiguous, std::ptrdiff_t count, std::uint16_t* out) {
  leave_out_ambiguous(ambiguous, count, out);
}

constexpr int kByteBits = 8;

}  // namespace

void code_words(const CodeImageView& image, std::uint16_t* out) {
  const std::ptrdiff_t count = static_cast<std::ptrdiff_t>(image.rows) * image.columns;
  if (image.bits <= kByteBits) {
    words_of_bytes(image.codes8, image.ambiguous8, count, out);
  } else {
    words_of_words(image.codes16, image.ambiguous16, count, out);
  }
}

void unambiguous_code_words(const CodeImageView& image, std::uint16_t* out) {
  code_words(image, out);
  const std::ptrdiff_t count = static_cast<std::ptrdiff_t>(image.rows) * image.columns;
  if (image.bits <= kByteBits) {
    leave_out_bytes(image.ambiguous8, count, out);
  } else {
    leave_out_words(image.ambiguous16, count, out);
  }
}

FastGrayDecoder::FastGrayDecoder(const model::GraySettings& settings) : settings_(settings) {
  check(settings.rows >= 1 && settings.rows <= kMaxSide, "fast gray decoder: rows out of range");
  check(settings.columns >= 1 && settings.columns <= kMaxSide, "fast gray decoder: columns out of range");
  check(settings.bits >= 1 && settings.bits <= model::GrayDecoder::kMaxBits, "fast gray decoder: bits out of range");
  check(settings.threshold >= 0 && settings.threshold <= 255, "fast gray decoder: threshold out of range");
  const std::size_t count = static_cast<std::size_t>(settings.rows) * static_cast<std::size_t>(settings.columns);
  if (settings.bits <= kByteBits) {
    codes8_.resize(count);
    ambiguous8_.resize(count);
  } else {
    codes16_.resize(count);
    ambiguous16_.resize(count);
  }
}

bool FastGrayDecoder::add_frame(const model::ImageView& image, int pattern, bool good) {
  check(image.rows == settings_.rows && image.columns == settings_.columns,
        "fast gray decoder: the image has not the size of the settings");
  check(image.pixels != nullptr, "fast gray decoder: null pointer");
  if (!good) {
    restart();
    return false;
  }
  if (pattern != next_) {
    restart();
  }
  if (pattern != next_) {
    return false;
  }
  next_ = (pattern + 1) % (2 * settings_.bits);
  if (pattern % 2 == 0) {
    positive_ = image;
    return false;
  }
  const int plane = pattern / 2;
  const unsigned bit = 1U << static_cast<unsigned>(settings_.bits - 1 - plane);
  const unsigned above = plane == 0 ? 0U : bit;
  const auto threshold = static_cast<std::uint8_t>(settings_.threshold);
  if (settings_.bits <= kByteBits) {
    update_image<std::uint8_t>(positive_, image,
                               {nullptr, nullptr, codes8_.data(), ambiguous8_.data(), threshold,
                                static_cast<std::uint8_t>(bit), static_cast<std::uint8_t>(above)},
                               downwards_);
  } else {
    update_image<std::uint16_t>(positive_, image,
                                {nullptr, nullptr, codes16_.data(), ambiguous16_.data(), threshold,
                                 static_cast<std::uint16_t>(bit), static_cast<std::uint16_t>(above)},
                                downwards_);
  }
  downwards_ = !downwards_;
  pairs_ = std::min(pairs_ + 1, settings_.bits);
  return pairs_ == settings_.bits;
}

CodeImageView FastGrayDecoder::codes() const {
  CodeImageView view{settings_.rows, settings_.columns, settings_.bits, nullptr, nullptr, nullptr, nullptr};
  if (settings_.bits <= kByteBits) {
    view.codes8 = codes8_.data();
    view.ambiguous8 = ambiguous8_.data();
  } else {
    view.codes16 = codes16_.data();
    view.ambiguous16 = ambiguous16_.data();
  }
  return view;
}

FastMedian::FastMedian(int columns) : columns_(columns) {
  check(columns >= 1 && columns <= FastGrayDecoder::kMaxSide, "fast median: columns out of range");
  const auto count = static_cast<std::size_t>(kLines * (columns + 2 * kMargin));
  scratch8_.resize(count);
  scratch16_.resize(count);
}

void FastMedian::filter(const CodeImageView& image, std::uint16_t* out) {
  check(image.rows >= 1 && image.columns >= 1 && image.columns <= columns_, "fast median: size out of range");
  if (image.bits <= kByteBits) {
    filter_bytes(image, scratch8_.data(), out);
  } else {
    filter_words(image, scratch16_.data(), out);
  }
}

}  // namespace selfproj::structured_light
