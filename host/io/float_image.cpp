#include "host/io/float_image.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "host/io/image_files.h"
#include "host/io/output_file.h"
#include "host/io/stderr_capture.h"
#include "host/io/user_error.h"

namespace selfproj {

FloatImage read_float_tiff(const std::string& file) {
  check_image_file(file);
  cv::Mat image;
  {
    const StderrCapture capture;
    try {
      image = cv::imread(file, cv::IMREAD_UNCHANGED);
    } catch (const cv::Exception&) {
      image.release();
    }
  }
  if (image.empty()) {
    throw UserError(file, "not an image in a known format, or damaged");
  }
  if (image.type() != CV_32FC1) {
    throw UserError(file, "is not an image of one channel of 32-bit floating-point numbers");
  }
  FloatImage result(image.rows, image.cols);
  for (int r = 0; r < image.rows; ++r) {
    std::copy_n(image.ptr<float>(r), image.cols, result.row(r));
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
