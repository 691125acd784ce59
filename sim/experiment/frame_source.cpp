#include "sim/experiment/frame_source.h"

#include <glob.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <future>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "host/io/frame_options.h"
#include "host/io/natural_order.h"
#include "host/io/user_error.h"
#include "model/spec/generated/selfproj_spec.h"

namespace selfproj {

SceneFrames::SceneFrames(Render render, int rows, int columns, std::size_t first, std::size_t count)
    : render_(std::move(render)), rows_(rows), columns_(columns), first_(first), count_(count) {}

const Image* SceneFrames::next() {
  const std::size_t wanted = std::max(1U, std::thread::hardware_concurrency());
  while (ahead_.size() < wanted && asked_ < count_) {
    const auto frame = static_cast<int>(first_ + asked_++);
    ahead_.push_back(std::async(std::launch::async, [this, frame] {
      Image image{rows_, columns_, {}};
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

RecordedFrames::RecordedFrames(std::vector<std::string> files, std::optional<Channel> channel,
                               std::vector<std::string> background)
    : files_(std::move(files)), background_(std::move(background)), channel_(channel) {
  for (const auto* list : {&files_, &background_}) {
    for (const std::string& file : *list) {
      check_image_file(file);
    }
  }
  first_ = read_image(files_.front(), channel_);
  check_frame_size(files_.front(), first_, spec::kMaxRows, spec::kMaxColumns);
}

const Image* RecordedFrames::next() {
  if (given_ == files_.size()) {
    return nullptr;
  }
  const std::string& file = files_[given_++];
  as_taken_ = read_image(file, channel_);
  check_same_size(file, as_taken_, files_.front(), first_.rows, first_.columns);
  image_ = as_taken_;
  if (!background_.empty()) {
    const std::string& name = background_[given_ - 1];
    const Image background = read_image(name, channel_);
    check_same_size(name, background, files_.front(), first_.rows, first_.columns);
    std::transform(image_.pixels.begin(), image_.pixels.end(), background.pixels.begin(), image_.pixels.begin(),
                   [](std::uint8_t with, std::uint8_t without) {
                     return static_cast<std::uint8_t>(std::max(0, int{with} - int{without}));
                   });
  }
  return &image_;
}

std::vector<std::string> files_of_pattern(const std::string& option, const std::string& pattern) {
  glob_t found{};
  const int result = glob(pattern.c_str(), 0, nullptr, &found);
  std::vector<std::string> files(found.gl_pathv, found.gl_pathv + (result == 0 ? found.gl_pathc : 0));
  globfree(&found);
  if (files.empty()) {
    throw UserError(option + " " + pattern, "no file matches");
  }
  return in_natural_order(std::move(files));
}

}  // namespace selfproj
