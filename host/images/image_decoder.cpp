#include "host/images/image_decoder.h"

#include <cctype>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "host/files/input_file.h"
#include "host/files/numbers.h"
#include "host/files/stderr_capture.h"
#include "selfproj/files/user_error.h"

namespace selfproj::images {
namespace {

using namespace std::string_view_literals;

enum class Order : std::uint8_t { little, big };

// Reads bytes as numbers; throws std::out_of_range behind their end.
class Bytes {
 public:
  Bytes(std::string_view bytes, Order order) : bytes_(bytes), order_(order) {}

  [[nodiscard]] std::uint64_t number(std::uint64_t at, unsigned count) const {
    if (at > bytes_.size() || count > bytes_.size() - at) {
      throw std::out_of_range("image header");
    }
    std::uint64_t value = 0;
    for (unsigned i = 0; i < count; ++i) {
      const unsigned place = order_ == Order::little ? count - 1 - i : i;
      value = value << 8U | static_cast<std::uint8_t>(bytes_[static_cast<std::size_t>(at) + place]);
    }
    return value;
  }

 private:
  std::string_view bytes_;
  Order order_;
};

ImageHeader png_header(std::string_view file) {
  const Bytes bytes(file, Order::big);
  return {ImageFormat::png, bytes.number(16, 4), bytes.number(20, 4)};
}

// Walks through the segments up to the frame header (SOF).
ImageHeader jpeg_header(std::string_view file) {
  const Bytes bytes(file, Order::big);
  for (std::uint64_t at = 2;;) {
    if (bytes.number(at, 1) != 0xFF) {
      throw std::out_of_range("no marker");
    }
    const std::uint64_t marker = bytes.number(at + 1, 1);
    if (marker == 0xFF) {  // fill byte
      ++at;
      continue;
    }
    if (marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC) {
      return {ImageFormat::jpeg, bytes.number(at + 7, 2), bytes.number(at + 5, 2)};
    }
    const bool alone = marker == 0x01 || (marker >= 0xD0 && marker <= 0xD8);
    at += 2 + (alone ? 0 : bytes.number(at + 2, 2));
  }
}

// The first directory of a TIFF (42) or BigTIFF (43) file.
ImageHeader tiff_header(std::string_view file) {
  constexpr std::uint64_t kWidth = 256;
  constexpr std::uint64_t kLength = 257;
  constexpr std::uint64_t kOrientation = 274;
  constexpr std::uint64_t kShort = 3;
  constexpr std::uint64_t kLong = 4;
  const Bytes bytes(file, file.starts_with("II") ? Order::little : Order::big);
  const bool big = bytes.number(2, 2) == 43;
  const unsigned word = big ? 8 : 4;
  const std::uint64_t directory = bytes.number(big ? 8 : 4, word);
  const std::uint64_t entries = bytes.number(directory, big ? 8 : 2);
  ImageHeader header{ImageFormat::tiff};
  for (std::uint64_t i = 0; i < entries; ++i) {
    const std::uint64_t entry = directory + (big ? 8 : 2) + i * (4 + 2 * std::uint64_t{word});
    const std::uint64_t tag = bytes.number(entry, 2);
    const std::uint64_t type = bytes.number(entry + 2, 2);
    const std::uint64_t place = entry + 4 + word;
    const unsigned size = type == kShort ? 2 : type == kLong ? 4 : word;
    if (tag == kWidth) {
      header.columns = bytes.number(place, size);
    } else if (tag == kLength) {
      header.rows = bytes.number(place, size);
    } else if (tag == kOrientation && type == kShort) {
      header.orientation_at = bytes.number(place, size) == 1 ? 0 : static_cast<std::size_t>(place);
    }
  }
  return header;
}

ImageHeader bmp_header(std::string_view file) {
  const Bytes bytes(file, Order::little);
  if (bytes.number(14, 4) == 12) {
    return {ImageFormat::bmp, bytes.number(18, 2), bytes.number(20, 2)};
  }
  // Rows that grow upwards have a negative number.
  const auto rows = static_cast<std::int32_t>(bytes.number(22, 4));
  return {ImageFormat::bmp, bytes.number(18, 4),
          static_cast<std::uint64_t>(rows < 0 ? -std::int64_t{rows} : std::int64_t{rows})};
}

// "P5", then columns and rows in digits, with spaces and comments between.
ImageHeader pnm_header(std::string_view file) {
  std::size_t at = 2;
  const auto next = [&] {
    while (at < file.size() && (std::isspace(static_cast<unsigned char>(file[at])) != 0 || file[at] == '#')) {
      at = file[at] == '#' ? file.find('\n', at) : at + 1;
    }
    const std::size_t begin = at;
    while (at < file.size() && std::isdigit(static_cast<unsigned char>(file[at])) != 0) {
      ++at;
    }
    const auto value = begin < at ? files::number_of_text<std::uint64_t>(file.substr(begin, at - begin)) : std::nullopt;
    if (!value) {
      throw std::out_of_range("no number");
    }
    return *value;
  };
  ImageHeader header{ImageFormat::pnm};
  header.columns = next();
  header.rows = next();
  return header;
}

// Messages that the libraries print only on standard error. libjpeg fills in missing parts of a damaged file and
// reports only the first fault, so no message may be missed.
bool reports_damage(ImageFormat format, const std::string& messages) {
  return (format == ImageFormat::jpeg && !messages.empty()) || messages.find("Premature") != std::string::npos ||
         messages.find("Corrupt") != std::string::npos;
}

}  // namespace

std::optional<ImageFormat> image_format(std::string_view bytes) {
  if (bytes.starts_with("\x89PNG\r\n\x1A\n"sv)) {
    return ImageFormat::png;
  }
  if (bytes.starts_with("\xFF\xD8\xFF"sv)) {
    return ImageFormat::jpeg;
  }
  if (bytes.starts_with("II*\0"sv) || bytes.starts_with("MM\0*"sv) || bytes.starts_with("II+\0"sv) ||
      bytes.starts_with("MM\0+"sv)) {
    return ImageFormat::tiff;
  }
  if (bytes.starts_with("BM"sv)) {
    return ImageFormat::bmp;
  }
  if (bytes.size() > 2 && bytes[0] == 'P' && bytes[1] >= '1' && bytes[1] <= '6' &&
      (std::isspace(static_cast<unsigned char>(bytes[2])) != 0 || bytes[2] == '#')) {
    return ImageFormat::pnm;
  }
  return std::nullopt;
}

std::optional<ImageHeader> image_header(std::string_view bytes) {
  const std::optional<ImageFormat> format = image_format(bytes);
  if (!format) {
    return std::nullopt;
  }
  try {
    switch (*format) {
      case ImageFormat::png:
        return png_header(bytes);
      case ImageFormat::jpeg:
        return jpeg_header(bytes);
      case ImageFormat::tiff:
        return tiff_header(bytes);
      case ImageFormat::bmp:
        return bmp_header(bytes);
      case ImageFormat::pnm:
        return pnm_header(bytes);
    }
  } catch (const std::out_of_range&) {
    return std::nullopt;
  }
  return std::nullopt;
}

void clear_orientation(const ImageHeader& header, std::string& bytes) {
  if (header.orientation_at != 0) {
    const bool little = bytes.starts_with("II");
    bytes[header.orientation_at] = little ? '\1' : '\0';
    bytes[header.orientation_at + 1] = little ? '\0' : '\1';
  }
}

cv::Mat decode_image(const std::string& file) {
  std::string bytes = files::read_input(file, files::kMostImageBytes);
  const std::optional<ImageHeader> header = image_header(bytes);
  if (!header || header->columns == 0 || header->rows == 0) {
    throw UserError(file, kNotAnImage);
  }
  if (header->columns > kMaxImagePixels || header->rows > kMaxImagePixels / header->columns) {
    throw UserError(file, "has " + std::to_string(header->columns) + " x " + std::to_string(header->rows) +
                              " pixels; at most 2^28 are taken");
  }
  cv::Mat image;
  files::StderrCapture capture;
  try {
    if (header->orientation_at != 0) {
      clear_orientation(*header, bytes);
      image = cv::imdecode(cv::Mat(1, static_cast<int>(bytes.size()), CV_8UC1, bytes.data()), cv::IMREAD_UNCHANGED);
    } else {
      // OpenCV reads the file itself. If it got bytes, libjpeg would stop silently at the end of a file that was cut
      // short.
      bytes.clear();
      bytes.shrink_to_fit();
      image = cv::imread(file, cv::IMREAD_UNCHANGED);
    }
  } catch (const cv::Exception&) {
    image.release();
  }
  if (image.empty() || reports_damage(header->format, capture.text())) {
    throw UserError(file, kNotAnImage);
  }
  return image;
}

}  // namespace selfproj::images
