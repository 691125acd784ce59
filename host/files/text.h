// Text in UTF-8: what people write is read as such or refused, and what is shown is such.
#ifndef SELFPROJ_HOST_FILES_TEXT_H
#define SELFPROJ_HOST_FILES_TEXT_H

#include <cstddef>
#include <string>
#include <string_view>

namespace selfproj::files {

// The text with U+FFFD, the replacement character, in place of each byte that is not part of a character of UTF-8, so
// that a name in any encoding can be shown and written into any file.
std::string shown(std::string_view text);

// The text without a byte order mark of UTF-8. Throws UserError, naming `source` and the line, for one that is not
// UTF-8: it was written in another encoding, and its names would be others.
std::string utf8_text(std::string text, const std::string& source);

// utf8_text of read_input (input_file.h): for every file that people write.
std::string read_text(const std::string& file, std::size_t most_bytes);

}  // namespace selfproj::files

#endif  // SELFPROJ_HOST_FILES_TEXT_H
