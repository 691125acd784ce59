#include "selfproj/structured_light/lens_triangulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <opencv2/core.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/structured_light/check.h"
#include "selfproj/files/user_error.h"
#include "selfproj/images/float_image.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/rig/calibration.h"
#include "selfproj/rig/calibration_file.h"
#include "selfproj/structured_light/triangulation.h"

namespace selfproj::structured_light {

LensTriangulation::LensTriangulation(const rig::Calibration& calibration, const LensSettings& settings)
    : Triangulation(settings.rows, settings.columns, settings.bits),
      calibration_(settings.rows_are_x ? rig::with_axes_exchanged(calibration) : calibration),
      settings_(settings) {
  check(settings.row_bits >= 0 && settings.row_bits <= model::GrayDecoder::kMaxBits,
        "triangulation: row bits out of range");
  if (settings_.lines <= 0) {
    settings_.lines = std::ldexp(1.0, settings.bits);
  }
  if (settings_.row_lines <= 0) {
    settings_.row_lines = std::ldexp(1.0, settings.row_bits);
  }
  set_origin({0, 0, 0});
  std::size_t i = 0;
  for (int r = 0; r < settings.rows; ++r) {
    for (int c = 0; c < settings.columns; ++c, ++i) {
      const std::optional<cv::Vec2d> ray =
          calibration_.camera.ray(settings.rows_are_x ? cv::Vec2d(r, c) : cv::Vec2d(c, r));
      if (!ray) {
        throw std::invalid_argument("triangulation: the camera's distortion cannot be undone at column " +
                                    std::to_string(c) + ", row " + std::to_string(r));
      }
      set_ray(i, {(*ray)[0], (*ray)[1], 1});
    }
  }
  // The direction in which the projector column moves with z along the middle ray: from the column of the camera's own
  // centre towards that of the point at infinity. Undistorted: d/dz of (A_x z + T_x)/(A_z z + T_z).
  const std::size_t middle =
      (static_cast<std::size_t>(settings.rows) / 2) * static_cast<std::size_t>(settings.columns) +
      static_cast<std::size_t>(settings.columns) / 2;
  const Point3f one = point(middle, 1);
  const cv::Vec3d a = calibration_.rotation * cv::Vec3d(static_cast<double>(one.x), static_cast<double>(one.y), 1);
  const cv::Vec3d& t = calibration_.translation;
  sign_ = (a[0] * t[2] - t[0] * a[2]) * calibration_.projector.fx < 0 ? -1 : 1;
}

cv::Vec2d LensTriangulation::image(const cv::Vec3d& ray, double z, cv::Vec2d& derivative) const {
  const cv::Vec3d at = ray * z + calibration_.translation;
  const cv::Vec2d flat(at[0] / at[2], at[1] / at[2]);
  cv::Matx22d lens;
  const cv::Vec2d pixel = calibration_.projector.pixel(flat, lens);
  derivative = lens * (cv::Vec2d(ray[0] - flat[0] * ray[2], ray[1] - flat[1] * ray[2]) * (1 / at[2]));
  return pixel;
}

LensTriangulation::Found LensTriangulation::solve(std::size_t pixel, std::uint16_t code,
                                                  const std::uint16_t* row_code) const {
  constexpr int kSteps = 20;
  constexpr double kClose = 1e-7;  // mm
  Found found;
  const auto fails = [&found](PointState state) {
    found.state = state;
    return found;
  };
  const bool measurable = (code & model::GrayDecoder::kMeasurable) != 0 &&
                          (row_code == nullptr || (*row_code & model::GrayDecoder::kMeasurable) != 0);
  if (!measurable) {
    return fails(PointState::not_measurable);
  }
  const rig::Lens& lens = calibration_.projector;
  const double column = ((code & model::GrayDecoder::kCode) + 0.5) * std::ldexp(settings_.lines, -settings_.bits) - 0.5;
  double row = lens.cy;
  if (row_code != nullptr) {
    row = ((*row_code & model::GrayDecoder::kCode) + 0.5) * std::ldexp(settings_.row_lines, -settings_.row_bits) - 0.5;
  }
  const bool on = (calibration_.projector_columns == 0 || column <= calibration_.projector_columns - 0.5) &&
                  (row_code == nullptr || calibration_.projector_rows == 0 || row <= calibration_.projector_rows - 0.5);
  if (!on) {
    return fails(PointState::no_line);
  }
  const Point3f one = point(pixel, 1);
  const cv::Vec3d ray = calibration_.rotation * cv::Vec3d(static_cast<double>(one.x), static_cast<double>(one.y), 1);
  const cv::Vec3d& t = calibration_.translation;
  // A first z from the plane of the column at this row and, with both codes, that of the row at this column (least
  // squares): below or above the camera, a projector's columns say nothing.
  const std::optional<cv::Vec2d> flat = lens.ray({column, row});
  if (!flat) {
    return fails(PointState::no_intersection);
  }
  const cv::Vec2d per_z(ray[0] - (*flat)[0] * ray[2], ray[1] - (*flat)[1] * ray[2]);
  const cv::Vec2d at((*flat)[0] * t[2] - t[0], (*flat)[1] * t[2] - t[1]);
  double z = row_code == nullptr ? at[0] / per_z[0] : per_z.dot(at) / per_z.dot(per_z);
  cv::Vec2d slope;
  cv::Vec2d off;
  bool converged = false;
  for (int step = 0; step < kSteps && !converged; ++step) {
    if (!(z > 0 && ray[2] * z + t[2] > 0)) {
      return fails(PointState::no_intersection);
    }
    off = image(ray, z, slope) - cv::Vec2d(column, row);
    const double change = row_code == nullptr ? off[0] / slope[0] : off.dot(slope) / slope.dot(slope);
    z -= change;
    converged = std::abs(change) < kClose;
  }
  // With the columns alone, z must change with them as in the middle of the image.
  if (!converged || !(z > 0 && ray[2] * z + t[2] > 0) || (row_code == nullptr && !(slope[0] * sign_ > 0))) {
    return fails(PointState::no_intersection);
  }
  found.z = z;
  found.residual = row_code == nullptr ? 0 : std::hypot(off[0], off[1]);
  const DepthLimits& limits = settings_.limits;
  if (!(1 < limits.max_z_per_line_mm * (row_code == nullptr ? std::abs(slope[0]) : cv::norm(slope)))) {
    return fails(PointState::too_coarse);
  }
  if (!(z > limits.min_z_mm && z < limits.max_z_mm)) {
    return fails(PointState::out_of_range);
  }
  if (found.residual > settings_.max_residual_px) {
    return fails(PointState::off_line);
  }
  return found;
}

void LensTriangulation::depth(const std::uint16_t* codes, float* z) const {
  for (std::size_t i = 0; i < pixels(); ++i) {
    const Found found = solve(i, codes[i], nullptr);
    z[i] = found.state == PointState::valid ? static_cast<float>(found.z) : images::kNoValue;
  }
}

void LensTriangulation::explain(const std::uint16_t* codes, const float* /*z*/, PointState* states) const {
  for (std::size_t i = 0; i < pixels(); ++i) {
    states[i] = solve(i, codes[i], nullptr).state;
  }
}

double LensTriangulation::rounding_error(std::size_t pixel, float z) const {
  const Point3f one = point(pixel, 1);
  const cv::Vec3d ray = calibration_.rotation * cv::Vec3d(static_cast<double>(one.x), static_cast<double>(one.y), 1);
  cv::Vec2d slope;
  (void)image(ray, static_cast<double>(z), slope);
  const double columns = std::ldexp(settings_.lines, -settings_.bits) / std::sqrt(12.0);
  if (settings_.row_bits == 0) {
    return std::abs(columns / slope[0]);
  }
  const double rows = std::ldexp(settings_.row_lines, -settings_.row_bits) / std::sqrt(12.0);
  return std::hypot(slope[0] * columns, slope[1] * rows) / slope.dot(slope);
}

void LensTriangulation::depth_of_both(const std::uint16_t* codes, const std::uint16_t* row_codes, float* z,
                                      PointState* states, float* residual_px) const {
  for (std::size_t i = 0; i < pixels(); ++i) {
    const Found found = solve(i, codes[i], row_codes + i);
    const bool valid = found.state == PointState::valid;
    z[i] = valid ? static_cast<float>(found.z) : images::kNoValue;
    if (states != nullptr) {
      states[i] = found.state;
    }
    if (residual_px != nullptr) {
      residual_px[i] = valid ? static_cast<float>(found.residual) : images::kNoValue;
    }
  }
}

namespace {

constexpr std::array<int, 4> kDegrees = {3, 5, 7, 9};
constexpr double kMaxRejected = 0.1;  // share of the pixels
constexpr double kMinFitted = 0.1;    // lines: of less, rounding makes too much
constexpr double kMinRange = 1;       // lines: a range is widened to this

}  // namespace

// Where a pixel is fitted: the undistorted line f and z at Chebyshev's places of its range.
struct LensLines::Nodes {
  double first = 1, last = 0;
  cv::Vec2d ray;
  cv::Vec3d turned;  // the ray in the projector's axes
  std::array<double, kNodes> f{}, z{}, series{};
};

LensLines::LensLines(const rig::Rig& rig, const std::vector<LineRange>& ranges, const DepthLimits& limits)
    : optics_(rig), limits_(limits), columns_(rig.camera.columns) {
  check(ranges.size() == rig.camera.pixels(), "lens lines: as many ranges are needed as the camera has pixels");
  const cv::Vec3d move = optics_.to_projector({0, 0, 0});
  move_x_ = move[0];
  move_z_ = move[2];
  std::vector<Nodes> nodes;
  nodes.reserve(ranges.size());
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    nodes.push_back(nodes_of(i, ranges[i]));
    const Nodes& at = nodes.back();
    first_.push_back(static_cast<float>(at.first));
    last_.push_back(static_cast<float>(at.last));
    middle_.push_back(static_cast<float>(0.5 * (at.first + at.last)));
    inverse_half_.push_back(static_cast<float>(at.last > at.first ? 2 / (at.last - at.first) : 0));
    ray_x_.push_back(at.turned[0]);
    ray_z_.push_back(at.turned[2]);
  }
  for (const int degree : kDegrees) {
    degree_ = degree;
    const std::vector<std::size_t> missed = fit(nodes, degree);
    if (missed.empty()) {
      return;
    }
    if (degree == kDegrees.back()) {
      reject(missed);
    }
  }
}

