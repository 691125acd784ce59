#include "selfproj/structured_light/triangulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/structured_light/check.h"
#include "model/cpu_clones.h"
#include "selfproj/model/gray_decoder.h"

namespace selfproj::structured_light {
namespace {

// Values that are the same for all pixels.
struct Common {
  float e0, e1;
  float origin_z;
  float low, high;
};

enum class Measurable : bool { no, yes };

// One pixel. NaN if not valid, also if the code (C, with its half) is NaN. Written without branches, for the
// vectorizer.
[[gnu::always_inline]] inline float depth_of(float code, Measurable measurable, float at, float slope, float least,
                                             const Common& k) {
  const float denominator = at - code * slope;
  const float z = k.origin_z + (code * k.e1 - k.e0) / denominator;
  const bool valid =
      (measurable == Measurable::yes) & (denominator > least) & (z > k.low) & (z < k.high);  // NOLINT: no branches
  return valid ? z : std::numeric_limits<float>::quiet_NaN();
}

[[gnu::always_inline]] inline float depth_of(std::uint16_t word, float at, float slope, float least, const Common& k) {
  return depth_of(static_cast<float>(static_cast<int>(word & model::GrayDecoder::kCode)) + 0.5F,
                  Measurable{(word & model::GrayDecoder::kMeasurable) != 0}, at, slope, least, k);
}

SELFPROJ_CLONES void depth_of_row(const std::uint16_t* __restrict codes, std::ptrdiff_t count, float at, float slope,
                                  float least, const Common& common, float* __restrict z) {
  const Common k = common;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    z[i] = depth_of(codes[i], at, slope, least, k);
  }
}

SELFPROJ_CLONES void depth_of_pixels(const std::uint16_t* __restrict codes, std::ptrdiff_t count,
                                     const float* __restrict at, const float* __restrict slope,
                                     const float* __restrict least, const Common& common, float* __restrict z) {
  const Common k = common;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    z[i] = depth_of(codes[i], at[i], slope[i], least[i], k);
  }
}

SELFPROJ_CLONES void depth_of_lines_of_row(const float* __restrict lines, std::ptrdiff_t count, float codes_per_line,
                                           float at, float slope, float least, const Common& common,
                                           float* __restrict z) {
  const Common k = common;
  const float half = 0.5F * codes_per_line;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    z[i] = depth_of(lines[i] * codes_per_line + half, Measurable::yes, at, slope, least, k);
  }
}

cv::Vec3d row_of(const cv::Matx<double, 2, 4>& matrix, int row) {
  return {matrix(row, 0), matrix(row, 1), matrix(row, 2)};
}

// The ray of a pixel by T_C, scaled to z = 1.
cv::Vec3d ray_of(const cv::Matx33d& inverse, double row, double column) {
  const cv::Vec3d ray = inverse * cv::Vec3d(column, row, 1);
  check(ray[2] > 0, "triangulation: the camera does not look along z");
  return ray / ray[2];
}

}  // namespace

Triangulation::Triangulation(int rows, int columns, int bits) : rows_(rows), columns_(columns), bits_(bits) {
  check(rows >= 1 && columns >= 1, "triangulation: rows or columns are less than 1");
  check(bits >= 1 && bits <= model::GrayDecoder::kMaxBits, "triangulation: bits out of range");
  const std::size_t count = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  x_per_z_.resize(count);
  y_per_z_.resize(count);
}

void Triangulation::set_origin(const cv::Vec3d& origin) {
  origin_ = {static_cast<float>(origin[0]), static_cast<float>(origin[1]), static_cast<float>(origin[2])};
}

void Triangulation::set_ray(std::size_t i, const cv::Vec3d& direction) {
  x_per_z_[i] = static_cast<float>(direction[0]);
  y_per_z_[i] = static_cast<float>(direction[1]);
}

