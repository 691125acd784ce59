// Depth from codes where camera and projector have lens distortion, and from codes along both axes.
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
  int rows = 0;  // of the camera
  int columns = 0;
  int bits = 0;                // of the projector columns' code
  int row_bits = 0;            // of its rows' code; 0 where only the columns are coded
  double lines = 0;            // projector columns that 2^bits codes cover; 0: 2^bits, a code a column
  double row_lines = 0;        // likewise rows
  double max_residual_px = 3;  // both axes: distance from the pixel of the two codes to the ray's image
  DepthLimits limits;
  bool rows_are_x = false;  // x and y of points, and columns and rows of the projector, are exchanged
};

// The world is the camera's frame, x along its columns; with rows_are_x it is a rig's, x along its rows, and the codes
// are those of the projector's rows (the rig's lines). Code c is the projector column (c + 1/2) lines/2^bits - 1/2.
//
// With a distorting projector the points of a column are no plane, so the depth at which the camera's ray meets them is
// found by Gauss-Newton: the ray's image in the projector, a curve in z, is brought to the code's column, or, with
// both axes, as near as possible to the pixel of both codes (least squares). The camera's rays are undistorted
// once.
class LensTriangulation : public Triangulation {
 public:
  // Throws std::invalid_argument where a size is out of range, a ray cannot be undistorted, or the settings
  // contradict the sizes in the calibration.
  LensTriangulation(const Calibration& calibration, const LensSettings& settings);

  // Columns alone.
  void depth(const std::uint16_t* codes, float* z) const override;
  void explain(const std::uint16_t* codes, const float* z, PointState* states) const override;

  // With row_bits, that of depth_of_both: the roundings of both axes are independent.
  [[nodiscard]] double rounding_error(std::size_t pixel, float z) const override;

  [[nodiscard]] bool rows_are_x() const override { return settings_.rows_are_x; }

  // Both axes: words of the columns' and of the rows' code. `states` and `residual_px` may be null; the residual is NaN
  // where there is no depth.
  void depth_of_both(const std::uint16_t* codes, const std::uint16_t* row_codes, float* z, PointState* states,
                     float* residual_px) const;

 private:
  struct Found {
    double z = 0;
    double residual = 0;  // pixels
    PointState state = PointState::valid;
  };
  [[nodiscard]] Found solve(std::size_t pixel, std::uint16_t code, const std::uint16_t* row_code) const;
  // Pixel of the projector that lights the point at z on the ray, and its derivative by z.
  [[nodiscard]] cv::Vec2d image(const cv::Vec3d& ray, double z, cv::Vec2d& derivative) const;

  Calibration calibration_;
  LensSettings settings_;
  double sign_ = 1;  // of d(projector column)/dz in the middle of the image
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_LENS_TRIANGULATION_H
