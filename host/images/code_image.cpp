#include "host/images/code_image.h"

#include <algorithm>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace selfproj {

std::string encode_png16(int rows, int columns, std::span<const std::uint16_t> pixels) {
  cv::Mat mat(rows, columns, CV_16UC1);
  std::copy(pixels.begin(), pixels.end(), mat.begin<std::uint16_t>());
  std::vector<std::uint8_t> bytes;
  if (mat.empty() || !cv::imencode(".png", mat, bytes)) {
    throw std::invalid_argument("an image of this size cannot be written as PNG");
  }
  return {bytes.begin(), bytes.end()};
}

}  // namespace selfproj
