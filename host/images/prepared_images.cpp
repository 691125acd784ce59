#include "host/images/prepared_images.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "host/images/frame_options.h"
#include "selfproj/files/user_error.h"

namespace selfproj::images {
namespace {

Image part_of(const Image& image, const ImagePart& part) {
  const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(part.top) * image.columns + part.left;
  return copy_of({image.pixels.data() + first, part.rows, part.columns, image.columns});
}

void subtract(Image& image, const Image& background) {
  std::transform(image.pixels.begin(), image.pixels.end(), background.pixels.begin(), image.pixels.begin(),
                 [](std::uint8_t with, std::uint8_t without) {
                   return static_cast<std::uint8_t>(std::max(0, int{with} - int{without}));
                 });
}

}  // namespace

Image transposed(const Image& image) {
  Image result{image.columns, image.rows, {}};
  result.pixels.resize(image.pixels.size());
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.columns; ++column) {
      result.pixels[static_cast<std::size_t>(column) * static_cast<std::size_t>(image.rows) +
                    static_cast<std::size_t>(row)] =
          image.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(image.columns) +
                       static_cast<std::size_t>(column)];
    }
  }
  return result;
}

Image with_columns(const Image& image, int columns) {
  Image result{image.rows, columns, {}};
  result.pixels.resize(static_cast<std::size_t>(image.rows) * static_cast<std::size_t>(columns), 0);
  const int kept = std::min(columns, image.columns);
  for (int row = 0; row < image.rows; ++row) {
    std::copy_n(image.pixels.begin() + static_cast<std::ptrdiff_t>(row) * image.columns, kept,
                result.pixels.begin() + static_cast<std::ptrdiff_t>(row) * columns);
  }
  return result;
}

PreparedImages::PreparedImages(std::vector<std::string> files, const Preparation& preparation)
    : images_(std::move(files)),
      background_(preparation.background),
      rule_(preparation.pixels.rule()),
      transpose_(preparation.transpose) {
  if (!preparation.roi.empty()) {
    constexpr int kMaxSide = 1 << 20;
    part_ = image_part(preparation.roi, kMaxSide);
    if (!part_) {
      throw UserError("--roi",
                      fmt::format("is '{}'; a part such as 320x60+0+40 is expected: columns, rows, and its left "
                                  "and upper pixel from 0",
                                  preparation.roi));
    }
  }
  if (background_.count() > 1 && background_.count() != images_.count()) {
    throw UserError("--background " + background_.names().front(),
                    fmt::format("has {} images for {} frames", background_.count(), images_.count()));
  }
  first_ = prepared(images_, 0);
  if (background_.count() == 1) {
    only_background_ = prepared(background_, 0);
    check_same_size(background_.names().front(), only_background_, images_.names().front(), first_.rows,
                    first_.columns);
  }
}

Image PreparedImages::frame(std::size_t i, Image* as_taken) {
  const std::string& first = images_.names().front();
  Image image = i == 0 ? first_ : prepared(images_, i);
  check_same_size(images_.names()[i], image, first, first_.rows, first_.columns);
  if (as_taken != nullptr) {
    *as_taken = image;
  }
  if (background_.count() == 1) {
    subtract(image, only_background_);
  } else if (background_.count() > 1) {
    const Image background = prepared(background_, i);
    check_same_size(background_.names()[i], background, first, first_.rows, first_.columns);
    subtract(image, background);
  }
  return image;
}

Image PreparedImages::prepared(ImagePages& from, std::size_t i) const {
  Image image = from.read(i, rule_);
  if (part_) {
    if (part_->left + part_->columns > image.columns || part_->top + part_->rows > image.rows) {
      throw UserError(from.names()[i],
                      fmt::format("is {}; --roi {}+{}+{} is not within it", size_text(image.rows, image.columns),
                                  size_text(part_->rows, part_->columns), part_->left, part_->top));
    }
    image = part_of(image, *part_);
  }
  return transpose_ ? transposed(image) : image;
}

}  // namespace selfproj::images
