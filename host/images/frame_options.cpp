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
#include "selfproj/files/user_error.h"
#include "selfproj/model/generated/selfproj_spec.h"

namespace selfproj::images {
namespace {

// The names of a table of names and values.
template <class Table>
std::vector<std::string> names_of(const Table& table) {
  std::vector<std::string> names;
  std::transform(table.begin(), table.end(), std::back_inserter(names), [](const auto& entry) { return entry.first; });
  return names;
}

// The value of one of these names; throws std::invalid_argument for any other.
template <class Table>
auto value_of(const Table& table, const std::string& name, const char* what) {
  const auto* const found =
      std::find_if(table.begin(), table.end(), [&](const auto& entry) { return name == entry.first; });
  if (found == table.end()) {
    throw std::invalid_argument(what + (": " + name));
  }
  return found->second;
}

// The name of a value; "unknown" for any that is not in the table.
template <class Table, class Value>
std::string name_in(const Table& table, Value value) {
  const auto* const found =
      std::find_if(table.begin(), table.end(), [&](const auto& entry) { return entry.second == value; });
  return found == table.end() ? "unknown" : found->first;
}

constexpr std::array<std::pair<const char*, model::Select>, 2> kSelects{
    {{"all", model::Select::all}, {"strongest", model::Select::strongest}}};

}  // namespace

std::vector<std::string> mode_names() { return names_of(kModes); }
model::Mode mode_of(const std::string& name) { return value_of(kModes, name, "mode_of"); }
std::string mode_name(model::Mode mode) { return name_in(kModes, mode); }

std::vector<std::string> select_names() { return names_of(kSelects); }
model::Select select_of(const std::string& name) { return value_of(kSelects, name, "select_of"); }
std::string select_name(model::Select select) { return name_in(kSelects, select); }

model::RowWindow rows_of_text(const std::string& option, const std::string& text, int max_rows) {
  const std::string_view all = text;
  const std::size_t middle = all.find("..");
  const auto first = files::number_of_text<int>(all.substr(0, middle));
  const auto last = files::number_of_text<int>(middle == std::string_view::npos ? all : all.substr(middle + 2));
  if (middle == std::string_view::npos || !first || !last || *first < 1 || *first > *last || *last > max_rows) {
    throw UserError(option, fmt::format("is '{}'; rows such as 10..80 are expected, from 1 to {}, the first not after "
                                        "the last",
                                        text, max_rows));
  }
  return {.first = *first, .last = *last};
}

std::string select_text(const model::Measure& measure) {
  std::string text;
  if (measure.select != model::Select::all) {
    text = fmt::format("{}, gap {}", select_name(measure.select), measure.gap);
  }
  if (measure.window != model::RowWindow{}) {
    text += fmt::format("{}rows {}..{}", text.empty() ? "" : ", ", measure.window.first, measure.window.last);
  }
  return text;
}

std::vector<std::string> channel_names() { return names_of(kChannels); }

std::optional<Channel> channel_of(const std::string& name) {
  return name.empty() ? std::nullopt : std::optional(value_of(kChannels, name, "channel_of"));
}

PixelRule PixelOptions::rule() const {
  if (shift && (*shift < 0 || *shift > kMaxShift)) {
    throw std::invalid_argument(fmt::format("shift: must be in 0..{}", kMaxShift));
  }
  const std::vector<std::string> names = channel_names();
  if (!channel.empty() && std::find(names.begin(), names.end(), channel) == names.end()) {
    throw std::invalid_argument(fmt::format("channel: is '{}'; must be one of {}", channel, fmt::join(names, ", ")));
  }
  return {channel_of(channel), shift};
}

std::string size_text(int rows, int columns) { return fmt::format("{} x {}", columns, rows); }

FrameSize size_of_text(const std::string& option, const std::string& text, int max_side) {
  const std::string_view all = text;
  const std::size_t middle = all.find('x');
  const auto columns = files::number_of_text<int>(all.substr(0, middle));
  const auto rows = files::number_of_text<int>(middle == std::string_view::npos ? all : all.substr(middle + 1));
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

void check_same_size(const std::string& file, const FrameSize& size, const std::string& first, int rows, int columns) {
  if (size.rows != rows || size.columns != columns) {
    throw UserError(file, fmt::format("is {}, but {} is {}; all images must have one size",
                                      size_text(size.rows, size.columns), first, size_text(rows, columns)));
  }
}

}  // namespace selfproj::images
