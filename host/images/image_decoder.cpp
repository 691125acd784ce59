#include "host/images/image_decoder.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

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

// Several images, such as the pages of a TIFF: whoever takes one of them silently measures something else than the user
// means.
std::string several_images(const std::string& what) {
  return fmt::format("has several images ({}); one image a file is taken, so split it", what);
}

// An animation (APNG) says so before its pixels.
ImageHeader png_header(std::string_view file) {
  const Bytes bytes(file, Order::big);
  ImageHeader header{ImageFormat::png, bytes.number(16, 4), bytes.number(20, 4)};
  for (std::uint64_t at = 8; header.refusal.empty() && at + 8 <= file.size();) {
    const std::string_view kind = file.substr(static_cast<std::size_t>(at) + 4, 4);
    if (kind == "IDAT") {
      break;
    }
    if (const std::uint64_t frames = kind == "acTL" ? bytes.number(at + 8, 4) : 1; frames > 1) {
      header.refusal = several_images(fmt::format("an animation of {}", frames));
    }
    at += 12 + bytes.number(at, 4);
  }
  return header;
}

bool is_frame_header(std::uint64_t marker) {
  return marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
}

constexpr std::uint64_t kStartOfScan = 0xDA;

// Walks through the segments of a JPEG up to its first scan. visit(marker, begin, end) gets each of them; bytes between
// them belong to none.
template <class Visit>
void walk_jpeg(std::string_view file, const Visit& visit) {
  const Bytes bytes(file, Order::big);
  std::uint64_t marker = 0;
  for (std::uint64_t at = 2; marker != kStartOfScan;) {
    marker = bytes.number(at, 1) == 0xFF ? bytes.number(at + 1, 1) : 0;
    if (marker == 0 || marker == 0xFF) {  // a byte too many, or a fill byte
      ++at;
      continue;
    }
    const bool alone = marker == 0x01 || (marker >= 0xD0 && marker <= 0xD9);
    const std::uint64_t end = at + 2 + (alone ? 0 : bytes.number(at + 2, 2));
    visit(marker, at, end);
    at = end;
  }
}

ImageHeader jpeg_header(std::string_view file) {
  const Bytes bytes(file, Order::big);
  ImageHeader header{ImageFormat::jpeg};
  walk_jpeg(file, [&](std::uint64_t marker, std::uint64_t at, std::uint64_t /*end*/) {
    if (is_frame_header(marker)) {
      header.columns = bytes.number(at + 7, 2);
      header.rows = bytes.number(at + 5, 2);
    }
  });
  return header;
}

// The JPEG without the bytes between its segments, and without the last `before_end` bytes of its pixels: what some
// cameras write too many.
std::string without_bytes_too_many(const std::string& file, std::size_t before_end) {
  std::string clean = file.substr(0, 2);
  std::size_t scan = file.size();
  try {
    walk_jpeg(file, [&](std::uint64_t /*marker*/, std::uint64_t at, std::uint64_t end) {
      clean += file.substr(static_cast<std::size_t>(at), static_cast<std::size_t>(end - at));
      scan = static_cast<std::size_t>(end);
    });
  } catch (const std::out_of_range&) {
    return file;
  }
  std::string pixels = file.substr(std::min(scan, file.size()));
  if (const std::size_t end = pixels.find("\xFF\xD9"sv); end != std::string::npos && before_end <= end) {
    pixels.erase(end - before_end, before_end);
  }
  return clean + pixels;
}

// The directories of a TIFF (42) or BigTIFF (43) file.
class TiffDirectories {
 public:
  explicit TiffDirectories(std::string_view file)
      : bytes_(file, file.starts_with("II") ? Order::little : Order::big),
        big_(bytes_.number(2, 2) == 43),
        word_(big_ ? 8 : 4) {}

  // Where the place of the first directory stands; that of the next one stands behind each.
  [[nodiscard]] std::uint64_t first_link() const { return big_ ? 8 : 4; }
  [[nodiscard]] std::uint64_t at_link(std::uint64_t link) const { return bytes_.number(link, word_); }

  // Writes another place where a link stands in these bytes.
  void set_link(std::string& bytes, std::uint64_t link, std::uint64_t place) const {
    const bool little = bytes.starts_with("II");
    for (unsigned i = 0; i < word_; ++i) {
      const unsigned digit = little ? i : word_ - 1 - i;
      bytes.at(static_cast<std::size_t>(link) + i) = static_cast<char>((place >> (8 * digit)) & 0xFFU);
    }
  }

