// Pure functions of the verdict: limits moved with a part, the state of a column, hits of the last frames. The SystemC
// shell (hls/shells/verdict_shell.h) uses them. include/selfproj/model/verdict.h has the definition.
#ifndef SELFPROJ_HLS_VERDICT_ARITHMETIC_H
#define SELFPROJ_HLS_VERDICT_ARITHMETIC_H

#include "hls/moments_arithmetic.h"
#include "hls/types.h"
#include "selfproj/model/generated/selfproj_spec.h"

// clang-tidy, in this file:
//   unnecessary-value-param: small integers are passed by value, which suits hardware compilers best
// NOLINTBEGIN(performance-unnecessary-value-param)
namespace selfproj {
namespace hls {

constexpr int kPastFrames = 7;  // before this one, which hits may count
constexpr int kShiftRowsBits = spec::kRegVerdictShiftRowsBits;
constexpr int kShiftColumnsBits = spec::kRegVerdictShiftColumnsBits;
constexpr int kLimitBits = bits_for(spec::kMaxRows) + 7;  // of a limit, in 1/128 rows
constexpr int kMovedBits = kLimitBits + 2;                // of one plus a shift, in two's complement

using Limit = Uint<kLimitBits>;
using LimitsWord = Uint<2 * kLimitBits + 1>;  // {judged, high, low}
using RowShift = Uint<kShiftRowsBits>;        // -d, in two's complement
using Past = Uint<kPastFrames>;               // a bit for each frame, the newest lowest
using VerdictM0 = Uint<spec::kGreyM0Bits>;
using VerdictM1 = Uint<spec::kGreyM1Bits>;
using VerdictProduct = Uint<spec::kGreyM0Bits + kLimitBits>;

// A limit plus d: 0 if it would be less, the greatest if it would have more bits. Rows are 1 to kMaxRows, so that this
// changes no verdict.
inline Limit moved_limit(Limit limit, RowShift back) {
  Uint<kMovedBits> extended = back;
  if ((back >> (kShiftRowsBits - 1)) != 0) {
    extended = extended + (1 << kMovedBits) - (1 << kShiftRowsBits);
  }
  const Uint<kMovedBits> moved = limit - extended;
  Limit result = moved;
  if ((moved >> (kMovedBits - 1)) != 0) {
    result = 0;
  } else if ((moved >> kLimitBits) != 0) {
    result = (1 << kLimitBits) - 1;
  }
  return result;
}

// A word of the table as a frame has it. A column that is not judged gets limits beyond which nothing lies.
inline LimitsWord moved_limits(LimitsWord word, bool there, RowShift back) {
  const bool judged = there && (word >> (2 * kLimitBits)) != 0;
  Limit low = word & ((1 << kLimitBits) - 1);
  Limit high = (word >> kLimitBits) & ((1 << kLimitBits) - 1);
  low = moved_limit(low, back);
  high = moved_limit(high, back);
  LimitsWord result = 1;
  result = (result << kLimitBits) | high;
  result = (result << kLimitBits) | low;
  if (!judged) {
    result = (1 << kLimitBits) - 1;
    result = result << kLimitBits;
  }
  return result;
}

inline VerdictProduct least_of(VerdictM0 m0, LimitsWord limits) {
  const Limit low = limits & ((1 << kLimitBits) - 1);
  return low * m0;
}

inline VerdictProduct most_of(VerdictM0 m0, LimitsWord limits) {
  const Limit high = (limits >> kLimitBits) & ((1 << kLimitBits) - 1);
  return high * m0;
}

// {lit, judged and unlit, below, above}, from the products of the limits with M0
inline Uint<4> state_of(VerdictM1 m1, VerdictProduct least, VerdictProduct most, bool judged, bool lit) {
  const Uint<spec::kGreyM1Bits + 7> at = Uint<spec::kGreyM1Bits + 7>(m1) << 7;
  Uint<4> state = 0;
  if (at < least) {
    state = state | 1;
  }
  if (at > most) {
    state = state | 2;
  }
  if (judged && !lit) {
    state = state | 4;
  }
  if (lit) {
    state = state | 8;
  }
  return state;
}

// The frames of `past` that count: `history` of them, which is h - 1.
inline Past counted(Past past, Uint<3> history) { return past & ((1 << history) - 1); }

inline Uint<4> hits_of(Past past, bool out) {
  Uint<4> hits = out ? 1 : 0;
  for (int frame = 0; frame < kPastFrames; ++frame) {
    hits = hits + ((past >> frame) & 1);
  }
  return hits;
}

}  // namespace hls
}  // namespace selfproj
// NOLINTEND(performance-unnecessary-value-param)

#endif  // SELFPROJ_HLS_VERDICT_ARITHMETIC_H
