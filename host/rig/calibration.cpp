#include "selfproj/rig/calibration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <stdexcept>
#include <utility>

namespace selfproj::rig {

cv::Vec2d Lens::pixel(const cv::Vec2d& ray) const {
  cv::Matx22d unused;
  return pixel(ray, unused);
}

cv::Vec2d Lens::pixel(const cv::Vec2d& ray, cv::Matx22d& derivative) const {
  const auto [k1, k2, p1, p2, k3, k4, k5, k6] = k;
  const double x = ray[0];
  const double y = ray[1];
  const double s = x * x + y * y;
  const double above = 1 + s * (k1 + s * (k2 + s * k3));
  const double below = 1 + s * (k4 + s * (k5 + s * k6));
  const double q = above / below;
  // dq/ds
  const double slope = ((k1 + s * (2 * k2 + s * 3 * k3)) - q * (k4 + s * (2 * k5 + s * 3 * k6))) / below;
  const double across = 2 * x * y * slope + 2 * p1 * x + 2 * p2 * y;
  derivative = {fx * (q + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x), fx * across,  //
                fy * across, fy * (q + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x)};
  return {fx * (x * q + 2 * p1 * x * y + p2 * (s + 2 * x * x)) + cx,
          fy * (y * q + p1 * (s + 2 * y * y) + 2 * p2 * x * y) + cy};
}

std::optional<cv::Vec2d> Lens::ray(const cv::Vec2d& pixel) const {
  constexpr int kSteps = 30;
  constexpr double kClose = 1e-9;  // pixels
  cv::Vec2d ray((pixel[0] - cx) / fx, (pixel[1] - cy) / fy);
  for (int step = 0; step < kSteps; ++step) {
    cv::Matx22d derivative;
    const cv::Vec2d off = this->pixel(ray, derivative) - pixel;
    // Beyond the place where the image folds over, another ray falls on the same pixel; a real lens has none there.
    if (!(cv::determinant(derivative) * fx * fy > 0)) {
      return std::nullopt;
    }
    if (std::abs(off[0]) + std::abs(off[1]) < kClose) {
      return ray;
    }
    ray -= derivative.inv() * off;
  }
  return std::nullopt;
}

namespace {

Lens lens_of(const RigLens& l) { return {l.fx_px, l.fy_px, l.cx_px, l.cy_px, {l.k1, l.k2, l.p1, l.p2, l.k3, 0, 0, 0}}; }

RigLens rig_lens_of(const Lens& l) {
  if (std::any_of(l.k.begin() + 5, l.k.end(), [](double k) { return k != 0; })) {
    throw std::invalid_argument("a rig has no rational distortion (k4, k5, k6)");
  }
  return {l.fx, l.fy, l.cx, l.cy, l.k[0], l.k[1], l.k[2], l.k[3], l.k[4]};
}

Lens exchanged(const Lens& l) {
  Lens result{l.fy, l.fx, l.cy, l.cx, l.k};
  std::swap(result.k[2], result.k[3]);  // p1, p2
  return result;
}

// Rodrigues' formula.
cv::Matx33d matrix_of(const std::array<double, 3>& r) {
  const double angle = std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
  const cv::Matx33d cross(0, -r[2], r[1], r[2], 0, -r[0], -r[1], r[0], 0);
  const double a = angle > 0 ? std::sin(angle) / angle : 1;
  const double b = angle > 0 ? (1 - std::cos(angle)) / (angle * angle) : 0.5;
  return cv::Matx33d::eye() + a * cross + b * (cross * cross);
}

// Through the quaternion (w, v), v = axis sin(angle/2), from the column of 4 q q^T with the greatest diagonal entry.
std::array<double, 3> vector_of(const cv::Matx33d& m) {
  const cv::Matx44d squares(1 + m(0, 0) + m(1, 1) + m(2, 2), m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1),
                            m(2, 1) - m(1, 2), 1 + m(0, 0) - m(1, 1) - m(2, 2), m(0, 1) + m(1, 0), m(0, 2) + m(2, 0),
                            m(0, 2) - m(2, 0), m(0, 1) + m(1, 0), 1 - m(0, 0) + m(1, 1) - m(2, 2), m(1, 2) + m(2, 1),
                            m(1, 0) - m(0, 1), m(0, 2) + m(2, 0), m(1, 2) + m(2, 1), 1 - m(0, 0) - m(1, 1) + m(2, 2));
  int greatest = 0;
  for (int i = 1; i < 4; ++i) {
    greatest = squares(i, i) > squares(greatest, greatest) ? i : greatest;
  }
  cv::Vec4d q = cv::normalize(cv::Vec4d(squares.col(greatest).val));
  q *= q[0] < 0 ? -1 : 1;
  const double sine = std::sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const double scale = sine > 0 ? 2 * std::atan2(sine, q[0]) / sine : 2;
  return {scale * q[1], scale * q[2], scale * q[3]};
}

}  // namespace

