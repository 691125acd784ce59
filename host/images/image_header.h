// Reads format and size from the first bytes of an image file, before anything is decoded.
#ifndef SELFPROJ_HOST_IMAGES_IMAGE_HEADER_H
#define SELFPROJ_HOST_IMAGES_IMAGE_HEADER_H

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace selfproj {

enum class ImageFormat : std::uint8_t { png, jpeg, tiff, bmp, pnm };

// The format according to the magic number, or nothing.
std::optional<ImageFormat> image_format(std::string_view bytes);

struct ImageHeader {
  ImageFormat format = ImageFormat::png;
  std::uint64_t columns = 0;
  std::uint64_t rows = 0;
  std::size_t orientation_at = 0;  // TIFF: position of the value of its orientation tag; 0: it has none
};

// Format and size of the (first) image. Nothing if the file is not an image or this part is damaged.
std::optional<ImageHeader> image_header(std::string_view bytes);

// Returns a TIFF file without its request to be turned.
void clear_orientation(const ImageHeader& header, std::string& bytes);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_IMAGES_IMAGE_HEADER_H
