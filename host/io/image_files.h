// Image files as frames of the camera: 8 bits, one channel.
#ifndef SELFPROJ_HOST_IO_IMAGE_FILES_H
#define SELFPROJ_HOST_IO_IMAGE_FILES_H

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "model/column_moments.h"

namespace selfproj {

// What to take of a colour image: one of its planes, or its luminance (ITU-R BT.601, as OpenCV rounds it).
enum class Channel : std::uint8_t { red, green, blue, grey };

// "red", "green", "blue", "grey".
std::string to_string(Channel channel);

// An image that owns its pixels, row by row without gaps.
struct Image {
  int rows = 0;
  int columns = 0;
  std::vector<std::uint8_t> pixels;

  // Valid while this object lives and its pixels are not resized.
  [[nodiscard]] ImageView view() const { return {pixels.data(), rows, columns, columns}; }
};

// Says early what read_image would say late: throws UserError where the file cannot be read or, by its first bytes, is
// no image.
void check_image_file(const std::string& file);

// Reads an image of any format known to OpenCV; the orientation some cameras note in the file is ignored.
// A colour image needs a channel; one of a single channel is taken as it is, and has no colour to ask for.
// Throws UserError, naming the file, where it cannot be read, is no image or a damaged one, has other than 8 bits, or
// channel and image do not go together.
Image read_image(const std::string& file, std::optional<Channel> channel);

// The files of a folder in natural order (img2 before img10), without those that begin with a dot. Throws UserError
// where the folder cannot be read or has none.
std::vector<std::string> files_of_folder(const std::string& folder);

// The bytes of a PNG file. Throws std::invalid_argument where the image has no pixels or is too large.
std::string encode_png(const Image& image);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_IO_IMAGE_FILES_H
