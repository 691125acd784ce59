#include "sim/cosim/cosim_measurement.h"

#include <glob.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <future>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "host/images/natural_order.h"
#include "host/images/prepared_images.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/generated/selfproj_spec.h"

namespace selfproj::sim {

SceneFrames::SceneFrames(Render render, int rows, int columns, std::size_t first, std::size_t count)
    : render_(std::move(render)), rows_(rows), columns_(columns), first_(first), count_(count) {}

const images::Image* SceneFrames::next() {
  const std::size_t wanted = std::max(1U, std::thread::hardware_concurrency());
  while (ahead_.size() < wanted && asked_ < count_) {
    const auto frame = static_cast<int>(first_ + asked_++);
    ahead_.push_back(std::async(std::launch::async, [this, frame] {
      images::Image image{rows_, columns_, {}};
      image.pixels.resize(static_cast<std::size_t>(rows_) * static_cast<std::size_t>(columns_));
      render_(frame, image.pixels);
      return image;
    }));
  }
  if (ahead_.empty()) {
    return nullptr;
  }
  image_ = ahead_.front().get();
  ahead_.pop_front();
  return &image_;
}

RecordedFrames::RecordedFrames(images::PreparedImages images, std::size_t first, std::size_t count)
    : images_(std::move(images)),
      first_(first),
      count_(count),
      columns_((images_.columns() + spec::kPixelsPerBeat - 1) / spec::kPixelsPerBeat * spec::kPixelsPerBeat) {
  images::check_frame_size(images_.files().front(), {.rows = images_.rows(), .columns = columns_, .pixels = {}},
                           spec::kMaxRows, spec::kMaxColumns);
}

const images::Image* RecordedFrames::next() {
  if (given_ == count_) {
    return nullptr;
  }
  image_ = images_.frame(first_ + given_++, &as_taken_);
  if (columns_ != image_.columns) {
    image_ = images::with_columns(image_, columns_);
  }
  return &image_;
}

std::vector<std::string> files_of_pattern(const std::string& option, const std::string& pattern) {
  std::error_code error;
  if (std::filesystem::is_directory(pattern, error)) {
    return images::files_of_folder(pattern);
  }
  if (std::filesystem::exists(pattern, error)) {
    return {pattern};
  }
  // Brackets are those of a name where there is one, else a set of characters.
  std::string of_name;
  for (const char c : pattern) {
    of_name += c == '[' ? "[[]" : std::string(1, c);
  }
  for (const std::string& wanted : {of_name, pattern}) {
    glob_t found{};
    const int result = glob(wanted.c_str(), 0, nullptr, &found);
    std::vector<std::string> files(found.gl_pathv, found.gl_pathv + (result == 0 ? found.gl_pathc : 0));
    globfree(&found);
    if (!files.empty()) {
      return images::in_natural_order(std::move(files));
    }
  }
  throw UserError(option + " " + pattern, "no file matches");
}

}  // namespace selfproj::sim
