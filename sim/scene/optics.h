// Camera and projector as projective pinholes behind lenses that distort and blur. Written apart from the angles of the
// host's triangulation and from the lenses of host/rig, so that each checks the other.
#ifndef SELFPROJ_SIM_SCENE_OPTICS_H
#define SELFPROJ_SIM_SCENE_OPTICS_H

#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "selfproj/rig/rig.h"

namespace selfproj::sim {

// The distortion of a lens by Brown's model, which OpenCV uses too, and its inverse to machine precision.

// Tangents of a ray: its components along columns and rows, divided by that along the axis.
struct Tangents {
  double across = 0;  // x of the formula
  double down = 0;    // y
};

// The ray (x, y) falls where a lens without distortion would show the ray
//     x (1 + k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 x y + p2 (r² + 2 x²)
//     y (1 + k1 r² + k2 r⁴ + k3 r⁶) + p1 (r² + 2 y²) + 2 p2 x y,     r² = x² + y²
class BrownLens {
 public:
  struct Coefficients {
    double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;
  };

  BrownLens() = default;  // without distortion
  explicit BrownLens(const Coefficients& c);

  [[nodiscard]] bool distorts() const { return distorts_; }
  [[nodiscard]] const Coefficients& coefficients() const { return c_; }

  // Whether the formula can be inverted at the ray: it folds the image over beyond some angle.
  [[nodiscard]] bool sees(Tangents ray) const { return ray.across * ray.across + ray.down * ray.down < max_r2_; }

  [[nodiscard]] Tangents distorted(Tangents ray) const;

  // The inverse. Throws std::invalid_argument where no ray that the lens sees falls.
  [[nodiscard]] Tangents undistorted(Tangents image) const;

  // How much the displacement by the lens changes at most between two rays of a rectangle that is `reach` wide from the
  // axis at most, for each unit of their distance.
  [[nodiscard]] double stretch(double reach) const;

 private:
  static constexpr double kUnlimited = 1e300;

  Coefficients c_;
  bool distorts_ = false;
  double max_r2_ = kUnlimited;
};

// Millimetres in the world frame of include/selfproj/rig/rig.h.
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
  static Pinhole of_camera(const rig::RigCamera& camera);
  static Pinhole of_projector(const rig::RigProjector& projector);

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

inline constexpr double kKernelReach = 4;  // of a blur, in standard deviations

// The weights of a Gaussian of standard deviation `sigma` at integers from -4 sigma to 4 sigma, of sum 1.
std::vector<double> gaussian_kernel(double sigma);

// The effect of the camera's lens and of its square pixels on an image of sub-pixels.

// Sub-pixels along a side of a pixel.
inline constexpr int kSubPixels = 4;

// The width in pixels of the margin from which a lens with this Gaussian blur (standard deviation in pixels) gathers
// light.
int lens_margin(double blur);

// The share of a sub-pixel's light that falls on a pixel: the pixel's square, folded with the lens's Gaussian. There is
// one weight for each sub-pixel of a pixel and of its margin on both sides, (2 lens_margin(blur) + 1) kSubPixels, of
// sum 1.
std::vector<float> lens_kernel(double blur);

// The sights of a camera's sub-pixels. A lens that distorts is inverted step by step for each, and every frame and
// every scene asks for the same ones.
class SightTable {
 public:
  // The table of a camera, which is shared with whoever asked for the same one before; null if its lens does not
  // distort, or if the table would be larger than 64 MiB. Several threads may call it at once.
  static std::shared_ptr<const SightTable> of(const Pinhole& camera, const rig::RigCamera& size);

  // What camera.sight(pixel) gives, to the last digit. It is looked up for the middles of sub-pixels in the image and
  // in a margin of 8 pixels around it.
  [[nodiscard]] Point3 sight(PixelPoint pixel) const {
    const double r = (pixel.row + kMargin + 0.5) * kSubPixels - 0.5;
    const double c = (pixel.column + kMargin + 0.5) * kSubPixels - 0.5;
    if (r >= 0 && c >= 0 && r < static_cast<double>(rows_) && c < static_cast<double>(columns_)) {
      const auto row = static_cast<std::size_t>(r);
      const auto column = static_cast<std::size_t>(c);
      if (static_cast<double>(row) == r && static_cast<double>(column) == c) {
        return sights_of(row)[column];
      }
    }
    return camera_.sight(pixel);
  }

 private:
  static constexpr int kMargin = 8;  // pixels

  SightTable(const Pinhole& camera, const rig::RigCamera& size);
  [[nodiscard]] bool is_of(const Pinhole& camera, const rig::RigCamera& size) const;
  const Point3* sights_of(std::size_t row) const {
    const Point3* const filled = ready_[row].load(std::memory_order_acquire);
    return filled != nullptr ? filled : fill(row);
  }
  const Point3* fill(std::size_t row) const;

  Pinhole camera_;
  std::size_t rows_, columns_;  // of sub-pixels
  mutable std::vector<std::vector<Point3>> sights_;
  mutable std::vector<std::atomic<const Point3*>> ready_;  // the rows that are filled; null before
  std::unique_ptr<std::once_flag[]> filled_;  // NOLINT(modernize-avoid-c-arrays): once_flag cannot be moved
};

// A thin lens. Lengths in mm.
class FocusedLens {
 public:
  // `pitch` is that of the image's pixels, and `focus` the distance from the lens that is sharp (> focal length).
  FocusedLens(double focal_length, double f_number, double pitch, double focus);

  // The standard deviation in pixels of the blur at a depth: that of an even disc whose diameter is the circle of
  // confusion, f² / N · |d − focus| / (d (focus − f)), and so a quarter of it.
  [[nodiscard]] double sigma_px(double depth) const;

 private:
  double scale_;  // f² / (N (focus - f)) / 4 / pitch
  double focus_;
};

// Spreads each pixel of an image over its neighbours with its own standard deviation in pixels, along rows and along
// columns. The weights have exactly this variance below 0.6 px, where a sampled Gaussian has not. Light that leaves the
// image is lost, and comes in as its border has it.
void spread(int rows, int columns, std::span<const float> sigma, std::span<float> pixels);

// The weights at -reach..reach of a blur of this standard deviation, of sum 1.
std::vector<float> spread_weights(double sigma);

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_SCENE_OPTICS_H
