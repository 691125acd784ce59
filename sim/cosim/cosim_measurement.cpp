#include "sim/cosim/cosim_measurement.h"

#include <algorithm>
#include <cstddef>
#include <future>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "host/images/prepared_images.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/generated/selfproj_spec.h"

namespace selfproj::sim {

SceneFrames::SceneFrames(Render render, int rows, int columns, int bits, std::size_t first, std::size_t count)
    : render_(std::move(render)), rows_(rows), columns_(columns), bits_(bits), first_(first), count_(count) {}

const images::SensorImage* SceneFrames::next() {
  const std::size_t wanted = std::max(1U, std::thread::hardware_concurrency());
  while (ahead_.size() < wanted && asked_ < count_) {
    const auto frame = static_cast<int>(first_ + asked_++);
    ahead_.push_back(std::async(std::launch::async, render_, frame));
  }
  if (ahead_.empty()) {
    return nullptr;
  }
  image_ = ahead_.front().get();
  ahead_.pop_front();
  return &image_;
}

RecordedFrames::RecordedFrames(images::PreparedSensorImages images, int bits, std::size_t first, std::size_t count)
    : images_(std::move(images)),
      bits_(bits),
      first_(first),
      count_(count),
      columns_((images_.columns() + spec::kPixelsPerBeat - 1) / spec::kPixelsPerBeat * spec::kPixelsPerBeat) {
  if (images_.count() != first + count) {
    throw UserError(images_.files().front(), "is one of several in its file; this command takes one image a file");
  }
  images::check_frame_size(images_.files().front(), {.rows = images_.rows(), .columns = columns_, .pixels = {}},
                           spec::kMaxRows, spec::kMaxColumns);
}

const images::SensorImage* RecordedFrames::next() {
  if (given_ == count_) {
    return nullptr;
  }
  image_ = images::with_columns(images_.frame(first_ + given_++, &as_taken_), columns_);
  return &image_;
}

}  // namespace selfproj::sim
