// The word of a pixel of a code image: its space code, and whether it is measurable.
#ifndef SELFPROJ_MODEL_CODE_WORD_H
#define SELFPROJ_MODEL_CODE_WORD_H

#include <cstdint>

#include "model/spec/generated/selfproj_spec.h"

namespace selfproj {

inline constexpr std::uint16_t kCodeMask = (1U << spec::kCodeCodeBits) - 1;
inline constexpr std::uint16_t kCodeMeasurable = std::uint16_t{1} << spec::kCodeMeasurableLsb;
static_assert(spec::kCodeCodeLsb == 0, "the code has the low bits of its word");

constexpr unsigned code_of(std::uint16_t word) { return word & kCodeMask; }
constexpr bool is_measurable(std::uint16_t word) { return (word & kCodeMeasurable) != 0; }

}  // namespace selfproj

#endif  // SELFPROJ_MODEL_CODE_WORD_H
