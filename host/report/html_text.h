// Text and pictures as HTML.
#ifndef SELFPROJ_HOST_REPORT_HTML_TEXT_H
#define SELFPROJ_HOST_REPORT_HTML_TEXT_H

#include <string>
#include <string_view>

#include "host/report/facts.h"

namespace selfproj {

// The text with & < > and the double quote replaced by their HTML entities.
std::string escaped(std::string_view text);

// An <img> that contains the bytes of a PNG file. `alternative` is its text for those who cannot see it.
std::string picture_html(std::string_view png, std::string_view alternative);

// The value of the fact without its unit: integers in groups of three digits, other numbers with six significant
// digits.
std::string fact_html(const Fact& fact);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_REPORT_HTML_TEXT_H
