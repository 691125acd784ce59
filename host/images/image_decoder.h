// Decodes image files, of which it first reads format and size; no other code does.
#ifndef SELFPROJ_HOST_IMAGES_IMAGE_DECODER_H
#define SELFPROJ_HOST_IMAGES_IMAGE_DECODER_H

#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace selfproj::images {

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

// The largest image that is decoded: 16384 x 16384 pixels, the largest camera and projector of a rig.
inline constexpr std::uint64_t kMaxImagePixels = std::uint64_t{1} << 28U;

// The error text for a file that is not one of these images.
inline constexpr const char* kNotAnImage = "is not an image in a known format, or is damaged";

// Decodes a PNG, JPEG, TIFF, BMP or PNM file that passes check_image_file. The image keeps its depth and channels, and
// is never turned, whatever orientation the file notes. Throws UserError, naming the file, if it cannot be read, is not
// an image, is damaged, or has more than kMaxImagePixels pixels.
cv::Mat decode_image(const std::string& file);

}  // namespace selfproj::images

#endif  // SELFPROJ_HOST_IMAGES_IMAGE_DECODER_H
