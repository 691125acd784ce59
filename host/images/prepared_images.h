// Recorded images as frames: read in turn, one channel, a part of them, turned so that the line crosses the columns,
// and without their background.
#ifndef SELFPROJ_HOST_IMAGES_PREPARED_IMAGES_H
#define SELFPROJ_HOST_IMAGES_PREPARED_IMAGES_H

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "host/images/image_files.h"

namespace selfproj::images {

// How images become frames, as the options say.
struct Preparation {
  PixelOptions pixels = {};
  std::string roi = {};                      // a part, as above; empty: all
  bool transpose = false;                    // rows become columns, after the part was taken
  std::vector<std::string> background = {};  // files: one for all images, or one for each; empty: none
  int bits = spec::kPixelBits;               // of a pixel, for WidePreparedImages
};

// Image with rows and columns exchanged.
template <typename Pixel>
ImageOf<Pixel> transposed(const ImageOf<Pixel>& image);

// The image with this many columns: the first ones, or followed by dark ones.
template <typename Pixel>
ImageOf<Pixel> with_columns(ImageOf<Pixel> image, int columns);
SensorImage with_columns(SensorImage image, int columns);

template <typename Pixel>
class PreparedImagesOf {
 public:
  // Looks at all files and reads the first. Throws UserError with the file or option if there is no file, a file is no
  // image, the part is not within it, or the numbers of images do not go together. A TIFF may have several pages, each
  // of which is an image.
  PreparedImagesOf(std::vector<std::string> files, const Preparation& preparation);

  [[nodiscard]] std::size_t count() const { return images_.count(); }
  [[nodiscard]] const std::vector<std::string>& files() const { return images_.names(); }
  [[nodiscard]] int rows() const { return first_.rows; }        // of a frame
  [[nodiscard]] int columns() const { return first_.columns; }  // of a frame

  // Frame i, from 0: the image less its background, where that is less than 0 it is 0. `as_taken` gets the frame with
  // its background, if given. Throws UserError with the file, also if its size differs from the first one's.
  ImageOf<Pixel> frame(std::size_t i, ImageOf<Pixel>* as_taken = nullptr);

 private:
  [[nodiscard]] ImageOf<Pixel> prepared(ImagePages& from, std::size_t i) const;

  ImagePages images_;
  ImagePages background_;
  PixelRule rule_;
  std::optional<ImagePart> part_;
  bool transpose_;
  ImageOf<Pixel> first_;
  ImageOf<Pixel> only_background_;  // the one for all images
};
using PreparedImages = PreparedImagesOf<std::uint8_t>;
using WidePreparedImages = PreparedImagesOf<std::uint16_t>;

// The same of a sensor whose pixels have the bits of the preparation.
class PreparedSensorImages {
 public:
  PreparedSensorImages(const std::vector<std::string>& files, const Preparation& preparation);

  [[nodiscard]] std::size_t count() const;
  [[nodiscard]] const std::vector<std::string>& files() const;
  [[nodiscard]] int rows() const;
  [[nodiscard]] int columns() const;
  SensorImage frame(std::size_t i, SensorImage* as_taken = nullptr);

 private:
  std::variant<PreparedImages, WidePreparedImages> images_;
};

}  // namespace selfproj::images

#endif  // SELFPROJ_HOST_IMAGES_PREPARED_IMAGES_H
