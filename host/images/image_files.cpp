#include "host/images/image_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <glob.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "host/files/file_descriptor.h"
#include "host/files/notes.h"
#include "host/files/numbers.h"
#include "host/files/run_files.h"
#include "host/images/image_decoder.h"
#include "host/images/natural_order.h"
#include "selfproj/files/user_error.h"

namespace selfproj::images {
namespace {

// One plane less the mean of the other two, (2 a - b - c + 1) / 2 rounded down, at least 0. OpenCV's order of planes is
// blue, green, red.
cv::Mat difference(const cv::Mat& image, int of) {
  cv::Mat plane(image.rows, image.cols, CV_8UC1);
  const int channels = image.channels();
  const int second = (of + 1) % 3;
  const int third = (of + 2) % 3;
  for (int row = 0; row < image.rows; ++row) {
    const auto* from = image.ptr<std::uint8_t>(row);
    auto* to = plane.ptr<std::uint8_t>(row);
    for (int column = 0; column < image.cols; ++column, from += channels) {
      const int twice = 2 * from[of] - from[second] - from[third];
      to[column] = static_cast<std::uint8_t>(twice > 0 ? (twice + 1) / 2 : 0);
    }
  }
  return plane;
}

cv::Mat one_channel(const std::string& file, const cv::Mat& image, std::optional<Channel> channel) {
  if (image.channels() == 1) {
    if (channel.value_or(Channel::grey) != Channel::grey) {
      throw UserError(file, std::string("has a single channel; --channel ") +
                                kChannels.at(static_cast<std::size_t>(*channel)).first + " needs a colour image");
    }
    return image;
  }
  if (image.channels() != 3 && image.channels() != 4) {
    throw UserError(file, "has " + std::to_string(image.channels()) + " channels; 1, 3 or 4 are expected");
  }
  if (!channel) {
    throw UserError(
        file,
        "is a colour image; choose a channel with --channel red, green, blue, grey or, for the light of a laser, "
        "red-difference, green-difference or blue-difference");
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
    case Channel::red_difference:
      plane = difference(image, 2);
      break;
    case Channel::green_difference:
      plane = difference(image, 1);
      break;
    case Channel::blue_difference:
      plane = difference(image, 0);
      break;
  }
  return plane;
}

// Throws UserError unless the values have 8 or 16 bits.
void check_whole_numbers(const std::string& file, const DecodedImage& image) {
  const int depth = image.pixels.depth();
  if (depth != CV_8U && depth != CV_16U) {
    const bool floats = depth == CV_32F || depth == CV_64F;
    throw UserError(file,
                    floats ? "has pixels that are floating-point numbers; whole numbers of 8 to 16 bits are expected"
                           : fmt::format("has {} bits per pixel; 8 to 16 are expected", 8 * image.pixels.elemSize1()));
  }
}

// The values as 8 bits.
cv::Mat narrow(const std::string& file, const DecodedImage& image, std::optional<int> shift) {
  if (image.pixels.depth() == CV_8U) {
    if (shift) {
      throw UserError(file, "has 8 bits per pixel; --shift goes only with images of more bits");
    }
    return image.pixels;
  }
  check_whole_numbers(file, image);
  if (!shift && image.white == 0) {
    throw UserError(file,
                    "has 16 bits per pixel, and does not say how many of them count: --shift 4 takes values of 12 "
                    "bits, --shift 8 of 16");
  }
  const bool whole_bits = image.white != 0 && std::has_single_bit(image.white + 1);
  const int by = shift.value_or(whole_bits ? std::bit_width(image.white) - 8 : 0);
  const bool scaled = !shift && image.white != 0 && !whole_bits;
  cv::Mat narrowed(image.pixels.rows, image.pixels.cols, CV_MAKETYPE(CV_8U, image.pixels.channels()));
  const int values = image.pixels.cols * image.pixels.channels();
  for (int row = 0; row < image.pixels.rows; ++row) {
    const auto* from = image.pixels.ptr<std::uint16_t>(row);
    auto* to = narrowed.ptr<std::uint8_t>(row);
    for (int i = 0; i < values; ++i) {
      const unsigned value = scaled ? (2U * 255U * from[i] + image.white) / (2 * image.white)
                                    : unsigned{from[i]} >> static_cast<unsigned>(by);
      if (value > 255) {
        throw UserError(file, fmt::format("has a value of {}; with {} values up to {} are possible", from[i],
                                          shift ? fmt::format("--shift {}", by) : "its bits", (256 << by) - 1));
      }
      to[i] = static_cast<std::uint8_t>(value);
    }
  }
  return narrowed;
}

// The image is only read.
std::string png_of(const cv::Mat& image) {
  std::vector<std::uint8_t> bytes;
  if (image.empty() || !cv::imencode(".png", image, bytes)) {
    throw std::invalid_argument("an image of this size cannot be written as PNG");
  }
  return {bytes.begin(), bytes.end()};
}

}  // namespace

std::optional<ImagePart> image_part(std::string_view text, int max_side) {
  std::array<int, 4> numbers{};
  constexpr std::array<std::string_view, 4> kBehind{"x", "+", "+", ""};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::size_t end = kBehind[i].empty() ? text.size() : text.find(kBehind[i]);
    const auto number = end == std::string_view::npos ? std::nullopt : files::number_of_text<int>(text.substr(0, end));
    if (!number || *number < (i < 2 ? 1 : 0) || *number > max_side) {
      return std::nullopt;
    }
    numbers[i] = *number;
    text.remove_prefix(std::min(text.size(), end + 1));
  }
  return ImagePart{.columns = numbers[0], .rows = numbers[1], .left = numbers[2], .top = numbers[3]};
}

