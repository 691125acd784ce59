// Decodes image files, of which it first reads format and size; no other code does.
#ifndef SELFPROJ_HOST_IMAGES_IMAGE_DECODER_H
#define SELFPROJ_HOST_IMAGES_IMAGE_DECODER_H

#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace selfproj::images {

enum class ImageFormat : std::uint8_t { png, jpeg, tiff, bmp, pnm };

// The format according to the magic number, or nothing.
std::optional<ImageFormat> image_format(std::string_view bytes);

struct ImageHeader {
  ImageFormat format = ImageFormat::png;
  std::uint64_t columns = 0;
  std::uint64_t rows = 0;
  std::size_t orientation_at = 0;  // TIFF: position of the value of its orientation tag; 0: it has none
  std::string refusal = {};        // why its pixels cannot be taken although the file is whole; empty: they can
  std::uint32_t white = 0;         // the largest value of a pixel, where the file says it; 0: it does not
  std::size_t pixels_at = 0;       // PNM: where they begin
};

// What the file says of its image. Nothing if the file is not an image or this part is damaged.
std::optional<ImageHeader> image_header(std::string_view bytes);

// Returns a TIFF file without its request to be turned.
void clear_orientation(const ImageHeader& header, std::string& bytes);

// The largest image that is decoded: 16384 x 16384 pixels, the largest camera and projector of a rig.
inline constexpr std::uint64_t kMaxImagePixels = std::uint64_t{1} << 28U;

// The error text for a file that is not one of these images.
inline constexpr const char* kNotAnImage = "is not an image in a known format, or is damaged";

struct DecodedImage {
  cv::Mat pixels;
  std::uint32_t white = 0;  // the largest value that a pixel can have; 0: the file does not say, or they are floats
};

// Decodes a PNG, JPEG, TIFF, BMP or PNM file that passes check_image_file. The image keeps its depth and channels, and
// is never turned, whatever orientation the file notes. Values of 8 bits go up to 255 whatever their maximum in the
// file. A JPEG with bytes too many is taken if its pixels are whole without them. Throws UserError, naming the file, if
// it cannot be read, is not an image, is damaged, has several images, or has more than kMaxImagePixels pixels.
DecodedImage decode_image(const std::string& file);

// A file that may be a TIFF of several pages, decoded page by page. Holds such a file in memory.
class PagedImage {
 public:
  // Throws UserError, naming the file, if it cannot be read or is a damaged TIFF.
  explicit PagedImage(std::string file);

  [[nodiscard]] const std::string& file() const { return file_; }
  [[nodiscard]] std::size_t pages() const { return links_.empty() ? 1 : links_.size(); }

  // Page i, from 0. Throws as decode_image does.
  [[nodiscard]] DecodedImage page(std::size_t i);

 private:
  std::string file_;
  std::string bytes_;                 // of a file with several pages
  std::vector<std::uint64_t> links_;  // where in them the places of the pages stand
};

}  // namespace selfproj::images

#endif  // SELFPROJ_HOST_IMAGES_IMAGE_DECODER_H