Calibration calibration_of(const Rig& rig) {
  const RigCamera& camera = rig.camera;
  const RigProjector& projector = rig.projector;
  Calibration result;
  result.camera_columns = camera.columns;
  result.camera_rows = camera.rows;
  result.projector_columns = projector.columns;
  result.projector_rows = projector.lines;
  if (rig.calibration) {
    result.camera = lens_of(rig.calibration->camera);
    result.projector = lens_of(rig.calibration->projector);
    result.rotation = matrix_of(rig.calibration->rotation_rad);
    const std::array<double, 3>& t = rig.calibration->translation_mm;
    result.translation = {t[0], t[1], t[2]};
    return result;
  }
  const double focal = camera.focal_length_mm / camera.pixel_pitch_mm;
  result.camera = {focal, focal, 0.5 * (camera.columns - 1), 0.5 * (camera.rows - 1), {}};
  result.projector = {projector.focal_length_mm / projector.column_pitch_mm,
                      -projector.focal_length_mm / projector.line_pitch_mm,
                      0.5 * (projector.columns - 1) - projector.center_yp_mm / projector.column_pitch_mm,
                      0.5 * (projector.lines - 1) - projector.center_xp_mm / projector.line_pitch_mm,
                      {}};
  // The projector's axis is (0, -sin, cos) in these axes; Yp is x, and Xp runs against the second row.
  const double sine = std::sin(projector.tilt_rad);
  const double cosine = std::cos(projector.tilt_rad);
  result.rotation = {1, 0, 0, 0, cosine, sine, 0, -sine, cosine};
  result.translation = -(result.rotation * cv::Vec3d(0, projector.x_mm, projector.z_mm));
  return result;
}

Calibration with_axes_exchanged(const Calibration& c) {
  const cv::Matx33d swap(0, 1, 0, 1, 0, 0, 0, 0, 1);
  return {exchanged(c.camera), exchanged(c.projector), swap * c.rotation * swap, swap * c.translation,
          c.camera_rows,       c.camera_columns,       c.projector_rows,         c.projector_columns};
}

Rig rig_of(const Calibration& c, const Rig& like) {
  if (c.camera_rows == 0 || c.projector_rows == 0) {
    throw std::invalid_argument("the calibration does not say the sizes of its images");
  }
  constexpr double kAlong = 0.7;  // least cosine between the projector's and the camera's columns
  const double along = c.rotation(0, 0);
  if (std::abs(along) < kAlong) {
    throw std::invalid_argument(
        "the projector's columns do not lie along the camera's; turn one of them by 90 degrees");
  }
  const cv::Vec3d centre = -(c.rotation.t() * c.translation);
  if (!(centre[1] > std::abs(centre[0]))) {
    throw std::invalid_argument(
        "a rig's projector stands beside the camera in the direction of growing image rows, and this one does not; "
        "turn "
        "the camera");
  }
  Rig rig = like;
  rig.camera.rows = c.camera_rows;
  rig.camera.columns = c.camera_columns;
  rig.camera.focal_length_mm = 0.5 * (c.camera.fx + c.camera.fy) * rig.camera.pixel_pitch_mm;
  RigProjector& projector = rig.projector;
  projector.lines = c.projector_rows;
  projector.columns = c.projector_columns;
  projector.x_mm = centre[1];
  projector.z_mm = centre[2];
  projector.tilt_rad = std::atan2(-c.rotation(2, 1), c.rotation(2, 2));
  const double side = along > 0 ? 1 : -1;
  projector.line_pitch_mm = -side * projector.focal_length_mm / c.projector.fy;
  projector.column_pitch_mm = side * projector.focal_length_mm / c.projector.fx;
  projector.center_xp_mm = (0.5 * (projector.lines - 1) - c.projector.cy) * projector.line_pitch_mm;
  projector.center_yp_mm = (0.5 * (projector.columns - 1) - c.projector.cx) * projector.column_pitch_mm;
  rig.calibration = RigCalibration{rig_lens_of(c.camera),
                                   rig_lens_of(c.projector),
                                   vector_of(c.rotation),
                                   {c.translation[0], c.translation[1], c.translation[2]}};
  return rig;
}

