#include "model/gray_match.h"

#include <stdexcept>

namespace selfproj {

void GrayMatch::look_up(const std::uint16_t* words, std::size_t count, int bits, const std::uint16_t* table,
                        std::uint16_t* lines) {
  if (bits < 1 || bits > kMaxBits) {
    throw std::invalid_argument("gray match: bits out of range");
  }
  for (std::size_t i = 0; i < count; ++i) {
    const unsigned code = words[i] & ((1U << spec::kCodeCodeBits) - 1);
    const bool measurable = (words[i] & GrayDecoder::kMeasurable) != 0;
    lines[i] = measurable && code >> static_cast<unsigned>(bits) == 0 ? table[(i << static_cast<unsigned>(bits)) + code]
                                                                      : kNone;
  }
}

}  // namespace selfproj
