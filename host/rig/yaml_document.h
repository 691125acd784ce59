// One YAML document out of a text.
#ifndef SELFPROJ_HOST_RIG_YAML_DOCUMENT_H
#define SELFPROJ_HOST_RIG_YAML_DOCUMENT_H

#include <yaml-cpp/yaml.h>

#include <string>

namespace selfproj {

// The document of the text. Throws UserError, naming `source` and the line: it is no YAML, has none or more than one
// document, aliases (which could name each other without an end), or is nested deeper than any file of ours.
YAML::Node parse_yaml(const std::string& text, const std::string& source);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_RIG_YAML_DOCUMENT_H
