#include "host/report/frame_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

namespace selfproj::report {
namespace {

constexpr int kShift = 4;  // fractional bits of OpenCV's drawing coordinates
constexpr double kLabelFontSize = 0.45;
const cv::Scalar kLabelInk(40, 40, 40);
const cv::Scalar kLine(0, 110, 255);       // orange
const cv::Scalar kAmbiguous(255, 0, 220);  // magenta

cv::Mat to_mat(const images::Image& image) {
  cv::Mat mat(image.rows, image.columns, CV_8UC1);
  for (int r = 0; r < image.rows; ++r) {
    std::copy_n(image.pixels.data() + static_cast<std::ptrdiff_t>(r) * image.columns, image.columns,
                mat.ptr<std::uint8_t>(r));
  }
  return mat;
}

void put_label(cv::Mat& picture, const std::string& text, cv::Point at) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, kLabelFontSize, kLabelInk, 1, cv::LINE_AA);
}

// Joins the points of the columns that have one (y is not NaN). Columns that are not neighbours, or whose points are
// more than `max_step` apart, are not joined.
void draw_trace(cv::Mat& picture, const std::vector<double>& x, const std::vector<double>& y, double max_step) {
  const auto fixed = [&](std::size_t i) {
    constexpr int kOne = 1 << kShift;
    return cv::Point(static_cast<int>(std::lround(x[i] * kOne)), static_cast<int>(std::lround(y[i] * kOne)));
  };
  for (std::size_t i = 0; i < y.size(); ++i) {
    if (std::isnan(y[i])) {
      continue;
    }
    const bool joined = i > 0 && !std::isnan(y[i - 1]) && std::abs(y[i] - y[i - 1]) <= max_step;
    cv::line(picture, fixed(joined ? i - 1 : i), fixed(i), kLine, 1, cv::LINE_AA, kShift);
  }
}

}  // namespace

std::string frame_png(const CameraPicture& camera) {
  constexpr int kMargin = 60;
  constexpr int kTop = 30;
  constexpr int kPlot = 130;
  constexpr int kGap = 34;
  const int columns = camera.image.columns;
  const int scale = std::clamp(1536 / columns, 1, 4);
  cv::Mat enlarged;
  cv::resize(to_mat(camera.image), enlarged, {}, scale, scale, cv::INTER_NEAREST);
  cv::cvtColor(enlarged, enlarged, cv::COLOR_GRAY2BGR);
  cv::Mat picture(kTop + enlarged.rows + 2 * (kGap + kPlot) + 20, enlarged.cols + 2 * kMargin, CV_8UC3,
                  cv::Scalar(255, 255, 255));
  enlarged.copyTo(picture(cv::Rect(kMargin, kTop, enlarged.cols, enlarged.rows)));
  put_label(picture, fmt::format("frame {}: image and centroid", camera.frame), {kMargin, kTop - 10});
  put_label(picture, "row 1", {6, kTop + 10});
  put_label(picture, std::to_string(camera.image.rows), {6, kTop + enlarged.rows});

  const auto count = static_cast<std::size_t>(columns);
  std::vector<double> x(count);
  std::vector<double> y(count, std::nan(""));
  for (std::size_t i = 0; i < count; ++i) {
    x[i] = kMargin + (static_cast<double>(i) + 0.5) * scale - 0.5;
    if (camera.moments.m0[i] > 0) {
      const double row = static_cast<double>(camera.moments.m1[i]) / camera.moments.m0[i] - 1;  // (3.2), rows from 0
      y[i] = kTop + (row + 0.5) * scale - 0.5;
    }
  }
  std::vector<double> sure = y;
  for (std::size_t i = 0; i < std::min(count, camera.ambiguous.size()); ++i) {
    if (camera.ambiguous[i] != 0 && !std::isnan(y[i])) {
      sure[i] = std::nan("");
      cv::circle(picture, {static_cast<int>(std::lround(x[i])), static_cast<int>(std::lround(y[i]))}, 2, kAmbiguous,
                 cv::FILLED, cv::LINE_AA);
    }
  }
  draw_trace(picture, x, sure, 4.0 * scale);

  int top = kTop + enlarged.rows + kGap;
  for (const auto& [values, name] :
       {std::pair(&camera.moments.m0, "M0"), std::pair(&camera.moments.n, "n, lit pixels")}) {
    const std::uint32_t most = std::max(1U, *std::max_element(values->begin(), values->end()));
    cv::rectangle(picture, cv::Rect(kMargin, top, enlarged.cols, kPlot), cv::Scalar(210, 210, 210));
    put_label(picture, name, {kMargin, top - 8});
    put_label(picture, std::to_string(most), {6, top + 10});
    put_label(picture, "0", {6, top + kPlot});
    for (std::size_t i = 0; i < count; ++i) {
      y[i] = top + kPlot - 1 - static_cast<double>((*values)[i]) / most * (kPlot - 2);
    }
    draw_trace(picture, x, y, kPlot);
    top += kPlot + kGap;
  }
  put_label(picture, "column 1", {kMargin, top - kGap + 16});
  put_label(picture, std::to_string(columns), {kMargin + enlarged.cols - 24, top - kGap + 16});
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", picture, bytes);
  return {bytes.begin(), bytes.end()};
}

}  // namespace selfproj::report
