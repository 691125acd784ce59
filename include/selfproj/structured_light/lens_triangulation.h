// Depth through the lenses of camera and projector: from codes along one axis or both, and from matched projector
// lines.
#ifndef SELFPROJ_STRUCTURED_LIGHT_LENS_TRIANGULATION_H
#define SELFPROJ_STRUCTURED_LIGHT_LENS_TRIANGULATION_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <optional>
#include <vector>

#include "selfproj/rig/calibration.h"
#include "selfproj/rig/calibration_file.h"
#include "selfproj/rig/optics.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/triangulation.h"

namespace selfproj::structured_light {

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
  LensTriangulation(const rig::Calibration& calibration, const LensSettings& settings);

  // From the columns alone.
  void depth(const std::uint16_t* codes, float* z) const override;
  void explain(const std::uint16_t* codes, const float* z, PointState* states) const override;

  // With row_bits it is that of depth_of_both, where both axes round independently.
  [[nodiscard]] double rounding_error(std::size_t pixel, float z) const override;

  [[nodiscard]] bool rows_are_x() const override { return settings_.rows_are_x; }

  // What it was made of.
  [[nodiscard]] rig::Calibration calibration() const {
    return settings_.rows_are_x ? rig::with_axes_exchanged(calibration_) : calibration_;
  }
  [[nodiscard]] const LensSettings& settings() const { return settings_; }

  // Both axes, from words of the columns' and of the rows' code. The projector may lie to any side of the camera. The
  // limit of z for a line is one for a projector pixel, in whatever direction the point moves there. `states` and
  // `residual_px` may be null. The residual is NaN if there is no depth.
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

  rig::Calibration calibration_;
  LensSettings settings_;
  double sign_ = 1;  // sign of d(projector column)/dz in the middle of the image
};

// The lines of a pixel that may be asked for, from 0 with a fraction; none if first > last.
struct LineRange {
  float first = 1;
  float last = 0;
};

// Without distortion the line of a point on a pixel's ray is a quotient of two terms linear in z. With it, a polynomial
// of the line takes the line's place in this quotient:
//
//     f = c_0 + c_1 s + c_2 s² + ...,   s = (line - middle) / half,   z = (f T_z - T_x) / (d_x - f d_z)
//
// where d is the pixel's ray in the projector's axes and T the camera's centre there.
class LensLines {
 public:
  // What z of a fit may be off, mm.
  static constexpr double kMaxError = 0.001;

  // `ranges`: for each pixel, row by row. A pixel at which even the greatest degree (9) misses kMaxError has no depth.
  // Throws std::invalid_argument if there are not as many ranges as pixels, and UserError if more than 10 % of the
  // pixels have no depth for this reason.
  LensLines(const rig::Rig& rig, const std::vector<LineRange>& ranges, const DepthLimits& limits);

  // Depths of the pixels of one row, as PlaneTriangulation::depth_of_lines; NaN also outside of the pixel's range.
  void depth_of_lines(int row, const float* lines, float* z) const;

  // Why a pixel has the depth z of its line.
  [[nodiscard]] PointState explain_line(std::size_t pixel, float line, float z) const;

  [[nodiscard]] double fit_error_mm() const { return fit_error_; }
  [[nodiscard]] int degree() const { return degree_; }

 private:
  static constexpr std::size_t kNodes = 14;  // where a pixel is fitted: more than coefficients
  struct Nodes;
  static std::array<double, kNodes> series_of(const Nodes& nodes);
  [[nodiscard]] std::vector<std::size_t> fit(const std::vector<Nodes>& nodes, int degree);
  void reject(const std::vector<std::size_t>& pixels);
  [[nodiscard]] std::optional<cv::Vec2d> ray_of(std::size_t pixel) const;  // none where the lens cannot be undone
  [[nodiscard]] Nodes nodes_of(std::size_t pixel, const LineRange& range) const;

  rig::RigOptics optics_;
  DepthLimits limits_;
  int columns_;
  int degree_ = 0;
  double fit_error_ = 0;
  double move_x_ = 0, move_z_ = 0;  // T
  // One entry for each pixel; coefficients of one power side by side.
  std::vector<float> first_, last_, middle_, inverse_half_, coefficients_;
  std::vector<double> ray_x_, ray_z_;  // d
};

}  // namespace selfproj::structured_light

#endif  // SELFPROJ_STRUCTURED_LIGHT_LENS_TRIANGULATION_H