void LensLines::reject(const std::vector<std::size_t>& pixels) {
  if (static_cast<double>(pixels.size()) > kMaxRejected * static_cast<double>(first_.size())) {
    throw UserError(
        optics_.rig().name,
        fmt::format("depths at {} of {} pixels are more than {} mm off when fitted by polynomials of degree "
                    "{}; {:g} % are allowed",
                    pixels.size(), first_.size(), kMaxError, degree_, 100 * kMaxRejected));
  }
  for (const std::size_t i : pixels) {
    first_[i] = 1;
    last_[i] = 0;
  }
}

std::optional<cv::Vec2d> LensLines::ray_of(std::size_t pixel) const {
  const std::size_t row = pixel / static_cast<std::size_t>(columns_);
  const std::size_t column = pixel % static_cast<std::size_t>(columns_);
  return optics_.ray({static_cast<double>(row), static_cast<double>(column)});
}

// The range is cut to the lines that the ray meets, and at which a line is worth no more than the rig's limit.
LensLines::Nodes LensLines::nodes_of(std::size_t pixel, const LineRange& range) const {
  constexpr int kSteps = 8;
  constexpr int kHalvings = 12;
  Nodes nodes;
  const std::optional<cv::Vec2d> ray = ray_of(pixel);
  if (!ray || !(range.first <= range.last)) {
    return nodes;
  }
  nodes.ray = *ray;
  nodes.turned = optics_.to_projector({(*ray)[0], (*ray)[1], 1}) - optics_.to_projector({0, 0, 0});
  const double middle_column = 0.5 * (optics_.rig().projector.columns - 1);
  const auto z_at = [&](double line) -> std::optional<double> {
    const std::optional<double> z = optics_.meet(*ray, {line, 0, middle_column});
    return z && optics_.z_per_line(*ray, *z) <= optics_.rig().measure.max_z_per_line_mm ? z : std::nullopt;
  };
  double low = static_cast<double>(range.first);
  double high = static_cast<double>(range.last);
  if (high - low < kMinRange) {
    low -= 0.5 * kMinRange;
    high += 0.5 * kMinRange;
  }
  // Some line of the range that is good, and how far it goes on to both sides.
  std::optional<double> good;
  for (int i = 0; i <= kSteps && !good; ++i) {
    const double line = low + (high - low) * ((kSteps / 2 + i) % (kSteps + 1)) / kSteps;
    good = z_at(line) ? std::optional(line) : std::nullopt;
  }
  if (!good) {
    return nodes;
  }
  const auto reach = [&](double from, double to) {
    if (z_at(to)) {
      return to;
    }
    double bad = to;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (from + bad);
      (z_at(middle) ? from : bad) = middle;
    }
    return from;
  };
  nodes.first = reach(*good, low);
  nodes.last = reach(*good, high);
  if (nodes.last - nodes.first < kMinFitted) {
    nodes.first = 1;
    nodes.last = 0;
    return nodes;
  }
  for (std::size_t k = 0; k < kNodes; ++k) {
    const double place = -std::cos(std::numbers::pi * (static_cast<double>(k) + 0.5) / kNodes);
    const double line = 0.5 * (nodes.first + nodes.last) + 0.5 * (nodes.last - nodes.first) * place;
    const std::optional<double> z = z_at(line);
    if (!z) {
      nodes.first = 1;
      nodes.last = 0;
      return nodes;
    }
    const cv::Vec3d at = optics_.to_projector({(*ray)[0] * *z, (*ray)[1] * *z, *z});
    nodes.f.at(k) = at[0] / at[2];
    nodes.z.at(k) = *z;
  }
  nodes.series = series_of(nodes);
  return nodes;
}

