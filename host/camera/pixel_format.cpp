#include "host/camera/pixel_format.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace selfproj::camera {
namespace {

constexpr std::array<PixelFormat, 24> kPixelFormats = {{
    {"Mono8", Layout::bytes, 8, ""},
    {"Mono10", Layout::words, 10, ""},
    {"Mono12", Layout::words, 12, ""},
    {"Mono16", Layout::words, 16, ""},
    {"Mono10p", Layout::packed_lsb, 10, ""},
    {"Mono12p", Layout::packed_lsb, 12, ""},
    {"Mono10Packed", Layout::packed_gige, 10, ""},
    {"Mono12Packed", Layout::packed_gige, 12, ""},
    {"BayerRG8", Layout::bytes, 8, "RGGB"},
    {"BayerGR8", Layout::bytes, 8, "GRBG"},
    {"BayerGB8", Layout::bytes, 8, "GBRG"},
    {"BayerBG8", Layout::bytes, 8, "BGGR"},
    {"BayerRG10", Layout::words, 10, "RGGB"},
    {"BayerGR10", Layout::words, 10, "GRBG"},
    {"BayerGB10", Layout::words, 10, "GBRG"},
    {"BayerBG10", Layout::words, 10, "BGGR"},
    {"BayerRG12", Layout::words, 12, "RGGB"},
    {"BayerGR12", Layout::words, 12, "GRBG"},
    {"BayerGB12", Layout::words, 12, "GBRG"},
    {"BayerBG12", Layout::words, 12, "BGGR"},
    {"YUV422_8", Layout::luma_even, 8, ""},
    {"YUV422_8_UYVY", Layout::luma_odd, 8, ""},
    {"RGB8", Layout::rgb, 8, ""},
    {"BGR8", Layout::bgr, 8, ""},
}};

std::uint8_t narrow(unsigned value) { return static_cast<std::uint8_t>(value); }

// The upper 8 bits of the values of a line.
void grey8_line(const PixelFormat& format, const std::uint8_t* raw, std::size_t count, std::uint8_t* out) {
  const auto shift = static_cast<unsigned>(format.bits - 8);
  switch (format.layout) {
    case Layout::bytes:
      std::copy_n(raw, count, out);
      return;
    case Layout::words:
      for (std::size_t i = 0; i < count; ++i) {
        out[i] = narrow((raw[2 * i] | unsigned{raw[2 * i + 1]} << 8U) >> shift);
      }
      return;
    case Layout::packed_lsb:
      for (std::size_t i = 0; i < count; ++i) {
        const std::size_t bit = i * static_cast<std::size_t>(format.bits) + shift;  // of the upper 8
        const std::size_t at = bit / 8;
        const unsigned low = static_cast<unsigned>(bit % 8);
        out[i] = low == 0 ? raw[at] : narrow(raw[at] >> low | unsigned{raw[at + 1]} << (8 - low));
      }
      return;
    case Layout::packed_gige:
      for (std::size_t i = 0; i < count; ++i) {
        out[i] = raw[i / 2 * 3 + (i % 2 == 0 ? 0 : 2)];
      }
      return;
    case Layout::luma_even:
    case Layout::luma_odd:
      for (std::size_t i = 0; i < count; ++i) {
        out[i] = raw[2 * i + (format.layout == Layout::luma_odd ? 1 : 0)];
      }
      return;
    case Layout::rgb:
    case Layout::bgr:
      throw std::invalid_argument("pixel format: several values a pixel");
  }
}

// All bits of the values of a line.
void word_line(const PixelFormat& format, const std::uint8_t* raw, std::size_t count, std::uint16_t* out) {
  const auto bits = static_cast<unsigned>(format.bits);
  const unsigned mask = (1U << bits) - 1;
  for (std::size_t i = 0; i < count; ++i) {
    unsigned value = 0;
    if (format.layout == Layout::words) {
      value = raw[2 * i] | unsigned{raw[2 * i + 1]} << 8U;
    } else if (format.layout == Layout::packed_lsb) {  // 16 bits from its byte on hold it: it begins at an even bit
      const std::size_t bit = i * bits;
      value = (raw[bit / 8] | unsigned{raw[bit / 8 + 1]} << 8U) >> bit % 8;
    } else {  // the upper bits of two values, and between them the lower bits of both
      const std::uint8_t* const pair = raw + i / 2 * 3;
      const unsigned low = i % 2 == 0 ? pair[1] & 0xFU : unsigned{pair[1]} >> 4U;
      value = unsigned{pair[i % 2 == 0 ? 0 : 2]} << (bits - 8) | (low & ((1U << (bits - 8)) - 1));
    }
    out[i] = static_cast<std::uint16_t>(value & mask);
  }
}

void colour_line(const PixelFormat& format, images::Channel channel, const std::uint8_t* raw, std::size_t count,
                 std::uint8_t* out) {
  const std::size_t red = format.layout == Layout::rgb ? 0 : 2;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t* pixel = raw + 3 * i;
    const unsigned r = pixel[red];
    const unsigned g = pixel[1];
    const unsigned b = pixel[2 - red];
    switch (channel) {
      case images::Channel::red:
        out[i] = narrow(r);
        break;
      case images::Channel::green:
        out[i] = narrow(g);
        break;
      case images::Channel::blue:
        out[i] = narrow(b);
        break;
      default:  // the weights of BT.601 in 2^-16, rounded
        out[i] = narrow((19595 * r + 38470 * g + 7471 * b + 32768) >> 16U);
        break;
    }
  }
}

