// Formats and pure functions of the column moments: operations on one pixel, one sum, one word. The SystemC
// shell (hls/shells/column_moments_shell.h) uses them. F is a MomentsFormats.
#ifndef SELFPROJ_HLS_MOMENTS_ARITHMETIC_H
#define SELFPROJ_HLS_MOMENTS_ARITHMETIC_H

#include "hls/types.h"
#include "selfproj/model/generated/selfproj_spec.h"

// clang-tidy, in this file:
//   unnecessary-value-param: small integers are passed by value, which suits hardware compilers best
// NOLINTBEGIN(performance-unnecessary-value-param)
namespace selfproj {
namespace hls {

// The formats of a circuit for pixels of `PixelBits` (8..12), `Lanes` of them in a beat (4, 8 or 16). Sums hold the
// largest values of the specification, so nothing ever wraps.
template <int PixelBits, int Lanes>
struct MomentsFormats {
  static constexpr int kPixelBits = PixelBits;
  static constexpr int kLanes = Lanes;
  static constexpr int kHalf = Lanes / 2;  // columns that the grey modes send in a clock
  static constexpr bool kWide = PixelBits > spec::kPixelBits;
  static constexpr int kM0Bits = kWide ? spec::kWideGreyM0Bits : spec::kGreyM0Bits;
  static constexpr int kM1Bits = kWide ? spec::kWideGreyM1Bits : spec::kGreyM1Bits;