  // Calls visit(tag, type, place of the value, value) for the directory at this place, and returns the next one's link.
  template <class Visit>
  std::uint64_t walk(std::uint64_t directory, const Visit& visit) {
    constexpr std::size_t kMostEntries = 1'000'000;  // of all directories, which may form a circle
    constexpr std::uint64_t kLong = 4;
    const std::uint64_t entries = bytes_.number(directory, big_ ? 8 : 2);
    const std::uint64_t first = directory + (big_ ? 8 : 2);
    const std::uint64_t each = 4 + 2 * std::uint64_t{word_};
    for (std::uint64_t i = 0; i < entries; ++i) {
      const std::uint64_t entry = first + i * each;
      const std::uint64_t type = bytes_.number(entry + 2, 2);
      const std::uint64_t count = bytes_.number(entry + 4, word_);
      const unsigned size = type == kShort ? 2 : type == kLong ? 4 : word_;
      // Values that do not fit in the entry are elsewhere.
      const std::uint64_t at = entry + 4 + word_;
      const std::uint64_t place = count <= word_ / size ? at : bytes_.number(at, word_);
      visit(bytes_.number(entry, 2), type, place, bytes_.number(place, size));
      if (++all_entries_ > kMostEntries) {
        throw std::out_of_range("directories");
      }
    }
    if (++directories_ > kMostEntries) {
      throw std::out_of_range("directories");
    }
    return first + entries * each;
  }

  static constexpr std::uint64_t kShort = 3;

 private:
  Bytes bytes_;
  bool big_;
  unsigned word_;
  std::size_t all_entries_ = 0;
  std::size_t directories_ = 0;
};

// Links to the directories of a TIFF that are pages: the first, and others unless they say that they hold the same
// image with fewer pixels, or a mask. Throws std::out_of_range if the file is damaged.
std::vector<std::uint64_t> page_links(std::string_view file) {
  constexpr std::uint64_t kKind = 254;
  constexpr std::uint64_t kReducedOrMask = 1 | 4;
  TiffDirectories directories(file);
  std::vector<std::uint64_t> links;
  for (std::uint64_t link = directories.first_link(); directories.at_link(link) != 0;) {
    std::uint64_t kind = 0;
    const std::uint64_t behind = directories.walk(
        directories.at_link(link), [&](std::uint64_t tag, std::uint64_t /*type*/, std::uint64_t /*place*/,
                                       std::uint64_t value) { kind = tag == kKind ? value : kind; });
    if (links.empty() || (kind & kReducedOrMask) == 0) {
      links.push_back(link);
    }
    link = behind;
  }
  return links;
}

