// Depth from codes with the lens distortion of camera and projector, and from codes along both axes.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_LENS_TRIANGULATION_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_LENS_TRIANGULATION_H

#include <cstddef>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "host/rig/calibration_file.h"
#include "host/structured_light/triangulation.h"

namespace selfproj {

struct LensSettings {
  int rows = 0;  // rows of the camera
  int columns = 0;
  int bits = 0;                // bits of the projector columns' code
  int row_bits = 0;            // bits of its rows' code; 0 if only the columns are coded
  double lines = 0;            // projector columns that 2^bits codes cover; 0: one for each code
  double row_lines = 0;        // the same for rows
  double max_residual_px = 3;  // both axes: greatest distance from the pixel of the two codes to the ray's image
  DepthLimits limits;
  bool rows_are_x = false;  // exchanges x and y of points, and columns and rows of the projector
};

// The world is the camera's frame, with x along its columns. With rows_are_x it is a rig's, with x along the rows, and
// the codes are those of the projector's rows (the rig's lines). Code c is projector column (c + 1/2) lines/2^bits -
// 1/2.
//
// With a distorting projector the points of a column form no plane. Gauss-Newton finds the depth at which the camera's
// ray meets them: it brings the ray's image in the projector, a curve in z, to the code's column, or, with both axes,
// as near as possible to the pixel of both codes (least squares). The camera's rays are undistorted once.
class LensTriangulation : public Triangulation {
 public:
  // Throws std::invalid_argument if a size is out of range, a ray cannot be undistorted, or the settings contradict the
  // sizes in the calibration.
  LensTriangulation(const Calibration& calibration, const LensSettings& settings);

  // From the columns alone.
  void depth(const std::uint16_t* codes, float* z) const override;
  void explain(const std::uint16_t* codes, const float* z, PointState* states) const override;

  // With row_bits it is that of depth_of_both, where both axes round independently.
  [[nodiscard]] double rounding_error(std::size_t pixel, float z) const override;

  [[nodiscard]] bool rows_are_x() const override { return settings_.rows_are_x; }

  // Both axes, from words of the columns' and of the rows' code. `states` and `residual_px` may be null. The residual
  // is NaN if there is no depth.
  void depth_of_both(const std::uint16_t* codes, const std::uint16_t* row_codes, float* z, PointState* states,
                     float* residual_px) const;

 private:
  struct Found {
    double z = 0;
    double residual = 0;  // pixels
    PointState state = PointState::valid;
  };
  [[nodiscard]] Found solve(std::size_t pixel, std::uint16_t code, const std::uint16_t* row_code) const;
  // The projector pixel that lights the point at z on the ray, and its derivative by z.
  [[nodiscard]] cv::Vec2d image(const cv::Vec3d& ray, double z, cv::Vec2d& derivative) const;

  Calibration calibration_;
  LensSettings settings_;
  double sign_ = 1;  // sign of d(projector column)/dz in the middle of the image
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_LENS_TRIANGULATION_H
