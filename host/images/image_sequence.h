// Images of one size, read in turn: of files, or made as they are asked for.
#ifndef SELFPROJ_HOST_IMAGES_IMAGE_SEQUENCE_H
#define SELFPROJ_HOST_IMAGES_IMAGE_SEQUENCE_H

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/images/image_files.h"

namespace selfproj::images {

class ImageSequence {
 public:
  // Checks the beginning of every file, so that a wrong name is found before the first image is read. Throws like
  // check_image_file.
  ImageSequence(std::vector<std::string> files, const PixelRule& rule);

  // Images that are in no files. `names` are for messages, one for each image; make(i) gives image i, from 0.
  ImageSequence(std::vector<std::string> names, std::function<Image(std::size_t)> make);

  [[nodiscard]] std::size_t count() const { return files_.size(); }
  [[nodiscard]] const std::vector<std::string>& files() const { return files_; }

  // The first image, to learn the size; read(0) does not read the file again.
  const Image& first();

  // Image i, from 0. Throws like read_image, and UserError, naming the file, if its size differs from that of the first
  // image read.
  Image read(std::size_t i);

 private:
  std::vector<std::string> files_;
  PixelRule rule_;
  std::function<Image(std::size_t)> make_;  // empty: the images are read from files_
  std::optional<Image> first_;
  int rows_ = 0;
  int columns_ = 0;
};

}  // namespace selfproj::images

#endif  // SELFPROJ_HOST_IMAGES_IMAGE_SEQUENCE_H
