#include "host/images/prepared_images.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "host/files/notes.h"
#include "host/images/frame_options.h"
#include "selfproj/files/user_error.h"

namespace selfproj::images {
namespace {

template <typename Pixel>
constexpr bool kWide = sizeof(Pixel) > 1;

template <typename Pixel>
ImageOf<Pixel> part_of(const ImageOf<Pixel>& image, const ImagePart& part) {
  const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(part.top) * image.columns + part.left;
  return copy_of(model::PixelView<Pixel>{image.pixels.data() + first, part.rows, part.columns, image.columns});
}

template <typename Pixel>
void subtract(ImageOf<Pixel>& image, const ImageOf<Pixel>& background) {
  std::transform(image.pixels.begin(), image.pixels.end(), background.pixels.begin(), image.pixels.begin(),
                 [](Pixel with, Pixel without) { return static_cast<Pixel>(std::max(0, int{with} - int{without})); });
}

// A file that does not say its bits may have values that its camera has shifted up.
void note_shift(const std::string& name, const WideImage& image) {
  std::uint16_t any = 0;
  for (const std::uint16_t pixel : image.pixels) {
    any |= pixel;
  }
  const int zeros = any == 0 ? 0 : std::countr_zero(any);
  if (zeros >= 2) {
    files::note(fmt::format("{}: all its values are multiples of {}; are they shifted up? --shift {} undoes it", name,
                            1 << zeros, zeros));
  }
}

}  // namespace

template <typename Pixel>
ImageOf<Pixel> transposed(const ImageOf<Pixel>& image) {
  ImageOf<Pixel> result{image.columns, image.rows, {}};
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

template <typename Pixel>
ImageOf<Pixel> with_columns(ImageOf<Pixel> image, int columns) {
  if (image.columns == columns) {
    return image;
  }
  ImageOf<Pixel> result{image.rows, columns, {}};
  result.pixels.resize(static_cast<std::size_t>(image.rows) * static_cast<std::size_t>(columns), 0);
  const int kept = std::min(columns, image.columns);
  for (int row = 0; row < image.rows; ++row) {
    std::copy_n(image.pixels.begin() + static_cast<std::ptrdiff_t>(row) * image.columns, kept,
                result.pixels.begin() + static_cast<std::ptrdiff_t>(row) * columns);
  }
  return result;
}

SensorImage with_columns(SensorImage image, int columns) {
  return std::visit([&](auto& one) { return SensorImage(with_columns(std::move(one), columns)); }, image);
}

template <typename Pixel>
PreparedImagesOf<Pixel>::PreparedImagesOf(std::vector<std::string> files, const Preparation& preparation)
    : images_(std::move(files)),
      background_(preparation.background),
      rule_(preparation.pixels.rule()),
      transpose_(preparation.transpose) {
  rule_.bits = preparation.bits;
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
  if constexpr (kWide<Pixel>) {
    if (!rule_.shift) {
      note_shift(images_.names().front(), first_);
    }
  }
  if (background_.count() == 1) {
    only_background_ = prepared(background_, 0);
    check_same_size(background_.names().front(), {only_background_.rows, only_background_.columns},
                    images_.names().front(), first_.rows, first_.columns);
  }
}

template <typename Pixel>
ImageOf<Pixel> PreparedImagesOf<Pixel>::frame(std::size_t i, ImageOf<Pixel>* as_taken) {
  const std::string& first = images_.names().front();
  ImageOf<Pixel> image = i == 0 ? first_ : prepared(images_, i);
  check_same_size(images_.names()[i], {image.rows, image.columns}, first, first_.rows, first_.columns);
  if (as_taken != nullptr) {
    *as_taken = image;
  }
  if (background_.count() == 1) {
    subtract(image, only_background_);
  } else if (background_.count() > 1) {
    const ImageOf<Pixel> background = prepared(background_, i);
    check_same_size(background_.names()[i], {background.rows, background.columns}, first, first_.rows, first_.columns);
    subtract(image, background);
  }
  return image;
}

template <typename Pixel>
ImageOf<Pixel> PreparedImagesOf<Pixel>::prepared(ImagePages& from, std::size_t i) const {
  ImageOf<Pixel> image;
  if constexpr (kWide<Pixel>) {
    image = from.read_wide(i, rule_);
  } else {
    image = from.read(i, rule_);
  }
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

template ImageOf<std::uint8_t> transposed(const ImageOf<std::uint8_t>& image);
template ImageOf<std::uint8_t> with_columns(ImageOf<std::uint8_t> image, int columns);
template ImageOf<std::uint16_t> with_columns(ImageOf<std::uint16_t> image, int columns);
template class PreparedImagesOf<std::uint8_t>;
template class PreparedImagesOf<std::uint16_t>;

PreparedSensorImages::PreparedSensorImages(const std::vector<std::string>& files, const Preparation& preparation)
    : images_(preparation.bits > spec::kPixelBits
                  ? decltype(images_)(std::in_place_type<WidePreparedImages>, files, preparation)
                  : decltype(images_)(std::in_place_type<PreparedImages>, files, preparation)) {}

std::size_t PreparedSensorImages::count() const { return files().size(); }
const std::vector<std::string>& PreparedSensorImages::files() const {
  return std::visit(
      [](const auto& images) -> const auto& { return images.files(); }, images_);
}
int PreparedSensorImages::rows() const {
  return std::visit([](const auto& images) { return images.rows(); }, images_);
}
int PreparedSensorImages::columns() const {
  return std::visit([](const auto& images) { return images.columns(); }, images_);
}
SensorImage PreparedSensorImages::frame(std::size_t i, SensorImage* as_taken) {
  return std::visit(
      [&]<typename Pixel>(PreparedImagesOf<Pixel>& images) {
        ImageOf<Pixel> taken;
        SensorImage image = images.frame(i, as_taken == nullptr ? nullptr : &taken);
        if (as_taken != nullptr) {
          *as_taken = std::move(taken);
        }
        return image;
      },
      images_);
}

}  // namespace selfproj::images