// All coefficients of Chebyshev's series that the places determine. Its first terms are the fit; the rest is its error,
// and twice its last two stand for what comes after them.
auto LensLines::series_of(const Nodes& nodes) -> std::array<double, kNodes> {
  std::array<double, kNodes> series{};
  for (std::size_t n = 0; n < kNodes; ++n) {
    for (std::size_t k = 0; k < kNodes; ++k) {
      const double angle = std::numbers::pi * (1 - (static_cast<double>(k) + 0.5) / kNodes);
      series.at(n) += (n == 0 ? 1.0 : 2.0) / kNodes * nodes.f.at(k) * std::cos(static_cast<double>(n) * angle);
    }
  }
  return series;
}

// Returns the pixels that miss kMaxError.
std::vector<std::size_t> LensLines::fit(const std::vector<Nodes>& nodes, int degree) {
  const std::size_t count = nodes.size();
  const std::size_t terms = static_cast<std::size_t>(degree) + 1;
  coefficients_.assign(terms * count, 0);
  // The coefficients of Chebyshev's polynomials by powers.
  std::vector<std::vector<double>> powers(terms, std::vector<double>(terms, 0));
  powers[0][0] = 1;
  powers[1][1] = 1;
  for (std::size_t n = 2; n < terms; ++n) {
    for (std::size_t p = 0; p <= n; ++p) {
      powers[n][p] = (p > 0 ? 2 * powers[n - 1][p - 1] : 0) - powers[n - 2][p];
    }
  }
  const cv::Vec3d move = optics_.to_projector({0, 0, 0});
  fit_error_ = 0;
  std::vector<std::size_t> missed;
  for (std::size_t i = 0; i < count; ++i) {
    const Nodes& at = nodes[i];
    if (!(at.first < at.last)) {
      continue;
    }
    double off = std::abs(at.series[kNodes - 2]) + std::abs(at.series[kNodes - 1]);
    for (std::size_t n = terms; n < kNodes; ++n) {
      off += std::abs(at.series.at(n));
    }
    std::vector<double> by_power(terms, 0);
    for (std::size_t n = 0; n < terms; ++n) {
      for (std::size_t p = 0; p <= n; ++p) {
        by_power[p] += at.series.at(n) * powers[n][p];
      }
    }
    for (std::size_t p = 0; p < terms; ++p) {
      coefficients_[p * count + i] = static_cast<float>(by_power[p]);
    }
    double greatest = 0;
    for (std::size_t k = 0; k < kNodes; ++k) {
      const double below = at.turned[0] - at.f.at(k) * at.turned[2];
      greatest = std::max(greatest, off * std::abs((move[2] + at.z.at(k) * at.turned[2]) / below));  // dz/df
    }
    if (greatest <= kMaxError) {
      fit_error_ = std::max(fit_error_, greatest);
    } else {
      missed.push_back(i);
    }
  }
  return missed;
}

