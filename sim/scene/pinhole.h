// Camera and projector as projective pinholes with lens distortion: they map points of the world to pixels and back.
// They are written apart from the angles of the host's triangulation, so that each checks the other.
#ifndef SELFPROJ_SIM_SCENE_PINHOLE_H
#define SELFPROJ_SIM_SCENE_PINHOLE_H

#include <array>
#include <optional>
#include <span>

#include "host/rig/rig.h"
#include "sim/scene/brown_lens.h"

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
inline Point3 cross(Point3 a, Point3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// A place in an image or a pattern, from 0; integers are centres of pixels.
struct PixelPoint {
  double row = 0;     // or line
  double column = 0;  // both grow with Xc, Yc (camera) or Xp, Yp (projector)
};

// A part of an image.
struct PixelBounds {
  double row_0, row_1;
  double column_0, column_1;
};

// w (row, column, 1)ᵀ = K [R | −R c] (x, y, z, 1)ᵀ with the rotation R, the centre c, and K made of focal length, pixel
// pitch and principal point. w is the distance along the axis; only points with w > 0 are in front of the pinhole. With
// a lens that distorts, its formula comes before K.
class Pinhole {
 public:
  struct Intrinsics {
    double row_scale;  // pixels for a tangent of 1: focal length / pitch
    double column_scale;
    double row_0;  // pixel on the axis
    double column_0;
  };

  // `axes` are the rows of R: directions of length 1 of rows, of columns, and of the optical axis.
  Pinhole(Point3 centre, const std::array<Point3, 3>& axes, const Intrinsics& k, const BrownLens& lens = {});

  // Without distortion, placed as the rig says.
  static Pinhole of_camera(const RigCamera& camera);
  static Pinhole of_projector(const RigProjector& projector);

  [[nodiscard]] Point3 centre() const { return centre_; }
  [[nodiscard]] Point3 axis() const { return axes_[2]; }  // of length 1
  [[nodiscard]] const std::array<Point3, 3>& axes() const { return axes_; }
  [[nodiscard]] const Intrinsics& intrinsics() const { return k_; }
  [[nodiscard]] const BrownLens& lens() const { return lens_; }

  // Distance of the point along the axis.
  [[nodiscard]] double depth(Point3 p) const { return row_of(2, p); }

  // The pixel of a point with depth > 0. Points at angles that the lens cannot show are far outside the image.
  [[nodiscard]] PixelPoint project(Point3 p) const {
    if (lens_.distorts()) {
      return project_distorted(p);
    }
    const double w = 1 / row_of(2, p);
    return {row_of(0, p) * w, row_of(1, p) * w};
  }

  // Whether its lens shows a point with depth > 0. The points between such points are shown, too.
  [[nodiscard]] bool sees(Point3 p) const { return !lens_.distorts() || lens_.sees(tangents_of(p)); }

  // The direction of the ray through a pixel, scaled to depth 1 along the axis. Throws std::invalid_argument where the
  // lens shows no ray.
  [[nodiscard]] Point3 ray(PixelPoint pixel) const;

  // The same, scaled to z = 1 of the world; and the point of the ray with this z.
  [[nodiscard]] Point3 sight(PixelPoint pixel) const {
    const Point3 along = ray(pixel);
    return along.z == 1 ? along : 1 / along.z * along;
  }
  [[nodiscard]] Point3 point_at(PixelPoint pixel, double z) const { return centre_ + (z - centre_.z) * sight(pixel); }

  // The four corners of a rectangle of the image as sight() gives them. The sights of all its pixels are between them:
  // if the lens distorts, the rectangle is enlarged by kBend on each side, more than its edges bend over a few pixels.
  [[nodiscard]] std::array<Point3, 4> corner_sights(PixelPoint first, PixelPoint last) const;
  static constexpr double kBend = 0.05;  // pixels

  // Bounds of the image of all points between these (of their convex hull). Nothing if one is not in front.
  [[nodiscard]] std::optional<PixelBounds> bounds(std::span<const Point3> points) const;

 private:
  [[nodiscard]] double row_of(std::size_t i, Point3 p) const {
    return matrix_[i][0] * p.x + matrix_[i][1] * p.y + matrix_[i][2] * p.z + matrix_[i][3];
  }
  [[nodiscard]] Tangents tangents_of(Point3 p) const;
  [[nodiscard]] PixelPoint pixel_of(Tangents image) const {
    return {k_.row_0 + k_.row_scale * image.down, k_.column_0 + k_.column_scale * image.across};
  }
  [[nodiscard]] PixelPoint project_distorted(Point3 p) const;

  Point3 centre_;
  std::array<Point3, 3> axes_;
  Intrinsics k_;
  BrownLens lens_;
  std::array<std::array<double, 4>, 3> matrix_{};
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_PINHOLE_H
