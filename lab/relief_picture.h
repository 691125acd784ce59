// Pictures of maps that the reports of the product do not have: a relief seen from above at a slant, and several maps
// side by side.
#ifndef SELFPROJ_LAB_RELIEF_PICTURE_H
#define SELFPROJ_LAB_RELIEF_PICTURE_H

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "host/images/image_files.h"
#include "host/report/map_picture.h"
#include "selfproj/images/float_image.h"

namespace selfproj::lab {

// The map in parallel projection, seen from 35 degrees above its plane, with its columns turned by 30 degrees, as PNG:
// colours by `scale`, shaded by the true slope. Values are mm; `pitch` are the distances of rows and columns; heights
// are drawn `exaggeration` times as high, and a bar shows how high. The edges in front have their lengths. No surface
// is drawn between neighbours of which one is NaN. Throws std::invalid_argument for a map of fewer than 2 x 2 values,
// or without any.
std::string relief_png(const images::FloatImage& map, const report::MapScale& scale, const report::MapPitch& pitch,
                       double exaggeration);

// Maps of one size in rows of `across`, in one scale, or as images of grey values 0..255 without one; NaN is grey.
std::string strip_png(const std::vector<images::FloatImage>& maps, const std::optional<report::MapScale>& scale,
                      std::size_t across);

// Images of one size below each other, with a white line of 8 pixels between them.
images::Image below_each_other(const std::vector<images::Image>& images);

}  // namespace selfproj::lab

#endif  // SELFPROJ_LAB_RELIEF_PICTURE_H
