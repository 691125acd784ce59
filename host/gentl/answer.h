// How every function of the interface answers: no exception leaves it, the last error of the thread is kept, and a
// piece of information has a type, a size, and a value if there is room.
#ifndef SELFPROJ_HOST_GENTL_ANSWER_H
#define SELFPROJ_HOST_GENTL_ANSWER_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>

#include "host/gentl/gentl_types.h"
#include "selfproj/files/user_error.h"

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

// The last error of this thread, for GCGetLastError.
struct LastError {
  GC_ERROR code = GC_ERR_SUCCESS;
  std::array<char, 1024> text{"no error"};
};

inline LastError& last_error() {
  thread_local LastError error;
  return error;
}

// Keeps the error, its text cut off if it is very long. Returns `code`.
inline GC_ERROR failed(GC_ERROR code, const char* text) noexcept {
  last_error().code = code;
  static_cast<void>(std::snprintf(last_error().text.data(), last_error().text.size(), "%s", text));
  return code;
}

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

// Where an answer goes. If the buffer is null, the consumer asks only for the size. The type may be null.
struct Answer {
  INFO_DATATYPE* type = nullptr;
  void* buffer = nullptr;
  std::size_t* size = nullptr;
};

// Writes `count` bytes. If there is no room, it throws GC_ERR_BUFFER_TOO_SMALL and writes nothing.
inline void give_bytes(INFO_DATATYPE type, const void* bytes, std::size_t count, const Answer& to) {
  require_pointer(to.size);
  if (to.buffer != nullptr) {
    require(*to.size >= count, GC_ERR_BUFFER_TOO_SMALL, "the buffer is smaller than the value");
    std::memcpy(to.buffer, bytes, count);
  }
  if (to.type != nullptr) {
    *to.type = type;
  }
  *to.size = count;
}

inline void give(const std::string& text, const Answer& to) {
  give_bytes(INFO_DATATYPE_STRING, text.c_str(), text.size() + 1, to);
}
inline void give(const char* text, const Answer& to) { give(std::string(text), to); }

inline void give(bool value, const Answer& to) {
  const bool8_t byte = value ? 1 : 0;
  give_bytes(INFO_DATATYPE_BOOL8, &byte, sizeof byte, to);
}
inline void give(void* value, const Answer& to) { give_bytes(INFO_DATATYPE_PTR, &value, sizeof value, to); }
inline void give(std::int32_t value, const Answer& to) { give_bytes(INFO_DATATYPE_INT32, &value, sizeof value, to); }
inline void give(std::uint32_t value, const Answer& to) { give_bytes(INFO_DATATYPE_UINT32, &value, sizeof value, to); }
inline void give(std::uint64_t value, const Answer& to) { give_bytes(INFO_DATATYPE_UINT64, &value, sizeof value, to); }

// For numbers that are size_t in the standard.
inline void give_size(std::size_t value, const Answer& to) {
  give_bytes(INFO_DATATYPE_SIZET, &value, sizeof value, to);
}

// Throws the error for information that this producer does not have.
[[noreturn]] inline void no_answer(std::int32_t command) {
  throw GenTLError(GC_ERR_NOT_IMPLEMENTED, "there is no answer to question " + std::to_string(command));
}

}  // namespace selfproj::gentl

#endif  // SELFPROJ_HOST_GENTL_ANSWER_H
