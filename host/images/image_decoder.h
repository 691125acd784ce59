// Decodes image files; no other code does.
#ifndef SELFPROJ_HOST_IMAGES_IMAGE_DECODER_H
#define SELFPROJ_HOST_IMAGES_IMAGE_DECODER_H

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>

namespace selfproj {

// The largest image that is decoded: 16384 x 16384 pixels, the largest camera and projector of a rig.
inline constexpr std::uint64_t kMostImagePixels = std::uint64_t{1} << 28U;

// The error text for a file that is not one of these images.
inline constexpr const char* kNotAnImage = "is not an image in a known format, or is damaged";

// Decodes a PNG, JPEG, TIFF, BMP or PNM file that passes check_image_file. The image keeps its depth and channels, and
// is never turned, whatever orientation the file notes. Throws UserError, naming the file, if it cannot be read, is not
// an image, is damaged, or has more than kMostImagePixels pixels.
cv::Mat decode_image(const std::string& file);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_IMAGES_IMAGE_DECODER_H