void LensLines::depth_of_lines(int row, const float* lines, float* z) const {
  const std::size_t count = first_.size();
  const std::size_t begin = static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_);
  const auto low = static_cast<float>(std::max(0.0, limits_.min_z_mm));
  const auto high = static_cast<float>(limits_.max_z_mm);
  for (std::size_t c = 0; c < static_cast<std::size_t>(columns_); ++c) {
    const std::size_t i = begin + c;
    const double s = static_cast<double>((lines[c] - middle_[i]) * inverse_half_[i]);
    double f = static_cast<double>(coefficients_[static_cast<std::size_t>(degree_) * count + i]);
    for (auto p = static_cast<std::size_t>(degree_); p-- > 0;) {
      f = f * s + static_cast<double>(coefficients_[p * count + i]);
    }
    // In double precision, as both terms vanish where the ray passes through the projector's centre.
    const auto found = static_cast<float>((f * move_z_ - move_x_) / (ray_x_[i] - f * ray_z_[i]));
    const bool valid = lines[c] >= first_[i] && lines[c] <= last_[i] && found > low && found < high;
    z[c] = valid ? found : images::kNoValue;
  }
}

PointState LensLines::explain_line(std::size_t pixel, float line, float z) const {
  if (std::isnan(line)) {
    return PointState::no_line;
  }
  if (!std::isnan(z)) {
    return PointState::valid;
  }
  const std::optional<cv::Vec2d> ray = ray_of(pixel);
  const std::optional<double> met =
      ray ? optics_.meet(*ray, {static_cast<double>(line), 0, 0.5 * (optics_.rig().projector.columns - 1)})
          : std::nullopt;
  if (!met) {
    return PointState::no_intersection;
  }
  const bool coarse = !(optics_.z_per_line(*ray, *met) <= optics_.rig().measure.max_z_per_line_mm);
  return coarse ? PointState::too_coarse : PointState::out_of_range;
}

}  // namespace selfproj::structured_light
