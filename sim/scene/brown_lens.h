// The distortion of a lens by Brown's model, which OpenCV uses too, and its inverse to machine precision. Written apart
// from host/rig/calibration.h, so that each checks the other.
#ifndef SELFPROJ_SIM_SCENE_BROWN_LENS_H
#define SELFPROJ_SIM_SCENE_BROWN_LENS_H

namespace selfproj {

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
  [[nodiscard]] bool sees(Tangents ray) const { return ray.across * ray.across + ray.down * ray.down < most_r2_; }

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
  double most_r2_ = kUnlimited;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_BROWN_LENS_H
