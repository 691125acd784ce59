// Images of 32-bit floating-point numbers: patterns, heights, differences.
#ifndef SELFPROJ_IMAGES_FLOAT_IMAGE_H
#define SELFPROJ_IMAGES_FLOAT_IMAGE_H

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace selfproj::images {

// The value of a pixel without a value: NaN.
inline constexpr float kNoValue = std::numeric_limits<float>::quiet_NaN();

// Row by row without gaps. NaN is a pixel without a value.
struct FloatImage {
  int rows = 0;
  int columns = 0;
  std::vector<float> values;

  FloatImage() = default;
  FloatImage(int row_count, int column_count, float value = 0)
      : rows(row_count),
        columns(column_count),
        values(static_cast<std::size_t>(row_count) * static_cast<std::size_t>(column_count), value) {}

  [[nodiscard]] float* row(int r) { return values.data() + static_cast<std::ptrdiff_t>(r) * columns; }
  [[nodiscard]] const float* row(int r) const { return values.data() + static_cast<std::ptrdiff_t>(r) * columns; }
  bool operator==(const FloatImage&) const = default;
};

// A word of the size and of every bit of the pixels, by which images of two runs can be compared. Two images that
// differ have the same word by chance in one of 2^64 cases; it is no protection against intent.
std::uint64_t digest(const FloatImage& image);

// Reads a TIFF file of one channel of 32-bit floating-point numbers. Throws UserError, naming the file, if it is
// unreadable, not such an image, or has a number greater than 1e9.
FloatImage read_float_tiff(const std::string& file);

// Returns the bytes of such a file. Throws UserError, naming the file, if the image has no pixels or is too large.
std::string encode_float_tiff(const std::string& file, const FloatImage& image);

// Writes the file, whole or not at all. Throws UserError.
void write_float_tiff(const std::string& file, const FloatImage& image);

}  // namespace selfproj::images

#endif  // SELFPROJ_IMAGES_FLOAT_IMAGE_H
