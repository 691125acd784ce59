#include "host/calibration/calibrated_rig.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <vector>

#include "host/rig/optics.h"
#include "host/rig/rig_calibration.h"

namespace selfproj {
namespace {

// Twice what a projector line is worth in z in the middle of the camera's image, at this distance.
double coarse(const Rig& rig, double distance_mm) {
  const RigOptics optics(rig);
  const auto ray = optics.ray({0.5 * (rig.camera.rows - 1), 0.5 * (rig.camera.columns - 1)});
  const double way = ray ? 2 * optics.z_per_line(*ray, distance_mm) : 0;
  return std::isfinite(way) ? way : 0;
}

// What a rig says of distance and focal length. A camera that the rig only draws may have the focal length that is
// printed on its lens; focused on the belt, the image lies a little further behind the lens than that.
DrawnScale scale_of(const Rig& rig, double focal_px, DrawnScale scale) {
  const double focal_mm = rig.camera.focal_length_mm;
  scale.distance_mm = rig.plane_z_mm;
  scale.least_focal_px = scale.most_focal_px = focal_px;
  if (!rig.calibration && rig.plane_z_mm > 2 * focal_mm) {
    scale.most_focal_px *= rig.plane_z_mm / (rig.plane_z_mm - focal_mm);
  }
  return scale;
}

}  // namespace

Plates plates_over(const Rig& rig, const Chessboard& chessboard, const std::vector<double>& heights_mm,
                   const std::vector<double>& belt_mm, const PlateTolerance& tolerance, const DrawnScale& tolerances) {
  const double side = chessboard.square_mm * (std::max(chessboard.columns, chessboard.rows) - 1);
  Plates plates(heights_mm, belt_mm, tolerance, side);
  const Calibration drawn = calibration_of(rig);
  const auto lens_of = [](const Lens& l) { return LensParameters{l.fx, l.fy, l.cx, l.cy}; };
  plates.camera = lens_of(drawn.camera);
  plates.projector = lens_of(drawn.projector);
  cv::Rodrigues(drawn.rotation, plates.stereo.rotation);
  plates.stereo.translation = drawn.translation;
  plates.scale = scale_of(rig, drawn.camera.fx, tolerances);
  return plates;
}

Rig calibrated_rig(const CalibrationReport& report, const Rig& drawn) {
  Rig rig = rig_of(report.calibration, drawn);
  if (report.belt) {
    if (report.belt->moved) {
      rig.belt_pose = report.belt->pose;
    }
    rig.plane_z_mm = report.belt->plane_z_mm;
  }
  if (rig.kind == RigKind::scanner) {
    // The limit of the drawn rig may be that of a much finer one.
    rig.measure.max_z_per_line_mm = std::max(rig.measure.max_z_per_line_mm, coarse(rig, report.mean_distance_mm));
  }
  return rig;
}

}  // namespace selfproj
