#include "selfproj/model/gray_match.h"

#include <stdexcept>

namespace selfproj::model {

void GrayMatch::look_up(const std::uint16_t* words, std::size_t count, int bits, const std::uint16_t* table,
                        std::uint16_t* lines) {
  if (bits < 1 || bits > kMaxBits) {
    throw std::invalid_argument("gray match: bits out of range");
  }
  for (std::size_t i = 0; i < count; ++i) {
    const unsigned code = code_of(words[i]);
    const bool has_line = is_measurable(words[i]) && code >> static_cast<unsigned>(bits) == 0;
    lines[i] = has_line ? table[(i << static_cast<unsigned>(bits)) + code] : kNone;
  }
}

}  // namespace selfproj::model