double pinhole_error(const Rig& rig, double z_mm) {
  constexpr int kGrid = 9;
  const Calibration full = calibration_of(rig);
  Rig flat = rig;
  flat.calibration.reset();
  const Calibration pinholes = calibration_of(flat);
  double greatest = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < kGrid * kGrid; ++i) {
    const cv::Vec2d pixel((full.camera_columns - 1) * (i % kGrid) / (kGrid - 1.0),
                          (full.camera_rows - 1) * (i / kGrid) / (kGrid - 1.0));  // NOLINT: whole rows of the grid
    const std::optional<cv::Vec2d> ray = full.camera.ray(pixel);
    if (!ray) {
      continue;
    }
    const cv::Vec3d at = full.rotation * (z_mm * cv::Vec3d((*ray)[0], (*ray)[1], 1)) + full.translation;
    if (!(at[2] > 0)) {
      continue;
    }
    const cv::Vec2d seen = full.projector.pixel({at[0] / at[2], at[1] / at[2]});
    const bool inside = seen[0] > -0.5 && seen[0] < full.projector_columns - 0.5 && seen[1] > -0.5 &&
                        seen[1] < full.projector_rows - 0.5;
    if (!inside) {
      continue;
    }
    // z of the pinholes' ray in the plane of the line; y' = flat z holds for both.
    const double line = (seen[1] - pinholes.projector.cy) / pinholes.projector.fy;
    const cv::Vec3d direction((pixel[0] - pinholes.camera.cx) / pinholes.camera.fx,
                              (pixel[1] - pinholes.camera.cy) / pinholes.camera.fy, 1);
    const cv::Vec3d turned = pinholes.rotation * direction;
    const double z = (line * pinholes.translation[2] - pinholes.translation[1]) / (turned[1] - line * turned[2]);
    greatest = std::isnan(greatest) ? std::abs(z - z_mm) : std::max(greatest, std::abs(z - z_mm));
  }
  return greatest;
}

double coded_height(int lines, int bits) { return std::max<double>(lines, std::ldexp(1.0, bits)); }

CodedLines central_lines(const Rig& rig, int count, int bits) {
  return {0.5 * (rig.projector.lines - count), coded_height(count, bits)};
}

DepthMatrices depth_matrices(const Rig& rig, int bits, const CodedLines& lines) {
  const RigCamera& camera = rig.camera;
  const RigProjector& projector = rig.projector;
  const double focal = camera.focal_length_mm / camera.pixel_pitch_mm;
  // Column <-> y, row <-> x (3.3).
  const cv::Matx34d camera_matrix(0, focal, 0.5 * (camera.columns - 1), 0,  //
                                  focal, 0, 0.5 * (camera.rows - 1), 0,     //
                                  0, 0, 1, 0);
  // Depth along the projector's axis and offset across it, of (x, y, z, 1): Xp = fp side / depth.
  const double sine = std::sin(projector.tilt_rad);
  const double cosine = std::cos(projector.tilt_rad);
  const cv::Vec4d depth(-sine, 0, cosine, sine * projector.x_mm - cosine * projector.z_mm);
  const cv::Vec4d side(-cosine, 0, -sine, cosine * projector.x_mm + sine * projector.z_mm);
  // C = (line - F + 1/2) 2^m / L with line = (H - 1)/2 + (Xp - center)/pitch.
  const double codes_per_line =
      std::ldexp(1.0, bits) / (lines.count > 0 ? lines.count : coded_height(projector.lines, bits));
  const cv::Vec4d code =
      codes_per_line *
      ((0.5 * projector.lines - lines.first - projector.center_xp_mm / projector.line_pitch_mm) * depth +
       (projector.focal_length_mm / projector.line_pitch_mm) * side);
  return {camera_matrix, {code[0], code[1], code[2], code[3], depth[0], depth[1], depth[2], depth[3]}};
}

DepthMatrices depth_matrices(const Calibration& c, CodedAxis axis) {
  const auto projected = [&](double focal, double centre, int i) {
    cv::Vec4d row;
    for (int k = 0; k < 3; ++k) {
      row[k] = focal * c.rotation(i, k) + centre * c.rotation(2, k);
    }
    row[3] = focal * c.translation[i] + centre * c.translation[2];
    return row;
  };
  const cv::Vec4d code = axis == CodedAxis::rows ? projected(c.projector.fy, c.projector.cy + 0.5, 1)
                                                 : projected(c.projector.fx, c.projector.cx + 0.5, 0);
  const cv::Vec4d depth = projected(0, 1, 0);
  return {{c.camera.fx, 0, c.camera.cx, 0, 0, c.camera.fy, c.camera.cy, 0, 0, 0, 1, 0},
          {code[0], code[1], code[2], code[3], depth[0], depth[1], depth[2], depth[3]}};
}

}  // namespace selfproj::rig
