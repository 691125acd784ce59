#include "lab/relief_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <stdexcept>
#include <utility>

namespace selfproj::lab {
namespace {

using Pixel = cv::Vec3b;  // blue, green, red

constexpr int kWidth = 900;
constexpr int kMargin = 20;
constexpr int kForText = 70;  // pixels on the right and below
constexpr int kGap = 4;

Pixel pixel_of(const report::MapScale& scale, double value, double light) {
  const report::Colour colour = report::colour_at(scale.map, (value - scale.low) / (scale.high - scale.low));
  const auto lit = [&](std::uint8_t c) { return cv::saturate_cast<std::uint8_t>(c * light); };
  return {lit(colour.blue), lit(colour.green), lit(colour.red)};
}

std::string png_of(const cv::Mat3b& picture) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", picture, bytes);
  return {bytes.begin(), bytes.end()};
}

struct Placed {
  double x = 0, y = 0;  // in the picture, mm; y downwards
  double near = 0;      // along the direction of view: larger is nearer
};

// The parallel projection.
class View {
 public:
  Placed operator()(double row_mm, double column_mm, double height_mm) const {
    const double right = column_mm * cos_turn_ - row_mm * sin_turn_;
    const double back = column_mm * sin_turn_ + row_mm * cos_turn_;  // towards the viewer
    return {right, back * sin_up_ - height_mm * cos_up_, back * cos_up_ + height_mm * sin_up_};
  }

 private:
  static constexpr double kTurn = 30 * std::numbers::pi / 180;
  static constexpr double kUp = 35 * std::numbers::pi / 180;
  double sin_turn_ = std::sin(kTurn), cos_turn_ = std::cos(kTurn), sin_up_ = std::sin(kUp), cos_up_ = std::cos(kUp);
};

// Fills triangles, the nearest of which is seen.
class Canvas {
 public:
  Canvas(int rows, int columns)
      : picture_(rows, columns, Pixel(255, 255, 255)), near_(rows, columns, -std::numeric_limits<double>::infinity()) {}

  void fill(const std::array<Placed, 3>& at, const Pixel& colour) {
    const auto [low_x, high_x] = std::minmax({at[0].x, at[1].x, at[2].x});
    const auto [low_y, high_y] = std::minmax({at[0].y, at[1].y, at[2].y});
    const double area = (at[1].x - at[0].x) * (at[2].y - at[0].y) - (at[2].x - at[0].x) * (at[1].y - at[0].y);
    if (std::abs(area) < 1e-9) {
      return;
    }
    for (int y = std::max(0, static_cast<int>(std::ceil(low_y))); y <= std::min(picture_.rows - 1.0, high_y); ++y) {
      for (int x = std::max(0, static_cast<int>(std::ceil(low_x))); x <= std::min(picture_.cols - 1.0, high_x); ++x) {
        const double b = ((x - at[0].x) * (at[2].y - at[0].y) - (at[2].x - at[0].x) * (y - at[0].y)) / area;
        const double c = ((at[1].x - at[0].x) * (y - at[0].y) - (x - at[0].x) * (at[1].y - at[0].y)) / area;
        constexpr double kSlack = 1e-6;
        if (b < -kSlack || c < -kSlack || b + c > 1 + kSlack) {
          continue;
        }
        const double near = at[0].near + b * (at[1].near - at[0].near) + c * (at[2].near - at[0].near);
        if (near > near_(y, x)) {
          near_(y, x) = near;
          picture_(y, x) = colour;
        }
      }
    }
  }

  [[nodiscard]] const cv::Mat3b& picture() const { return picture_; }

  void line(const Placed& from, const Placed& to) {
    cv::line(picture_, cv::Point2d(from.x, from.y), cv::Point2d(to.x, to.y), kInk, 1, cv::LINE_AA);
  }

  void write(const std::string& text, double x, double y) {
    cv::putText(picture_, text, cv::Point2d(x, y), cv::FONT_HERSHEY_SIMPLEX, 0.5, kInk, 1, cv::LINE_AA);
  }

