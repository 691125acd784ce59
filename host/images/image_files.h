// Image files as frames of the camera: 8 bits, one channel.
#ifndef SELFPROJ_HOST_IMAGES_IMAGE_FILES_H
#define SELFPROJ_HOST_IMAGES_IMAGE_FILES_H

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "selfproj/model/column_moments.h"

namespace selfproj::images {

// The part of a colour image to take: one of its planes, its luminance (ITU-R BT.601, rounded as in OpenCV), or for the
// light of a red laser the red plane less the mean of green and blue, at least 0, halves rounded up.
enum class Channel : std::uint8_t { red, green, blue, grey, red_difference };

// Their names in options.
inline constexpr std::array<std::pair<const char*, Channel>, 5> kChannels{
    {{"red", Channel::red},
     {"green", Channel::green},
     {"blue", Channel::blue},
     {"grey", Channel::grey},
     {"red-difference", Channel::red_difference}}};

// An image that owns its pixels, row by row without gaps.
struct Image {
  int rows = 0;
  int columns = 0;
  std::vector<std::uint8_t> pixels;

  // Valid while this object lives and its pixels are not resized.
  [[nodiscard]] model::ImageView view() const { return {pixels.data(), rows, columns, columns}; }
};

// The image as one that owns its pixels.
Image copy_of(const model::ImageView& view);

// A part of an image or of a sensor; left and top from 0.
struct ImagePart {
  int columns = 0;
  int rows = 0;
  int left = 0;
  int top = 0;

  bool operator==(const ImagePart&) const = default;
};

// The part of a text such as 320x60+0+40: columns, rows, left, top, none of them above max_side. Nothing for any other
// text.
std::optional<ImagePart> image_part(std::string_view text, int max_side);

// Finds errors early that read_image would find late: throws UserError if the file cannot be read or its first bytes
// are not those of an image.
void check_image_file(const std::string& file);

// Reads an image of any format known to OpenCV, and ignores the orientation that some cameras note in the file. A
// colour image needs a channel. An image of one channel is taken as it is, and accepts no channel. Throws UserError,
// naming the file, if it cannot be read, is not an image, is damaged, does not have 8 bits, or does not fit the
// channel.
Image read_image(const std::string& file, std::optional<Channel> channel);

// The files of a folder in natural order (img2 before img10), without those that begin with a dot and without
// capture.json, the record of a capture. Throws UserError if the folder cannot be read or has no files.
std::vector<std::string> files_of_folder(const std::string& folder);

// The image files that a command is given: the files themselves, or those of the folder if it is given a single one.
std::vector<std::string> image_arguments(const std::vector<std::string>& arguments);

// Returns the bytes of a PNG file. Throws std::invalid_argument if the image has no pixels or is too large.
std::string encode_png(const Image& image);

// Returns the bytes of a PNG file of rows x columns pixels of 16 bits, given row by row without gaps. Throws
// std::invalid_argument if the image has no pixels or is too large.
std::string encode_png16(int rows, int columns, std::span<const std::uint16_t> pixels);

}  // namespace selfproj::images

#endif  // SELFPROJ_HOST_IMAGES_IMAGE_FILES_H
