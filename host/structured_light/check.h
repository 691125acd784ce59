#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_CHECK_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_CHECK_H

#include <stdexcept>

namespace selfproj::structured_light {

// Throws std::invalid_argument(reason) unless `holds`. For preconditions that a caller must meet; an error of a user
// is a UserError.
inline void check(bool holds, const char* reason) {
  if (!holds) {
    throw std::invalid_argument(reason);
  }
}

}  // namespace selfproj::structured_light

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_CHECK_H
