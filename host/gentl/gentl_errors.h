// What every function of the interface does: no exception leaves it, and the last error of the thread is kept.
#ifndef SELFPROJ_HOST_GENTL_GENTL_ERRORS_H
#define SELFPROJ_HOST_GENTL_GENTL_ERRORS_H

#include <exception>
#include <new>
#include <stdexcept>
#include <string>

#include "host/files/user_error.h"
#include "host/gentl/gentl_types.h"

namespace selfproj::gentl {

// An error of the standard, with a text for GCGetLastError.
class GenTLError : public std::runtime_error {
 public:
  GenTLError(GC_ERROR code, const std::string& text) : std::runtime_error(text), code_(code) {}
  [[nodiscard]] GC_ERROR code() const { return code_; }

 private:
  GC_ERROR code_;
};

// Throws the error unless `good`.
inline void require(bool good, GC_ERROR code, const char* text) {
  if (!good) {
    throw GenTLError(code, text);
  }
}

// Throws GC_ERR_INVALID_PARAMETER if a pointer that the caller must give is null.
inline void require_pointer(const void* pointer) {
  require(pointer != nullptr, GC_ERR_INVALID_PARAMETER, "a pointer that is needed is null");
}

// Keeps the error for GCGetLastError, cut off if it is very long. Returns `code`.
GC_ERROR failed(GC_ERROR code, const char* text) noexcept;

// The last error of this thread.
GC_ERROR last_error_code() noexcept;
const char* last_error_text() noexcept;

// Calls `work`, and turns exceptions into errors.
template <typename Work>
GC_ERROR guarded(const Work& work) noexcept {
  try {
    work();
    return GC_ERR_SUCCESS;
  } catch (const GenTLError& error) {
    return failed(error.code(), error.what());
  } catch (const UserError& error) {
    return failed(GC_ERR_IO, error.what());
  } catch (const std::bad_alloc&) {
    return failed(GC_ERR_OUT_OF_MEMORY, "there is not enough memory");
  } catch (const std::exception& error) {
    return failed(GC_ERR_ERROR, error.what());
  } catch (...) {
    return failed(GC_ERR_ERROR, "unknown exception");
  }
}

}  // namespace selfproj::gentl

#endif  // SELFPROJ_HOST_GENTL_GENTL_ERRORS_H
