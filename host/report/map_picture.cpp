#include "host/report/map_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "host/report/tables.h"
#include "selfproj/files/user_error.h"
#include "selfproj/images/float_image.h"

namespace selfproj::report {

namespace {

using Stop = std::array<double, 3>;

// ColorBrewer's RdBu, from blue to red (Brewer and others 2003, Apache 2.0): eleven colours in even steps, safe for
// those who cannot tell red from green.
constexpr std::array<Stop, 11> kDiverging = {{{0x05, 0x30, 0x61},
                                              {0x21, 0x66, 0xAC},
                                              {0x43, 0x93, 0xC3},
                                              {0x92, 0xC5, 0xDE},
                                              {0xD1, 0xE5, 0xF0},
                                              {0xF7, 0xF7, 0xF7},
                                              {0xFD, 0xDB, 0xC7},
                                              {0xF4, 0xA5, 0x82},
                                              {0xD6, 0x60, 0x4D},
                                              {0xB2, 0x18, 0x2B},
                                              {0x67, 0x00, 0x1F}}};

// Every eighth of viridis (van der Walt and Smith 2015, CC0).
constexpr std::array<Stop, 9> kSequential = {{{0x44, 0x01, 0x54},
                                              {0x47, 0x2D, 0x7B},
                                              {0x3B, 0x52, 0x8B},
                                              {0x2C, 0x72, 0x8E},
                                              {0x21, 0x91, 0x8C},
                                              {0x28, 0xAE, 0x80},
                                              {0x5E, 0xC9, 0x62},
                                              {0xAD, 0xDC, 0x30},
                                              {0xFD, 0xE7, 0x25}}};

template <std::size_t Count>
Colour between(const std::array<Stop, Count>& stops, double t) {
  const double place = std::clamp(t, 0.0, 1.0) * static_cast<double>(Count - 1);
  const auto low = std::min(static_cast<std::size_t>(place), Count - 2);
  const double share = place - static_cast<double>(low);
  const auto mix = [&](std::size_t i) {
    return static_cast<std::uint8_t>(std::lround(stops[low][i] + share * (stops[low + 1][i] - stops[low][i])));
  };
  return {mix(0), mix(1), mix(2)};
}

}  // namespace

Colour colour_at(ColourMap map, double t) {
  return map == ColourMap::diverging ? between(kDiverging, t) : between(kSequential, t);
}

namespace {

constexpr double kFontSize = 0.5;
const cv::Scalar kInk(40, 40, 40);

cv::Vec3b bgr(Colour colour) { return {colour.blue, colour.green, colour.red}; }

// The colour of a pixel without a value.
cv::Vec3b hatch(int row, int column) {
  return (row + column) % 8 < 2 ? cv::Vec3b(178, 178, 178) : cv::Vec3b(132, 132, 132);
}

// The first of `values` values that falls into pixel `i` of `count`.
int begin_of(int i, int count, int values) { return static_cast<int>(static_cast<std::int64_t>(i) * values / count); }

float mean_of_block(const images::FloatImage& map, int row_begin, int row_end, int column_begin, int column_end) {
  double sum = 0;
  int count = 0;
  for (int r = row_begin; r < row_end; ++r) {
    const float* row = map.row(r);
    for (int c = column_begin; c < column_end; ++c) {
      if (!std::isnan(row[c])) {
        sum += static_cast<double>(row[c]);
        ++count;
      }
    }
  }
  return count > 0 ? static_cast<float>(sum / count) : std::numeric_limits<float>::quiet_NaN();
}

cv::Mat draw_map(const images::FloatImage& map, const MapScale& scale, const MapSize& size) {
  constexpr int kColours = 1024;
  std::vector<cv::Vec3b> colours;
  for (int i = 0; i < kColours; ++i) {
    colours.push_back(bgr(colour_at(scale.map, static_cast<double>(i) / (kColours - 1))));
  }
  const double factor = (kColours - 1) / (scale.high - scale.low);
  cv::Mat picture(size.height, size.width, CV_8UC3);
  for (int i = 0; i < size.height; ++i) {
    const int row_begin = begin_of(i, size.height, map.rows);
    const int row_end = std::max(row_begin + 1, begin_of(i + 1, size.height, map.rows));
    auto* out = picture.ptr<cv::Vec3b>(i);
    for (int j = 0; j < size.width; ++j) {
      const int column_begin = begin_of(j, size.width, map.columns);
      const int column_end = std::max(column_begin + 1, begin_of(j + 1, size.width, map.columns));
      const float value = mean_of_block(map, row_begin, row_end, column_begin, column_end);
      if (std::isnan(value)) {
        out[j] = hatch(i, j);
      } else {
        const double place = std::clamp((static_cast<double>(value) - scale.low) * factor, 0.0, kColours - 1.0);
        out[j] = colours[static_cast<std::size_t>(std::lround(place))];
      }
    }
  }
  return picture;
}

std::string png(const cv::Mat& picture) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", picture, bytes, {cv::IMWRITE_PNG_COMPRESSION, 6});
  return {bytes.begin(), bytes.end()};
}

cv::Size text_size(const std::string& text) {
  int base = 0;
  return cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, kFontSize, 1, &base);
}

