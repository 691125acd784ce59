// Pure functions of the Gray-code decoder: state and code of one pixel, masks of the planes. The SystemC shell
// (hls/shells/gray_decoder_shell.h) uses them.
#ifndef SELFPROJ_HLS_GRAY_ARITHMETIC_H
#define SELFPROJ_HLS_GRAY_ARITHMETIC_H

#include "hls/median_arithmetic.h"
#include "hls/types.h"
#include "selfproj/model/generated/selfproj_spec.h"

// clang-tidy, in this file:
//   unnecessary-value-param: small integers are passed by value, which suits hardware compilers best
// NOLINTBEGIN(performance-unnecessary-value-param)
namespace selfproj {
namespace hls {

constexpr int kMaxCodeBits = spec::kCodeCodeBits;

using Plane = Uint<kMaxCodeBits>;  // one bit for each plane: plane p of m has bit m-1-p
using PlaneCount = Uint<4>;        // 0..kMaxCodeBits
using PatternIndex = Uint<16>;
// The state of a pixel, from the low bits: the positive, 8 bits; the planes' bits; which of them are ambiguous.
constexpr int kStateBits = spec::kPixelBits + 2 * kMaxCodeBits;
using PixelState = Uint<kStateBits>;

// The state of a pixel after a frame. In a negative the one bit in `weight` becomes
//     B = (positive - pixel > threshold)  xor  the bit in `above`, that of the previous plane (plane 0: none)
//     (4.15, 4.17)
// It becomes ambiguous if the two differ by no more than the threshold. Bits outside `mask`, left over from another m,
// become 0.
inline PixelState next_state(GrayPixel pixel, PixelState state, GrayPixel threshold, bool negative, Plane weight,
                             Plane above, Plane mask) {
  const GrayPixel positive = state;
  const Plane planes = state >> spec::kPixelBits;
  const Plane ambiguous = state >> (spec::kPixelBits + kMaxCodeBits);
  // The threshold less and plus the difference: their signs, in the highest bit, say lit and dark for certain.
  const Uint<spec::kPixelBits + 2> difference = positive - pixel;
  const Uint<spec::kPixelBits + 2> under = threshold - difference;
  const Uint<spec::kPixelBits + 2> over = threshold + difference;
  const bool lit = (under >> (spec::kPixelBits + 1)) != 0;
  const bool dark = (over >> (spec::kPixelBits + 1)) != 0;
  const Plane before = planes & above;
  Plane changed = 0;
  Plane set_plane = 0;
  Plane set_ambiguous = 0;
  if (negative) {
    changed = weight;
    if (lit != (before != 0)) {
      set_plane = weight;
    }
    if (!lit && !dark) {
      set_ambiguous = weight;
    }
  }
  const Plane kept = mask & ~changed;
  const Plane next_planes = (planes & kept) | set_plane;
  const Plane next_ambiguous = (ambiguous & kept) | set_ambiguous;
  PixelState next = next_ambiguous;
  next = (next << kMaxCodeBits) | next_planes;
  next = (next << spec::kPixelBits) | pixel;
  return next;
}

// The code word of a pixel, measurable if at most one plane is ambiguous (4.4, 4.16, 4.18).
inline CodeWord code_word(PixelState state) {
  const Plane planes = state >> spec::kPixelBits;
  const Plane ambiguous = state >> (spec::kPixelBits + kMaxCodeBits);
  const Plane but_lowest = ambiguous & (ambiguous - 1);
  CodeWord word = planes;
  if (but_lowest == 0) {
    word = word | (1 << spec::kCodeMeasurableLsb);
  }
  return word;
}

inline Plane weight_of_plane(PlaneCount bits, Uint<4> plane) {
  const Uint<4> place = bits - 1 - plane;
  const Plane weight = 1 << static_cast<int>(place);
  return weight;
}

// A mask of the m planes.
inline Plane mask_of(PlaneCount bits) {
  const Uint<kMaxCodeBits + 1> all = (1 << static_cast<int>(bits)) - 1;
  const Plane mask = all;
  return mask;
}

}  // namespace hls
}  // namespace selfproj
// NOLINTEND(performance-unnecessary-value-param)

#endif  // SELFPROJ_HLS_GRAY_ARITHMETIC_H
