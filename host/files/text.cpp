#include "host/files/text.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "host/files/input_file.h"
#include "selfproj/files/user_error.h"

namespace selfproj::files {
namespace {

using namespace std::string_view_literals;

// The bytes of the character of UTF-8 (RFC 3629) at the beginning of the text; 0 if there is none.
std::size_t character_at(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<std::uint8_t>(text[i]) : 0U; };
  const unsigned first = byte(0);
  if (first < 0x80) {
    return 1;
  }
  const std::size_t size = first >= 0xC2 && first <= 0xDF   ? 2
                           : first >= 0xE0 && first <= 0xEF ? 3
                           : first >= 0xF0 && first <= 0xF4 ? 4
                                                            : 0;
  // The second byte's range leaves out overlong forms, surrogates, and what is beyond U+10FFFF.
  const unsigned low = first == 0xE0 ? 0xA0 : first == 0xF0 ? 0x90 : 0x80;
  const unsigned high = first == 0xED ? 0x9F : first == 0xF4 ? 0x8F : 0xBF;
  if (size == 0 || byte(1) < low || byte(1) > high) {
    return 0;
  }
  for (std::size_t i = 2; i < size; ++i) {
    if ((byte(i) & 0xC0U) != 0x80) {
      return 0;
    }
  }
  return size;
}

// The first byte that is not part of a character; the text's size if there is none.
std::size_t fault_of(std::string_view text) {
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t size = character_at(text.substr(at));
    if (size == 0) {
      break;
    }
    at += size;
  }
  return at;
}

}  // namespace

std::string shown(std::string_view text) {
  std::string result;
  for (;;) {
    const std::size_t good = fault_of(text);
    result += text.substr(0, good);
    if (good == text.size()) {
      return result;
    }
    result += "\xEF\xBF\xBD"sv;
    text.remove_prefix(good + 1);
  }
}

std::string utf8_text(std::string text, const std::string& source) {
  if (text.starts_with("\xFF\xFE"sv) || text.starts_with("\xFE\xFF"sv)) {
    throw UserError(source, "line 1: is text in UTF-16; save the file as UTF-8");
  }
  if (text.starts_with("\xEF\xBB\xBF"sv)) {
    text.erase(0, 3);
  }
  if (const std::size_t fault = fault_of(text); fault < text.size()) {
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(fault), '\n');
    throw UserError(source, "line " + std::to_string(line) + ": is not text in UTF-8; save the file as UTF-8");
  }
  return text;
}

std::string read_text(const std::string& file, std::size_t most_bytes) {
  return utf8_text(read_input(file, most_bytes), file);
}

}  // namespace selfproj::files
