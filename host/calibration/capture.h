// The captures of one pose of the chessboard: images of the whole Gray-code sequence, decoded along both axes.
#ifndef SELFPROJ_HOST_CALIBRATION_CAPTURE_H
#define SELFPROJ_HOST_CALIBRATION_CAPTURE_H

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/io/image_files.h"
#include "host/structured_light/gray_sequence.h"

namespace selfproj {

struct DecodeSettings {
  int threshold = 5;  // differences of a pair up to this are ambiguous (4.15)
  int contrast = 20;  // the white image must be more than this above the black one
};

// What each camera pixel sees of the projector. A pixel has a code where white is above black by more than the
// contrast, no pair of either axis is ambiguous, and column and row are the projector's.
struct Capture {
  static constexpr std::int16_t kNone = -1;

  int rows = 0;  // of the camera
  int columns = 0;
  std::vector<std::int16_t> projector_column, projector_row;  // from 0; both kNone where there is no code
  Image mean;  // the mean of all images, in which the patterns cancel, stretched to 0..255

  [[nodiscard]] std::size_t decoded() const;
};

// Decodes the images, read in the order of the sequence. Throws UserError naming the file: as read_image, of another
// size than the first, more columns or rows than a decoder takes; or naming `name` where there are more or fewer images
// than the sequence has.
Capture decode_capture(const std::string& name, const std::vector<std::string>& files, const GraySequence& sequence,
                       const DecodeSettings& settings, std::optional<Channel> channel);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_CAPTURE_H
