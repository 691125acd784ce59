// A map of millimetres on a page.
#ifndef SELFPROJ_HOST_REPORT_PAGE_MAP_H
#define SELFPROJ_HOST_REPORT_PAGE_MAP_H

#include <string>
#include <string_view>

#include "host/images/float_image.h"
#include "host/report/map_picture.h"

namespace selfproj {

// Appends a map as HTML, with its scale bars beside and below it and an explanation of its colours. `title` and
// `explanation` are HTML.
void add_map(std::string& html, std::string_view title, std::string_view explanation, const FloatImage& map,
             const MapScale& scale, const MapPitch& pitch);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_REPORT_PAGE_MAP_H
