// Patterns for the projector: images of its lines x columns, from 0 (dark) to 1 (full light); and a picture of pattern
// and reference to look at.
#ifndef SELFPROJ_HOST_LIGHT_SECTION_PATTERN_H
#define SELFPROJ_HOST_LIGHT_SECTION_PATTERN_H

#include <span>
#include <string>

#include "selfproj/images/float_image.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/rig/rig.h"

namespace selfproj::light_section {

// Draws a line of light. `line_of_column` has its centre for each projector column (lines from 0, with a fraction; NaN
// for no light). Its width is the rig's line_width_px. A pixel's value is the share of it that the line covers, so the
// line's light does not depend on its position. Its centroid is exact if the width is a whole number of lines, else
// within 1 / (8 width) of a line. Each column is drawn on its own, so no light bridges gaps or steps. Throws
// std::invalid_argument if the number of columns is wrong.
images::FloatImage draw_pattern(const rig::Rig& rig, std::span<const double> line_of_column);

// The straight line of the conventional method and of the scan.
images::FloatImage draw_straight_line(const rig::Rig& rig, double line);

// The pattern as an 8-bit PNG file for projectors: 0..255, rounded. Throws std::invalid_argument for a pattern without
// pixels.
std::string encode_pattern_png(const images::FloatImage& pattern);

// PNG bytes: the pattern as the projector shows it, and below it the reference's height (plane_z - z) over the camera's
// columns, with gaps at columns without a reference. If `reference` has no columns, only the pattern is drawn; a
// laser has no pattern.
std::string draw_preview(const rig::Rig& rig, const images::FloatImage& pattern, const ReferenceProfile& reference);

}  // namespace selfproj::light_section

#endif  // SELFPROJ_HOST_LIGHT_SECTION_PATTERN_H