  using Pixel = Uint<PixelBits>;
  using Pixels = AnyUint<Lanes * PixelBits>;                     // leftmost pixel in the low bits
  using Group = Uint<bits_for(spec::kMaxColumns / Lanes - 1)>;   // the columns of a beat, counted from 0
  using GroupCount = Uint<bits_for(spec::kMaxColumns / Lanes)>;  // 0 to all of a line
  using Sum0 = Uint<kM0Bits>;
  using Sum1 = Uint<kM1Bits>;
  using Payload = WideUint<32 * Lanes>;
};

using ModeBits = Uint<2>;
using Columns = Uint<bits_for(spec::kMaxColumns)>;
using Row = Uint<bits_for(spec::kMaxRows)>;  // a row, counted from 1, or a number of lit pixels
static_assert(bits_for(spec::kMaxRows) == spec::kGreyNBits, "a number of lit pixels has the bits of a row");

// Those of the other circuits
using FourOfEight = MomentsFormats<spec::kPixelBits, spec::kPixelsPerBeat>;
constexpr int kLanes = FourOfEight::kLanes;
using Pixels = FourOfEight::Pixels;
using Group = FourOfEight::Group;

// The weight of a pixel; 0 if and only if it is not lit.
template <typename F>
inline typename F::Pixel weight_of(typename F::Pixel pixel, typename F::Pixel threshold, ModeBits mode) {
  typename F::Pixel weight = 0;
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

template <typename F>
inline typename F::Pixel lane_of(typename F::Pixels pixels, int lane) {
  typename F::Pixel pixel = part_of<F::kPixelBits>(pixels, F::kPixelBits * lane);
  return pixel;
}

// The weights of a beat's pixels.
template <typename F>
inline typename F::Pixels weights_of(typename F::Pixels pixels, typename F::Pixel threshold, ModeBits mode) {
  typename F::Pixels weights = 0;
  for (int lane = F::kLanes - 1; lane >= 0; --lane) {
    typename F::Pixel pixel = lane_of<F>(pixels, lane);
    typename F::Pixel weight = weight_of<F>(pixel, threshold, mode);
    weights = (weights << F::kPixelBits) | typename F::Pixels(weight);
  }
  return weights;
}

template <typename F>
inline typename F::Sum0 next_m0(typename F::Sum0 m0, typename F::Pixel weight) {
  typename F::Sum0 next = m0 + weight;
  return next;
}

template <typename F>
inline Row next_n(Row n, typename F::Pixel weight) {
  Row next = n;
  if (weight != 0) {
    next = n + 1;
  }
  return next;
}

// The summand of A for a row: the M0 before it in the grey modes, and the row of a lit pixel in mode binary.
template <typename F>
inline typename F::Sum1 addend_of(typename F::Sum0 m0_before, typename F::Pixel weight, Row row, bool grey) {
  typename F::Sum1 addend = 0;
  if (grey) {
    addend = m0_before;
  } else if (weight != 0) {
    addend = row;
  }
  return addend;
}

// M1 of a column with `rows` rows, from M0 with the last row, and M0 and A before it.
template <typename F>
inline typename F::Sum1 finished_m1(Row rows, typename F::Sum0 m0, typename F::Sum0 m0_before, typename F::Sum1 a) {
  Uint<F::kM0Bits + spec::kGreyNBits> product = rows * m0;
  typename F::Sum1 over = a + m0_before;
  typename F::Sum1 m1 = product - over;  // the difference fits, because it is M1
  return m1;
}

// The payload word of a column in mode binary.
template <typename F>
inline Uint<spec::kBinaryWordBits> binary_word(typename F::Sum0 m0, typename F::Sum1 m1) {
  Uint<spec::kBinaryWordBits> word = m0;
  word = (word << (spec::kBinaryM0Lsb - spec::kBinaryM1Lsb)) | m1;
  return word;
}

// The payload word of a column in the grey modes.
template <typename F>
inline Uint<spec::kGreyWordBits> grey_word(typename F::Sum0 m0, typename F::Sum1 m1, Row n) {
  Uint<spec::kGreyWordBits> word = n;
  word = (word << F::kM0Bits) | m0;
  word = (word << F::kM1Bits) | m1;
  return word;
}
static_assert(spec::kBinaryM1Lsb == 0 && spec::kGreyM1Lsb == 0 && spec::kWideGreyM1Lsb == 0 &&
                  spec::kGreyM0Lsb == spec::kGreyM1Bits && spec::kWideGreyM0Lsb == spec::kWideGreyM1Bits &&
                  spec::kGreyNLsb == spec::kGreyM0Lsb + spec::kGreyM0Bits &&
                  spec::kWideGreyNLsb == spec::kWideGreyM0Lsb + spec::kWideGreyM0Bits,
              "N, M0 and M1 follow each other");

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
template <typename F>
inline Uint<spec::kGreyRunWordBits> grey_run_word(typename F::Sum0 m0, typename F::Sum1 m1, Row n, Uint<2> runs,
                                                  Uint<5> second) {
  Uint<spec::kGreyRunWordBits> all = second;
  if (F::kWide) {
    Row most = spec::kWideGreyRunNMax;
    if (n < most) {
      most = n;
    }
    all = (all << spec::kWideGreyRunNBits) | most;
  } else {
    all = (all << spec::kGreyRunRunsBits) | runs;
    all = (all << spec::kGreyRunNBits) | n;
  }
  all = (all << F::kM0Bits) | m0;
  all = (all << F::kM1Bits) | m1;
  return all;
}
static_assert(spec::kBinaryRunM1Lsb == spec::kBinaryM1Lsb && spec::kBinaryRunM0Lsb == spec::kBinaryM0Lsb &&
                  spec::kGreyRunM1Lsb == spec::kGreyM1Lsb && spec::kGreyRunM0Lsb == spec::kGreyM0Lsb &&
                  spec::kGreyRunNLsb == spec::kGreyNLsb && spec::kWideGreyRunM0Lsb == spec::kWideGreyM0Lsb &&
                  spec::kWideGreyRunNLsb == spec::kWideGreyNLsb,
              "moments have the same places with and without runs");
static_assert(spec::kGreyRunRunsLsb == spec::kGreyRunNLsb + spec::kGreyRunNBits &&
                  spec::kGreyRunSecondLsb == spec::kGreyRunRunsLsb + spec::kGreyRunRunsBits &&
                  spec::kWideGreyRunSecondLsb == spec::kWideGreyRunNLsb + spec::kWideGreyRunNBits,
              "what the words of the strongest run say besides follows them");

}  // namespace hls
}  // namespace selfproj
// NOLINTEND(performance-unnecessary-value-param)

#endif  // SELFPROJ_HLS_MOMENTS_ARITHMETIC_H
