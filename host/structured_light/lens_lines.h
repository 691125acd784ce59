// From matched projector lines to depth through the lenses of a calibrated rig, with a fit for each camera pixel.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_LENS_LINES_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_LENS_LINES_H

#include <array>
#include <cstddef>
#include <opencv2/core/matx.hpp>
#include <optional>
#include <vector>

#include "host/rig/optics.h"
#include "host/rig/rig.h"
#include "host/structured_light/triangulation.h"

namespace selfproj {

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
  static constexpr double kMostError = 0.001;

  // `ranges`: for each pixel, row by row. A pixel at which even the greatest degree (9) misses kMostError has no depth.
  // Throws std::invalid_argument if there are not as many ranges as pixels, and UserError if more than 10 % of the
  // pixels have no depth for this reason.
  LensLines(const Rig& rig, const std::vector<LineRange>& ranges, const DepthLimits& limits);

  // Depths of the pixels of one row, as PlaneTriangulation::depth_of_lines; NaN also outside of the pixel's range.
  void depth_of_lines(int row, const float* lines, float* z) const;

  // Why a pixel has the depth z of its line.
  [[nodiscard]] PointState explain_line(std::size_t pixel, float line, float z) const;

  [[nodiscard]] double fit_error_mm() const { return fit_error_; }
  [[nodiscard]] int degree() const { return degree_; }
  [[nodiscard]] std::size_t rejected() const { return rejected_; }  // pixels without a fit

 private:
  static constexpr std::size_t kNodes = 14;  // where a pixel is fitted: more than coefficients
  struct Nodes;
  static std::array<double, kNodes> series_of(const Nodes& nodes);
  [[nodiscard]] std::vector<std::size_t> fit(const std::vector<Nodes>& nodes, int degree);
  void reject(const std::vector<std::size_t>& pixels);
  [[nodiscard]] std::optional<cv::Vec2d> ray_of(std::size_t pixel) const;  // none where the lens cannot be undone
  [[nodiscard]] Nodes nodes_of(std::size_t pixel, const LineRange& range) const;

  RigOptics optics_;
  DepthLimits limits_;
  int rows_, columns_;
  int degree_ = 0;
  double fit_error_ = 0;
  std::size_t rejected_ = 0;
  double move_x_ = 0, move_z_ = 0;  // T
  // One entry for each pixel; coefficients of one power side by side.
  std::vector<float> first_, last_, middle_, inverse_half_, coefficients_;
  std::vector<double> ray_x_, ray_z_;  // d
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_LENS_LINES_H
