// Unsigned integers in little-endian order at any address, on every machine.
#ifndef SELFPROJ_MODEL_LITTLE_ENDIAN_H
#define SELFPROJ_MODEL_LITTLE_ENDIAN_H

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace selfproj::model {

// Reads the integer from the sizeof(T) bytes at `bytes`.
template <typename T>
[[gnu::always_inline]] inline T load_little_endian(const std::uint8_t* bytes) {
  T value = 0;
  if constexpr (std::endian::native == std::endian::little) {
    std::memcpy(&value, bytes, sizeof value);
  } else {
    for (std::size_t i = 0; i < sizeof value; ++i) {
      value = static_cast<T>(value | static_cast<T>(bytes[i]) << (8 * i));
    }
  }
  return value;
}

// Writes the integer to the sizeof(T) bytes at `bytes`.
template <typename T>
[[gnu::always_inline]] inline void store_little_endian(std::uint8_t* bytes, T value) {
  if constexpr (std::endian::native == std::endian::little) {
    std::memcpy(bytes, &value, sizeof value);
  } else {
    for (std::size_t i = 0; i < sizeof value; ++i) {
      bytes[i] = static_cast<std::uint8_t>(value >> (8 * i));
    }
  }
}

}  // namespace selfproj::model

#endif  // SELFPROJ_MODEL_LITTLE_ENDIAN_H
