#include "host/io/image_files.h"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "host/io/natural_order.h"
#include "host/io/stderr_capture.h"
#include "host/io/user_error.h"

namespace selfproj {
namespace {

constexpr const char* kNoImage = "not an image in a known format, or damaged";

// libjpeg fills up what is missing from a damaged file, and says so on standard error only.
bool tells_of_damage(const std::string& messages) {
  return messages.find("Premature end") != std::string::npos || messages.find("Corrupt") != std::string::npos;
}

// OpenCV reads the file itself: given bytes, it would let libjpeg stop at the end of a file cut short without a word.
cv::Mat decode(const std::string& file) {
  cv::Mat image;
  const StderrCapture capture;
  try {
    image = cv::imread(file, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    throw UserError(file, kNoImage);
  }
  if (image.empty() || tells_of_damage(capture.text())) {
    throw UserError(file, kNoImage);
  }
  return image;
}

cv::Mat one_channel(const std::string& file, const cv::Mat& image, std::optional<Channel> channel) {
  if (image.channels() == 1) {
    if (channel.value_or(Channel::grey) != Channel::grey) {
      throw UserError(file, "has a single channel; --channel " + to_string(*channel) + " asks for a colour image");
    }
    return image;
  }
  if (image.channels() != 3 && image.channels() != 4) {
    throw UserError(file, "has " + std::to_string(image.channels()) + " channels; 1, 3 or 4 are taken");
  }
  if (!channel) {
    throw UserError(file, "is a colour image; say with --channel red|green|blue|grey what to take");
  }
  cv::Mat plane;
  switch (*channel) {  // OpenCV's order of planes is blue, green, red
    case Channel::blue:
      cv::extractChannel(image, plane, 0);
      break;
    case Channel::green:
      cv::extractChannel(image, plane, 1);
      break;
    case Channel::red:
      cv::extractChannel(image, plane, 2);
      break;
    case Channel::grey:
      cv::cvtColor(image, plane, image.channels() == 3 ? cv::COLOR_BGR2GRAY : cv::COLOR_BGRA2GRAY);
      break;
  }
  return plane;
}

}  // namespace

std::string to_string(Channel channel) {
  switch (channel) {
    case Channel::red:
      return "red";
    case Channel::green:
      return "green";
    case Channel::blue:
      return "blue";
    case Channel::grey:
      break;
  }
  return "grey";
}

void check_image_file(const std::string& file) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    throw UserError(file, std::filesystem::is_directory(status) ? "is a folder" : "is not a regular file");
  }
  std::FILE* opened = std::fopen(file.c_str(), "rb");
  if (opened == nullptr) {
    throw UserError(file, std::generic_category().message(errno));
  }
  static_cast<void>(std::fclose(opened));
  if (!cv::haveImageReader(file)) {
    throw UserError(file, kNoImage);
  }
}

Image read_image(const std::string& file, std::optional<Channel> channel) {
  check_image_file(file);
  const cv::Mat image = decode(file);
  if (image.depth() != CV_8U) {
    throw UserError(file, "has " + std::to_string(8 * image.elemSize1()) + " bits a pixel; 8 are needed");
  }
  const cv::Mat plane = one_channel(file, image, channel);
  Image result{plane.rows, plane.cols, {}};
  result.pixels.reserve(plane.total());
  for (int row = 0; row < plane.rows; ++row) {
    const auto* pixels = plane.ptr<std::uint8_t>(row);
    result.pixels.insert(result.pixels.end(), pixels, pixels + plane.cols);
  }
  return result;
}

std::vector<std::string> files_of_folder(const std::string& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw UserError(folder, fs::exists(folder, error) ? "is not a folder" : "there is no such folder");
  }
  std::vector<std::string> files;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (!entry->path().filename().string().starts_with('.')) {
      files.push_back(entry->path().string());
    }
  }
  if (error) {
    throw UserError(folder, error.message());
  }
  if (files.empty()) {
    throw UserError(folder, "has no images");
  }
  return in_natural_order(std::move(files));
}

std::string encode_png(const Image& image) {
  cv::Mat mat(image.rows, image.columns, CV_8UC1);
  std::vector<std::uint8_t> bytes;
  std::copy(image.pixels.begin(), image.pixels.end(), mat.begin<std::uint8_t>());
  if (image.pixels.empty() || !cv::imencode(".png", mat, bytes)) {
    throw std::invalid_argument("an image of this size cannot be written as PNG");
  }
  return {bytes.begin(), bytes.end()};
}

}  // namespace selfproj
