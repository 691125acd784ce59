// Text and pictures as HTML.
#ifndef SELFPROJ_HOST_REPORT_HTML_TEXT_H
#define SELFPROJ_HOST_REPORT_HTML_TEXT_H

#include <string>
#include <string_view>

#include "host/report/facts.h"

namespace selfproj {

// The text with the characters that mean something in HTML written out: & < > and the double quote.
std::string escaped(std::string_view text);

// An <img> that holds the bytes of a PNG file; `alternative` is read out in its place.
std::string picture_html(std::string_view png, std::string_view alternative);

// The fact's value without its unit: integers in groups of three digits, others with six significant digits.
std::string fact_html(const Fact& fact);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_REPORT_HTML_TEXT_H
