// Image files as frames of the camera: one channel of 8 bits, or of as many as a rig says.
#ifndef SELFPROJ_HOST_IMAGES_IMAGE_FILES_H
#define SELFPROJ_HOST_IMAGES_IMAGE_FILES_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "selfproj/model/column_moments.h"

namespace selfproj::images {

class PagedImage;
struct DecodedImage;

// The part of a colour image to take: one of its planes, its luminance (ITU-R BT.601, rounded as in OpenCV), or for the
// light of a laser one plane less the mean of the other two, at least 0, halves rounded up.
enum class Channel : std::uint8_t { red, green, blue, grey, red_difference, green_difference, blue_difference };

// Their names in options.
inline constexpr std::array<std::pair<const char*, Channel>, 7> kChannels{
    {{"red", Channel::red},
     {"green", Channel::green},
     {"blue", Channel::blue},
     {"grey", Channel::grey},
     {"red-difference", Channel::red_difference},
     {"green-difference", Channel::green_difference},
     {"blue-difference", Channel::blue_difference}}};

// An image that owns its pixels, row by row without gaps.
template <typename Pixel>
struct ImageOf {
  int rows = 0;
  int columns = 0;
  std::vector<Pixel> pixels;

  // Valid while this object lives and its pixels are not resized.
  [[nodiscard]] model::PixelView<Pixel> view() const { return {pixels.data(), rows, columns, columns}; }
};
using Image = ImageOf<std::uint8_t>;
using WideImage = ImageOf<std::uint16_t>;  // pixels of more than 8 bits, from bit 0 on

// The image as one that owns its pixels.
template <typename Pixel>
ImageOf<Pixel> copy_of(const model::PixelView<Pixel>& view) {
  ImageOf<Pixel> image{view.rows, view.columns, {}};
  image.pixels.reserve(static_cast<std::size_t>(view.rows) * static_cast<std::size_t>(view.columns));
  for (int row = 0; row < view.rows; ++row) {
    const Pixel* const pixels = view.pixels + row * view.stride;
    image.pixels.insert(image.pixels.end(), pixels, pixels + view.columns);
  }
  return image;
}

// A part of an image or of a sensor; left and top from 0.
struct ImagePart {
  int columns = 0;
  int rows = 0;
  int left = 0;
  int top = 0;

  bool operator==(const ImagePart&) const = default;
};

// The part of a text such as 320x60+0+40: columns, rows, left, top, none of them above max_side. Nothing for any other
// text.
std::optional<ImagePart> image_part(std::string_view text, int max_side);

// Finds errors early that read_image would find late: throws UserError if the file cannot be read or its first bytes
// are not those of an image.
void check_image_file(const std::string& file);

// Whether the file has an image of several channels. Throws UserError if it has none.
bool is_colour_image(const std::string& file);

// What may lie in a folder of images that is none: the reference of a light section under whose pattern they were
// taken.
inline constexpr const char* kReferenceFile = "reference.csv";

// How the pixels of a file become one channel of 8 bits, or of `bits`.
struct PixelRule {
  std::optional<Channel> channel = std::nullopt;
  std::optional<int> shift = std::nullopt;  // values of more than 8 bits become floor(value / 2^shift); 0..kMaxShift
  int bits = spec::kPixelBits;              // for read_wide and read_sensor_image

  PixelRule() = default;
  PixelRule(std::optional<Channel> of_colours, std::optional<int> of_bits = std::nullopt)  // NOLINT: converts
      : channel(of_colours), shift(of_bits) {}
  PixelRule(Channel of_colours) : channel(of_colours) {}  // NOLINT: converts
  PixelRule(std::nullopt_t /*none*/) {}                   // NOLINT: converts
};

inline constexpr int kMaxShift = 8;

// The same as options say it: the name of a channel, empty for none.
struct PixelOptions {
  std::string channel = {};
  std::optional<int> shift = {};

  // "--channel" or "--shift", whichever is given; empty if none is.
  [[nodiscard]] std::string given() const { return !channel.empty() ? "--channel" : shift ? "--shift" : ""; }
  // Throws std::invalid_argument for another name or shift.
  [[nodiscard]] PixelRule rule() const;
};

// Reads an image of any format known to OpenCV, and ignores the orientation that some cameras note in the file. A
// colour image needs a channel. An image of one channel is taken as it is, and accepts no channel.
//
// Values of more than 8 bits need a shift, and none may then be above 255, unless the file says how large they can be:
// a PGM does, and a TIFF of 9 to 15 bits. Of b bits they then become the upper 8 bits, floor(value / 2^(b - 8)), as a
// live camera's do; of another maximum, 255 value / maximum, rounded.
//
// Throws UserError, naming the file, if it cannot be read, is not an image, has several, is damaged, or does not fit
// the rule.
Image read_image(const std::string& file, const PixelRule& rule);

// The same of a sensor with pixels of rule.bits: with more than 8 all of them, which the file must have.
using SensorImage = std::variant<Image, WideImage>;
SensorImage read_sensor_image(const std::string& file, const PixelRule& rule);

// The upper eight bits of its pixels of `bits`, for a picture.
Image upper_bits(const SensorImage& image, int bits);

// The images of files, of which a TIFF may have several pages.
class ImagePages {
 public:
  // Looks at all files. Throws UserError as read_image does, except for several pages.
  explicit ImagePages(std::vector<std::string> files);

  [[nodiscard]] std::size_t count() const { return places_.size(); }
  // What messages call image i, from 0: "lines.tiff", or "lines.tiff: page 2".
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }

  // Image i. Throws as read_image does.
  [[nodiscard]] Image read(std::size_t i, const PixelRule& rule);
  [[nodiscard]] WideImage read_wide(std::size_t i, const PixelRule& rule);

 private:
  struct Place {
    std::size_t file = 0;
    std::size_t page = 0;
    bool alone = true;  // in its file
  };
  [[nodiscard]] DecodedImage decoded(std::size_t i);

  std::vector<std::string> files_;
  std::vector<Place> places_;
  std::vector<std::string> names_;
  std::shared_ptr<PagedImage> open_;  // the file of the last page
};

// The images of a folder in natural order (img2 before img10): the files that have an image's extension or begin like
// one. A damaged image is thus not left out in silence, which would move those behind it. What else there is, is noted
// (host/files/notes.h), without names that begin with a dot and capture.json, the record of a capture. Throws UserError
// if the folder cannot be read or has no images.
std::vector<std::string> files_of_folder(const std::string& folder);

// The image files that a command is given: the files themselves, or those of the folder if it is given a single one.
// Throws UserError about a file that is not there, or a folder among others.
std::vector<std::string> image_arguments(const std::vector<std::string>& arguments);

// The files matched by a pattern with * ? [], in natural order; a name without any of these is a file.
// Throws UserError with the option if there is none.
std::vector<std::string> files_of_pattern(const std::string& option, const std::string& pattern);

// The files of all patterns of an option, one pattern after another.
std::vector<std::string> files_of_patterns(const std::string& option, const std::vector<std::string>& patterns);

// Returns the bytes of a PNG file. Throws std::invalid_argument if the image has no pixels or is too large.
std::string encode_png(const Image& image);

// Returns the bytes of a PNG file of rows x columns pixels of 16 bits, given row by row without gaps. Throws
// std::invalid_argument if the image has no pixels or is too large.
std::string encode_png16(int rows, int columns, std::span<const std::uint16_t> pixels);
inline std::string encode_png(const WideImage& image) { return encode_png16(image.rows, image.columns, image.pixels); }

}  // namespace selfproj::images

#endif  // SELFPROJ_HOST_IMAGES_IMAGE_FILES_H
