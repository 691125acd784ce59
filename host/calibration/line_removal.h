// A laser's line that crosses the image of a chessboard: found, and filled from what lies beside it.
#ifndef SELFPROJ_HOST_CALIBRATION_LINE_REMOVAL_H
#define SELFPROJ_HOST_CALIBRATION_LINE_REMOVAL_H

#include <opencv2/core/types.hpp>
#include <optional>

#include "host/images/image_files.h"

namespace selfproj::calibration {

// A straight band: pixels (column, row) whose distance from the line through `at` along `direction` is at most half.
struct LightBand {
  cv::Point2d at;
  cv::Point2d direction;  // of length 1
  double half = 0;

  // The distance of a place from the middle of the band, signed.
  [[nodiscard]] double off(const cv::Point2d& place) const {
    return direction.x * (place.y - at.y) - direction.y * (place.x - at.x);
  }
};

// What is thin, and brighter than its surroundings and than white paper, in an image of one channel: the line of a
// laser. `most_px`: what is wider does not count.
images::Image thin_light(const images::Image& image, int most_px);

// The straight line in an image of light alone, such as a difference of channels or thin_light(). Nothing if no line
// crosses at least a quarter of the image's shorter side, or the light is too wide or has too many gaps for a line.
std::optional<LightBand> line_of_light(const images::Image& light);

// The image without the band: filled straight across from both of its sides. The veil of light around it is taken away
// where black squares show it: what the darkest tenth of the pixels at a distance from the band has more than farther
// away.
images::Image without_band(const images::Image& image, const LightBand& band);

}  // namespace selfproj::calibration

#endif  // SELFPROJ_HOST_CALIBRATION_LINE_REMOVAL_H
