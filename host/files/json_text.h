#ifndef SELFPROJ_HOST_FILES_JSON_TEXT_H
#define SELFPROJ_HOST_FILES_JSON_TEXT_H

#include <string>

namespace selfproj::files {

// The text of a JSON value of nlohmann's library, on one line or with this indentation. Names of files and answers of
// devices may be in any encoding: bytes that are not UTF-8 become U+FFFD (the library's dump() throws).
template <class Json>
std::string json_text(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace selfproj::files

#endif  // SELFPROJ_HOST_FILES_JSON_TEXT_H
