#include "host/calibration/calibration_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace selfproj {
namespace {

constexpr int kPanel = 520;  // the longer side of an image in a picture
constexpr int kGap = 24;
constexpr int kTitle = 28;
const cv::Scalar kInk(40, 40, 40);
const cv::Scalar kGrid(215, 215, 215);

cv::Scalar colour_of(std::size_t pose) {
  constexpr std::array<std::array<int, 3>, 8> kColours{{{180, 119, 31},
                                                        {14, 127, 255},
                                                        {44, 160, 44},
                                                        {40, 39, 214},
                                                        {189, 103, 148},
                                                        {75, 86, 140},
                                                        {194, 119, 227},
                                                        {127, 127, 127}}};
  const auto& c = kColours[pose % kColours.size()];
  return {static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2])};
}

void write(cv::Mat& picture, const std::string& text, cv::Point at, const cv::Scalar& colour = kInk) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.42, colour, 1, cv::LINE_AA);
}

std::string png_of(const cv::Mat& picture) {
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".png", picture, bytes)) {
    throw std::runtime_error("calibration: a picture cannot be written as PNG");
  }
  return {bytes.begin(), bytes.end()};
}

// Camera or projector, for code that treats both alike.
struct Instrument {
  const char* name;
  cv::Point2d Corner::*place;
  cv::Vec2d Corner::*residual;
  int columns, rows;
  double rms;
  double coverage;
};

std::array<Instrument, 2> instruments(const CalibrationReport& report) {
  const Calibration& c = report.calibration;
  return {{{"camera", &Corner::camera, &Corner::camera_residual, c.camera_columns, c.camera_rows,
            report.bundle.camera_rms, report.camera_coverage},
           {"projector", &Corner::projector, &Corner::projector_residual, c.projector_columns, c.projector_rows,
            report.bundle.projector_rms, report.projector_coverage}}};
}

// A rectangle of the picture that shows an image, to scale.
struct Frame {
  cv::Rect area;
  double scale;

  [[nodiscard]] cv::Point at(const cv::Point2d& pixel) const {
    return {area.x + static_cast<int>(std::lround((pixel.x + 0.5) * scale)),
            area.y + static_cast<int>(std::lround((pixel.y + 0.5) * scale))};
  }
};

Frame frame_of(const Instrument& what, int left, int top) {
  const double scale = static_cast<double>(kPanel) / std::max(what.columns, what.rows);
  return {{left, top, static_cast<int>(std::lround(what.columns * scale)),
           static_cast<int>(std::lround(what.rows * scale))},
          scale};
}

int left_of(std::size_t panel) { return kGap + static_cast<int>(panel) * (kPanel + kGap); }
constexpr int kWidth = 3 * kGap + 2 * kPanel;

int tallest(const std::array<Instrument, 2>& both) {
  int height = 0;
  for (const Instrument& what : both) {
    height = std::max(height, frame_of(what, 0, 0).area.height);
  }
  return height;
}

// The value that `share` of the numbers do not exceed.
double quantile(std::vector<double> values, double share) {
  if (values.empty()) {
    return 0;
  }
  const auto i = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + i, values.end());
  return values[static_cast<std::size_t>(i)];
}

// The greatest of 1, 2 or 5 times a power of ten that is at most `limit`.
double round_step(double limit) {
  const double power = std::pow(10, std::floor(std::log10(limit)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= limit) {
      return factor * power;
    }
  }
  return power;
}

template <class Function>
void for_each_used(const CalibrationReport& report, const Function& function) {
  for (std::size_t p = 0; p < report.poses.size(); ++p) {
    if (report.poses[p].reason.empty()) {
      for (const Corner& corner : report.poses[p].corners) {
        if (corner.used) {
          function(p, corner);
        }
      }
    }
  }
}

void draw_scatter(cv::Mat& picture, const CalibrationReport& report, const Instrument& what, int left, int top) {
  std::vector<double> lengths;
  for_each_used(report, [&](std::size_t, const Corner& c) { lengths.push_back(cv::norm(c.*what.residual)); });
  const double reach = std::max(1e-6, 1.05 * quantile(lengths, 1));
  const double scale = 0.5 * kPanel / reach;
  const cv::Point centre(left + kPanel / 2, top + kPanel / 2);
  const double step = round_step(0.6 * reach);
  for (int k = -5; k <= 5; ++k) {
    const int off = static_cast<int>(std::lround(k * step * scale));
    if (std::abs(off) <= kPanel / 2) {
      cv::line(picture, {centre.x + off, top}, {centre.x + off, top + kPanel}, kGrid);
      cv::line(picture, {left, centre.y + off}, {left + kPanel, centre.y + off}, kGrid);
    }
  }
  for_each_used(report, [&](std::size_t pose, const Corner& c) {
    const cv::Vec2d r = c.*what.residual;
    cv::circle(picture,
               {centre.x + static_cast<int>(std::lround(r[0] * scale)),
                centre.y + static_cast<int>(std::lround(r[1] * scale))},
               2, colour_of(pose), cv::FILLED, cv::LINE_AA);
  });
  cv::rectangle(picture, {left, top, kPanel, kPanel}, kInk);
  write(picture, fmt::format("{}: residuals, RMS {:.3f} px; a square is {:g} px", what.name, what.rms, step),
        {left, top - 8});
}

