#include "host/structured_light/accuracy.h"

#include <cmath>
#include <opencv2/core.hpp>
#include <optional>

#include "host/rig/geometry.h"
#include "host/structured_light/self_reference.h"
#include "selfproj/rig/optics.h"

namespace selfproj::structured_light {
namespace {

const cv::Vec3d kNowhere(rig::kUnknown, rig::kUnknown, rig::kUnknown);

// The point of a camera place at depth z.
cv::Vec3d point_at(const rig::RigOptics& optics, const rig::CameraPlace& place, double z) {
  const std::optional<cv::Vec2d> ray = optics.ray(place);
  return ray ? cv::Vec3d((*ray)[0] * z, (*ray)[1] * z, z) : kNowhere;
}

// The point of a camera place in the light of a line.
cv::Vec3d lit_point(const rig::RigOptics& optics, const rig::CameraPlace& place, double line) {
  const std::optional<cv::Vec2d> ray = optics.ray(place);
  const rig::LightSheet sheet{line, 0, 0.5 * (optics.rig().projector.columns - 1)};
  const std::optional<double> z = ray ? optics.meet(*ray, sheet) : std::nullopt;
  return z ? cv::Vec3d((*ray)[0] * *z, (*ray)[1] * *z, *z) : kNowhere;
}

double line_at(const rig::RigOptics& optics, const cv::Vec3d& point) {
  const std::optional<rig::ProjectorPlace> light = optics.lit_by(point);
  return light ? light->line : rig::kUnknown;
}

PointError error_of(const cv::Vec3d& p) { return {p[0], p[1], p[2]}; }

// The camera row at which the light of the point falls on the plane z = plane_z.
double row_on_plane(const rig::RigOptics& optics, const cv::Vec3d& point, double plane_z) {
  const cv::Vec3d centre = optics.projector_centre();
  const cv::Vec3d on = centre + (point - centre) * ((plane_z - centre[2]) / (point[2] - centre[2]));
  const std::optional<rig::CameraPlace> place = optics.seen(on);
  return place ? place->row : rig::kUnknown;
}

ErrorTerms lens_error_terms(const rig::Rig& rig, const CameraPoint& point, double delta_xp_mm, double delta_xc_mm) {
  constexpr double kStep = 1e-3;  // lines and rows
  const rig::RigOptics optics(rig);
  const rig::CameraPlace place{point.row, point.column};
  const double line = line_at(optics, point_at(optics, place, point.z));
  const double lines = delta_xp_mm / rig.projector.line_pitch_mm;
  const double rows = delta_xc_mm / rig.camera.pixel_pitch_mm;
  const cv::Vec3d by_line =
      (lit_point(optics, place, line + kStep) - lit_point(optics, place, line - kStep)) / (2 * kStep);
  const cv::Vec3d by_row = (lit_point(optics, {place.row + kStep, place.column}, line) -
                            lit_point(optics, {place.row - kStep, place.column}, line)) /
                           (2 * kStep);
  return {error_of(by_line * lines), error_of(by_row * rows)};
}

DepthRange lens_range_of_lines(const rig::Rig& rig, const CameraPoint& reference, double below, double above) {
  const rig::RigOptics optics(rig);
  const rig::CameraPlace place{reference.row, reference.column};
  const double line = line_at(optics, point_at(optics, place, reference.z));
  const double way = optics.lines_rise() ? 1 : -1;
  return {lit_point(optics, place, line + way * above)[2], lit_point(optics, place, line - way * below)[2]};
}

// The end of a cell lies where the light of the pixel's point would fall on the reference at the edge of a camera row.
DepthRange lens_range_of_cells(const rig::Rig& rig, const CameraPoint& reference, int width, int bits, int e) {
  constexpr int kSteps = 50;
  constexpr double kStep = 1e-3;
  const rig::RigOptics optics(rig);
  const rig::CameraPlace place{reference.row, reference.column};
  const double middle = 0.5 * (rig.camera.rows - 1);
  const int own = cell_of_row(reference.row, rig.camera.rows, width);
  const auto depth_of_cell = [&](int cell) {  // at its first edge
    const double row = middle + static_cast<double>(cell) * width;
    double z = reference.z;
    for (int i = 0; i < kSteps; ++i) {
      const double off = row_on_plane(optics, point_at(optics, place, z), reference.z) - row;
      const double next = row_on_plane(optics, point_at(optics, place, z + kStep), reference.z) - row;
      const double change = off * kStep / (next - off);
      z -= change;
      if (!(std::abs(change) > 1e-9)) {
        break;
      }
    }
    return z;
  };
  const int codes = 1 << bits;
  return {depth_of_cell(own - (codes - e - 1)), depth_of_cell(own + e + 1)};
}

// Here rows count from 0, in geometry.h from 1.
double alpha_of(const rig::Rig& rig, double row) { return rig::tan_alpha(rig.camera, row + 1); }

// tan θ of the light that hits the point.
double theta_at(const rig::Rig& rig, const CameraPoint& point) {
  return (rig.projector.x_mm - point.z * alpha_of(rig, point.row)) / (point.z - rig.projector.z_mm);
}

}  // namespace

ErrorTerms error_terms(const rig::Rig& rig, const CameraPoint& point, double delta_xp_mm, double delta_xc_mm) {
  if (!rig.is_pinholes()) {
    return lens_error_terms(rig, point, delta_xp_mm, delta_xc_mm);
  }
  const rig::RigProjector& p = rig.projector;
  const double fc = rig.camera.focal_length_mm;
  const double alpha = alpha_of(rig, point.row);
  const double beta = rig::tan_beta(rig.camera, point.column);
  const double theta = theta_at(rig, point);
  const double tilt = std::tan(p.tilt_rad);
  const double xp = p.focal_length_mm * std::tan(std::atan(theta) - p.tilt_rad);
  const double sum = (alpha + theta) * (alpha + theta);
  const double along = p.focal_length_mm - xp * tilt;
  const double projector =
      p.focal_length_mm * (1 + tilt * tilt) * (p.z_mm * alpha - p.x_mm) / (along * along * sum) * delta_xp_mm;
  const double camera = (p.z_mm * theta + p.x_mm) / (fc * sum) * delta_xc_mm;
  return {{alpha * projector, beta * projector, projector}, {theta * camera, -beta * camera, -camera}};
}

double half_pixel_error(const rig::Rig& rig, const CameraPoint& point) {
  const ErrorTerms terms = error_terms(rig, point, 0.5 * rig.projector.line_pitch_mm, 0.5 * rig.camera.pixel_pitch_mm);
  return std::abs(terms.projector.z) + std::abs(terms.camera.z);
}

ErrorTerms approximate_error(const rig::Rig& rig, double delta_xp_mm, double delta_xc_mm) {
  const rig::RigProjector& p = rig.projector;
  const double tilt = std::tan(p.tilt_rad);
  return {{0, 0, p.x_mm * (1 + tilt * tilt) / (p.focal_length_mm * tilt * tilt) * delta_xp_mm},
          {0, 0, -(p.z_mm * tilt + p.x_mm) / (rig.camera.focal_length_mm * tilt * tilt) * delta_xc_mm}};
}

double depth_of_line(const rig::Rig& rig, double row, double line) {
  const double theta = rig::tan_theta(rig.projector, line);
  return (rig.projector.x_mm + rig.projector.z_mm * theta) / (alpha_of(rig, row) + theta);
}

DepthRange range_of_lines(const rig::Rig& rig, const CameraPoint& reference, double below, double above) {
  if (!rig.is_pinholes()) {
    return lens_range_of_lines(rig, reference, below, above);
  }
  const double line = rig::line_of(rig.projector, theta_at(rig, reference));
  return {depth_of_line(rig, reference.row, line + above), depth_of_line(rig, reference.row, line - below)};
}

DepthRange range_of_cells(const rig::Rig& rig, const CameraPoint& reference, int width, int bits, int e) {
  if (!rig.is_pinholes()) {
    return lens_range_of_cells(rig, reference, width, bits, e);
  }
  // The projector line that a camera row sees on the plane z = z_R.
  const auto line_of_row = [&](double row) {
    return rig::line_of(rig.projector,
                        (rig.projector.x_mm - reference.z * alpha_of(rig, row)) / (reference.z - rig.projector.z_mm));
  };
  const double middle = 0.5 * (rig.camera.rows - 1);
  const int own = cell_of_row(reference.row, rig.camera.rows, width);
  const auto row_of_cell = [&](int cell) { return middle + static_cast<double>(cell) * width; };  // its first edge
  const int codes = 1 << bits;
  // n grows as the row of the cell falls.
  const double upper = line_of_row(row_of_cell(own - (codes - e - 1)));
  const double lower = line_of_row(row_of_cell(own + e + 1));
  return {depth_of_line(rig, reference.row, upper), depth_of_line(rig, reference.row, lower)};
}

}  // namespace selfproj::structured_light