PlaneTriangulation::PlaneTriangulation(int rows, int columns, int bits, const rig::DepthMatrices& matrices,
                                       const DepthLimits& limits, double codes_per_line)
    : Triangulation(rows, columns, bits), projector_(matrices.projector), high_(limits.max_z_mm) {
  check(codes_per_line > 0, "triangulation: codes per line are not positive");
  const cv::Matx33d turn = matrices.camera.get_minor<3, 3>(0, 0);
  check(std::abs(cv::determinant(turn)) > 0, "triangulation: T_C cannot be inverted");
  const cv::Matx33d inverse = turn.inv();
  center_ = -1.0 * (inverse * cv::Vec3d(matrices.camera(0, 3), matrices.camera(1, 3), matrices.camera(2, 3)));
  set_origin(center_);
  low_ = std::max(limits.min_z_mm, center_[2]);
  codes_per_line_ = codes_per_line;
  coarse_ = codes_per_line / limits.max_z_per_line_mm;

  e0_ = row_of(projector_, 0).dot(center_) + projector_(0, 3);
  e1_ = row_of(projector_, 1).dot(center_) + projector_(1, 3);
  const cv::Vec3d middle = ray_of(inverse, 0.5 * (rows - 1), 0.5 * (columns - 1));
  sign_ = e1_ * row_of(projector_, 0).dot(middle) - e0_ * row_of(projector_, 1).dot(middle) < 0 ? -1 : 1;

  // Whether the terms hold for the whole row: rays of a pinhole are linear in the column, so the row's ends decide.
  const auto equal = [](double a, double b) { return std::abs(a - b) <= 1e-12 * (std::abs(a) + std::abs(b)); };
  by_rows_ = true;
  for (int r = 0; r < rows && by_rows_; ++r) {
    const Terms first = terms(ray_of(inverse, r, 0));
    const Terms last = terms(ray_of(inverse, r, columns - 1));
    by_rows_ = equal(first.at, last.at) && equal(first.slope, last.slope);
  }
  std::size_t i = 0;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c, ++i) {
      const cv::Vec3d ray = ray_of(inverse, r, c);
      set_ray(i, ray);
      if (!by_rows_ || c == 0) {
        const Terms pixel = terms(ray);
        at_.push_back(static_cast<float>(pixel.at));
        slope_.push_back(static_cast<float>(pixel.slope));
        least_.push_back(static_cast<float>(pixel.least));
      }
    }
  }
}

PlaneTriangulation::PlaneTriangulation(const rig::Rig& rig, int bits, DepthLimits limits, const rig::CodedLines& lines)
    : PlaneTriangulation(
          rig.camera.rows, rig.camera.columns, bits, rig::depth_matrices(rig, bits, lines),
          [&] {
            limits.max_z_per_line_mm = rig.measure.max_z_per_line_mm;
            return limits;
          }(),
          std::ldexp(1.0, bits) / (lines.count > 0 ? lines.count : rig::coded_height(rig.projector.lines, bits))) {}

// H_P = (e1 n0 - n1 e0) / (n0 - C n1). In front of the projector both have one sign, which `sign_` makes positive.
PlaneTriangulation::Terms PlaneTriangulation::terms(const cv::Vec3d& ray) const {
  const double n0 = row_of(projector_, 0).dot(ray);
  const double n1 = row_of(projector_, 1).dot(ray);
  const double fall = sign_ * (e1_ * n0 - n1 * e0_);
  // |dz/dC| codes_per_line = fall codes_per_line / denominator^2 <= limit
  const double least = fall > 0 ? std::sqrt(fall * coarse_) : std::numeric_limits<double>::infinity();
  return {sign_ * n0, sign_ * n1, least};
}

void PlaneTriangulation::depth(const std::uint16_t* codes, float* z) const {
  const Common common{static_cast<float>(sign_ * e0_), static_cast<float>(sign_ * e1_), static_cast<float>(center_[2]),
                      static_cast<float>(low_), static_cast<float>(high_)};
  if (!by_rows_) {
    depth_of_pixels(codes, static_cast<std::ptrdiff_t>(pixels()), at_.data(), slope_.data(), least_.data(), common, z);
    return;
  }
  for (int r = 0; r < rows(); ++r) {
    const auto row = static_cast<std::size_t>(r);
    const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(r) * columns();
    depth_of_row(codes + first, columns(), at_[row], slope_[row], least_[row], common, z + first);
  }
}