void draw_arrows(cv::Mat& picture, const CalibrationReport& report, const Instrument& what, int left, int top) {
  constexpr double kLongest = 30;  // length in the picture of the 98 % quantile
  std::vector<double> lengths;
  for_each_used(report, [&](std::size_t, const Corner& c) { lengths.push_back(cv::norm(c.*what.residual)); });
  const Frame frame = frame_of(what, left, top);
  const double factor = kLongest / std::max(1e-9, quantile(lengths, 0.98));
  for_each_used(report, [&](std::size_t pose, const Corner& c) {
    const cv::Point from = frame.at(c.*what.place);
    const cv::Vec2d r = factor * (c.*what.residual);
    cv::arrowedLine(picture, from,
                    {from.x + static_cast<int>(std::lround(r[0])), from.y + static_cast<int>(std::lround(r[1]))},
                    colour_of(pose), 1, cv::LINE_AA, 0, 0.25);
  });
  cv::rectangle(picture, frame.area, kInk);
  write(picture,
        fmt::format("{}: where they are, {:.0f} times as long as in the image", what.name, factor / frame.scale),
        {left, top - 8});
}

void draw_legend(cv::Mat& picture, const CalibrationReport& report, int top) {
  for (std::size_t p = 0; p < report.poses.size(); ++p) {
    const PoseReport& pose = report.poses[p];
    const cv::Point at(kGap, top + 18 * static_cast<int>(p));
    cv::circle(picture, {at.x + 4, at.y - 4}, 4, colour_of(p), cv::FILLED, cv::LINE_AA);
    write(picture,
          pose.reason.empty() ? fmt::format("{}: {} of {} corners used, turned by {:.1f} degrees", pose.name,
                                            pose.used(), pose.corners.size(), pose.angle_deg)
                              : fmt::format("{}: left out, {}", pose.name, pose.reason),
          {at.x + 16, at.y});
  }
}

int legend_height(const CalibrationReport& report) { return 18 * static_cast<int>(report.poses.size()) + kGap; }

}  // namespace

std::string coverage_picture(const CalibrationReport& report) {
  const std::array<Instrument, 2> both = instruments(report);
  const int below = kTitle + tallest(both) + kGap;
  cv::Mat picture(below + legend_height(report), kWidth, CV_8UC3, cv::Scalar::all(255));
  for (std::size_t i = 0; i < both.size(); ++i) {
    const Instrument& what = both[i];
    const Frame frame = frame_of(what, left_of(i), kTitle);
    std::vector<cv::Point> points;
    for_each_used(report, [&](std::size_t, const Corner& c) { points.push_back(frame.at(c.*what.place)); });
    std::vector<cv::Point> hull;
    cv::convexHull(points, hull);
    cv::fillConvexPoly(picture, hull, cv::Scalar(240, 245, 235), cv::LINE_AA);
    for (std::size_t p = 0; p < report.poses.size(); ++p) {
      for (const Corner& corner : report.poses[p].corners) {
        const cv::Point2d place = corner.*what.place;
        if (std::isnan(place.x)) {
          continue;
        }
        if (corner.used && report.poses[p].reason.empty()) {
          cv::circle(picture, frame.at(place), 2, colour_of(p), cv::FILLED, cv::LINE_AA);
        } else {
          cv::drawMarker(picture, frame.at(place), colour_of(p), cv::MARKER_TILTED_CROSS, 7, 1, cv::LINE_AA);
        }
      }
    }
    cv::rectangle(picture, frame.area, kInk);
    write(picture,
          fmt::format("{}: {} x {}, {:.0f} % within the corners' hull", what.name, what.columns, what.rows,
                      100 * what.coverage),
          {frame.area.x, kTitle - 8});
  }
  draw_legend(picture, report, below + 8);
  return png_of(picture);
}

std::string residual_picture(const CalibrationReport& report) {
  const std::array<Instrument, 2> both = instruments(report);
  const int arrows = kTitle + kPanel + kGap + kTitle;
  const int below = arrows + tallest(both) + kGap;
  cv::Mat picture(below + legend_height(report), kWidth, CV_8UC3, cv::Scalar::all(255));
  for (std::size_t i = 0; i < both.size(); ++i) {
    draw_scatter(picture, report, both[i], left_of(i), kTitle);
    draw_arrows(picture, report, both[i], left_of(i), arrows);
  }
  draw_legend(picture, report, below + 8);
  return png_of(picture);
}

}  // namespace selfproj