// What a TIFF says of its first page.
ImageHeader tiff_header(std::string_view file) {
  constexpr std::uint64_t kWidth = 256;
  constexpr std::uint64_t kLength = 257;
  constexpr std::uint64_t kBits = 258;
  constexpr std::uint64_t kLight = 262;
  constexpr std::uint64_t kOrientation = 274;
  constexpr std::uint64_t kForm = 339;
  constexpr std::uint64_t kSigned = 2;
  constexpr std::uint64_t kFloats = 3;
  ImageHeader header{ImageFormat::tiff};
  std::uint64_t bits = 1;
  std::uint64_t form = 1;
  std::uint64_t light = 1;
  TiffDirectories directories(file);
  directories.walk(directories.at_link(directories.first_link()),
                   [&](std::uint64_t tag, std::uint64_t type, std::uint64_t place, std::uint64_t value) {
                     if (tag == kWidth) {
                       header.columns = value;
                     } else if (tag == kLength) {
                       header.rows = value;
                     } else if (tag == kBits) {
                       bits = value;
                     } else if (tag == kLight) {
                       light = value;
                     } else if (tag == kForm) {
                       form = value;
                     } else if (tag == kOrientation && type == TiffDirectories::kShort) {
                       header.orientation_at = value == 1 ? 0 : static_cast<std::size_t>(place);
                     }
                   });
  if (page_links(file).size() > 1) {
    header.refusal = several_images("a TIFF of several pages");
  } else if (form == kSigned) {
    header.refusal = "has pixels that are signed numbers; brightness from 0 on is expected";
  } else if (form != kFloats && bits > 8 && light == 0) {
    header.refusal = "has more than 8 bits per pixel and stores black as its largest value; invert it";
  } else if (bits != 1 && bits != 8 && bits != 10 && bits != 12 && bits != 14 && bits != 16 && bits != 32 &&
             bits != 64) {
    header.refusal = fmt::format("has {} bits per pixel; 1, 8, 10, 12, 14 or 16 are taken of a TIFF", bits);
  } else if (form != kFloats && bits > 8 && bits < 16) {
    header.white = (1U << bits) - 1;
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

constexpr const char* kPnmAfterPnm = "one PNM image after another";

// Whether another PNM image follows from this byte on.
bool follows_pnm(std::string_view file, std::size_t at) {
  while (at < file.size() && std::isspace(static_cast<unsigned char>(file[at])) != 0) {
    ++at;
  }
  return at < file.size() && image_format(file.substr(at)) == ImageFormat::pnm;
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
  if (file[1] == '1' || file[1] == '4') {
    const std::uint64_t bytes = header.rows < file.size() ? header.rows * ((header.columns + 7) / 8) : file.size();
    if (follows_pnm(file, file[1] == '4' ? at + 1 + std::min<std::uint64_t>(bytes, file.size()) : file.find('P', at))) {
      header.refusal = several_images(kPnmAfterPnm);
    }
    return header;
  }
  constexpr std::uint64_t kMaxWhite = 65535;
  const std::uint64_t white = next();
  if (white < 1 || white > kMaxWhite) {
    throw std::out_of_range("maximum");
  }
  header.white = static_cast<std::uint32_t>(white);
  header.pixels_at = at + 1;  // one white space
  return header;
}

// The pixels of a grey (P2, P5) or colour (P3, P6) image. OpenCV takes those of most files as they are, whatever the
// maximum that the file gives. Throws std::out_of_range if the file ends early or a value is beyond the maximum.
cv::Mat pnm_pixels(std::string_view file, ImageHeader& header) {
  const bool text = file[1] == '2' || file[1] == '3';
  const int channels = file[1] == '2' || file[1] == '5' ? 1 : 3;
  const unsigned size = header.white > 255 ? 2 : 1;
  const std::size_t row_values = static_cast<std::size_t>(header.columns) * static_cast<std::size_t>(channels);
  const std::size_t values = row_values * static_cast<std::size_t>(header.rows);
  if (file.size() < header.pixels_at || (file.size() - header.pixels_at) / (text ? 1 : size) < values) {
    throw std::out_of_range("pixels");  // before memory is taken for them; a number in digits has one or more
  }
  cv::Mat image(static_cast<int>(header.rows), static_cast<int>(header.columns),
                CV_MAKETYPE(size == 2 ? CV_16U : CV_8U, channels));
  const Bytes bytes(file, Order::big);
  std::size_t at = header.pixels_at;
  const auto next = [&]() -> std::uint64_t {
    if (!text) {
      at += size;
      return bytes.number(at - size, size);
    }
    while (at < file.size() && std::isspace(static_cast<unsigned char>(file[at])) != 0) {
      ++at;
    }
    const std::size_t begin = at;
    while (at < file.size() && std::isdigit(static_cast<unsigned char>(file[at])) != 0) {
      ++at;
    }
    return files::number_of_text<std::uint64_t>(file.substr(begin, at - begin))
        .value_or(header.white + std::uint64_t{1});
  };
  for (int row = 0; row < image.rows; ++row) {
    for (std::size_t i = 0; i < row_values; ++i) {
      const std::uint64_t value = next();
      if (value > header.white) {
        throw std::out_of_range("value");
      }
      const std::size_t place = channels == 3 ? i - i % 3 + 2 - i % 3 : i;  // OpenCV's order: blue, green, red
      if (size == 2) {
        image.ptr<std::uint16_t>(row)[place] = static_cast<std::uint16_t>(value);
      } else {  // halves rounded up
        image.ptr<std::uint8_t>(row)[place] =
            static_cast<std::uint8_t>((2 * 255 * value + header.white) / (2 * header.white));
      }
    }
  }
  if (follows_pnm(file, at)) {
    header.refusal = several_images(kPnmAfterPnm);
  }
  return image;
}

// Messages that the libraries print only on standard error. libjpeg fills in missing parts of a damaged file and
// reports only the first fault, so no message may be missed.
bool reports_damage(ImageFormat format, const std::string& messages) {
  return (format == ImageFormat::jpeg && !messages.empty()) || messages.find("Premature") != std::string::npos ||
         messages.find("Corrupt") != std::string::npos;
}

struct Attempt {
  cv::Mat pixels;
  std::string messages;
};

// Calls OpenCV, and keeps what its libraries say meanwhile.
template <class Read>
Attempt attempt(const Read& read) {
  Attempt result;
  files::StderrCapture capture;
  try {
    result.pixels = read();
  } catch (const cv::Exception&) {
    result.pixels.release();
  }
  result.messages = capture.text();
  return result;
}

cv::Mat decoded_bytes(std::string& bytes) {
  return cv::imdecode(cv::Mat(1, static_cast<int>(bytes.size()), CV_8UC1, bytes.data()), cv::IMREAD_UNCHANGED);
}

// A JPEG of which libjpeg says that there are bytes too many. It says no more after its first complaint, so the image
// is taken only if there is none once these bytes are gone.
Attempt without_complaint(const std::string& file, const Attempt& first) {
  constexpr std::string_view kBefore = "Corrupt JPEG data: ";
  constexpr std::string_view kBehind = " extraneous bytes before marker";
  std::string_view message = first.messages;
  const std::size_t end = message.find(kBehind);
  if (!message.starts_with(kBefore) || end == std::string_view::npos) {
    return first;
  }
  const auto count =
      files::number_of_text<std::size_t>(message.substr(kBefore.size(), end - kBefore.size())).value_or(0);
  const std::string bytes = files::read_input(file, files::kMostImageBytes);
  for (const std::size_t before_end : {std::size_t{0}, count}) {
    std::string clean = without_bytes_too_many(bytes, before_end);
    Attempt again = attempt([&] { return decoded_bytes(clean); });
    if (!again.pixels.empty() && again.messages.empty()) {
      return again;
    }
  }
  return first;
}

// What a library of a format has said, as the end of a message: its first line, or nothing. OpenCV itself says where in
// its own source something happened.
std::string said(const std::string& messages) {
  const std::string line = messages.substr(0, messages.find('\n'));
  const bool own = line.starts_with('[') || line.find("OpenCV") != std::string::npos || line.starts_with("imread");
  return line.empty() || own ? "" : fmt::format(" (its decoder says: {})", line);
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

namespace {

// Decodes the bytes of a file; OpenCV reads the file itself if it may.
DecodedImage decode_bytes(const std::string& file, std::string& bytes, bool from_file) {
  std::optional<ImageHeader> header = image_header(bytes);
  if (!header || header->columns == 0 || header->rows == 0) {
    throw UserError(file, kNotAnImage);
  }
  if (header->columns > kMaxImagePixels || header->rows > kMaxImagePixels / header->columns) {
    throw UserError(file, "has " + std::to_string(header->columns) + " x " + std::to_string(header->rows) +
                              " pixels; at most 2^28 are taken");
  }
  const auto refuse = [&] {
    if (!header->refusal.empty()) {
      throw UserError(file, header->refusal);
    }
  };
  refuse();
  if (header->pixels_at != 0) {
    try {
      cv::Mat pixels = pnm_pixels(bytes, *header);
      refuse();
      return {std::move(pixels), std::max(header->white, 255U)};
    } catch (const std::out_of_range&) {
      throw UserError(file, kNotAnImage);
    }
  }
  Attempt result;
  if (header->orientation_at != 0 || !from_file) {
    clear_orientation(*header, bytes);
    result = attempt([&] { return decoded_bytes(bytes); });
  } else {
    // OpenCV reads the file itself. If it got bytes, libjpeg would stop silently at the end of a file that was cut
    // short.
    bytes.clear();
    bytes.shrink_to_fit();
    result = attempt([&] { return cv::imread(file, cv::IMREAD_UNCHANGED); });
    if (header->format == ImageFormat::jpeg) {
      result = without_complaint(file, result);
    }
  }
  if (result.pixels.empty() || reports_damage(header->format, result.messages)) {
    throw UserError(file, kNotAnImage + said(result.messages));
  }
  if (result.pixels.depth() == CV_16U && header->white != 0) {
    // OpenCV gives the values of a TIFF of fewer bits as the upper bits of 16.
    result.pixels.forEach<std::uint16_t>(
        [by = 16 - std::bit_width(header->white)](std::uint16_t& value, const int* /*place*/) {
          value = static_cast<std::uint16_t>(value >> static_cast<unsigned>(by));
        });
  }
  const std::uint32_t white = result.pixels.depth() == CV_8U ? 255 : header->white;
  return {std::move(result.pixels), white};
}

}  // namespace

DecodedImage decode_image(const std::string& file) {
  std::string bytes = files::read_input(file, files::kMostImageBytes);
  return decode_bytes(file, bytes, true);
}

PagedImage::PagedImage(std::string file) : file_(std::move(file)) {
  std::string bytes = files::read_input(file_, files::kMostImageBytes);
  if (image_format(bytes) == ImageFormat::tiff) {
    try {
      links_ = page_links(bytes);
    } catch (const std::out_of_range&) {
      throw UserError(file_, kNotAnImage);
    }
  }
  if (links_.size() > 1) {
    bytes_ = std::move(bytes);
  }
}

DecodedImage PagedImage::page(std::size_t i) {
  if (pages() == 1) {
    return decode_image(file_);
  }
  // The bytes are those of a file with this page alone.
  TiffDirectories directories(bytes_);
  const std::uint64_t directory = directories.at_link(links_.at(i));
  const std::uint64_t behind = directories.walk(directory, [](auto, auto, auto, auto) {});
  const std::uint64_t first = directories.at_link(directories.first_link());
  const std::uint64_t next = directories.at_link(behind);
  directories.set_link(bytes_, directories.first_link(), directory);
  directories.set_link(bytes_, behind, 0);
  DecodedImage image = decode_bytes(file_, bytes_, false);
  directories.set_link(bytes_, behind, next);
  directories.set_link(bytes_, directories.first_link(), first);
  return image;
}

}  // namespace selfproj::images