void check_image_file(const std::string& file) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    throw UserError(file, std::filesystem::is_directory(status) ? "is a folder" : "is not a regular file");
  }
  const files::FileDescriptor opened(open(file.c_str(), O_RDONLY | O_CLOEXEC));
  std::array<char, 16> first{};
  const ssize_t count = opened.number() < 0 ? -1 : read(opened.number(), first.data(), first.size());
  if (count < 0) {
    throw UserError(file, files::error_text(errno));
  }
  if (!image_format({first.data(), static_cast<std::size_t>(count)})) {
    throw UserError(file, kNotAnImage);
  }
  files::note_input(file);
}

namespace {

Image by_rule(const std::string& name, const DecodedImage& decoded, const PixelRule& rule) {
  const cv::Mat plane = one_channel(name, narrow(name, decoded, rule.shift), rule.channel);
  return copy_of(
      model::ImageView{plane.ptr<std::uint8_t>(), plane.rows, plane.cols, static_cast<std::ptrdiff_t>(plane.step)});
}

// The values as they are, which must be those of rule.bits bits.
WideImage wide_by_rule(const std::string& name, const DecodedImage& decoded, const PixelRule& rule) {
  if (decoded.pixels.channels() != 1 || rule.channel) {
    throw UserError(name, fmt::format("pixels of {} bits (measure.pixel_bits of the rig) are taken of images of one "
                                      "channel, without --channel",
                                      rule.bits));
  }
  check_whole_numbers(name, decoded);
  const int shift = rule.shift.value_or(0);
  const bool eight = decoded.pixels.depth() == CV_8U;
  const bool said = eight || decoded.white != 0;  // how many bits there are
  const std::uint32_t white = eight ? UINT8_MAX : decoded.white;
  if (said && white >> shift != (1U << rule.bits) - 1) {
    throw UserError(
        name,
        fmt::format("has values up to {}{}; pixels of {} bits are expected, up to {}, as measure.pixel_bits of the "
                    "rig says{}",
                    white, rule.shift ? fmt::format(", with --shift {} up to {}", shift, white >> shift) : "",
                    rule.bits, (1 << rule.bits) - 1,
                    white == UINT16_MAX && !rule.shift
                        ? fmt::format("; --shift {} takes values that are shifted up", 16 - rule.bits)
                        : ""));
  }
  WideImage image{decoded.pixels.rows, decoded.pixels.cols, {}};
  image.pixels.reserve(decoded.pixels.total());
  for (int row = 0; row < image.rows; ++row) {
    const auto* from = decoded.pixels.ptr<std::uint16_t>(row);
    for (int column = 0; column < image.columns; ++column) {
      const int value = from[column] >> shift;
      if (value >= 1 << rule.bits) {
        throw UserError(name, fmt::format("has a value of {}; pixels of {} bits are expected, as measure.pixel_bits of "
                                          "the rig says, and --shift N takes values of N bits more",
                                          from[column], rule.bits));
      }
      image.pixels.push_back(static_cast<std::uint16_t>(value));
    }
  }
  return image;
}

// The pages of a TIFF; 1 for any other image.
std::size_t count_pages(const std::string& file) {
  const files::FileDescriptor opened(open(file.c_str(), O_RDONLY | O_CLOEXEC));
  std::array<char, 4> first{};
  const ssize_t count = opened.number() < 0 ? 0 : read(opened.number(), first.data(), first.size());
  const bool tiff =
      image_format({first.data(), static_cast<std::size_t>(std::max<ssize_t>(0, count))}) == ImageFormat::tiff;
  return tiff ? PagedImage(file).pages() : 1;
}

}  // namespace