 private:
  static inline const cv::Scalar kInk{60, 60, 60};
  cv::Mat3b picture_;
  cv::Mat1d near_;
};

// The corner points of a map in the picture, NaN where there is no value.
class Corners {
 public:
  Corners(const images::FloatImage& map, const report::MapPitch& pitch, double exaggeration)
      : map_(map), exaggeration_(exaggeration) {
    const View view;
    double low_x = std::numeric_limits<double>::infinity();
    double high_x = -low_x;
    double low_y = low_x;
    double high_y = -low_x;
    for (int r = 0; r < map.rows; ++r) {
      for (int c = 0; c < map.columns; ++c) {
        const auto value = static_cast<double>(map.row(r)[c]);
        seen_.push_back(view(r * pitch.row_mm, c * pitch.column_mm, exaggeration * value));
        if (!std::isnan(value)) {
          low_x = std::min(low_x, seen_.back().x), high_x = std::max(high_x, seen_.back().x);
          low_y = std::min(low_y, seen_.back().y), high_y = std::max(high_y, seen_.back().y);
          low_ = std::min(low_, value), high_ = std::max(high_, value);
        }
      }
    }
    if (!(high_x > low_x)) {
      throw std::invalid_argument("relief: the map has no surface");
    }
    // The axes are at height 0 along the edges in front, the bar stands at the corner on the right.
    low_y = std::min(low_y, view(0, (map.columns - 1) * pitch.column_mm, exaggeration * bar_mm()).y);
    for (const auto& [row, column] :
         {std::pair{map.rows - 1, 0}, {map.rows - 1, map.columns - 1}, {0, map.columns - 1}}) {
      const Placed corner = view(row * pitch.row_mm, column * pitch.column_mm, 0);
      low_x = std::min(low_x, corner.x), high_x = std::max(high_x, corner.x);
      low_y = std::min(low_y, corner.y), high_y = std::max(high_y, corner.y);
    }
    low_x_ = low_x, low_y_ = low_y;
    per_mm_ = (kWidth - 2 * kMargin - kForText) / (high_x - low_x);
    height_ = static_cast<int>(std::ceil((high_y - low_y) * per_mm_)) + 2 * kMargin + kForText / 2;
    std::transform(seen_.begin(), seen_.end(), seen_.begin(), [this](const Placed& seen) { return in_picture(seen); });
  }

  // A point of the map's space.
  [[nodiscard]] Placed at_mm(double row_mm, double column_mm, double height_mm) const {
    return in_picture(View()(row_mm, column_mm, exaggeration_ * height_mm));
  }

  // The length of a bar for heights: 1, 2 or 5 times a power of ten, at least a quarter of what there is.
  [[nodiscard]] double bar_mm() const {
    const double least = std::max(0.25 * (high_ - low_), 1e-3);
    const double ten = std::pow(10, std::floor(std::log10(least)));
    return least <= 1 * ten ? ten : least <= 2 * ten ? 2 * ten : least <= 5 * ten ? 5 * ten : 10 * ten;
  }

  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] const Placed& at(int r, int c) const {
    return seen_[static_cast<std::size_t>(r) * static_cast<std::size_t>(map_.columns) + static_cast<std::size_t>(c)];
  }

 private:
  [[nodiscard]] Placed in_picture(const Placed& seen) const {
    return {kMargin + (seen.x - low_x_) * per_mm_, kMargin + (seen.y - low_y_) * per_mm_, seen.near};
  }

  const images::FloatImage& map_;
  double exaggeration_;
  std::vector<Placed> seen_;
  double low_ = std::numeric_limits<double>::infinity(), high_ = -std::numeric_limits<double>::infinity();
  double low_x_ = 0, low_y_ = 0, per_mm_ = 1;
  int height_ = 0;
};