void PlaneTriangulation::depth_of_lines(int row, const float* lines, float* z) const {
  const Common common{static_cast<float>(sign_ * e0_), static_cast<float>(sign_ * e1_), static_cast<float>(center_[2]),
                      static_cast<float>(low_), static_cast<float>(high_)};
  const auto per_line = static_cast<float>(codes_per_line_);
  if (by_rows_) {
    const auto r = static_cast<std::size_t>(row);
    depth_of_lines_of_row(lines, columns(), per_line, at_[r], slope_[r], least_[r], common, z);
    return;
  }
  const std::size_t first = static_cast<std::size_t>(row) * static_cast<std::size_t>(columns());
  for (std::size_t c = 0; c < static_cast<std::size_t>(columns()); ++c) {
    z[c] = depth_of((lines[c] + 0.5F) * per_line, Measurable::yes, at_[first + c], slope_[first + c], least_[first + c],
                    common);
  }
}

PointState PlaneTriangulation::explain_code(std::size_t pixel, double code, float z) const {
  const std::size_t k = by_rows_ ? pixel / static_cast<std::size_t>(columns()) : pixel;
  const double denominator = static_cast<double>(at_[k]) - code * static_cast<double>(slope_[k]);
  const double distance = sign_ * (code * e1_ - e0_) / denominator;
  const bool out = center_[2] + distance <= low_ || center_[2] + distance >= high_;
  if (!std::isnan(z)) {
    return PointState::valid;
  }
  if (denominator <= 0 || distance <= 0 || std::isinf(least_[k])) {
    return PointState::no_intersection;
  }
  return denominator <= static_cast<double>(least_[k]) || !out ? PointState::too_coarse : PointState::out_of_range;
}

double PlaneTriangulation::rounding_error(std::size_t pixel, float z) const {
  const std::size_t k = by_rows_ ? pixel / static_cast<std::size_t>(columns()) : pixel;
  const auto at = static_cast<double>(at_[k]);
  const auto slope = static_cast<double>(slope_[k]);
  const double distance = static_cast<double>(z) - center_[2];
  // The code, with a fraction, whose plane meets the ray there, and |dz/dC| as above.
  const double code = (distance * at + sign_ * e0_) / (distance * slope + sign_ * e1_);
  const double denominator = at - code * slope;
  return std::abs(e1_ * at - slope * e0_) / (denominator * denominator) / std::sqrt(12.0);
}

PointState PlaneTriangulation::explain_line(std::size_t pixel, float line, float z) const {
  return std::isnan(line) ? PointState::no_line
                          : explain_code(pixel, (static_cast<double>(line) + 0.5) * codes_per_line_, z);
}

void PlaneTriangulation::explain(const std::uint16_t* codes, const float* z, PointState* states) const {
  for (std::size_t i = 0; i < pixels(); ++i) {
    states[i] = std::isnan(z[i]) && (codes[i] & model::GrayDecoder::kMeasurable) == 0
                    ? PointState::not_measurable
                    : explain_code(i, (codes[i] & model::GrayDecoder::kCode) + 0.5, z[i]);
  }
}

namespace {

constexpr std::array<const char*, kPointStates> kNames{"valid",      "not_measurable", "no_line", "no_intersection",
                                                       "too_coarse", "out_of_range",   "off_line"};

}  // namespace

std::size_t DepthShares::total() const { return std::accumulate(count.begin(), count.end(), std::size_t{0}); }

DepthShares count_states(const std::vector<PointState>& states) {
  DepthShares shares;
  for (const PointState state : states) {
    ++shares.count[static_cast<std::size_t>(state)];
  }
  return shares;
}

const char* name_of(PointState state) { return kNames[static_cast<std::size_t>(state)]; }

std::string share_text(const DepthShares& shares, PointState state) {
  return fmt::format("{:.2f} % {}", 100.0 * static_cast<double>(shares.of(state)) / static_cast<double>(shares.total()),
                     name_of(state));
}

}  // namespace selfproj::structured_light
