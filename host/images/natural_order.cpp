#include "host/images/natural_order.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace selfproj::images {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Returns the digits at the beginning, without leading zeros.
std::string_view number_at(std::string_view text) {
  const auto* const end = std::find_if_not(text.begin(), text.end(), is_digit);
  text = text.substr(0, static_cast<std::size_t>(end - text.begin()));
  return text.substr(std::min(text.find_first_not_of('0'), text.size()));
}

std::size_t digits_at(std::string_view text) {
  return static_cast<std::size_t>(std::find_if_not(text.begin(), text.end(), is_digit) - text.begin());
}

// Returns the name with '#' in place of each number.
std::string shape_of(std::string_view name) {
  std::string shape;
  while (!name.empty()) {
    const std::size_t digits = digits_at(name);
    shape += digits > 0 ? '#' : name.front();
    name.remove_prefix(std::max<std::size_t>(digits, 1));
  }
  return shape;
}

// The orders in which shells expand patterns: by bytes (LC_ALL=C), and with marks before digits before letters.
bool less_by_bytes(const std::string& a, const std::string& b) { return a < b; }

bool less_by_class(const std::string& a, const std::string& b) {
  const auto key = [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || byte >= 0x80U;
    return std::pair(letter ? 2 : is_digit(c) ? 1 : 0, byte);
  };
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(),
                                      [&](char x, char y) { return key(x) < key(y); });
}

}  // namespace

bool natural_less(std::string_view a, std::string_view b) {
  const std::string_view whole_a = a;
  const std::string_view whole_b = b;
  while (!a.empty() && !b.empty()) {
    if (is_digit(a.front()) && is_digit(b.front())) {
      const std::string_view x = number_at(a);
      const std::string_view y = number_at(b);
      if (x != y) {
        return x.size() != y.size() ? x.size() < y.size() : x < y;
      }
      a.remove_prefix(digits_at(a));
      b.remove_prefix(digits_at(b));
    } else if (a.front() != b.front()) {
      return static_cast<unsigned char>(a.front()) < static_cast<unsigned char>(b.front());
    } else {
      a.remove_prefix(1);
      b.remove_prefix(1);
    }
  }
  return a.empty() && b.empty() ? whole_a < whole_b : a.empty();
}

std::vector<std::string> in_natural_order(std::vector<std::string> names) {
  std::sort(names.begin(), names.end(), natural_less);
  return names;
}

std::vector<std::string> in_listed_order(std::vector<std::string> files) {
  for (auto first = files.begin(); first != files.end();) {
    const std::string shape = shape_of(*first);
    const auto last =
        std::find_if(first, files.end(), [&](const std::string& file) { return shape_of(file) != shape; });
    if (std::is_sorted(first, last, less_by_bytes) || std::is_sorted(first, last, less_by_class)) {
      std::sort(first, last, natural_less);
    }
    first = last;
  }
  return files;
}

}  // namespace selfproj::images
