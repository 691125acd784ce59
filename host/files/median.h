#ifndef SELFPROJ_HOST_FILES_MEDIAN_H
#define SELFPROJ_HOST_FILES_MEDIAN_H

#include <algorithm>
#include <cstddef>
#include <vector>

namespace selfproj {

// The median of one or more values, none of them NaN; the upper of the two middle values if their number is even.
template <typename T>
T median_of(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace selfproj

#endif  // SELFPROJ_HOST_FILES_MEDIAN_H
