#include "host/production/part_reference.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "host/production/height_map.h"
#include "host/rig/geometry.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/model/column_moments.h"

namespace selfproj::production {
namespace {

cv::Mat1b square(int to_each_side) {
  const int side = 2 * to_each_side + 1;
  return cv::Mat1b(side, side, std::uint8_t{1});
}

}  // namespace

double SectionReference::at(double across, double widest_mm) const {
  const auto after = std::upper_bound(across_mm.begin(), across_mm.end(), across);
  if (after == across_mm.begin() || after == across_mm.end()) {
    return rig::kUnknown;
  }
  const auto i = static_cast<std::size_t>(after - across_mm.begin());
  const double width = across_mm[i] - across_mm[i - 1];
  const double rise = height_mm[i] - height_mm[i - 1];
  if (width > widest_mm || std::abs(rise) > light_section::kSteepest * width) {
    return rig::kUnknown;
  }
  return height_mm[i - 1] + rise * (across - across_mm[i - 1]) / width;
}

std::vector<std::pair<double, double>> SectionReference::jumps(const rig::Rig& rig, double widest_mm) const {
  std::vector<std::pair<double, double>> jumps;
  if (rig.light_plane) {
    return jumps;
  }
  const double beside = light_section::kBesideWalls * pixel_mm(rig);
  for (std::size_t i = 1; i < across_mm.size(); ++i) {
    if (std::isnan(at(0.5 * (across_mm[i - 1] + across_mm[i]), widest_mm))) {
      jumps.emplace_back(across_mm[i - 1] - beside, across_mm[i] + beside);
    }
  }
  return jumps;
}

SectionReference section_of(const rig::Rig& rig, const light_section::ReferenceProfile& reference,
                            const light_section::DifferentialProfiler& profiler) {
  constexpr double kLight = 1 << 20;  // M0: fine enough for a thousandth of a row and below 2^31 as M1
  const int columns = profiler.columns();
  model::Moments moments;
  moments.resize(columns);
  for (std::size_t i = 0; i < static_cast<std::size_t>(columns); ++i) {
    const double row = rig::middle_row(rig.camera) + reference.offset_px[i];
    if (reference.valid[i] == 0 || !(row > 0)) {
      continue;
    }
    moments.m0[i] = static_cast<std::uint32_t>(kLight);
    moments.m1[i] = static_cast<std::uint32_t>(std::lround(kLight * row));
    moments.n[i] = static_cast<std::uint32_t>(rig.measure.min_lit_px);
  }
  light_section::Profile profile;
  profile.resize(columns);
  profiler.profile(moments.view(), profile.view());
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < static_cast<std::size_t>(columns); ++i) {
    if (profile.validity[i] == static_cast<std::uint8_t>(light_section::Validity::valid)) {
      order.push_back(i);
    }
  }
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return profile.y[a] < profile.y[b]; });
  SectionReference section;
  for (const std::size_t i : order) {
    section.across_mm.push_back(static_cast<double>(profile.y[i]));
    section.height_mm.push_back(rig.plane_z_mm - static_cast<double>(profile.z[i]));
  }
  return section;
}

images::FloatImage without_steep_places(const images::FloatImage& heights, const rig::Rig& rig) {
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
  cv::Mat steep = (high - low) > 2 * light_section::kSteepest * pitch;
  cv::bitwise_and(steep, there, steep);
  cv::dilate(steep, steep, square(static_cast<int>(std::ceil(light_section::kBesideWalls * pixel_mm(rig) / pitch))));
  images::FloatImage result = heights;
  for (int r = 0; r < result.rows; ++r) {
    for (int c = 0; c < result.columns; ++c) {
      if (steep.at<std::uint8_t>(r, c) != 0) {
        result.row(r)[c] = images::kNoValue;
      }
    }
  }
  return result;
}

}  // namespace selfproj::production
