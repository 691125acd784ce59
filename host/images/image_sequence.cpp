#include "host/images/image_sequence.h"

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/images/frame_options.h"

namespace selfproj::images {

ImageSequence::ImageSequence(std::vector<std::string> files, const PixelRule& rule)
    : files_(std::move(files)), rule_(rule) {
  for (const std::string& file : files_) {
    check_image_file(file);
  }
}

ImageSequence::ImageSequence(std::vector<std::string> names, std::function<Image(std::size_t)> make)
    : files_(std::move(names)), make_(std::move(make)) {}

const Image& ImageSequence::first() {
  first_ = read(0);
  return *first_;
}

Image ImageSequence::read(std::size_t i) {
  if (i == 0 && first_) {
    Image image = std::move(*first_);
    first_.reset();
    return image;
  }
  Image image = make_ ? make_(i) : read_image(files_[i], rule_);
  if (rows_ == 0) {
    rows_ = image.rows;
    columns_ = image.columns;
  } else {
    check_same_size(files_[i], {image.rows, image.columns}, files_.front(), rows_, columns_);
  }
  return image;
}

}  // namespace selfproj::images
