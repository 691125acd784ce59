#ifndef SELFPROJ_HOST_IMAGES_CODE_IMAGE_H
#define SELFPROJ_HOST_IMAGES_CODE_IMAGE_H

#include <cstdint>
#include <span>
#include <string>

namespace selfproj {

// Returns the bytes of a PNG file of rows x columns pixels of 16 bits, given row by row without gaps. Throws
// std::invalid_argument if the image has no pixels or is too large.
std::string encode_png16(int rows, int columns, std::span<const std::uint16_t> pixels);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_IMAGES_CODE_IMAGE_H
