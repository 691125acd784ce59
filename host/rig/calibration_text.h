// Looks at the text of a calibration before OpenCV reads it.
#ifndef SELFPROJ_HOST_RIG_CALIBRATION_TEXT_H
#define SELFPROJ_HOST_RIG_CALIBRATION_TEXT_H

#include <string>

namespace selfproj {

// Throws UserError, naming `source` and the line, for a text (YAML, JSON or XML) that cv::FileStorage would read
// wrongly or that would crash it: it is nested deeper than any calibration, has more than one document or aliases, or
// has a whole number that begins with 0, which OpenCV takes for an octal one ("010" for 8) or a hexadecimal one.
void check_calibration_text(const std::string& text, const std::string& source);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_RIG_CALIBRATION_TEXT_H
