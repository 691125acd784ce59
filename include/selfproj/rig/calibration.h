// The full model of a camera and a projector: their lenses and the pose between them; what it is for a rig, and the rig
// nearest to it; and the matrices of triangulation by structured light (4.7).
#ifndef SELFPROJ_RIG_CALIBRATION_H
#define SELFPROJ_RIG_CALIBRATION_H

#include <array>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <optional>
#include <string>

#include "selfproj/rig/rig.h"

namespace selfproj::rig {

// A pinhole with the distortion model of OpenCV's calibration. Focal lengths and centre are in pixels; pixel centres
// are integers from 0. The coefficients k1, k2, p1, p2, k3, k4, k5, k6 are those of OpenCV. The ray (x, y, 1) falls on
// pixel column fx x' + cx, row fy y' + cy, where
//
//     x' = x q + 2 p1 x y + p2 (r² + 2 x²)      q = (1 + k1 r² + k2 r⁴ + k3 r⁶) / (1 + k4 r² + k5 r⁴ + k6 r⁶)
//     y' = y q + p1 (r² + 2 y²) + 2 p2 x y      r² = x² + y²
struct Lens {
  double fx = 1;
  double fy = 1;
  double cx = 0;
  double cy = 0;
  std::array<double, 8> k{};

  // The pixel (column, row) of the ray (x, y, 1).
  [[nodiscard]] cv::Vec2d pixel(const cv::Vec2d& ray) const;

  // The same, and its derivative by x and y.
  [[nodiscard]] cv::Vec2d pixel(const cv::Vec2d& ray, cv::Matx22d& derivative) const;

  // The ray (x, y, 1) that falls on a pixel, to 1e-9 pixels. Far from the axis the distortion model may fold the image
  // over; rays from there do not count. Returns nothing if no other ray falls on this pixel.
  [[nodiscard]] std::optional<cv::Vec2d> ray(const cv::Vec2d& pixel) const;
};

// A calibration. In the camera's frame and in mm, x_projector = R x_camera + T. A projector that shows its image
// mirrored has a negative fy: the camera sees the projector's rows grow upwards if its columns grow to the right.
struct Calibration {
  Lens camera;
  Lens projector;
  cv::Matx33d rotation = cv::Matx33d::eye();      // R
  cv::Vec3d translation;                          // T
  int camera_columns = 0, camera_rows = 0;        // 0 if the file does not say
  int projector_columns = 0, projector_rows = 0;  // 0 if the file does not say
};

// The rig's full model if it is calibrated, else its two pinholes; lengths in mm, focal lengths in pixels. The rig must
// have a projector, not a laser. The axes are those of a calibration: x along the
// camera's columns (the rig's y), y along its rows (the rig's x). This mirrors the rig's frame, so the projector of a
// rig with positive pitches has a negative fy: its lines count upwards.
Calibration calibration_of(const Rig& rig);

// The same calibration with x and y exchanged in camera, projector and space: rows take the place of columns. Doing it
// twice gives the original calibration.
Calibration with_axes_exchanged(const Calibration& calibration);

// A rig with this calibration as its full model. It is `like` with the sizes of the calibration's images, and with the
// pinholes of (3.4) that are nearest to the calibration. These keep the pixel pitch and the projector's focal length of
// `like`. They cannot have distortion, a principal point of the camera, a projector place along y, or turns other than
// the tilt, so these are left out. Throws std::invalid_argument if the calibration has no sizes, the projector's
// columns do not lie along the camera's, it does not stand beside the camera in the direction of growing rows, or a
// lens has rational distortion (k4, k5, k6), which rigs do not have.
Rig rig_of(const Calibration& calibration, const Rig& like);

// How far the rig's pinholes are from its full model: the greatest error in z, mm, of triangulation by (3.4) over
// points of the plane at `z_mm` that both camera and projector see, on a 9 x 9 grid of camera pixels; NaN if there is
// none.
double pinhole_error(const Rig& rig, double z_mm);

// The two matrices of (4.7):
//
//     H_C (X, Y, 1)^T = T_C (x, y, z, 1)^T       X image column, Y image row, from 0, pixel centres are integers
//     H_P (C, 1)^T    = T_P (x, y, z, 1)^T       C = code + 1/2: code c covers [c, c + 1)
//
// Each is scaled so that H is positive in front of the camera or the projector.
struct DepthMatrices {
  cv::Matx34d camera;                // T_C
  cv::Matx<double, 2, 4> projector;  // T_P
};

// H of (4.1) for 2^bits codes over `lines` lines of a projector: no code is narrower than a line, so that each line has
// a code of its own where the codes are more.
double coded_height(int lines, int bits);

// The lines of a projector that 2^bits codes cover: `count` of them from line `first` on, which may be more than it
// has. A count of 0 stands for all of the projector's, coded_height(H, bits) from its first on.
struct CodedLines {
  double first = 0;
  double count = 0;
};

// The central `count` lines of the rig's projector, as structured_light::gray_pattern codes them.
CodedLines central_lines(const Rig& rig, int count, int bits);

// The matrices of the pinholes of a rig whose projector of H lines shows `bits` pairs, 1..12, coded along L of its
// lines from line F on: code centre Xp = pitch (F + (c + 1/2) L/2^bits - 1/2 - (H - 1)/2) + center_xp_mm.
DepthMatrices depth_matrices(const Rig& rig, int bits, const CodedLines& lines = {});

// The projector axis along which codes count.
enum class CodedAxis : std::uint8_t { columns, rows };

// The matrices of (4.7) of a calibration without its distortion, along one of its axes: C = projector column or row +
// 1/2.
DepthMatrices depth_matrices(const Calibration& calibration, CodedAxis axis);

}  // namespace selfproj::rig

#endif  // SELFPROJ_RIG_CALIBRATION_H
