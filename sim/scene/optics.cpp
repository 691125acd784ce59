#include "sim/scene/optics.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <mutex>
#include <numbers>
#include <optional>
#include <span>
#include <stdexcept>
#include <vector>

#include "selfproj/rig/rig.h"

namespace selfproj::sim {
namespace {

// d(r (1 + k1 r² + k2 r⁴ + k3 r⁶)) / dr
double radial_slope(const BrownLens::Coefficients& c, double r2) {
  return 1 + r2 * (3 * c.k1 + r2 * (5 * c.k2 + r2 * 7 * c.k3));
}

// The square of the angle's tangent at which the image begins to fold over.
double fold(const BrownLens::Coefficients& c) {
  constexpr double kStep = 1e-3;
  constexpr double kMost = 9;       // 72 degrees
  constexpr double kShallow = 0.1;  // leaves room for the tangential terms
  double r2 = 0;
  while (r2 < kMost && radial_slope(c, r2) > kShallow) {
    r2 += kStep;
  }
  return r2;
}

}  // namespace

BrownLens::BrownLens(const Coefficients& c)
    : c_(c),
      distorts_(c.k1 != 0 || c.k2 != 0 || c.p1 != 0 || c.p2 != 0 || c.k3 != 0),
      max_r2_(distorts_ ? fold(c) : kUnlimited) {}

Tangents BrownLens::distorted(Tangents ray) const {
  const double x = ray.across;
  const double y = ray.down;
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (c_.k1 + r2 * (c_.k2 + r2 * c_.k3));
  return {x * radial + 2 * c_.p1 * x * y + c_.p2 * (r2 + 2 * x * x),
          y * radial + c_.p1 * (r2 + 2 * y * y) + 2 * c_.p2 * x * y};
}

// Newton's method with the exact derivatives. It ends when a step no longer changes the ray but in its last digits.
Tangents BrownLens::undistorted(Tangents image) const {
  if (!distorts_) {
    return image;
  }
  constexpr int kMaxSteps = 50;
  constexpr double kLastDigits = 1e-30;  // of the square of the step
  Tangents ray = image;
  for (int i = 0; i < kMaxSteps; ++i) {
    const double x = ray.across;
    const double y = ray.down;
    const double r2 = x * x + y * y;
    const double radial = 1 + r2 * (c_.k1 + r2 * (c_.k2 + r2 * c_.k3));
    const double slope = 2 * (c_.k1 + r2 * (2 * c_.k2 + r2 * 3 * c_.k3));  // of `radial`, by x is slope x
    const double xx = radial + slope * x * x + 2 * c_.p1 * y + 6 * c_.p2 * x;
    const double xy = slope * x * y + 2 * c_.p1 * x + 2 * c_.p2 * y;  // of x by y, and of y by x
    const double yy = radial + slope * y * y + 6 * c_.p1 * y + 2 * c_.p2 * x;
    const Tangents found = distorted(ray);
    const double dx = image.across - found.across;
    const double dy = image.down - found.down;
    const double determinant = xx * yy - xy * xy;
    const double step_x = (yy * dx - xy * dy) / determinant;
    const double step_y = (xx * dy - xy * dx) / determinant;
    ray = {x + step_x, y + step_y};
    if (step_x * step_x + step_y * step_y <= kLastDigits * (1 + r2) && sees(ray)) {
      return ray;
    }
  }
  throw std::invalid_argument(
      fmt::format("the lens shows no ray at the tangents ({:g}, {:g})", image.across, image.down));
}

double BrownLens::stretch(double reach) const {
  const double r2 = reach * reach;
  return r2 * (3 * std::abs(c_.k1) + r2 * (5 * std::abs(c_.k2) + r2 * 7 * std::abs(c_.k3))) +
         8 * reach * (std::abs(c_.p1) + std::abs(c_.p2));
}

namespace {

// Grows to hold all points that are added to it.
class Bounds {
 public:
  void add(double row, double column) {
    b_ = {std::min(b_.row_0, row), std::max(b_.row_1, row), std::min(b_.column_0, column),
          std::max(b_.column_1, column)};
  }
  [[nodiscard]] const PixelBounds& all() const { return b_; }

