#include "host/structured_light/lens_triangulation.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <stdexcept>
#include <string>

#include "host/images/float_image.h"
#include "host/rig/calibration_file.h"
#include "host/rig/rig_calibration.h"
#include "host/structured_light/check.h"
#include "host/structured_light/triangulation.h"
#include "model/gray_decoder.h"

namespace selfproj {
LensTriangulation::LensTriangulation(const Calibration& calibration, const LensSettings& settings)
    : Triangulation(settings.rows, settings.columns, settings.bits),
      calibration_(settings.rows_are_x ? with_axes_exchanged(calibration) : calibration),
      settings_(settings) {
  check(settings.row_bits >= 0 && settings.row_bits <= GrayDecoder::kMaxBits, "triangulation: row bits out of range");
  if (settings_.lines <= 0) {
    settings_.lines = std::ldexp(1.0, settings.bits);
  }
  if (settings_.row_lines <= 0) {
    settings_.row_lines = std::ldexp(1.0, settings.row_bits);
  }
  set_origin({0, 0, 0});
  std::size_t i = 0;
  for (int r = 0; r < settings.rows; ++r) {
    for (int c = 0; c < settings.columns; ++c, ++i) {
      const std::optional<cv::Vec2d> ray =
          calibration_.camera.ray(settings.rows_are_x ? cv::Vec2d(r, c) : cv::Vec2d(c, r));
      if (!ray) {
        throw std::invalid_argument("triangulation: the camera's distortion cannot be undone at column " +
                                    std::to_string(c) + ", row " + std::to_string(r));
      }
      set_ray(i, {(*ray)[0], (*ray)[1], 1});
    }
  }
  // The direction in which the projector column moves with z along the middle ray: from the column of the camera's own
  // centre towards that of the point at infinity. Undistorted: d/dz of (A_x z + T_x)/(A_z z + T_z).
  const std::size_t middle =
      (static_cast<std::size_t>(settings.rows) / 2) * static_cast<std::size_t>(settings.columns) +
      static_cast<std::size_t>(settings.columns) / 2;
  const Point3f one = point(middle, 1);
  const cv::Vec3d a = calibration_.rotation * cv::Vec3d(static_cast<double>(one.x), static_cast<double>(one.y), 1);
  const cv::Vec3d& t = calibration_.translation;
  sign_ = (a[0] * t[2] - t[0] * a[2]) * calibration_.projector.fx < 0 ? -1 : 1;
}

cv::Vec2d LensTriangulation::image(const cv::Vec3d& ray, double z, cv::Vec2d& derivative) const {
  const cv::Vec3d at = ray * z + calibration_.translation;
  const cv::Vec2d flat(at[0] / at[2], at[1] / at[2]);
  cv::Matx22d lens;
  const cv::Vec2d pixel = calibration_.projector.pixel(flat, lens);
  derivative = lens * (cv::Vec2d(ray[0] - flat[0] * ray[2], ray[1] - flat[1] * ray[2]) * (1 / at[2]));
  return pixel;
}

LensTriangulation::Found LensTriangulation::solve(std::size_t pixel, std::uint16_t code,
                                                  const std::uint16_t* row_code) const {
  constexpr int kSteps = 20;
  constexpr double kClose = 1e-7;  // mm
  Found found;
  const auto fails = [&found](PointState state) {
    found.state = state;
    return found;
  };
  const bool measurable =
      (code & GrayDecoder::kMeasurable) != 0 && (row_code == nullptr || (*row_code & GrayDecoder::kMeasurable) != 0);
  if (!measurable) {
    return fails(PointState::not_measurable);
  }
  const Lens& lens = calibration_.projector;
  const double column = ((code & GrayDecoder::kCode) + 0.5) * std::ldexp(settings_.lines, -settings_.bits) - 0.5;
  double row = lens.cy;
  if (row_code != nullptr) {
    row = ((*row_code & GrayDecoder::kCode) + 0.5) * std::ldexp(settings_.row_lines, -settings_.row_bits) - 0.5;
  }
  const bool on = (calibration_.projector_columns == 0 || column <= calibration_.projector_columns - 0.5) &&
                  (row_code == nullptr || calibration_.projector_rows == 0 || row <= calibration_.projector_rows - 0.5);
  if (!on) {
    return fails(PointState::no_line);
  }
  const Point3f one = point(pixel, 1);
  const cv::Vec3d ray = calibration_.rotation * cv::Vec3d(static_cast<double>(one.x), static_cast<double>(one.y), 1);
  const cv::Vec3d& t = calibration_.translation;
  // A first z from the plane of the column at this row.
  const std::optional<cv::Vec2d> flat = lens.ray({column, row});
  if (!flat) {
    return fails(PointState::no_intersection);
  }
  double z = ((*flat)[0] * t[2] - t[0]) / (ray[0] - (*flat)[0] * ray[2]);
  cv::Vec2d slope;
  cv::Vec2d off;
  bool converged = false;
  for (int step = 0; step < kSteps && !converged; ++step) {
    if (!(z > 0 && ray[2] * z + t[2] > 0)) {
      return fails(PointState::no_intersection);
    }
    off = image(ray, z, slope) - cv::Vec2d(column, row);
    const double change = row_code == nullptr ? off[0] / slope[0] : off.dot(slope) / slope.dot(slope);
    z -= change;
    converged = std::abs(change) < kClose;
  }
  if (!converged || !(z > 0 && ray[2] * z + t[2] > 0) || !(slope[0] * sign_ > 0)) {
    return fails(PointState::no_intersection);
  }
  found.z = z;
  found.residual = row_code == nullptr ? 0 : std::hypot(off[0], off[1]);
  const DepthLimits& limits = settings_.limits;
  if (!(1 < limits.max_z_per_line_mm * std::abs(slope[0]))) {
    return fails(PointState::too_coarse);
  }
  if (!(z > limits.min_z_mm && z < limits.max_z_mm)) {
    return fails(PointState::out_of_range);
  }
  if (found.residual > settings_.max_residual_px) {
    return fails(PointState::off_line);
  }
  return found;
}

void LensTriangulation::depth(const std::uint16_t* codes, float* z) const {
  for (std::size_t i = 0; i < pixels(); ++i) {
    const Found found = solve(i, codes[i], nullptr);
    z[i] = found.state == PointState::valid ? static_cast<float>(found.z) : kNoValue;
  }
}

void LensTriangulation::explain(const std::uint16_t* codes, const float* /*z*/, PointState* states) const {
  for (std::size_t i = 0; i < pixels(); ++i) {
    states[i] = solve(i, codes[i], nullptr).state;
  }
}

double LensTriangulation::rounding_error(std::size_t pixel, float z) const {
  const Point3f one = point(pixel, 1);
  const cv::Vec3d ray = calibration_.rotation * cv::Vec3d(static_cast<double>(one.x), static_cast<double>(one.y), 1);
  cv::Vec2d slope;
  (void)image(ray, static_cast<double>(z), slope);
  const double columns = std::ldexp(settings_.lines, -settings_.bits) / std::sqrt(12.0);
  if (settings_.row_bits == 0) {
    return std::abs(columns / slope[0]);
  }
  const double rows = std::ldexp(settings_.row_lines, -settings_.row_bits) / std::sqrt(12.0);
  return std::hypot(slope[0] * columns, slope[1] * rows) / slope.dot(slope);
}

void LensTriangulation::depth_of_both(const std::uint16_t* codes, const std::uint16_t* row_codes, float* z,
                                      PointState* states, float* residual_px) const {
  for (std::size_t i = 0; i < pixels(); ++i) {
    const Found found = solve(i, codes[i], row_codes + i);
    const bool valid = found.state == PointState::valid;
    z[i] = valid ? static_cast<float>(found.z) : kNoValue;
    if (states != nullptr) {
      states[i] = found.state;
    }
    if (residual_px != nullptr) {
      residual_px[i] = valid ? static_cast<float>(found.residual) : kNoValue;
    }
  }
}

}  // namespace selfproj
