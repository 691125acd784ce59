#include "host/app/length_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "host/files/numbers.h"
#include "host/files/user_error.h"

namespace selfproj {

std::vector<double> ascending_lengths(const char* option, const std::string& text) {
  constexpr double kMost = 1e5;
  std::vector<double> values;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string entry = text.substr(begin, end - begin);
    const std::optional<double> value = number_of_text<double>(entry);
    if (!value || !(std::abs(*value) <= kMost)) {
      throw UserError(option, fmt::format("'{}' is not a number of mm", entry));
    }
    if (!values.empty() && !(*value > values.back())) {
      throw UserError(option,
                      fmt::format("{} follows {}; numbers are expected in ascending order", *value, values.back()));
    }
    values.push_back(*value);
    begin = end + 1;
  }
  return values;
}

}  // namespace selfproj
