#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_CHECK_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_CHECK_H

#include <stdexcept>

namespace selfproj {

// Throws std::invalid_argument(reason) unless `holds`: for duties of a caller, not for errors of a user.
inline void check(bool holds, const char* reason) {
  if (!holds) {
    throw std::invalid_argument(reason);
  }
}

}  // namespace selfproj

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_CHECK_H