// The edges in front, with their lengths, and a bar for heights at the corner on the right.
void draw_axes(const Corners& corners, const images::FloatImage& map, const report::MapPitch& pitch, Canvas& canvas) {
  const double rows = (map.rows - 1) * pitch.row_mm;
  const double columns = (map.columns - 1) * pitch.column_mm;
  const Placed left = corners.at_mm(rows, 0, 0);
  const Placed front = corners.at_mm(rows, columns, 0);
  const Placed right = corners.at_mm(0, columns, 0);
  const Placed top = corners.at_mm(0, columns, corners.bar_mm());
  canvas.line(left, front);
  canvas.line(front, right);
  canvas.line(right, top);
  canvas.write(fmt::format("{} {:.0f} mm", pitch.column_axis, columns), 0.5 * (left.x + front.x) - 70,
               0.5 * (left.y + front.y) + 24);
  canvas.write(fmt::format("{} {:.0f} mm", pitch.row_axis, rows), 0.5 * (front.x + right.x) + 10,
               0.5 * (front.y + right.y) + 16);
  canvas.write(fmt::format("{:g} mm", corners.bar_mm()), right.x + 6, 0.5 * (right.y + top.y) + 5);
}

}  // namespace

std::string relief_png(const images::FloatImage& map, const report::MapScale& scale, const report::MapPitch& pitch,
                       double exaggeration) {
  if (map.rows < 2 || map.columns < 2) {
    throw std::invalid_argument("relief: the map is too small");
  }
  const Corners corners(map, pitch, exaggeration);
  Canvas canvas(corners.height(), kWidth);
  for (int r = 0; r + 1 < map.rows; ++r) {
    for (int c = 0; c + 1 < map.columns; ++c) {
      const auto z = static_cast<double>(map.row(r)[c]);
      const auto right = static_cast<double>(map.row(r)[c + 1]);
      const auto below = static_cast<double>(map.row(r + 1)[c]);
      const auto across = static_cast<double>(map.row(r + 1)[c + 1]);
      if (std::isnan(z + right + below + across)) {
        continue;
      }
      // Light from the upper left: what falls to the right or towards the viewer is darker.
      const double slope = (right - z) / pitch.column_mm + (below - z) / pitch.row_mm;
      const double light = 0.85 + 0.3 * std::tanh(slope);
      const Pixel colour = pixel_of(scale, 0.25 * (z + right + below + across), std::clamp(light, 0.45, 1.1));
      canvas.fill({corners.at(r, c), corners.at(r, c + 1), corners.at(r + 1, c)}, colour);
      canvas.fill({corners.at(r + 1, c + 1), corners.at(r + 1, c), corners.at(r, c + 1)}, colour);
    }
  }
  draw_axes(corners, map, pitch, canvas);
  return png_of(canvas.picture());
}

std::string strip_png(const std::vector<images::FloatImage>& maps, const std::optional<report::MapScale>& scale,
                      std::size_t across) {
  const images::FloatImage& first = maps.at(0);
  const int step = std::max(1, first.columns / 256);
  const int rows = first.rows / step;
  const int columns = first.columns / step;
  const int lines = static_cast<int>((maps.size() + across - 1) / across);
  cv::Mat3b picture(lines * (rows + kGap) - kGap, static_cast<int>(across) * (columns + kGap) - kGap,
                    Pixel(255, 255, 255));
  for (std::size_t i = 0; i < maps.size(); ++i) {
    const int top = static_cast<int>(i / across) * (rows + kGap);
    const int left = static_cast<int>(i % across) * (columns + kGap);
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        const float value = maps[i].row(r * step)[c * step];
        Pixel& pixel = picture(top + r, left + c);
        if (std::isnan(value)) {
          pixel = {200, 200, 200};
        } else if (scale) {
          pixel = pixel_of(*scale, static_cast<double>(value), 1);
        } else {
          pixel = Pixel::all(cv::saturate_cast<std::uint8_t>(value));
        }
      }
    }
  }
  return png_of(picture);
}

images::Image below_each_other(const std::vector<images::Image>& images) {
  constexpr int kWhite = 8;
  images::Image result{0, images.at(0).columns, {}};
  for (const images::Image& image : images) {
    if (result.rows > 0) {
      result.pixels.insert(result.pixels.end(), static_cast<std::size_t>(kWhite * result.columns), 255);
      result.rows += kWhite;
    }
    result.pixels.insert(result.pixels.end(), image.pixels.begin(), image.pixels.end());
    result.rows += image.rows;
  }
  return result;
}

}  // namespace selfproj::lab
