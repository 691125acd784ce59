#ifndef SELFPROJ_TESTS_CLI_RANDOM_IMAGE_H
#define SELFPROJ_TESTS_CLI_RANDOM_IMAGE_H

#include <algorithm>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "tests/support/random_cases.h"

namespace selfproj::test {

// Returns an image of random bytes.
inline cv::Mat random_image(Random& random, int rows, int columns, int type = CV_8UC1) {
  cv::Mat image(rows, columns, type);
  const std::vector<std::uint8_t> bytes = random.bytes(image.total() * image.elemSize());
  std::copy(bytes.begin(), bytes.end(), image.data);
  return image;
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_CLI_RANDOM_IMAGE_H
