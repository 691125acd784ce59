// From code images to depth: the ray of a camera pixel meets the plane of its code (4.7).
//
// Axes and signs are those of the world in section 1 of the method. Depth is z in mm, NaN if there is none. Pixels
// count from 0, row by row. Code words are those of model/gray_decoder (code in bits 11..0, bit 15 measurable).
#ifndef SELFPROJ_STRUCTURED_LIGHT_TRIANGULATION_H
#define SELFPROJ_STRUCTURED_LIGHT_TRIANGULATION_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <opencv2/core/matx.hpp>
#include <string>
#include <vector>

#include "selfproj/rig/calibration.h"
#include "selfproj/rig/rig.h"

namespace selfproj::structured_light {

// Why a pixel has no depth, or valid if it has one. The first reason that applies counts.
enum class PointState : std::uint8_t {
  valid = 0,
  not_measurable,   // more than one ambiguous pair, or too few neighbours for the median
  no_line,          // the code belongs to no line of the projector
  no_intersection,  // the ray meets the plane behind camera or projector, or z would not fall with θ (z0 tan α >= x0)
  too_coarse,       // one projector line is worth more than max_z_per_line_mm
  out_of_range,     // z is not between min_z_mm and max_z_mm
  off_line,         // both axes: the codes of the two axes belong to no common point (max_residual_px)
};
inline constexpr int kPointStates = 7;

// The limits within which a point is valid.
struct DepthLimits {
  double min_z_mm = 0;
  double max_z_mm = std::numeric_limits<double>::infinity();
  double max_z_per_line_mm = std::numeric_limits<double>::infinity();  // greatest |dz| from one line to the next
};

struct Point3f {
  float x = 0;
  float y = 0;
  float z = 0;
};

// Depth from codes along one axis of the projector, for images of one size: rows() x columns() pixels, row by row. Any
// number of threads may call the const functions at once.
class Triangulation {
 public:
  Triangulation(const Triangulation&) = delete;
  Triangulation& operator=(const Triangulation&) = delete;
  virtual ~Triangulation() = default;

  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] int bits() const { return bits_; }
  [[nodiscard]] std::size_t pixels() const { return x_per_z_.size(); }

  // Converts rows() * columns() words to as many depths. Allocates nothing and keeps no state.
  virtual void depth(const std::uint16_t* codes, float* z) const = 0;

  // The state of each pixel, given its code and the depth that `depth` gave it.
  virtual void explain(const std::uint16_t* codes, const float* z, PointState* states) const = 0;

  // Standard deviation in mm of the error in z that rounding to whole codes causes at a pixel with depth z. The place
  // is uniform over the code, so it is 1/√12 of the depth that a code is worth there.
  [[nodiscard]] virtual double rounding_error(std::size_t pixel, float z) const = 0;

  // The point of pixel i at depth z, on the pixel's ray.
  [[nodiscard]] Point3f point(std::size_t i, float z) const {
    const float along = z - origin_.z;
    return {origin_.x + along * x_per_z_[i], origin_.y + along * y_per_z_[i], z};
  }

  // Whether image rows run along x and columns along y, as in a rig; otherwise it is the other way round.
  [[nodiscard]] virtual bool rows_are_x() const = 0;

  // The axes of its points in words, for the head of a file.
  [[nodiscard]] const char* axes() const {
    return rows_are_x() ? "x down the image, y right, z away (left-handed)" : "x right, y down the image, z away";
  }

  // The camera's optical centre, and dx/dz and dy/dz of each pixel's ray.
  [[nodiscard]] const Point3f& origin() const { return origin_; }
  [[nodiscard]] const float* x_per_z() const { return x_per_z_.data(); }
  [[nodiscard]] const float* y_per_z() const { return y_per_z_.data(); }

 protected:
  // Throws std::invalid_argument if rows or columns are less than 1, or bits are not 1..12.
  Triangulation(int rows, int columns, int bits);

  void set_origin(const cv::Vec3d& origin);
  void set_ray(std::size_t i, const cv::Vec3d& direction);  // direction[2] must be 1

