// Camera and projector as projective pinholes: what maps points of the world to their pixels and back, as matrices.
// Written apart from the angles of the host's triangulation, so that each checks the other.
#ifndef SELFPROJ_SIM_SCENE_PINHOLE_H
#define SELFPROJ_SIM_SCENE_PINHOLE_H

#include <array>

#include "host/rig/rig.h"

namespace selfproj {

// Millimetres, in the world frame of host/rig/rig.h.
struct Point3 {
  double x = 0;
  double y = 0;
  double z = 0;
};

inline Point3 operator+(Point3 a, Point3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Point3 operator-(Point3 a, Point3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Point3 operator*(double s, Point3 a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(Point3 a, Point3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// A place in an image or a pattern, from 0; whole numbers are centres of pixels.
struct PixelPoint {
  double row = 0;     // or line
  double column = 0;  // both grow with Xc, Yc (camera) or Xp, Yp (projector)
};

// w (row, column, 1)ᵀ = K [R | −R c] (x, y, z, 1)ᵀ, with the rotation R, the centre c, and K of focal length, pixel
// pitch and principal point. w is the distance along the axis; only points with w > 0 are before the pinhole.
class Pinhole {
 public:
  static Pinhole of_camera(const RigCamera& camera);
  static Pinhole of_projector(const RigProjector& projector);

  [[nodiscard]] Point3 centre() const { return centre_; }
  [[nodiscard]] Point3 axis() const { return axes_[2]; }  // of length 1

  // The distance of the point along the axis.
  [[nodiscard]] double depth(Point3 p) const { return row_of(2, p); }

  // The pixel of a point with depth > 0.
  [[nodiscard]] PixelPoint project(Point3 p) const {
    const double w = 1 / row_of(2, p);
    return {row_of(0, p) * w, row_of(1, p) * w};
  }

  // The direction of the ray through a pixel, of depth 1 along the axis.
  [[nodiscard]] Point3 ray(PixelPoint pixel) const;

 private:
  struct Intrinsics {
    double row_scale;  // pixels a unit of tangent: focal length / pitch
    double column_scale;
    double row_0;  // pixel on the axis
    double column_0;
  };
  Pinhole(Point3 centre, const std::array<Point3, 3>& axes, const Intrinsics& k);

  [[nodiscard]] double row_of(std::size_t i, Point3 p) const {
    return matrix_[i][0] * p.x + matrix_[i][1] * p.y + matrix_[i][2] * p.z + matrix_[i][3];
  }

  Point3 centre_;
  std::array<Point3, 3> axes_;  // of rows, of columns, optical: the rows of R
  Intrinsics k_;
  std::array<std::array<double, 4>, 3> matrix_{};
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_PINHOLE_H
