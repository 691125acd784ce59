// The frames of a co-simulation: a scene in front of the simulated camera, or recorded images.
#ifndef SELFPROJ_SIM_COSIM_FRAME_SOURCE_H
#define SELFPROJ_SIM_COSIM_FRAME_SOURCE_H

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <future>
#include <span>
#include <string>
#include <vector>

#include "host/images/image_files.h"
#include "host/images/prepared_images.h"

namespace selfproj {

class FrameSource {
 public:
  FrameSource() = default;
  FrameSource(const FrameSource&) = delete;
  FrameSource& operator=(const FrameSource&) = delete;
  virtual ~FrameSource() = default;

  [[nodiscard]] virtual std::size_t total() const = 0;
  [[nodiscard]] virtual int rows() const = 0;
  [[nodiscard]] virtual int columns() const = 0;

  // The next frame, valid until the next call; null after the last one. Throws UserError about bad input.
  virtual const Image* next() = 0;

  // The picture to show for the frame that next() gave last. It differs from the frame only if a background was
  // subtracted.
  [[nodiscard]] virtual const Image& picture() const = 0;
};

// Frames first..first + count - 1 (from 0) of a rendered scene. Several threads render some of them ahead.
class SceneFrames final : public FrameSource {
 public:
  // Renders the image of a frame; several threads may call it at once.
  using Render = std::function<void(int frame, std::span<std::uint8_t> pixels)>;
  SceneFrames(Render render, int rows, int columns, std::size_t first, std::size_t count);

  [[nodiscard]] std::size_t total() const override { return count_; }
  [[nodiscard]] int rows() const override { return rows_; }
  [[nodiscard]] int columns() const override { return columns_; }
  const Image* next() override;
  [[nodiscard]] const Image& picture() const override { return image_; }

 private:
  Render render_;
  int rows_;
  int columns_;
  std::size_t first_;
  std::size_t count_;
  std::size_t asked_ = 0;  // frames whose rendering has begun
  std::deque<std::future<Image>> ahead_;
  Image image_;
};

// Images of one size, padded with dark columns to a size that fits the board.
class RecordedFrames final : public FrameSource {
 public:
  // The images from `first`, from 0, on. Throws UserError as PreparedImages does, and if they do not fit the board.
  RecordedFrames(PreparedImages images, std::size_t first, std::size_t count);

  [[nodiscard]] std::size_t total() const override { return count_; }
  [[nodiscard]] int rows() const override { return images_.rows(); }
  [[nodiscard]] int columns() const override { return columns_; }
  // Columns of the images, without the padding.
  [[nodiscard]] int image_columns() const { return images_.columns(); }
  const Image* next() override;
  [[nodiscard]] const Image& picture() const override { return as_taken_; }

 private:
  PreparedImages images_;
  std::size_t first_;
  std::size_t count_;
  int columns_;
  Image as_taken_;
  Image image_;
  std::size_t given_ = 0;
};

// The files matched by a pattern with * ? [], in natural order; a name without any of these is a file.
// Throws UserError with the option if there is none.
std::vector<std::string> files_of_pattern(const std::string& option, const std::string& pattern);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_COSIM_FRAME_SOURCE_H