// A line of cells, from two lines of 8-bit values.
void bayer_line(std::string_view bayer, images::Channel channel, const std::uint8_t* upper, const std::uint8_t* lower,
                std::size_t count, std::uint8_t* out) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::array<unsigned, 4> cell = {upper[2 * i], upper[2 * i + 1], lower[2 * i], lower[2 * i + 1]};
    if (channel == images::Channel::grey) {
      out[i] = narrow((cell[0] + cell[1] + cell[2] + cell[3] + 2) / 4);
    } else if (channel == images::Channel::green) {
      const std::size_t first = bayer[0] == 'G' ? 0 : 1;  // the other one is opposite
      out[i] = narrow((cell[first] + cell[3 - first] + 1) / 2);
    } else {
      out[i] = narrow(cell[bayer.find(channel == images::Channel::red ? 'R' : 'B')]);
    }
  }
}

}  // namespace

std::optional<PixelFormat> pixel_format(std::string_view name) {
  const auto* const found = std::find_if(kPixelFormats.begin(), kPixelFormats.end(),
                                         [&](const PixelFormat& format) { return format.name == name; });
  return found == kPixelFormats.end() ? std::nullopt : std::optional(*found);
}

std::vector<std::string> pixel_format_names() {
  std::vector<std::string> names;
  std::transform(kPixelFormats.begin(), kPixelFormats.end(), std::back_inserter(names),
                 [](const PixelFormat& format) { return std::string(format.name); });
  return names;
}

bool needs_channel(const PixelFormat& format) {
  return !format.bayer.empty() || format.layout == Layout::rgb || format.layout == Layout::bgr;
}

int rows_of(const PixelFormat& format, int rows) { return format.bayer.empty() ? rows : rows / 2; }
int columns_of(const PixelFormat& format, int columns) { return format.bayer.empty() ? columns : columns / 2; }

std::size_t line_bytes(const PixelFormat& format, int columns) {
  const auto count = static_cast<std::size_t>(columns);
  switch (format.layout) {
    case Layout::bytes:
      return count;
    case Layout::words:
    case Layout::luma_even:
    case Layout::luma_odd:
      return 2 * count;
    case Layout::packed_lsb:
      return (count * static_cast<std::size_t>(format.bits) + 7) / 8;
    case Layout::packed_gige:
      return (count * 3 + 1) / 2;
    case Layout::rgb:
    case Layout::bgr:
      return 3 * count;
  }
  throw std::invalid_argument("pixel format: unknown layout");
}

bool has_words(const PixelFormat& format) {
  return format.bits > 8 && format.bayer.empty() &&
         (format.layout == Layout::words || format.layout == Layout::packed_lsb ||
          format.layout == Layout::packed_gige);
}

void to_words(const PixelFormat& format, std::span<const std::uint8_t> raw, int rows, int columns, std::size_t stride,
              std::uint16_t* out) {
  const auto lines = static_cast<std::size_t>(rows);
  const auto count = static_cast<std::size_t>(columns);
  if (!has_words(format) || rows < 1 || columns < 1 || stride < line_bytes(format, columns) ||
      raw.size() < (lines - 1) * stride + line_bytes(format, columns)) {
    throw std::invalid_argument("pixel format: the image is too short, or its values have 8 bits or colours");
  }
  for (std::size_t row = 0; row < lines; ++row) {
    word_line(format, raw.data() + row * stride, count, out + row * count);
  }
}

bool is_plain(const PixelFormat& format) { return format.layout == Layout::bytes && format.bayer.empty(); }

void to_grey8(const PixelFormat& format, std::optional<images::Channel> channel, std::span<const std::uint8_t> raw,
              int rows, int columns, std::size_t stride, std::uint8_t* out) {
  const auto lines = static_cast<std::size_t>(rows);
  const auto count = static_cast<std::size_t>(columns);
  if (rows < 1 || columns < 1 || stride < line_bytes(format, columns) ||
      raw.size() < (lines - 1) * stride + line_bytes(format, columns)) {
    throw std::invalid_argument("pixel format: the image is too short");
  }
  if (needs_channel(format) && (!channel || *channel > images::Channel::grey)) {
    throw std::invalid_argument("pixel format: a channel is missing");
  }
  if (!format.bayer.empty()) {
    std::vector<std::uint8_t> pair(2 * count);
    const std::size_t cells = count / 2;
    for (std::size_t row = 0; row < lines / 2; ++row) {
      grey8_line(format, raw.data() + 2 * row * stride, count, pair.data());
      grey8_line(format, raw.data() + (2 * row + 1) * stride, count, pair.data() + count);
      bayer_line(format.bayer, *channel, pair.data(), pair.data() + count, cells, out + row * cells);
    }
    return;
  }
  for (std::size_t row = 0; row < lines; ++row) {
    if (needs_channel(format)) {
      colour_line(format, *channel, raw.data() + row * stride, count, out + row * count);
    } else {
      grey8_line(format, raw.data() + row * stride, count, out + row * count);
    }
  }
}

}  // namespace selfproj::camera
