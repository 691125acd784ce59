#include "host/io/float_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "host/io/image_decoder.h"
#include "host/io/image_files.h"
#include "host/io/output_file.h"
#include "host/io/user_error.h"

namespace selfproj {
namespace {

constexpr float kMostFloat = 1e9F;  // no length in mm, no row and no column is larger

}  // namespace

FloatImage read_float_tiff(const std::string& file) {
  check_image_file(file);
  const cv::Mat image = decode_image(file);
  if (image.type() != CV_32FC1) {
    throw UserError(file, "is not an image of one channel of 32-bit floating-point numbers");
  }
  FloatImage result(image.rows, image.cols);
  for (int r = 0; r < image.rows; ++r) {
    std::copy_n(image.ptr<float>(r), image.cols, result.row(r));
  }
  const auto wrong = std::find_if(result.values.begin(), result.values.end(),
                                  [](float value) { return std::abs(value) > kMostFloat; });  // infinite ones, too
  if (wrong != result.values.end()) {
    throw UserError(file, fmt::format("has a pixel that is {}; its size may be at most {:.0e}", *wrong, kMostFloat));
  }
  return result;
}

std::string encode_float_tiff(const std::string& file, const FloatImage& image) {
  cv::Mat mat(image.rows, image.columns, CV_32FC1);
  for (int r = 0; r < image.rows; ++r) {
    std::copy_n(image.row(r), image.columns, mat.ptr<float>(r));
  }
  std::vector<std::uint8_t> bytes;
  if (image.values.empty() || !cv::imencode(".tiff", mat, bytes)) {
    throw UserError(file, "an image of this size cannot be written as TIFF");
  }
  std::string text(bytes.size(), '\0');
  std::memcpy(text.data(), bytes.data(), bytes.size());
  return text;
}

void write_float_tiff(const std::string& file, const FloatImage& image) {
  const OutputFile output(file);
  output.write(encode_float_tiff(file, image));
}

}  // namespace selfproj
