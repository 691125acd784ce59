// Matching of self-projected structured light: what the circuit sp_gray_match makes of a code image, to the last bit.
//
// A table, computed before the first frame, has one word for each pixel and code: the projector line that the pixel
// sees, in units of 1/64 line, or kNone if there is no match (method.md section 5, (4.19) and (4.20)).
#ifndef SELFPROJ_MODEL_GRAY_MATCH_H
#define SELFPROJ_MODEL_GRAY_MATCH_H

#include <cstddef>
#include <cstdint>

#include "selfproj/model/gray_decoder.h"

namespace selfproj::model {

struct GrayMatch {
  static constexpr int kMaxBits = 8;
  static constexpr unsigned kFractionBits = 6;    // fraction bits of a line
  static constexpr std::uint16_t kNone = 0xFFFF;  // no match, or not measurable

  // The word for a line >= 0, rounded; kNone if the line has no word.
  static constexpr std::uint16_t word_of(double line) {
    const double scaled = line * (1 << kFractionBits) + 0.5;
    return scaled >= 0 && scaled < kNone ? static_cast<std::uint16_t>(scaled) : kNone;
  }
  static constexpr double line_of(std::uint16_t word) { return static_cast<double>(word) / (1 << kFractionBits); }

  // Looks up `count` pixels. `words` are those of a code image (code in bits 11..0, bit 15 measurable). `table` has
  // 2^bits words for each pixel, one pixel after another. A pixel that is not measurable, or whose code has more than
  // `bits` bits, gives kNone. Throws std::invalid_argument if bits are not in 1..kMaxBits.
  static void look_up(const std::uint16_t* words, std::size_t count, int bits, const std::uint16_t* table,
                      std::uint16_t* lines);
};

}  // namespace selfproj::model

#endif  // SELFPROJ_MODEL_GRAY_MATCH_H