// Draws text with its left end and the middle of its height at `at`.
void put_text(cv::Mat& picture, const std::string& text, cv::Point at) {
  at.y += text_size(text).height / 2;
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, kFontSize, kInk, 1, cv::LINE_AA);
}

// Draws the colour bar with its ticks from the top to the bottom of `place`, and below it the hatching for no value.
void draw_colour_bar(cv::Mat& picture, const MapScale& scale, const cv::Rect& place) {
  constexpr int kSwatch = 20;
  const int bar_height = place.height - kSwatch - 14;
  for (int i = 0; i < bar_height; ++i) {
    const Colour colour = colour_at(scale.map, 1.0 - static_cast<double>(i) / (bar_height - 1));
    cv::line(picture, {place.x, place.y + i}, {place.x + place.width - 1, place.y + i}, cv::Scalar(bgr(colour)));
  }
  cv::rectangle(picture, cv::Rect(place.x, place.y, place.width, bar_height), kInk);
  const std::vector<double> marks = ticks(scale.low, scale.high, std::clamp(bar_height / 40, 2, 10));
  const double step = marks.size() > 1 ? marks[1] - marks[0] : scale.high - scale.low;
  const int right = place.x + place.width;
  for (const double mark : marks) {
    const double share = (scale.high - mark) / (scale.high - scale.low);
    const int y = place.y + static_cast<int>(std::lround(share * (bar_height - 1)));
    cv::line(picture, {right, y}, {right + 4, y}, kInk);
    put_text(picture, tick_text(mark, step), {right + 9, y});
  }
  const cv::Rect swatch(place.x, place.y + place.height - kSwatch, place.width, kSwatch);
  for (int i = 0; i < swatch.height; ++i) {
    for (int j = 0; j < swatch.width; ++j) {
      picture.at<cv::Vec3b>(swatch.y + i, swatch.x + j) = hatch(i, j);
    }
  }
  cv::rectangle(picture, swatch, kInk);
  put_text(picture, "no value", {right + 9, swatch.y + swatch.height / 2});
}

// Length of a scale bar for a side of length `length`: about a fifth of it.
double bar_length(double length) { return round_down(length / 4); }

}  // namespace

std::vector<int> full_rows(const images::FloatImage& map) {
  std::vector<std::ptrdiff_t> counts;
  for (int r = 0; r < map.rows; ++r) {
    counts.push_back(
        std::count_if(map.row(r), map.row(r) + map.columns, [](float value) { return !std::isnan(value); }));
  }
  const std::ptrdiff_t fullest = counts.empty() ? 0 : *std::max_element(counts.begin(), counts.end());
  std::vector<int> rows;
  for (int r = 0; r < map.rows; ++r) {
    if (10 * counts[static_cast<std::size_t>(r)] >= 9 * fullest) {
      rows.push_back(r);
    }
  }
  return rows;
}

