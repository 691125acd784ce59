// Camera and projector as projective pinholes: matrices that map points of the world to pixels and back. They are
// written apart from the angles of the host's triangulation, so that each checks the other.
#ifndef SELFPROJ_SIM_SCENE_PINHOLE_H
#define SELFPROJ_SIM_SCENE_PINHOLE_H

#include <array>

#include "host/rig/rig.h"

namespace selfproj {

// Millimetres in the world frame of host/rig/rig.h.
struct Point3 {
  double x = 0;
  double y = 0;
  double z = 0;
};

inline Point3 operator+(Point3 a, Point3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Point3 operator-(Point3 a, Point3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Point3 operator*(double s, Point3 a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(Point3 a, Point3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// A place in an image or a pattern, from 0; integers are centres of pixels.
struct PixelPoint {
  double row = 0;     // or line
  double column = 0;  // both grow with Xc, Yc (camera) or Xp, Yp (projector)
};

// w (row, column, 1)ᵀ = K [R | −R c] (x, y, z, 1)ᵀ with the rotation R, the centre c, and K made of focal length, pixel
// pitch and principal point. w is the distance along the axis; only points with w > 0 are in front of the pinhole.
class Pinhole {
 public:
  static Pinhole of_camera(const RigCamera& camera);
  static Pinhole of_projector(const RigProjector& projector);

  [[nodiscard]] Point3 centre() const { return centre_; }
  [[nodiscard]] Point3 axis() const { return axes_[2]; }  // of length 1

  // Distance of the point along the axis.
  [[nodiscard]] double depth(Point3 p) const { return row_of(2, p); }

  // The pixel of a point with depth > 0.
  [[nodiscard]] PixelPoint project(Point3 p) const {
    const double w = 1 / row_of(2, p);
    return {row_of(0, p) * w, row_of(1, p) * w};
  }

  // The direction of the ray through a pixel, scaled to depth 1 along the axis.
  [[nodiscard]] Point3 ray(PixelPoint pixel) const;

 private:
  struct Intrinsics {
    double row_scale;  // pixels for a tangent of 1: focal length / pitch
    double column_scale;
    double row_0;  // pixel on the axis
    double column_0;
  };
  Pinhole(Point3 centre, const std::array<Point3, 3>& axes, const Intrinsics& k);

  [[nodiscard]] double row_of(std::size_t i, Point3 p) const {
    return matrix_[i][0] * p.x + matrix_[i][1] * p.y + matrix_[i][2] * p.z + matrix_[i][3];
  }

  Point3 centre_;
  std::array<Point3, 3> axes_;  // the rows of R: directions of rows, of columns, and of the optical axis
  Intrinsics k_;
  std::array<std::array<double, 4>, 3> matrix_{};
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_PINHOLE_H
