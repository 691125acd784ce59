// Formats and pure functions of the column moments: operations on one pixel, one sum, one word. The SystemC
// shell (hls/shells/column_moments_shell.h) uses them.
#ifndef SELFPROJ_HLS_MOMENTS_ARITHMETIC_H
#define SELFPROJ_HLS_MOMENTS_ARITHMETIC_H

#include "hls/types.h"
#include "selfproj/model/generated/selfproj_spec.h"

// clang-tidy, in this file:
//   unnecessary-value-param: small integers are passed by value, which suits hardware compilers best
// NOLINTBEGIN(performance-unnecessary-value-param)
namespace selfproj {
namespace hls {

constexpr int kLanes = spec::kPixelsPerBeat;
static_assert(kLanes == 4, "the payload is cut into beats for four lanes");

// The formats of the sums. They hold the largest values of the specification, so nothing ever wraps.
using Pixel = Uint<spec::kPixelBits>;
using Pixels = Uint<kLanes * spec::kPixelBits>;  // leftmost pixel in the low bits
using ModeBits = Uint<2>;
using Columns = Uint<bits_for(spec::kMaxColumns)>;
using Row = Uint<bits_for(spec::kMaxRows)>;                    // a row, counted from 1, or a number of lit pixels
using Group = Uint<bits_for(spec::kMaxColumns / kLanes - 1)>;  // a group of four columns, counted from 0
using Sum0 = Uint<spec::kGreyM0Bits>;
using Sum1 = Uint<spec::kGreyM1Bits>;
static_assert(bits_for(spec::kMaxRows) == spec::kGreyNBits, "a number of lit pixels has the bits of a row");

// The weight of a pixel; 0 if and only if it is not lit.
inline Pixel weight_of(Pixel pixel, Pixel threshold, ModeBits mode) {
  Pixel weight = 0;
  if (pixel > threshold) {
    if (mode == spec::kModeBinary) {
      weight = 1;
    } else if (mode == spec::kModeGrey) {
      weight = pixel;
    } else {
      weight = pixel - threshold;
    }
  }
  return weight;
}

inline Pixel lane_of(Pixels pixels, int lane) {
  Pixel pixel = pixels >> (spec::kPixelBits * lane);
  return pixel;
}

// The weights of four pixels.
inline Pixels weights_of(Pixels pixels, Pixel threshold, ModeBits mode) {
  Pixels weights = 0;
  for (int lane = kLanes - 1; lane >= 0; --lane) {
    Pixel pixel = lane_of(pixels, lane);
    Pixel weight = weight_of(pixel, threshold, mode);
    weights = (weights << spec::kPixelBits) | weight;
  }
  return weights;
}

inline Sum0 next_m0(Sum0 m0, Pixel weight) {
  Sum0 next = m0 + weight;
  return next;
}

inline Row next_n(Row n, Pixel weight) {
  Row next = n;
  if (weight != 0) {
    next = n + 1;
  }
  return next;
}

// The summand of A for a row: the M0 before it in the grey modes, and the row of a lit pixel in mode binary.
inline Sum1 addend_of(Sum0 m0_before, Pixel weight, Row row, bool grey) {
  Sum1 addend = 0;
  if (grey) {
    addend = m0_before;
  } else if (weight != 0) {
    addend = row;
  }
  return addend;
}

// M1 of a column with `rows` rows, from M0 with the last row, and M0 and A before it.
inline Sum1 finished_m1(Row rows, Sum0 m0, Sum0 m0_before, Sum1 a) {
  Uint<spec::kGreyM0Bits + spec::kGreyNBits> product = rows * m0;
  Sum1 over = a + m0_before;
  Sum1 m1 = product - over;  // the difference fits, because it is M1
  return m1;
}

// The payload word of a column in mode binary.
inline Uint<spec::kBinaryWordBits> binary_word(Sum0 m0, Sum1 m1) {
  Uint<spec::kBinaryWordBits> word = m0;
  word = (word << (spec::kBinaryM0Lsb - spec::kBinaryM1Lsb)) | m1;
  return word;
}

// The payload word of a column in the grey modes.
inline Uint<spec::kGreyWordBits> grey_word(Sum0 m0, Sum1 m1, Row n) {
  Uint<spec::kGreyWordBits> word = n;
  word = (word << (spec::kGreyNLsb - spec::kGreyM0Lsb)) | m0;
  word = (word << (spec::kGreyM0Lsb - spec::kGreyM1Lsb)) | m1;
  return word;
}
static_assert(spec::kBinaryM1Lsb == 0 && spec::kGreyM1Lsb == 0, "M1 has the low bits of its word");

// What the words of the strongest run report besides: the number of runs, and how strong the second is in sixteenths.
inline Uint<spec::kBinaryRunWordBits> binary_run_word(Uint<spec::kBinaryWordBits> word, Uint<2> runs, Uint<5> second) {
  Uint<spec::kBinaryRunWordBits> all = runs;
  all = all << (spec::kBinaryRunRunsLsb - spec::kBinaryRunSecondLsb);
  if (second >= 8) {
    all = all | 1;
  }
  all = (all << spec::kBinaryRunSecondLsb) | word;
  return all;
}
inline Uint<spec::kGreyRunWordBits> grey_run_word(Uint<spec::kGreyWordBits> word, Uint<2> runs, Uint<5> second) {
  Uint<spec::kGreyRunWordBits> all = second;
  all = (all << (spec::kGreyRunSecondLsb - spec::kGreyRunRunsLsb)) | runs;
  all = (all << spec::kGreyRunRunsLsb) | word;
  return all;
}
static_assert(spec::kBinaryRunM1Lsb == spec::kBinaryM1Lsb && spec::kBinaryRunM0Lsb == spec::kBinaryM0Lsb &&
                  spec::kGreyRunM1Lsb == spec::kGreyM1Lsb && spec::kGreyRunM0Lsb == spec::kGreyM0Lsb &&
                  spec::kGreyRunNLsb == spec::kGreyNLsb,
              "moments have the same places with and without runs");

}  // namespace hls
}  // namespace selfproj
// NOLINTEND(performance-unnecessary-value-param)

#endif  // SELFPROJ_HLS_MOMENTS_ARITHMETIC_H
