#include "host/production/map_reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "host/files/numbers.h"
#include "host/files/user_error.h"
#include "host/light_section/reference.h"
#include "host/production/section_reference.h"

namespace selfproj {
namespace {

double pixel_mm(const Rig& rig) { return rig.plane_z_mm * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm; }

// The height at a place, of the nearest cell; NaN outside.
float height_at(const HeightCells& cells, double along, double across) {
  const auto row = std::lround(cells.grid.row_of(along));
  const auto column = std::lround(cells.grid.column_of(across));
  const bool there = row >= 0 && column >= 0 && row < cells.height.rows && column < cells.height.columns;
  return there ? cells.height.row(static_cast<int>(row))[column] : kNoValue;
}

cv::Mat1b square(int to_each_side) {
  const int side = 2 * to_each_side + 1;
  return cv::Mat1b(side, side, std::uint8_t{1});
}

}  // namespace

FloatImage without_steep_places(const FloatImage& heights, const Rig& rig) {
  const double pitch = rig.parts.value().grid_mm;
  const cv::Mat1f map(heights.rows, heights.columns, const_cast<float*>(heights.values.data()));  // NOLINT
  // A place without a height is neither a hill nor a hole.
  const cv::Mat there = map == map;  // NOLINT(misc-redundant-expression): NaN differs from itself
  cv::Mat1f low = map.clone();
  cv::Mat1f high = map.clone();
  low.setTo(cv::Scalar(1e9), ~there);
  high.setTo(cv::Scalar(-1e9), ~there);
  cv::erode(low, low, square(1));
  cv::dilate(high, high, square(1));
  cv::Mat steep = (high - low) > 2 * kSteepest * pitch;
  cv::bitwise_and(steep, there, steep);
  cv::dilate(steep, steep, square(static_cast<int>(std::ceil(kBesideWalls * pixel_mm(rig) / pitch))));
  FloatImage result = heights;
  for (int r = 0; r < result.rows; ++r) {
    for (int c = 0; c < result.columns; ++c) {
      if (steep.at<std::uint8_t>(r, c) != 0) {
        result.row(r)[c] = kNoValue;
      }
    }
  }
  return result;
}

std::vector<ToleranceRegion> map_regions(const FloatImage& comparable, const MapGrid& grid, double edge_mm,
                                         double smallest_mm2) {
  cv::Mat1b there(comparable.rows, comparable.columns, std::uint8_t{0});
  for (int r = 0; r < there.rows; ++r) {
    for (int c = 0; c < there.cols; ++c) {
      there(r, c) = std::isnan(comparable.row(r)[c]) ? 0 : UINT8_MAX;
    }
  }
  // Single places without a height are no border.
  cv::morphologyEx(there, there, cv::MORPH_CLOSE, square(1));
  cv::erode(there, there, square(static_cast<int>(std::ceil(edge_mm / grid.pitch_mm))), {-1, -1}, 1,
            cv::BORDER_CONSTANT, cv::Scalar(0));
  std::vector<std::vector<cv::Point>> contours;
  std::vector<cv::Vec4i> places;  // of a contour; the last number is that of the contour around a hole
  cv::findContours(there, contours, places, cv::RETR_CCOMP, cv::CHAIN_APPROX_SIMPLE);
  std::vector<ToleranceRegion> regions;
  for (std::size_t i = 0; i < contours.size(); ++i) {
    std::vector<cv::Point> corners;
    cv::approxPolyDP(contours[i], corners, 1, true);
    constexpr double kLeastAreas = 16;
    const bool hole = places[i][3] >= 0;
    if (corners.size() < 3 || hole ||
        cv::contourArea(corners) * grid.pitch_mm * grid.pitch_mm < kLeastAreas * smallest_mm2) {
      continue;
    }
    ToleranceRegion region;
    region.name = fmt::format("surface {}", regions.size() + 1);
    for (const cv::Point& corner : corners) {
      region.corners_mm.push_back(rounded(grid.along_of(corner.y), 2));
      region.corners_mm.push_back(rounded(grid.across_of(corner.x), 2));
    }
    region.low_mm = -1e6;
    region.high_mm = 1e6;
    region.most_missing = 1;
    regions.push_back(std::move(region));
  }
  return regions;
}

std::vector<double> middle_section(const HeightCells& reference, const Tolerance& outline, double step_mm) {
  std::vector<double> result;
  for (double across = outline.left_mm; across <= outline.right_mm; across += step_mm) {
    result.push_back(rounded(static_cast<double>(height_at(reference, 0.5 * outline.length_mm, across)), 3));
  }
  return result;
}

void check_map_tolerance(const Tolerance& tolerance, const Rig& rig, const HeightCells& reference,
                         const std::string& source) {
  if (tolerance.by_edges) {
    throw UserError(source, "part.place_by is edges; structured light judges parts where they lie: belt");
  }
  const double slack = rig.parts.value().grid_mm;
  const double length = rig.camera.rows * pixel_mm(rig);
  const double across = 0.5 * rig.camera.columns * pixel_mm(rig);
  if (tolerance.left_mm < -across - slack || tolerance.right_mm > across + slack ||
      tolerance.length_mm > length + 2 * slack) {
    throw UserError(
        source,
        fmt::format("its part is {} mm long and from {} to {} mm across; the camera of {} sees {:.1f} "
                    "mm, from {:.1f} to {:.1f}",
                    tolerance.length_mm, tolerance.left_mm, tolerance.right_mm, rig.name, length, -across, across));
  }
  const std::vector<double> here = tolerance.section_step_mm > 0
                                       ? middle_section(reference, tolerance, tolerance.section_step_mm)
                                       : std::vector<double>();
  std::size_t compared = 0;
  std::size_t other = 0;
  const double most = std::max(kOtherPart, 0.01 * rig.plane_z_mm);
  for (std::size_t i = 0; i < std::min(here.size(), tolerance.section_mm.size()); ++i) {
    if (!std::isnan(here[i]) && !std::isnan(tolerance.section_mm[i])) {
      ++compared;
      other += std::abs(here[i] - tolerance.section_mm[i]) > most ? 1 : 0;
    }
  }
  if (2 * other > compared) {
    throw UserError(source, fmt::format("is for another part: in {} of {} places across its middle, the reference is "
                                        "more than {:.3g} mm higher or lower",
                                        other, compared, most));
  }
}

}  // namespace selfproj
