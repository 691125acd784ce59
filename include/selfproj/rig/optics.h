// The whole geometry of a rig: lenses of camera and projector, any pose between them, a laser's plane, the pose of the
// belt, corrected heights. Axes are those of include/selfproj/rig/rig.h, with the origin in the camera's centre: x
// along camera rows and y along columns, or along and across the belt if the rig has a belt_pose. Rows, columns and
// lines count from 0; lengths are in mm.
#ifndef SELFPROJ_RIG_OPTICS_H
#define SELFPROJ_RIG_OPTICS_H

#include <opencv2/core/matx.hpp>
#include <optional>
#include <vector>

#include "selfproj/rig/calibration.h"
#include "selfproj/rig/height_correction.h"
#include "selfproj/rig/rig.h"

namespace selfproj::rig {

// A place in the projector's image, or in the camera's.
struct ProjectorPlace {
  double line = 0;
  double column = 0;
};
struct CameraPlace {
  double row = 0;
  double column = 0;
};

// The light of a line, `line + slope (column - at_column)`, as a sheet in space. A laser's plane needs none of this.
struct LightSheet {
  double line = 0;
  double slope = 0;
  double at_column = 0;
};

class RigOptics {
 public:
  explicit RigOptics(const Rig& rig);

  [[nodiscard]] const Rig& rig() const { return rig_; }
  [[nodiscard]] bool has_projector() const { return !rig_.light_plane; }

  // The projector's optical centre; not for a laser.
  [[nodiscard]] cv::Vec3d projector_centre() const;

  // (x / z, y / z) of what a camera place sees; nothing where the lens model folds over.
  [[nodiscard]] std::optional<cv::Vec2d> ray(const CameraPlace& place) const;

  // Where camera and projector have this point in their images, perhaps beyond the border. Nothing behind them, or
  // where the lens model folds over.
  [[nodiscard]] std::optional<CameraPlace> seen(const cv::Vec3d& point) const;
  [[nodiscard]] std::optional<ProjectorPlace> lit_by(const cv::Vec3d& point) const;

  // The point in the projector's axes (lines in the place of x), and the places at which the projector has the ray
  // between two of its depths: `count` of them, at equal distances without distortion. Empty where one of them cannot
  // be lit.
  [[nodiscard]] cv::Vec3d to_projector(const cv::Vec3d& point) const {
    return calibration_.rotation * point + calibration_.translation;
  }
  [[nodiscard]] std::vector<ProjectorPlace> epipolar_line(const cv::Vec2d& ray, double z_first, double z_last,
                                                          int count) const;

  // The direction in which a projector place sends its light, scaled to 1 along the projector's axis.
  [[nodiscard]] std::optional<cv::Vec3d> light_of(const ProjectorPlace& place) const;

  // z by the geometry alone at which a camera place with this ray sees the light of the sheet (or the laser's plane),
  // to 1e-7 mm. Nothing if the light is behind camera or projector, or z does not fall with the line as in the middle
  // of the image.
  [[nodiscard]] std::optional<double> meet(const cv::Vec2d& ray, const LightSheet& sheet) const;

  // Whether the projector's lines rise towards the camera, as they do on a rig with positive pitches.
  [[nodiscard]] bool lines_rise() const { return sign_ < 0; }

  // How far z moves from one projector line to the next at depth z on the ray, mm; for a laser 0.
  [[nodiscard]] double z_per_line(const cv::Vec2d& ray, double z) const;

  // The same place's z with its height corrected (include/selfproj/rig/height_correction.h), and the inverse; NaN far
  // outside of the calibrated heights.
  [[nodiscard]] double corrected(const CameraPlace& place, double z) const;
  [[nodiscard]] double uncorrected(const CameraPlace& place, double z) const;

 private:
  // Whether the line moves with z as in the middle of the image, by the geometry without distortion. It does not beyond
  // the ray that passes through the projector's centre (on a rig of pinholes: z0 tan α = x0).
  [[nodiscard]] double fall(const cv::Vec3d& direction) const {
    return direction[0] * calibration_.translation[2] - calibration_.translation[0] * direction[2];
  }
  // Projector line and column of ray z, and their derivatives by z.
  struct Track {
    ProjectorPlace place, by_z;
    double depth = 0;  // along the projector's axis
  };
  [[nodiscard]] Track track(const cv::Vec2d& ray, double z) const;
  [[nodiscard]] std::optional<double> meet_plane(const cv::Vec2d& ray) const;

  Rig rig_;
  Calibration calibration_;                // with rows in the place of x: a pixel is (row, column) or (line, column)
  cv::Matx33d belt_ = cv::Matx33d::eye();  // from the camera's axes, rows first, to those of the belt
  cv::Vec3d normal_;                       // of the laser's plane
  double camera_reach_ = 0, projector_reach_ = 0;  // greatest x² + y² of a ray, before the lens model folds over
  double sign_ = -1;                               // sign of d line / d z in the middle of the image
  double fall_sign_ = 1;                           // and of `fall` there
  std::optional<HeightCorrection> correction_;
};

}  // namespace selfproj::rig

#endif  // SELFPROJ_RIG_OPTICS_H
