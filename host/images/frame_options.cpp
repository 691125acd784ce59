#include "host/images/frame_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/files/numbers.h"
#include "host/files/user_error.h"
#include "model/spec/generated/selfproj_spec.h"

namespace selfproj {
namespace {

constexpr std::array<Channel, 5> kChannels{Channel::red, Channel::green, Channel::blue, Channel::grey,
                                           Channel::red_difference};

}  // namespace

std::vector<std::string> mode_names() {
  std::vector<std::string> names;
  std::transform(kModes.begin(), kModes.end(), std::back_inserter(names),
                 [](const auto& entry) { return entry.first; });
  return names;
}

Mode mode_of(const std::string& name) {
  for (const auto& [known, mode] : kModes) {
    if (name == known) {
      return mode;
    }
  }
  throw std::invalid_argument("mode_of: " + name);
}

std::string mode_name(Mode mode) {
  const auto* const found =
      std::find_if(kModes.begin(), kModes.end(), [&](const auto& entry) { return entry.second == mode; });
  return found == kModes.end() ? "unknown" : found->first;
}

std::vector<std::string> select_names() { return {select_name(Select::all), select_name(Select::strongest)}; }

Select select_of(const std::string& name) {
  for (const Select select : {Select::all, Select::strongest}) {
    if (name == select_name(select)) {
      return select;
    }
  }
  throw std::invalid_argument("select_of: " + name);
}

std::string select_name(Select select) {
  return select == Select::all ? "all" : select == Select::strongest ? "strongest" : "unknown";
}

RowWindow rows_of_text(const std::string& option, const std::string& text) {
  const std::string_view all = text;
  const std::size_t middle = all.find("..");
  const auto first = number_of_text<int>(all.substr(0, middle));
  const auto last = number_of_text<int>(middle == std::string_view::npos ? all : all.substr(middle + 2));
  if (middle == std::string_view::npos || !first || !last || *first < 1 || *first > *last || *last > spec::kMaxRows) {
    throw UserError(option, fmt::format("is '{}'; rows such as 10..80 are expected, from 1 to {}, the first not after "
                                        "the last",
                                        text, spec::kMaxRows));
  }
  return {.first = *first, .last = *last};
}

std::string select_text(const Measure& measure) {
  std::string text;
  if (measure.select != Select::all) {
    text = fmt::format("{}, gap {}", select_name(measure.select), measure.gap);
  }
  if (measure.window != RowWindow{}) {
    text += fmt::format("{}rows {}..{}", text.empty() ? "" : ", ", measure.window.first, measure.window.last);
  }
  return text;
}

std::vector<std::string> channel_names() {
  std::vector<std::string> names;
  std::transform(kChannels.begin(), kChannels.end(), std::back_inserter(names),
                 [](Channel channel) { return to_string(channel); });
  return names;
}

std::optional<Channel> channel_of(const std::string& name) {
  if (name.empty()) {
    return std::nullopt;
  }
  const auto* const found =
      std::find_if(kChannels.begin(), kChannels.end(), [&](Channel channel) { return to_string(channel) == name; });
  if (found == kChannels.end()) {
    throw std::invalid_argument("channel_of: " + name);
  }
  return *found;
}

std::string size_text(int rows, int columns) { return fmt::format("{} x {}", columns, rows); }

FrameSize size_of_text(const std::string& option, const std::string& text, int max_side) {
  const std::string_view all = text;
  const std::size_t middle = all.find('x');
  const auto columns = number_of_text<int>(all.substr(0, middle));
  const auto rows = number_of_text<int>(middle == std::string_view::npos ? all : all.substr(middle + 1));
  if (middle == std::string_view::npos || !columns || !rows || *columns < 1 || *columns > max_side || *rows < 1 ||
      *rows > max_side) {
    throw UserError(
        option, fmt::format("is '{}'; a size such as 1024x768 is expected, with columns and rows from 1 to {}", text,
                            max_side));
  }
  return {.rows = *rows, .columns = *columns};
}

void check_frame_size(const std::string& file, const Image& image, int max_rows, int max_columns) {
  if (image.columns % spec::kPixelsPerBeat != 0) {
    throw UserError(file,
                    fmt::format("has {} columns; a multiple of {} is needed", image.columns, spec::kPixelsPerBeat));
  }
  if (image.columns > max_columns) {
    throw UserError(file, fmt::format("has {} columns; at most {} are possible", image.columns, max_columns));
  }
  if (image.rows > max_rows) {
    throw UserError(file, fmt::format("has {} rows; at most {} are possible", image.rows, max_rows));
  }
}

void check_same_size(const std::string& file, const Image& image, const std::string& first, int rows, int columns) {
  if (image.rows != rows || image.columns != columns) {
    throw UserError(file, fmt::format("is {}, but {} is {}; all images must have one size",
                                      size_text(image.rows, image.columns), first, size_text(rows, columns)));
  }
}

}  // namespace selfproj