 private:
  int rows_, columns_, bits_;
  Point3f origin_;
  std::vector<float> x_per_z_, y_per_z_;
};

// Pinholes: everything in (4.7) that does not depend on the code is computed once. With the ray o + s d, d_z = 1, and
// the rows t0, t1 of T_P, the plane of the code is (t0 - C t1) . (x, y, z, 1) = 0, and
//
//     z = o_z + (C e1 - e0)/(n0 - C n1),   n = t . (d, 0) of the pixel,   e = t . (o, 1)
//
// This is a quotient of two terms linear in C, so no table of planes is needed. |dz/dC| = |e1 n0 - n1 e0| / (n0 - C
// n1)^2, and the sign of e1 n0 - n1 e0 says whether z falls or grows with C. The sign changes where the ray passes
// through the projector's centre (on a rig: z0 tan α = x0). Pixels whose sign differs from that of the image's centre
// have no intersection.
class PlaneTriangulation : public Triangulation {
 public:
  // `codes_per_line` is 2^bits / L, what a projector line is worth in codes, for the limit. Throws
  // std::invalid_argument if a size is out of range, T_C cannot be inverted, the camera does not look along +z
  // everywhere, or codes_per_line is not > 0.
  PlaneTriangulation(int rows, int columns, int bits, const rig::DepthMatrices& matrices, const DepthLimits& limits,
                     double codes_per_line = 1);

  // Uses the size of the rig's camera, and its max_z_per_line_mm instead of that of `limits`.
  PlaneTriangulation(const rig::Rig& rig, int bits, DepthLimits limits = {}, const rig::CodedLines& lines = {});

  void depth(const std::uint16_t* codes, float* z) const override;
  void explain(const std::uint16_t* codes, const float* z, PointState* states) const override;
  [[nodiscard]] double rounding_error(std::size_t pixel, float z) const override;
  [[nodiscard]] bool rows_are_x() const override { return true; }

  // Depths of the pixels of one row whose places on the projector are known as lines of a rig's projector (from 0, with
  // a fraction; NaN: none). Codes must begin with line 0. Allocates nothing.
  void depth_of_lines(int row, const float* lines, float* z) const;

  // Why a pixel has the depth z of its line; no_line if it has no line.
  [[nodiscard]] PointState explain_line(std::size_t pixel, float line, float z) const;

 private:
  // Terms of a pixel, or of a row if they are the same for all its pixels (a camera that is not rotated about z against
  // the coded axis, as in both rigs). The denominator is at - slope C, and must be greater than least.
  struct Terms {
    double at, slope, least;
  };
  [[nodiscard]] Terms terms(const cv::Vec3d& ray) const;
  [[nodiscard]] PointState explain_code(std::size_t pixel, double code, float z) const;

  cv::Matx<double, 2, 4> projector_;
  cv::Vec3d center_;
  double e0_ = 0, e1_ = 0;  // signed so that valid denominators are > 0
  double codes_per_line_ = 1;
  double coarse_ = 0;          // codes for each line / limit
  double sign_ = 1;            // sign of e1 n0 - n1 e0 in the middle of the image
  double low_ = 0, high_ = 0;  // limits of z
  bool by_rows_ = false;
  std::vector<float> at_, slope_, least_;  // one entry for each pixel or for each row
};

// How many pixels of a depth image have a depth, and why the others have none: the number of pixels in each state.
struct DepthShares {
  std::array<std::size_t, kPointStates> count{};

  [[nodiscard]] std::size_t of(PointState state) const { return count[static_cast<std::size_t>(state)]; }
  [[nodiscard]] std::size_t total() const;
};
DepthShares count_states(const std::vector<PointState>& states);

// The name used in summary.json: "valid", "not_measurable", ...
const char* name_of(PointState state);

// Text such as "44.37 % valid".
std::string share_text(const DepthShares& shares, PointState state);

}  // namespace selfproj::structured_light

#endif  // SELFPROJ_STRUCTURED_LIGHT_TRIANGULATION_H