 private:
  static constexpr double kMost = std::numeric_limits<double>::max();
  PixelBounds b_{kMost, -kMost, kMost, -kMost};
};

}  // namespace

Pinhole::Pinhole(Point3 centre, const std::array<Point3, 3>& axes, const Intrinsics& k, const BrownLens& lens)
    : centre_(centre), axes_(axes), k_(k), lens_(lens) {
  // K R: each row is the direction of a pixel axis, scaled, plus the optical axis times the principal point.
  const std::array<Point3, 3> kr{k.row_scale * axes[0] + k.row_0 * axes[2],
                                 k.column_scale * axes[1] + k.column_0 * axes[2], axes[2]};
  for (std::size_t i = 0; i < kr.size(); ++i) {
    matrix_[i] = {kr[i].x, kr[i].y, kr[i].z, -dot(kr[i], centre)};
  }
}

Pinhole Pinhole::of_camera(const rig::RigCamera& camera) {
  const double scale = camera.focal_length_mm / camera.pixel_pitch_mm;
  return {{0, 0, 0},
          {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
          {scale, scale, (camera.rows - 1) / 2.0, (camera.columns - 1) / 2.0}};
}

// The axis, tilted from z towards −x, is (−sin θ0, 0, cos θ0). Xp grows in the direction in which it turns as θ0 grows.
Pinhole Pinhole::of_projector(const rig::RigProjector& projector) {
  const double s = std::sin(projector.tilt_rad);
  const double c = std::cos(projector.tilt_rad);
  return {{projector.x_mm, 0, projector.z_mm},
          {{{-c, 0, -s}, {0, 1, 0}, {-s, 0, c}}},
          {projector.focal_length_mm / projector.line_pitch_mm, projector.focal_length_mm / projector.column_pitch_mm,
           (projector.lines - 1) / 2.0 - projector.center_xp_mm / projector.line_pitch_mm,
           (projector.columns - 1) / 2.0 - projector.center_yp_mm / projector.column_pitch_mm}};
}

Tangents Pinhole::tangents_of(Point3 p) const {
  const Point3 from = p - centre_;
  const double w = 1 / dot(axes_[2], from);
  return {dot(axes_[1], from) * w, dot(axes_[0], from) * w};
}

PixelPoint Pinhole::project_distorted(Point3 p) const {
  const Tangents ray = tangents_of(p);
  if (!lens_.sees(ray)) {
    constexpr double kFar = -1e6;
    return {kFar, kFar};
  }
  return pixel_of(lens_.distorted(ray));
}

Point3 Pinhole::ray(PixelPoint pixel) const {
  const Tangents ray =
      lens_.undistorted({(pixel.column - k_.column_0) / k_.column_scale, (pixel.row - k_.row_0) / k_.row_scale});
  return ray.down * axes_[0] + ray.across * axes_[1] + axes_[2];
}

std::array<Point3, 4> Pinhole::corner_sights(PixelPoint first, PixelPoint last) const {
  const double bend = lens_.distorts() ? kBend : 0;
  return {sight({first.row - bend, first.column - bend}), sight({first.row - bend, last.column + bend}),
          sight({last.row + bend, first.column - bend}), sight({last.row + bend, last.column + bend})};
}

// Without distortion the image of a convex body is convex, so its corners bound it. With distortion they bound its
// tangents; the lens then displaces each of these as it displaces the rectangle's middle, but for the stretch.
std::optional<PixelBounds> Pinhole::bounds(std::span<const Point3> points) const {
  if (std::any_of(points.begin(), points.end(), [&](Point3 p) { return depth(p) <= 0; })) {
    return std::nullopt;
  }
  Bounds result;
  if (!lens_.distorts()) {
    for (const Point3 p : points) {
      const PixelPoint pixel = project(p);
      result.add(pixel.row, pixel.column);
    }
    return result.all();
  }
  Bounds rays;  // rows are `down`, columns `across`
  for (const Point3 p : points) {
    const Tangents ray = tangents_of(p);
    rays.add(ray.down, ray.across);
  }
  const PixelBounds& r = rays.all();
  const Tangents middle{(r.column_0 + r.column_1) / 2, (r.row_0 + r.row_1) / 2};
  const Tangents moved = lens_.distorted(middle);
  const double reach =
      std::hypot(std::max(std::abs(r.row_0), std::abs(r.row_1)), std::max(std::abs(r.column_0), std::abs(r.column_1)));
  const double slack = lens_.stretch(reach) * std::hypot(r.row_1 - middle.down, r.column_1 - middle.across);
  for (const double down : {r.row_0 - slack, r.row_1 + slack}) {
    for (const double across : {r.column_0 - slack, r.column_1 + slack}) {
      const PixelPoint pixel = pixel_of({across + moved.across - middle.across, down + moved.down - middle.down});
      result.add(pixel.row, pixel.column);
    }
  }
  return result.all();
}

std::vector<double> gaussian_kernel(double sigma) {
  const int reach = static_cast<int>(std::ceil(kKernelReach * sigma));
  std::vector<double> kernel(static_cast<std::size_t>(2 * reach + 1));
  double sum = 0;
  for (int k = -reach; k <= reach; ++k) {
    const double weight = sigma > 0 ? std::exp(-0.5 * k * k / (sigma * sigma)) : 1;
    kernel[static_cast<std::size_t>(k + reach)] = weight;
    sum += weight;
  }
  for (double& weight : kernel) {
    weight /= sum;
  }
  return kernel;
}

int lens_margin(double blur) { return blur > 0 ? static_cast<int>(std::ceil(4 * blur)) : 0; }

std::vector<float> lens_kernel(double blur) {
  const int margin = lens_margin(blur);
  const auto below = [&](double d) {  // share of the Gaussian below d
    return blur > 0 ? 0.5 * std::erfc(-d / (blur * std::numbers::sqrt2)) : static_cast<double>(d > 0);
  };
  std::vector<double> weights;
  double sum = 0;
  for (int k = 0; k < (2 * margin + 1) * kSubPixels; ++k) {
    const double d = (k + 0.5) / kSubPixels - margin - 0.5;  // from the pixel's centre
    weights.push_back(below(d + 0.5) - below(d - 0.5));
    sum += weights.back();
  }
  std::vector<float> kernel(weights.size());
  std::transform(weights.begin(), weights.end(), kernel.begin(),
                 [sum](double weight) { return static_cast<float>(weight / sum); });
  return kernel;
}

namespace {

// All that a camera's sights depend on.
std::array<double, 21> numbers_of(const Pinhole& camera) {
  const Point3 c = camera.centre();
  const auto& a = camera.axes();
  const Pinhole::Intrinsics& k = camera.intrinsics();
  const BrownLens::Coefficients& l = camera.lens().coefficients();
  return {c.x,     c.y,        c.z,    a[0].x, a[0].y, a[0].z,      a[1].x,
          a[1].y,  a[1].z,     a[2].x, a[2].y, a[2].z, k.row_scale, k.column_scale,
          k.row_0, k.column_0, l.k1,   l.k2,   l.p1,   l.p2,        l.k3};
}

}  // namespace

SightTable::SightTable(const Pinhole& camera, const rig::RigCamera& size)
    : camera_(camera),
      rows_(static_cast<std::size_t>((size.rows + 2 * kMargin) * kSubPixels)),
      columns_(static_cast<std::size_t>((size.columns + 2 * kMargin) * kSubPixels)),
      sights_(rows_),
      ready_(rows_),
      filled_(std::make_unique<std::once_flag[]>(rows_)) {}  // NOLINT(modernize-avoid-c-arrays)

bool SightTable::is_of(const Pinhole& camera, const rig::RigCamera& size) const {
  return numbers_of(camera) == numbers_of(camera_) &&
         rows_ == static_cast<std::size_t>((size.rows + 2 * kMargin) * kSubPixels) &&
         columns_ == static_cast<std::size_t>((size.columns + 2 * kMargin) * kSubPixels);
}

const Point3* SightTable::fill(std::size_t row) const {
  std::call_once(filled_[row], [&] {
    const auto middle = [](std::size_t i) { return (static_cast<double>(i) + 0.5) / kSubPixels - 0.5 - kMargin; };
    sights_[row].reserve(columns_);
    for (std::size_t column = 0; column < columns_; ++column) {
      sights_[row].push_back(camera_.sight({middle(row), middle(column)}));
    }
    ready_[row].store(sights_[row].data(), std::memory_order_release);
  });
  return sights_[row].data();
}

std::shared_ptr<const SightTable> SightTable::of(const Pinhole& camera, const rig::RigCamera& size) {
  constexpr std::size_t kMost = std::size_t{64} << 20U;  // bytes
  constexpr std::size_t kSquare = std::size_t{kSubPixels} * kSubPixels;
  if (!camera.lens().distorts() || size.pixels() * kSquare * sizeof(Point3) > kMost) {
    return nullptr;
  }
  static std::mutex mutex;
  static std::array<std::shared_ptr<const SightTable>, 2> kept;  // the newest first
  const std::lock_guard lock(mutex);
  const auto found =
      std::find_if(kept.begin(), kept.end(), [&](const auto& table) { return table && table->is_of(camera, size); });
  if (found != kept.end()) {
    std::rotate(kept.begin(), found, found + 1);
  } else {
    kept[1] = kept[0];
    kept[0] = std::shared_ptr<const SightTable>(new SightTable(camera, size));
  }
  return kept[0];
}

namespace {

constexpr double kSampled = 0.6;  // pixels; from here on a sampled Gaussian is right

// Weights for standard deviations in steps, made when they are first needed.
class Weights {
 public:
  const std::vector<float>& of(float sigma) {
    constexpr float kStepsPerPixel = 64;
    const auto step = static_cast<std::size_t>(std::lround(std::max(0.0F, sigma) * kStepsPerPixel));
    if (step >= all_.size()) {
      all_.resize(step + 1);
    }
    if (all_[step].empty()) {
      all_[step] = spread_weights(static_cast<double>(step) / static_cast<double>(kStepsPerPixel));
    }
    return all_[step];
  }

 private:
  std::vector<std::vector<float>> all_;
};

}  // namespace

FocusedLens::FocusedLens(double focal_length, double f_number, double pitch, double focus)
    : scale_(focal_length * focal_length / (f_number * (focus - focal_length)) / 4 / pitch), focus_(focus) {}

double FocusedLens::sigma_px(double depth) const { return scale_ * std::abs(depth - focus_) / depth; }

std::vector<float> spread_weights(double sigma) {
  if (sigma < kSampled) {
    const auto side = static_cast<float>(sigma * sigma / 2);
    return {side, 1 - 2 * side, side};
  }
  const std::vector<double> kernel = gaussian_kernel(sigma);
  return {kernel.begin(), kernel.end()};
}

void spread(int rows, int columns, std::span<const float> sigma, std::span<float> pixels) {
  Weights weights;
  std::vector<float> half(pixels.size(), 0.0F);
  const auto pass = [&](std::span<const float> from, std::span<float> to, bool down) {
    std::fill(to.begin(), to.end(), 0.0F);
    const int last = (down ? rows : columns) - 1;
    const std::ptrdiff_t step = down ? columns : 1;
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        const std::ptrdiff_t i = static_cast<std::ptrdiff_t>(r) * columns + c;
        const std::vector<float>& w = weights.of(sigma[static_cast<std::size_t>(i)]);
        const int reach = static_cast<int>(w.size() / 2);
        const int place = down ? r : c;
        for (int k = -reach; k <= reach; ++k) {
          const int at = std::clamp(place + k, 0, last);  // at the border as much comes in as leaves
          to[static_cast<std::size_t>(i + (at - place) * step)] +=
              w[static_cast<std::size_t>(k + reach)] * from[static_cast<std::size_t>(i)];
        }
      }
    }
  };
  pass(pixels, half, true);
  pass(half, pixels, false);
}

}  // namespace selfproj::sim
