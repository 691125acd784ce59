// The captures of one pose of the chessboard: the images of a whole Gray-code sequence, decoded along both axes; and
// where the chessboard's corners are in the projector's image, from the codes that the camera pixels around them see.
#ifndef SELFPROJ_HOST_CALIBRATION_CAPTURE_H
#define SELFPROJ_HOST_CALIBRATION_CAPTURE_H

#include <cstddef>
#include <cstdint>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "host/images/image_files.h"
#include "host/images/image_sequence.h"
#include "selfproj/structured_light/gray_sequence.h"

namespace selfproj::calibration {

struct DecodeSettings {
  int threshold = 5;  // a pair that differs by no more than this is ambiguous (4.15)
  int contrast = 20;  // the white image must exceed the black one by more than this
};

// The projector pixel that each camera pixel sees. A pixel has a code if white exceeds black by more than the contrast,
// no pair of either axis is ambiguous, and column and row are within the projector.
struct Capture {
  static constexpr std::int16_t kNone = -1;

  int rows = 0;  // rows of the camera
  int columns = 0;
  std::vector<std::int16_t> projector_column, projector_row;  // from 0; both are kNone if there is no code
  std::vector<bool> lit;                                      // white exceeds black by more than the contrast
  images::Image mean;         // the mean of all images, in which the patterns cancel, stretched to 0..255
  std::string contradiction;  // why the images are not those of the sequence (sequence_check.h); empty: they may be

  [[nodiscard]] std::size_t decoded() const;
};

// Decodes the images, which are those of the sequence in its order. Throws UserError as ImageSequence::read does, and
// for more columns or rows than a decoder takes. Throws it with `name` if there are more or fewer images than the
// sequence has.
Capture decode_capture(const std::string& name, images::ImageSequence& captured,
                       const structured_light::GraySequence& sequence, const DecodeSettings& settings);

// Two ways from the codes (u, v) of the pixels (x, y) in a window around the corner (x0, y0) to the corner's own code:
//   homography   (u, v, 1) ~ H (x - x0, y - y0, 1): the map of a plane (Moreno and Taubin, 2012; US 10,008,007)
//   direct       u and v are each a polynomial of second degree in x - x0 and y - y0
// Both are fitted with Tukey's weights, so that single wrong codes do not matter.
enum class CornerMethod : std::uint8_t { homography, direct };

struct CornerSettings {
  CornerMethod method = CornerMethod::homography;
  double window_px = 0;    // half the window's side; 0: 0.7 of the spacing of the corners, and at least 6 pixels
  double max_sd_px = 0.3;  // a corner with a greater estimated standard deviation in the projector is left out
};

struct CornerCode {
  bool valid = false;
  cv::Point2d projector;   // column, row, from 0
  double sd_px = 0;        // estimated standard deviation, the greater of both directions
  double residual_px = 0;  // residual of the fit, root mean square of both directions together
  int pixels = 0;          // pixels with a code in the window
};

// The corner at `camera` of the capture. It is not valid if too few pixels have a code: fewer than 25, none on one side
// of the corner, or so few that sd_px is above its limit.
CornerCode corner_code(const Capture& capture, const cv::Point2d& camera, double spacing_px,
                       const CornerSettings& settings);

}  // namespace selfproj::calibration

#endif  // SELFPROJ_HOST_CALIBRATION_CAPTURE_H
