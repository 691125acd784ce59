// The captures of one pose of the chessboard: the images of a whole Gray-code sequence, decoded along both axes.
#ifndef SELFPROJ_HOST_CALIBRATION_CAPTURE_H
#define SELFPROJ_HOST_CALIBRATION_CAPTURE_H

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "host/images/image_files.h"
#include "host/images/image_sequence.h"
#include "host/structured_light/gray_sequence.h"

namespace selfproj {

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
  Image mean;  // the mean of all images, in which the patterns cancel, stretched to 0..255

  [[nodiscard]] std::size_t decoded() const;
};

// Decodes the images, which are those of the sequence in its order. Throws UserError as ImageSequence::read does, and
// for more columns or rows than a decoder takes. Throws it with `name` if there are more or fewer images than the
// sequence has.
Capture decode_capture(const std::string& name, ImageSequence& captured, const GraySequence& sequence,
                       const DecodeSettings& settings);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_CAPTURE_H