bool is_colour_image(const std::string& file) {
  check_image_file(file);
  return decode_image(file).pixels.channels() > 1;
}

Image read_image(const std::string& file, const PixelRule& rule) {
  check_image_file(file);
  return by_rule(file, decode_image(file), rule);
}

SensorImage read_sensor_image(const std::string& file, const PixelRule& rule) {
  check_image_file(file);
  const DecodedImage decoded = decode_image(file);
  return rule.bits > spec::kPixelBits ? SensorImage(wide_by_rule(file, decoded, rule)) : by_rule(file, decoded, rule);
}

Image upper_bits(const SensorImage& image, int bits) {
  if (const auto* eight = std::get_if<Image>(&image)) {
    return *eight;
  }
  const auto& wide = std::get<WideImage>(image);
  Image upper{wide.rows, wide.columns, {}};
  upper.pixels.reserve(wide.pixels.size());
  for (const std::uint16_t pixel : wide.pixels) {
    upper.pixels.push_back(static_cast<std::uint8_t>(pixel >> (bits - spec::kPixelBits)));
  }
  return upper;
}

ImagePages::ImagePages(std::vector<std::string> files) : files_(std::move(files)) {
  for (std::size_t i = 0; i < files_.size(); ++i) {
    check_image_file(files_[i]);
    const std::size_t pages = count_pages(files_[i]);
    for (std::size_t page = 0; page < pages; ++page) {
      places_.push_back({i, page, pages == 1});
      names_.push_back(pages == 1 ? files_[i] : fmt::format("{}: page {}", files_[i], page + 1));
    }
  }
}

Image ImagePages::read(std::size_t i, const PixelRule& rule) { return by_rule(names_.at(i), decoded(i), rule); }

WideImage ImagePages::read_wide(std::size_t i, const PixelRule& rule) {
  return wide_by_rule(names_.at(i), decoded(i), rule);
}

DecodedImage ImagePages::decoded(std::size_t i) {
  const Place& place = places_.at(i);
  const std::string& file = files_[place.file];
  if (place.alone) {
    check_image_file(file);
    return decode_image(file);
  }
  if (open_ == nullptr || open_->file() != file) {
    open_ = std::make_shared<PagedImage>(file);
  }
  return open_->page(place.page);
}

