// Pure functions of the 3 x 3 median of measurable codes: the codes of words, and the median of nine. The SystemC shell
// (hls/shells/median3x3_shell.h) uses them.
#ifndef SELFPROJ_HLS_MEDIAN_ARITHMETIC_H
#define SELFPROJ_HLS_MEDIAN_ARITHMETIC_H

#include "hls/types.h"
#include "selfproj/model/generated/selfproj_spec.h"

// clang-tidy, in this file:
//   unnecessary-value-param: small integers are passed by value, which suits hardware compilers best
// NOLINTBEGIN(performance-unnecessary-value-param)
namespace selfproj {
namespace hls {

constexpr int kCodeLanes = spec::kPixelsPerBeat;

using GrayPixel = Uint<spec::kPixelBits>;
using CodeWord = Uint<spec::kCodeWordBits>;
using Code = Uint<spec::kCodeCodeBits + 1>;  // a code; the highest bit says whether it is measurable

inline Code code_of(CodeWord word) {
  const Uint<1> measurable = word >> spec::kCodeMeasurableLsb;
  Code code = measurable;
  code = (code << spec::kCodeCodeBits) | (word & ((1 << spec::kCodeCodeBits) - 1));
  return code;
}

inline CodeWord word_of(Code code) {
  const Uint<1> measurable = code >> spec::kCodeCodeBits;
  CodeWord word = measurable;
  word = (word << spec::kCodeMeasurableLsb) | (code & ((1 << spec::kCodeCodeBits) - 1));
  return word;
}

// The median of nine codes, of which number 4 is the centre. A code that does not exist counts as not measurable. If
// more than `half` are measurable, the result is the lower median of their codes, and measurable; else it is 0. The
// rank of a code is the number of codes that are less, or equal and earlier, where measurable ones come first: every
// pair is compared once.
inline Code median_of(const Code codes[9], Uint<4> half) {
  Uint<4> count = 0;
  Uint<1> earlier[9][9];  // [i][j]: j comes before i
  Code key[9];            // in order of rank
  for (int i = 0; i < 9; ++i) {
    const Uint<1> measurable = codes[i] >> spec::kCodeCodeBits;
    count = count + measurable;
    key[i] = codes[i] ^ (1 << spec::kCodeCodeBits);
  }
  for (int i = 0; i < 9; ++i) {
    for (int j = 0; j < 9; ++j) {
      if (i < j) {
        const Uint<1> less = key[j] < key[i] ? 1 : 0;
        earlier[i][j] = less;
        earlier[j][i] = 1 - less;
      }
    }
  }
  const Uint<4> target = (count - 1) >> 1;
  Code median = 0;
  for (int i = 0; i < 9; ++i) {
    Uint<4> rank = 0;
    for (int j = 0; j < 9; ++j) {
      if (i != j) {
        rank = rank + earlier[i][j];
      }
    }
    if (rank == target) {
      median = median | codes[i];  // one of the nine has this rank
    }
  }
  if (count <= half) {
    median = 0;
  }
  return median;
}

// Half the number of existing codes (9, 6, 4, 3 or 2), rounded down.
inline Uint<4> half_of(bool above, bool below, bool outer) {
  Uint<4> half = 1;
  if (above && below) {
    half = outer ? 3 : 4;
  } else if (above || below) {
    half = outer ? 2 : 3;
  }
  return half;
}

}  // namespace hls
}  // namespace selfproj
// NOLINTEND(performance-unnecessary-value-param)

#endif  // SELFPROJ_HLS_MEDIAN_ARITHMETIC_H
