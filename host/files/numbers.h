// Numbers: read from texts, for files and options alike; rounded; their median.
#ifndef SELFPROJ_HOST_FILES_NUMBERS_H
#define SELFPROJ_HOST_FILES_NUMBERS_H

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <vector>

namespace selfproj::files {

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

// Returns the multiple of 10^-decimals that is nearest to `value`, as a text of so many decimals would be read: 0.0003,
// not 0.00030000000000000003. `decimals` is 0..15; NaN and infinities stay.
inline double rounded(double value, int decimals) {
  const double units = std::pow(10.0, decimals);
  return std::round(value * units) / units + 0.0;  // never -0
}

// The median of one or more values, none of them NaN; the upper of the two middle values if their number is even.
template <typename T>
T median_of(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace selfproj::files

#endif  // SELFPROJ_HOST_FILES_NUMBERS_H
