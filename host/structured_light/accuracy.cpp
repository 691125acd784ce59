#include "host/structured_light/accuracy.h"

#include <cmath>

#include "host/rig/geometry.h"
#include "host/structured_light/lens_accuracy.h"
#include "host/structured_light/stripe_code.h"

namespace selfproj {
namespace {

// Here rows count from 0, in geometry.h from 1.
double alpha_of(const Rig& rig, double row) { return tan_alpha(rig.camera, row + 1); }

// tan θ of the light that hits the point.
double theta_at(const Rig& rig, const SeenPoint& point) {
  return (rig.projector.x_mm - point.z * alpha_of(rig, point.row)) / (point.z - rig.projector.z_mm);
}

}  // namespace

ErrorTerms error_terms(const Rig& rig, const SeenPoint& point, double delta_xp_mm, double delta_xc_mm) {
  if (!rig.is_pinholes()) {
    return lens_error_terms(rig, point, delta_xp_mm, delta_xc_mm);
  }
  const RigProjector& p = rig.projector;
  const double fc = rig.camera.focal_length_mm;
  const double alpha = alpha_of(rig, point.row);
  const double beta = tan_beta(rig.camera, point.column);
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

double half_pixel_error(const Rig& rig, const SeenPoint& point) {
  const ErrorTerms terms = error_terms(rig, point, 0.5 * rig.projector.line_pitch_mm, 0.5 * rig.camera.pixel_pitch_mm);
  return std::abs(terms.projector.z) + std::abs(terms.camera.z);
}

ErrorTerms approximate_error(const Rig& rig, double delta_xp_mm, double delta_xc_mm) {
  const RigProjector& p = rig.projector;
  const double tilt = std::tan(p.tilt_rad);
  return {{0, 0, p.x_mm * (1 + tilt * tilt) / (p.focal_length_mm * tilt * tilt) * delta_xp_mm},
          {0, 0, -(p.z_mm * tilt + p.x_mm) / (rig.camera.focal_length_mm * tilt * tilt) * delta_xc_mm}};
}

double depth_of_line(const Rig& rig, double row, double line) {
  const double theta = tan_theta(rig.projector, line);
  return (rig.projector.x_mm + rig.projector.z_mm * theta) / (alpha_of(rig, row) + theta);
}

DepthRange range_of_lines(const Rig& rig, const SeenPoint& reference, double below, double above) {
  if (!rig.is_pinholes()) {
    return lens_range_of_lines(rig, reference, below, above);
  }
  const double line = line_of(rig.projector, theta_at(rig, reference));
  return {depth_of_line(rig, reference.row, line + above), depth_of_line(rig, reference.row, line - below)};
}

DepthRange range_of_cells(const Rig& rig, const SeenPoint& reference, int width, int bits, int e) {
  if (!rig.is_pinholes()) {
    return lens_range_of_cells(rig, reference, width, bits, e);
  }
  // The projector line that a camera row sees on the plane z = z_R.
  const auto line_of_row = [&](double row) {
    return line_of(rig.projector,
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

}  // namespace selfproj
