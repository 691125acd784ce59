#include "host/images/image_decoder.h"

#include <cstddef>
#include <exception>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string>

#include "host/files/input_file.h"
#include "host/files/stderr_capture.h"
#include "host/files/user_error.h"
#include "host/images/image_header.h"

namespace selfproj {
namespace {

// Messages that the libraries print only on standard error. libjpeg fills in missing parts of a damaged file and
// reports only the first fault, so no message may be missed.
bool tells_of_damage(ImageFormat format, const std::string& messages) {
  return (format == ImageFormat::jpeg && !messages.empty()) || messages.find("Premature") != std::string::npos ||
         messages.find("Corrupt") != std::string::npos;
}

}  // namespace

cv::Mat decode_image(const std::string& file) {
  std::string bytes = read_input(file, kMostImageBytes);
  const std::optional<ImageHeader> header = image_header(bytes);
  if (!header || header->columns == 0 || header->rows == 0) {
    throw UserError(file, kNotAnImage);
  }
  if (header->columns > kMostImagePixels || header->rows > kMostImagePixels / header->columns) {
    throw UserError(file, "has " + std::to_string(header->columns) + " x " + std::to_string(header->rows) +
                              " pixels; at most 2^28 are taken");
  }
  cv::Mat image;
  StderrCapture capture;
  try {
    if (header->orientation_at != 0) {
      clear_orientation(*header, bytes);
      image = cv::imdecode(cv::Mat(1, static_cast<int>(bytes.size()), CV_8UC1, bytes.data()), cv::IMREAD_UNCHANGED);
    } else {
      // OpenCV reads the file itself. If it got bytes, libjpeg would stop silently at the end of a file that was cut
      // short.
      bytes.clear();
      bytes.shrink_to_fit();
      image = cv::imread(file, cv::IMREAD_UNCHANGED);
    }
  } catch (const cv::Exception&) {
    image.release();
  }
  if (image.empty() || tells_of_damage(header->format, capture.text())) {
    throw UserError(file, kNotAnImage);
  }
  return image;
}

}  // namespace selfproj
