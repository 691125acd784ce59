// Reads numbers from texts, for files and options alike.
#ifndef SELFPROJ_HOST_FILES_NUMBERS_H
#define SELFPROJ_HOST_FILES_NUMBERS_H

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <system_error>
#include <type_traits>

namespace selfproj {

// Returns the number if the whole text is one in base 10: "12", "-3", "+5", and for a floating-point T also "1.5" and
// "2e-3". "010" is ten. Returns nothing for any other text, such as an empty one, spaces, "0x10", "nan", "inf", and
// numbers that T cannot hold.
template <class T>
std::optional<T> number_of_text(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) {
    text.remove_prefix(1);
  }
  T value{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end) {
    return std::nullopt;
  }
  if constexpr (std::is_floating_point_v<T>) {
    if (!std::isfinite(value)) {
      return std::nullopt;
    }
  }
  return value;
}

}  // namespace selfproj

#endif  // SELFPROJ_HOST_FILES_NUMBERS_H
