// What every function of the C interface does: no exception leaves it, and the last error of the thread is kept as
// text.
#ifndef SELFPROJ_CAPI_ERRORS_H
#define SELFPROJ_CAPI_ERRORS_H

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <new>
#include <stdexcept>

#include "capi/selfproj.h"
#include "host/files/user_error.h"

namespace selfproj {

// Keeps the text for selfproj_last_error(), cut off if it is very long. Returns `result`.
std::int32_t failed(std::int32_t result, const char* text) noexcept;

// Throws std::invalid_argument with the text unless `good`.
inline void require(bool good, const char* text) {
  if (!good) {
    throw std::invalid_argument(text);
  }
}

// Calls `work`, which returns what the C function returns, and turns exceptions into results.
template <typename Work>
std::int32_t guarded(const Work& work) noexcept {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return failed(SELFPROJ_NO_MEMORY, "there is not enough memory");
  } catch (const std::invalid_argument& error) {
    return failed(SELFPROJ_BAD_ARGUMENT, error.what());
  } catch (const UserError& error) {
    return failed(SELFPROJ_BAD_INPUT, error.what());
  } catch (const std::exception& error) {
    return failed(SELFPROJ_INTERNAL, error.what());
  } catch (...) {
    return failed(SELFPROJ_INTERNAL, "unknown exception");
  }
}

// A structure of the caller, who may have an older or newer version of it: fields that he does not have are 0. `oldest`
// is the size that the first version had.
template <typename Struct>
Struct copy_of(const Struct* from, std::size_t oldest, const char* text) {
  Struct copy{};
  require(from != nullptr && from->size >= oldest, text);
  std::memcpy(&copy, from, std::min<std::size_t>(from->size, sizeof copy));
  return copy;
}

// Writes the fields that the caller has; his `size` stays.
template <typename Struct>
void copy_to(Struct& value, Struct* to) {
  value.size = to->size;
  std::memcpy(to, &value, std::min<std::size_t>(value.size, sizeof value));
}

}  // namespace selfproj

#endif  // SELFPROJ_CAPI_ERRORS_H
