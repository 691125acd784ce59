// Images of any of these pixel formats as images of 8 bits.
#ifndef SELFPROJ_HOST_CAMERA_PIXEL_FORMAT_H
#define SELFPROJ_HOST_CAMERA_PIXEL_FORMAT_H

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/images/image_files.h"

namespace selfproj::camera {

enum class Layout : std::uint8_t {
  bytes,        // one byte a pixel
  words,        // two bytes a pixel, little endian, value in the low bits
  packed_lsb,   // GenICam's Mono10p and Mono12p: values one after another, from the lowest bit on
  packed_gige,  // GigE Vision's Mono10Packed and Mono12Packed: high, low bits of both, high, in three bytes
  luma_even,    // YUYV: luminance in the even bytes
  luma_odd,     // UYVY: luminance in the odd bytes
  rgb,          // three bytes a pixel
  bgr,
};

// A pixel format by its name in GenICam, or for V4L2 the same names.
struct PixelFormat {
  std::string_view name;
  Layout layout;
  int bits;                // of a value
  std::string_view bayer;  // colours of the upper left 2 x 2 pixels, row by row; empty if there is no colour filter
};

// The format of this name; nothing if it is not known.
std::optional<PixelFormat> pixel_format(std::string_view name);

// All names, for messages and help.
std::vector<std::string> pixel_format_names();

// Whether a channel must be said: for colour filters and for red, green and blue.
bool needs_channel(const PixelFormat& format);

// The size of the 8-bit image. A colour filter halves both sides: each pixel is one cell of 2 x 2.
int rows_of(const PixelFormat& format, int rows);
int columns_of(const PixelFormat& format, int columns);

// The bytes of a line of `columns` pixels without padding.
std::size_t line_bytes(const PixelFormat& format, int columns);

// Whether the image can be used in place: one byte a pixel, no colour filter.
bool is_plain(const PixelFormat& format);

// Whether to_words takes the format: values of more than 8 bits, one a pixel.
bool has_words(const PixelFormat& format);

// Writes the values of `raw`, whose lines are `stride` bytes apart, to `out`, rows · columns of them. Throws
// std::invalid_argument if raw is too short, or unless has_words(format).
void to_words(const PixelFormat& format, std::span<const std::uint8_t> raw, int rows, int columns, std::size_t stride,
              std::uint16_t* out);

// Writes the 8-bit image of `raw`, whose lines are `stride` bytes apart, to `out`, rows_of · columns_of bytes.
//
// A value of b > 8 bits becomes its upper 8 bits, floor(value / 2^(b - 8)): what a camera of 8 bits gives, and the
// largest value stays the largest. Of a cell of a colour filter, red and blue are their one pixel; green is the mean of
// its two, and grey the mean of all four, halves rounded up. For red, green and blue, grey is the luminance of ITU-R
// BT.601.
//
// Throws std::invalid_argument if raw is too short for `rows` lines, or the channel is missing or a difference.
void to_grey8(const PixelFormat& format, std::optional<images::Channel> channel, std::span<const std::uint8_t> raw,
              int rows, int columns, std::size_t stride, std::uint8_t* out);

}  // namespace selfproj::camera

#endif  // SELFPROJ_HOST_CAMERA_PIXEL_FORMAT_H
