#include "host/structured_light/lens_accuracy.h"

#include <cmath>
#include <opencv2/core.hpp>
#include <optional>

#include "host/rig/geometry.h"
#include "host/rig/optics.h"
#include "host/structured_light/stripe_code.h"

namespace selfproj {
namespace {

const cv::Vec3d kNowhere(kUnknown, kUnknown, kUnknown);

// The point of a camera place at depth z.
cv::Vec3d point_at(const RigOptics& optics, const CameraPlace& place, double z) {
  const std::optional<cv::Vec2d> ray = optics.ray(place);
  return ray ? cv::Vec3d((*ray)[0] * z, (*ray)[1] * z, z) : kNowhere;
}

// The point of a camera place in the light of a line.
cv::Vec3d lit_point(const RigOptics& optics, const CameraPlace& place, double line) {
  const std::optional<cv::Vec2d> ray = optics.ray(place);
  const LightSheet sheet{line, 0, 0.5 * (optics.rig().projector.columns - 1)};
  const std::optional<double> z = ray ? optics.meet(*ray, sheet) : std::nullopt;
  return z ? cv::Vec3d((*ray)[0] * *z, (*ray)[1] * *z, *z) : kNowhere;
}

double line_at(const RigOptics& optics, const cv::Vec3d& point) {
  const std::optional<ProjectorPlace> light = optics.lit_by(point);
  return light ? light->line : kUnknown;
}

PointError error_of(const cv::Vec3d& p) { return {p[0], p[1], p[2]}; }

// The camera row at which the light of the point falls on the plane z = plane_z.
double row_on_plane(const RigOptics& optics, const cv::Vec3d& point, double plane_z) {
  const cv::Vec3d centre = optics.projector_centre();
  const cv::Vec3d on = centre + (point - centre) * ((plane_z - centre[2]) / (point[2] - centre[2]));
  const std::optional<CameraPlace> place = optics.seen(on);
  return place ? place->row : kUnknown;
}

}  // namespace

ErrorTerms lens_error_terms(const Rig& rig, const SeenPoint& point, double delta_xp_mm, double delta_xc_mm) {
  constexpr double kStep = 1e-3;  // lines and rows
  const RigOptics optics(rig);
  const CameraPlace place{point.row, point.column};
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

DepthRange lens_range_of_lines(const Rig& rig, const SeenPoint& reference, double below, double above) {
  const RigOptics optics(rig);
  const CameraPlace place{reference.row, reference.column};
  const double line = line_at(optics, point_at(optics, place, reference.z));
  const double way = optics.lines_rise() ? 1 : -1;
  return {lit_point(optics, place, line + way * above)[2], lit_point(optics, place, line - way * below)[2]};
}

// The end of a cell lies where the light of the pixel's point would fall on the reference at the edge of a camera row.
DepthRange lens_range_of_cells(const Rig& rig, const SeenPoint& reference, int width, int bits, int e) {
  constexpr int kSteps = 50;
  constexpr double kStep = 1e-3;
  const RigOptics optics(rig);
  const CameraPlace place{reference.row, reference.column};
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

}  // namespace selfproj