MapScale difference_scale(const images::FloatImage& difference, double at_most) {
  std::vector<float> values;
  for (const int r : full_rows(difference)) {
    for (const float* value = difference.row(r); value < difference.row(r) + difference.columns; ++value) {
      if (!std::isnan(*value)) {
        values.push_back(std::abs(*value));
      }
    }
  }
  double reach = 0;
  if (!values.empty()) {
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(0.995 * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    reach = static_cast<double>(*at);
  }
  reach = round_up(std::max(reach, 0.1));
  reach = at_most > 0 ? std::min(reach, at_most) : reach;
  return {ColourMap::diverging, -reach, reach};
}

MapScale height_scale(const images::FloatImage& height) {
  std::vector<float> values;
  std::copy_if(height.values.begin(), height.values.end(), std::back_inserter(values),
               [](float value) { return !std::isnan(value); });
  if (values.empty()) {
    return {ColourMap::sequential, 0, 1};
  }
  const auto quantile = [&values](double share) {
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return static_cast<double>(*at);
  };
  const double low = quantile(0.001);
  const double high = quantile(0.999);
  const double middle = (low + high) / 2;
  const double half = std::max((high - low) / 2, 0.5);
  return {ColourMap::sequential, middle - half, middle + half};
}

MapSize map_size(int rows, int columns, const MapPitch& pitch, int longest) {
  const double row_mm = pitch.row_mm > 0 ? pitch.row_mm : pitch.column_mm;
  const double height = rows * row_mm;
  const double width = columns * pitch.column_mm;
  const double scale = longest / std::max(height, width);
  const auto side = [&](double length) {
    return std::max({static_cast<int>(std::lround(length * scale)), longest / 5, 1});
  };
  return {side(width), side(height)};
}

std::string map_png(const images::FloatImage& map, const MapScale& scale, const MapSize& size) {
  if (map.values.empty()) {
    throw UserError("inspection", "there is nothing to draw");
  }
  return png(draw_map(map, scale, size));
}

std::string labelled_map_png(const images::FloatImage& map, const MapScale& scale, const MapPitch& pitch,
                             const std::string& title, const std::vector<MapMark>& marks) {
  if (map.values.empty()) {
    throw UserError("inspection", "there is nothing to draw");
  }
  constexpr int kLongest = 1200;
  constexpr int kLeft = 110;
  constexpr int kTop = 48;
  constexpr int kRight = 150;
  constexpr int kBottom = 64;
  const MapSize size = map_size(map.rows, map.columns, pitch, kLongest);
  cv::Mat picture(size.height + kTop + kBottom, size.width + kLeft + kRight, CV_8UC3, cv::Scalar(255, 255, 255));
  const cv::Rect place(kLeft, kTop, size.width, size.height);
  draw_map(map, scale, size).copyTo(picture(place));
  for (const MapMark& mark : marks) {
    constexpr int kAway = 4;  // pixels between a mark and what it marks
    const double wide = static_cast<double>(size.width) / map.columns;
    const double high = static_cast<double>(size.height) / map.rows;
    const int left = static_cast<int>(std::lround((mark.column + 0.5 - 0.5 * mark.columns) * wide)) - kAway;
    const int top = static_cast<int>(std::lround((mark.row + 0.5 - 0.5 * mark.rows) * high)) - kAway;
    const int width = static_cast<int>(std::lround(mark.columns * wide)) + 2 * kAway;
    const int height = static_cast<int>(std::lround(mark.rows * high)) + 2 * kAway;
    cv::rectangle(picture, cv::Rect(place.x + left, place.y + top, width, height), kInk, 2);
  }
  put_text(picture, title, {kLeft, kTop / 2});

  draw_colour_bar(picture, scale, {place.x + place.width + 20, place.y, 24, place.height});
  put_text(picture, std::string(scale.unit), {place.x + place.width + 20, kTop / 2});

  // Scale bars: that of the columns is below the picture, from its left; that of the rows is beside it, from its
  // bottom.
  const double width_mm = map.columns * pitch.column_mm;
  const double along_y = bar_length(width_mm);
  const int y_length = static_cast<int>(std::lround(along_y / width_mm * place.width));
  const int base = place.y + place.height + 16;
  cv::rectangle(picture, cv::Rect(place.x, base, y_length, 5), kInk, cv::FILLED);
  put_text(picture, fmt::format("{}  {} {}", pitch.column_axis, tick_text(along_y, along_y), pitch.unit),
           {place.x, base + 24});

  const bool known = pitch.row_mm > 0;
  const double height_length = known ? map.rows * pitch.row_mm : map.rows;
  const double along_x = known ? bar_length(height_length) : std::max(1.0, std::floor(bar_length(height_length)));
  const int x_length = static_cast<int>(std::lround(along_x / height_length * place.height));
  cv::rectangle(picture, cv::Rect(place.x - 21, place.y + place.height - x_length, 5, x_length), kInk, cv::FILLED);
  const int middle = place.y + place.height - x_length / 2;
  put_text(picture, pitch.row_axis, {12, middle - 10});
  put_text(picture, fmt::format("{} {}", tick_text(along_x, along_x), known ? pitch.unit : "fr."), {12, middle + 10});
  return png(picture);
}

}  // namespace selfproj::report
