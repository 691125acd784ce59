#include "host/light_section/pattern.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/images/image_files.h"
#include "selfproj/light_section/reference.h"

namespace selfproj::light_section {

images::FloatImage draw_pattern(const rig::Rig& rig, std::span<const double> line_of_column) {
  if (line_of_column.size() != static_cast<std::size_t>(rig.projector.columns)) {
    throw std::invalid_argument("pattern: as many lines are needed as the projector has columns");
  }
  images::FloatImage pattern(rig.projector.lines, rig.projector.columns);
  const double half = 0.5 * rig.measure.line_width_px;
  for (int c = 0; c < pattern.columns; ++c) {
    const double center = line_of_column[static_cast<std::size_t>(c)];
    if (!(center + half > -0.5 && center - half < pattern.rows - 0.5)) {  // true for NaN, too
      continue;
    }
    const int first = std::max(0, static_cast<int>(std::floor(center - half + 0.5)));
    const int last = std::min(pattern.rows - 1, static_cast<int>(std::ceil(center + half - 0.5)));
    for (int r = first; r <= last; ++r) {
      const double covered = std::min(r + 0.5, center + half) - std::max(r - 0.5, center - half);
      pattern.row(r)[c] = static_cast<float>(std::max(0.0, covered));
    }
  }
  return pattern;
}

images::FloatImage draw_straight_line(const rig::Rig& rig, double line) {
  return draw_pattern(rig, std::vector<double>(static_cast<std::size_t>(rig.projector.columns), line));
}

std::string encode_pattern_png(const images::FloatImage& pattern) {
  constexpr float kFull = 255;
  images::Image image{pattern.rows, pattern.columns, std::vector<std::uint8_t>(pattern.values.size())};
  std::transform(pattern.values.begin(), pattern.values.end(), image.pixels.begin(), [](float value) {
    return static_cast<std::uint8_t>(std::lround(kFull * std::clamp(value, 0.0F, 1.0F)));
  });
  return images::encode_png(image);
}

namespace {

constexpr int kPlotHeight = 220;
constexpr int kMargin = 56;  // left of and around the plot, for text
const cv::Scalar kInk(40, 40, 40);
const cv::Scalar kGrid(215, 215, 215);
const cv::Scalar kCurve(170, 90, 20);

void write(cv::Mat& image, const std::string& text, int x, int y) {
  cv::putText(image, text, {x, y}, cv::FONT_HERSHEY_SIMPLEX, 0.4, kInk, 1, cv::LINE_AA);
}

// A step of 1, 2 or 5 times a power of ten, so that there are at most about six in `span`.
double grid_step(double span) {
  const double power = std::pow(10, std::floor(std::log10(span / 6)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (span / (factor * power) <= 6) {
      return factor * power;
    }
  }
  return 10 * power;
}

void draw_plot(cv::Mat& image, int top, const rig::Rig& rig, const ReferenceProfile& reference) {
  const int left = kMargin;
  const int width = image.cols - left - 16;
  double low = 0;
  double high = 1;
  for (std::size_t i = 0; i < reference.valid.size(); ++i) {
    if (reference.valid[i] != 0) {
      low = std::min(low, rig.plane_z_mm - reference.z_mm[i]);
      high = std::max(high, rig.plane_z_mm - reference.z_mm[i]);
    }
  }
  const double span = (high - low) * 1.1;
  const auto x_of = [&](std::size_t i) {
    return left +
           static_cast<int>(std::lround(static_cast<double>(i) * width / static_cast<double>(reference.valid.size())));
  };
  const auto y_of = [&](double height) {
    return top + kPlotHeight - static_cast<int>(std::lround((height - low) / span * kPlotHeight));
  };
  const double step = grid_step(span);
  for (double height = std::ceil(low / step) * step; height <= low + span; height += step) {
    cv::line(image, {left, y_of(height)}, {left + width, y_of(height)}, kGrid);
    write(image, fmt::format("{:g}", std::round(height / step) * step), 8, y_of(height) + 4);
  }
  for (std::size_t i = 0; i + 1 < reference.valid.size(); ++i) {
    if (reference.valid[i] != 0 && reference.valid[i + 1] != 0 &&
        std::abs(reference.z_mm[i + 1] - reference.z_mm[i]) < kSteepest) {
      cv::line(image, {x_of(i), y_of(rig.plane_z_mm - reference.z_mm[i])},
               {x_of(i + 1), y_of(rig.plane_z_mm - reference.z_mm[i + 1])}, kCurve, 2, cv::LINE_AA);
    }
  }
  write(image, "height above the plane, mm", left, top - 6);
  const int below = top + kPlotHeight + 18;
  const MiddleRow middle(rig);
  write(image,
        fmt::format("camera columns 1..{}, y {:.1f}..{:.1f} mm on the plane", reference.columns(),
                    rig.plane_z_mm * middle.tan_beta(0), rig.plane_z_mm * middle.tan_beta(rig.camera.columns - 1)),
        left, below);
  write(image, fmt::format("{} of them have a reference", reference.valid_columns()), left, below + 16);
}

}  // namespace

std::string draw_preview(const rig::Rig& rig, const images::FloatImage& pattern, const ReferenceProfile& reference) {
  constexpr int kTitle = 24;
  constexpr int kGap = 40;
  constexpr int kMin = 480;  // pixels: the text needs them
  const bool plot = reference.columns() > 0;
  const int width = std::max(kMin, pattern.columns + kMargin + 16);
  cv::Mat image(kTitle + pattern.rows + (plot ? kGap + kPlotHeight + 48 : 16), width, CV_8UC3, cv::Scalar::all(255));
  for (int r = 0; r < pattern.rows; ++r) {
    for (int c = 0; c < pattern.columns; ++c) {
      const auto grey = static_cast<std::uint8_t>(std::lround(255.0F * pattern.row(r)[c]));
      image.at<cv::Vec3b>(kTitle + r, kMargin + c) = {grey, grey, grey};
    }
  }
  write(
      image,
      rig.light_plane ? "laser" : fmt::format("projector: {} lines (down) x {} columns", pattern.rows, pattern.columns),
      kMargin, 16);
  if (plot) {
    draw_plot(image, kTitle + pattern.rows + kGap, rig, reference);
  }
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".png", image, bytes)) {
    throw std::runtime_error("preview: the image cannot be written as PNG");
  }
  return {bytes.begin(), bytes.end()};
}

}  // namespace selfproj::light_section