namespace {

// Extensions of images, also of formats that are refused.
constexpr std::array kImageExtensions{".png", ".jpg", ".jpeg", ".jpe", ".tif", ".tiff", ".bmp",  ".dib",
                                      ".pbm", ".pgm", ".ppm",  ".pnm", ".pam", ".gif",  ".webp", ".jp2",
                                      ".exr", ".hdr", ".raw",  ".dng", ".cr2", ".nef",  ".heic", ".avif"};

bool is_image(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  if (std::find(kImageExtensions.begin(), kImageExtensions.end(), extension) != kImageExtensions.end()) {
    return true;
  }
  std::error_code error;
  const files::FileDescriptor opened(
      std::filesystem::is_regular_file(file, error) ? open(file.c_str(), O_RDONLY | O_CLOEXEC) : -1);
  std::array<char, 16> first{};
  const ssize_t count = opened.number() < 0 ? 0 : read(opened.number(), first.data(), first.size());
  return count > 0 && image_format({first.data(), static_cast<std::size_t>(count)}).has_value();
}

}  // namespace

std::vector<std::string> files_of_folder(const std::string& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw UserError(folder, fs::exists(folder, error) ? "is not a folder" : "there is no such folder");
  }
  files::note_input_folder(folder);
  std::vector<std::string> files;
  std::vector<std::string> others;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (!name.starts_with('.') && name != "capture.json" && name != kReferenceFile) {
      (is_image(entry->path()) ? files : others).push_back(entry->path().string());
    }
  }
  if (error) {
    throw UserError(folder, error.message());
  }
  if (files.empty()) {
    throw UserError(folder, "contains no images");
  }
  if (!others.empty()) {
    others = in_natural_order(std::move(others));
    files::note(fmt::format("{}: is no image and left out{}", others.front(),
                            others.size() == 1   ? ""
                            : others.size() == 2 ? ", like another one of its folder"
                                                 : fmt::format(", like {} others of its folder", others.size() - 1)));
  }
  return in_natural_order(std::move(files));
}

std::vector<std::string> image_arguments(const std::vector<std::string>& arguments) {
  std::error_code error;
  if (arguments.size() == 1 && std::filesystem::is_directory(arguments.front(), error)) {
    return files_of_folder(arguments.front());
  }
  for (const std::string& argument : arguments) {
    const std::filesystem::file_status status = std::filesystem::status(argument, error);
    if (status.type() == std::filesystem::file_type::not_found) {
      throw UserError(argument, "No such file or directory");
    }
    if (std::filesystem::is_directory(status)) {
      throw UserError(argument, "is a folder; give one folder, or files");
    }
  }
  return arguments;
}

std::vector<std::string> files_of_pattern(const std::string& option, const std::string& pattern) {
  std::error_code error;
  if (std::filesystem::is_directory(pattern, error)) {
    return files_of_folder(pattern);
  }
  if (std::filesystem::exists(pattern, error)) {
    return {pattern};
  }
  // Brackets are those of a name where there is one, else a set of characters.
  std::string of_name;
  for (const char c : pattern) {
    of_name += c == '[' ? "[[]" : std::string(1, c);
  }
  for (const std::string& wanted : {of_name, pattern}) {
    glob_t found{};
    const int result = glob(wanted.c_str(), 0, nullptr, &found);
    std::vector<std::string> files(found.gl_pathv, found.gl_pathv + (result == 0 ? found.gl_pathc : 0));
    globfree(&found);
    if (!files.empty()) {
      return in_natural_order(std::move(files));
    }
  }
  throw UserError(option + " " + pattern, "no file matches");
}

std::vector<std::string> files_of_patterns(const std::string& option, const std::vector<std::string>& patterns) {
  std::vector<std::string> files;
  for (const std::string& pattern : patterns) {
    const std::vector<std::string> found = files_of_pattern(option, pattern);
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

std::string encode_png(const Image& image) {
  return png_of({image.rows, image.columns, CV_8UC1, const_cast<std::uint8_t*>(image.pixels.data())});
}

std::string encode_png16(int rows, int columns, std::span<const std::uint16_t> pixels) {
  return png_of({rows, columns, CV_16UC1, const_cast<std::uint16_t*>(pixels.data())});
}

}  // namespace selfproj::images
