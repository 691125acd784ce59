// Images as arguments: arrays, or files.
#ifndef SELFPROJ_PYTHON_BINDINGS_IMAGES_INPUT_H
#define SELFPROJ_PYTHON_BINDINGS_IMAGES_INPUT_H

#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "host/images/image_files.h"
#include "host/images/image_sequence.h"
#include "python/bindings/arrays.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/gray_decoder.h"

namespace selfproj::python {

// An array of (images, rows, columns) or of one image, a folder or file, several of them, or several arrays.
using ImagesArgument = std::variant<In<std::uint8_t>, In<std::uint16_t>, Path, Paths, std::vector<In<std::uint8_t>>,
                                    std::vector<In<std::uint16_t>>>;

// The images of an argument, which must outlive this object.
class GivenImages {
 public:
  // Of pixels of so many bits: arrays are uint8 or, with more than 8, uint16. Throws ValueError if there are none, for
  // arrays of another shape or other bits, and for options of files with arrays.
  GivenImages(const ImagesArgument& images, const images::PixelOptions& pixels, int bits = spec::kPixelBits)
      : rule_(pixels.rule()) {
    rule_.bits = bits;
    if (const auto* path = std::get_if<Path>(&images)) {
      names_ = images::image_arguments({path->string()});
    } else if (const auto* paths = std::get_if<Paths>(&images)) {
      require(!paths->empty(), "images: none are given");
      names_ = images::image_arguments(names_of(*paths));
    } else {
      require(pixels.given().empty(), "channel, shift: are for files; arrays have their bits already");
      if (const auto* array = std::get_if<In<std::uint8_t>>(&images)) {
        add(*array);
      } else if (const auto* wide = std::get_if<In<std::uint16_t>>(&images)) {
        add(*wide);
      } else if (const auto* several = std::get_if<std::vector<In<std::uint8_t>>>(&images)) {
        add_each(*several);
      } else {
        add_each(std::get<std::vector<In<std::uint16_t>>>(images));
      }
      require(!views_.empty(), "images: none are given");
    }
  }

  // Names for messages: the files, or "image 0", "image 1", ...
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  [[nodiscard]] std::size_t count() const { return names_.size(); }

  // Leaves out those from `count` on.
  void resize(std::size_t count) { names_.resize(count); }

  // May be called, and read, without the GIL.
  [[nodiscard]] images::ImageSequence sequence() const {
    if (views_.empty()) {
      return {names_, rule_};
    }
    return {names_, [this](std::size_t i) { return images::copy_of(std::get<model::ImageView>(views_[i])); }};
  }

  // Image i, from 0, of the bits given above. May be called without the GIL. Throws as read_image, and UserError for an
  // array with brighter pixels.
  [[nodiscard]] images::SensorImage read(std::size_t i) const {
    if (views_.empty()) {
      return images::read_sensor_image(names_[i], rule_);
    }
    return std::visit(
        [&](const auto& view) {
          auto image = images::copy_of(view);
          for (const auto pixel : image.pixels) {
            if (pixel >> rule_.bits != 0) {
              throw UserError(names_[i], "has a pixel of " + std::to_string(pixel) + "; the rig's have " +
                                             std::to_string(rule_.bits) + " bits");
            }
          }
          return images::SensorImage(std::move(image));
        },
        views_[i]);
  }

 private:
  template <typename Pixel>
  void add_each(const std::vector<In<Pixel>>& arrays) {
    for (const In<Pixel>& one : arrays) {
      require(one.ndim() == 2, "images: each array of a list must have 2 dimensions");
      add(one);
    }
  }

  template <typename Pixel>
  void add(const In<Pixel>& array) {
    require((sizeof(Pixel) > 1) == (rule_.bits > spec::kPixelBits),
            rule_.bits > spec::kPixelBits
                ? "images: arrays of uint16 are needed; the rig's pixels have more than 8 bits"
                : "images: arrays of uint8 are needed");
    const ImagesOf<Pixel> several(array);
    for (std::size_t i = 0; i < several.count(); ++i) {
      require(several.rows() > 0 && several.columns() > 0, "images: have no pixels");
      names_.push_back("image " + std::to_string(views_.size()));
      views_.push_back(several.view(i));
    }
  }

  images::PixelRule rule_;
  std::vector<std::string> names_;
  std::vector<model::SensorView> views_;  // empty: files
};

// How a decoder shows itself.
inline std::string decoder_text(const model::GraySettings& settings) {
  return "GrayDecoder(" + std::to_string(settings.rows) + " x " + std::to_string(settings.columns) +
         ", bits=" + std::to_string(settings.bits) + ")";
}

// Decoders read the positive of a pair again when its negative comes. It is copied, so that what Python does with the
// array meanwhile does not matter.
class KeptPositive {
 public:
  // The image, or for a positive its copy, which lives until the next one.
  model::ImageView keep(const model::ImageView& image, int pattern) {
    if (pattern % 2 != 0) {
      return image;
    }
    const auto columns = static_cast<std::size_t>(image.columns);
    pixels_.resize(static_cast<std::size_t>(image.rows) * columns);
    for (int row = 0; row < image.rows; ++row) {
      std::memcpy(pixels_.data() + static_cast<std::size_t>(row) * columns, image.pixels + row * image.stride, columns);
    }
    return {pixels_.data(), image.rows, image.columns, image.columns};
  }

 private:
  std::vector<std::uint8_t> pixels_;
};

}  // namespace selfproj::python

#endif  // SELFPROJ_PYTHON_BINDINGS_IMAGES_INPUT_H
