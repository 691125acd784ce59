// 3 × 3 median of a code image: what the circuit sp_median3x3 computes, to the last bit.
//
// For each pixel, of those of its 3 × 3 neighbours (itself among them) that exist, which are fewer at the border: where
// more than half of them are measurable, the lower median of the measurable codes, measurable; else 0, not measurable.
// The lower median of k values in ascending order, from 1, is value number ⌊(k + 1)/2⌋.
#ifndef SELFPROJ_MODEL_MEDIAN3X3_H
#define SELFPROJ_MODEL_MEDIAN3X3_H

#include <cstdint>

namespace selfproj {

// Reads rows · columns words of a code image, row by row, as GrayDecoder writes them, and writes as many to `out`,
// which must not overlap `codes`. Bits 14..12 are not read. Throws std::invalid_argument where rows or columns are less
// than 1 or a pointer is null. Keeps no state.
void median3x3(const std::uint16_t* codes, int rows, int columns, std::uint16_t* out);

}  // namespace selfproj

#endif  // SELFPROJ_MODEL_MEDIAN3X3_H
