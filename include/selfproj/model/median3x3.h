// 3 × 3 median of a code image: what the circuit sp_median3x3 computes, to the last bit.
//
// Each pixel is computed from its existing 3 × 3 neighbours, itself included; there are fewer at the border. If more
// than half of these are measurable, the result is the lower median of the measurable codes, and it is measurable.
// Otherwise the result is 0 and not measurable. The lower median of k values in ascending order is value number ⌊(k +
// 1)/2⌋, from 1.
#ifndef SELFPROJ_MODEL_MEDIAN3X3_H
#define SELFPROJ_MODEL_MEDIAN3X3_H

#include <cstdint>

namespace selfproj::model {

// Reads rows · columns words of a code image, row by row, as GrayDecoder writes them, and writes as many to `out`,
// which must not overlap `codes`. Ignores bits 14..12. Throws std::invalid_argument if rows or columns are less than 1
// or a pointer is null. Keeps no state.
void median3x3(const std::uint16_t* codes, int rows, int columns, std::uint16_t* out);

}  // namespace selfproj::model

#endif  // SELFPROJ_MODEL_MEDIAN3X3_H
