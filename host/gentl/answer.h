// Returns a piece of information to a consumer that has asked for it: its type, its size, and its value if there is
// room.
#ifndef SELFPROJ_HOST_GENTL_ANSWER_H
#define SELFPROJ_HOST_GENTL_ANSWER_H

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>

#include "host/gentl/gentl_errors.h"
#include "host/gentl/gentl_types.h"

namespace selfproj::gentl {

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
