#include "selfproj/images/float_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "host/files/output_file.h"
#include "host/images/image_decoder.h"
#include "host/images/image_files.h"
#include "selfproj/files/user_error.h"

namespace selfproj::images {
namespace {

constexpr float kMaxFloat = 1e9F;  // no length in mm, no row and no column is larger

}  // namespace

std::uint64_t digest(const FloatImage& image) {
  constexpr std::uint64_t kOdd = 0x9E3779B97F4A7C15U;  // 2^64 over the golden ratio: its multiples are spread evenly
  constexpr std::size_t kLanes = 4;                    // multiplications that need not wait for each other
  std::array<std::uint64_t, kLanes> lanes{1, 2, 3, 4};
  const auto add = [](std::uint64_t& lane, std::uint64_t word) { lane = std::rotl((lane ^ word) * kOdd, 31); };
  const std::size_t pairs = image.values.size() / 2;
  const float* from = image.values.data();
  const auto pair_at = [&](std::size_t i) {
    std::uint64_t word = 0;
    std::memcpy(&word, from + 2 * i, sizeof(word));
    return word;
  };
  std::size_t i = 0;
  for (; i + kLanes <= pairs; i += kLanes) {
    add(lanes[0], pair_at(i));
    add(lanes[1], pair_at(i + 1));
    add(lanes[2], pair_at(i + 2));
    add(lanes[3], pair_at(i + 3));
  }
  for (; i < pairs; ++i) {
    add(lanes[0], pair_at(i));
  }
  if (image.values.size() % 2 != 0) {
    add(lanes[0], std::bit_cast<std::uint32_t>(image.values.back()));
  }
  std::uint64_t result = static_cast<std::uint64_t>(image.rows) << 32U | static_cast<std::uint64_t>(image.columns);
  for (const std::uint64_t lane : lanes) {
    add(result, lane);
  }
  return result ^ result >> 29U;
}

FloatImage read_float_tiff(const std::string& file) {
  check_image_file(file);
  const cv::Mat image = decode_image(file).pixels;
  if (image.type() != CV_32FC1) {
    throw UserError(file, "is not an image of one channel of 32-bit floating-point numbers");
  }
  FloatImage result(image.rows, image.cols);
  result.values.assign(image.begin<float>(), image.end<float>());
  const auto wrong = std::find_if(result.values.begin(), result.values.end(),
                                  [](float value) { return std::abs(value) > kMaxFloat; });  // infinite ones, too
  if (wrong != result.values.end()) {
    throw UserError(file, fmt::format("has a pixel that is {}; its size may be at most {:.0e}", *wrong, kMaxFloat));
  }
  return result;
}

std::string encode_float_tiff(const std::string& file, const FloatImage& image) {
  const cv::Mat mat(image.rows, image.columns, CV_32FC1, const_cast<float*>(image.values.data()));  // is only read
  std::vector<std::uint8_t> bytes;
  if (image.values.empty() || !cv::imencode(".tiff", mat, bytes)) {
    throw UserError(file, "an image of this size cannot be written as TIFF");
  }
  return {bytes.begin(), bytes.end()};
}

void write_float_tiff(const std::string& file, const FloatImage& image) {
  const files::OutputFile output(file);
  output.write(encode_float_tiff(file, image));
}

}  // namespace selfproj::images
