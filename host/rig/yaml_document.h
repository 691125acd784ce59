// One YAML document out of a text.
#ifndef SELFPROJ_HOST_RIG_YAML_DOCUMENT_H
#define SELFPROJ_HOST_RIG_YAML_DOCUMENT_H

#include <yaml-cpp/yaml.h>

#include <functional>
#include <string>

namespace selfproj {

// The document of the text. Throws UserError, naming `source` and the line: it is not YAML, has none or more than one
// document, aliases (which could name each other without an end), or is nested deeper than any file of ours.
YAML::Node parse_yaml(const std::string& text, const std::string& source);

inline constexpr int kDeepestDocument = 16;  // levels

// The same checks without the document, which is then read by something else. `fault` gets each scalar that stands
// without quotation marks; if it returns a text, the scalar is refused for this reason.
void judge_yaml(const std::string& text, const std::string& source,
                const std::function<std::string(const std::string&)>& fault);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_RIG_YAML_DOCUMENT_H
