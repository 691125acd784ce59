#include "sim/scene/projected_light.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "selfproj/files/user_error.h"
#include "selfproj/images/float_image.h"
#include "sim/scene/optics.h"

namespace selfproj::sim {
namespace {

constexpr double kReach = kKernelReach;
constexpr int kLevels = 6;  // of blur by defocus

// The blurred pattern with `margin` dark pixels around it.
images::FloatImage blurred(const images::FloatImage& pattern, int margin, double sigma) {
  images::FloatImage image(pattern.rows + 2 * margin, pattern.columns + 2 * margin);
  for (int r = 0; r < pattern.rows; ++r) {
    std::copy_n(pattern.row(r), pattern.columns, image.row(r + margin) + margin);
  }
  if (sigma <= 0) {
    return image;
  }
  const std::vector<double> kernel = gaussian_kernel(sigma);
  const int reach = static_cast<int>(kernel.size() / 2);
  images::FloatImage half(image.rows, image.columns);  // blurred across lines
  for (int r = 0; r < image.rows; ++r) {
    const float* from = image.row(r);
    if (std::all_of(from, from + image.columns, [](float value) { return value == 0; })) {
      continue;
    }
    for (int k = -reach; k <= reach; ++k) {
      if (r + k < 0 || r + k >= image.rows) {
        continue;
      }
      const auto weight = static_cast<float>(kernel[static_cast<std::size_t>(k + reach)]);
      float* to = half.row(r + k);
      for (int c = 0; c < image.columns; ++c) {
        to[c] += weight * from[c];
      }
    }
  }
  std::fill(image.values.begin(), image.values.end(), 0.0F);
  for (int r = 0; r < image.rows; ++r) {
    const float* from = half.row(r);
    if (std::all_of(from, from + image.columns, [](float value) { return value == 0; })) {
      continue;
    }
    float* to = image.row(r);
    for (int k = -reach; k <= reach; ++k) {
      const auto weight = static_cast<float>(kernel[static_cast<std::size_t>(k + reach)]);
      const int first = std::max(0, k);
      const int last = std::min(image.columns, image.columns + k);
      for (int c = first; c < last; ++c) {
        to[c] += weight * from[c - k];
      }
    }
  }
  return image;
}

std::vector<double> centres_of(const images::FloatImage& pattern) {
  const auto columns = static_cast<std::size_t>(pattern.columns);
  std::vector<double> m0(columns);
  std::vector<double> m1(columns);
  for (int r = 0; r < pattern.rows; ++r) {
    for (std::size_t c = 0; c < columns; ++c) {
      m0[c] += static_cast<double>(pattern.row(r)[c]);
      m1[c] += static_cast<double>(pattern.row(r)[c]) * r;
    }
  }
  for (std::size_t c = 0; c < columns; ++c) {
    m1[c] = m0[c] > 0 ? m1[c] / m0[c] : std::numeric_limits<double>::quiet_NaN();
  }
  return m1;
}

}  // namespace

double ProjectorFocus::sigma_px(double line, double column, double z) const {
  const Point3 along = projector.ray({line, column});
  return lens.sigma_px((z - projector.centre().z) / along.z);
}

ProjectedLight::ProjectedLight(const images::FloatImage& pattern, double blur,
                               const std::optional<ProjectorFocus>& focus)
    : margin_(static_cast<int>(std::ceil(kReach * blur)) + 1),
      light_(blurred(pattern, margin_, blur)),
      ranges_(light_),
      centres_(centres_of(pattern)),
      focus_(focus) {
  if (!focus) {
    return;
  }
  double most = 0;
  for (const double line : {0.0, pattern.rows - 1.0}) {
    for (const double column : {0.0, pattern.columns - 1.0}) {
      for (const double z : {focus->nearest_z, focus->farthest_z}) {
        most = std::max(most, focus->sigma_px(line, column, z));
      }
    }
  }
  variance_step_ = most * most / kLevels;
  for (int level = 1; level <= kLevels && most > 0; ++level) {
    wider_.emplace_back(pattern, std::sqrt(blur * blur + level * variance_step_));
  }
}

// Between two blurred patterns the mixture's variance is linear, and so exact.
double ProjectedLight::focused_at(PixelPoint p, double z) const {
  if (wider_.empty()) {
    return at(p);
  }
  const double sigma = focus_->sigma_px(p.row, p.column, z);
  const double level = std::clamp(sigma * sigma / variance_step_, 0.0, static_cast<double>(wider_.size()));
  const auto below = std::min(static_cast<std::size_t>(level), wider_.size() - 1);
  const double f = level - static_cast<double>(below);
  const ProjectedLight& sharper = below == 0 ? *this : wider_[below - 1];
  return (1 - f) * sharper.at(p) + f * wider_[below].at(p);
}

ProjectedLight::Part ProjectedLight::in(int first_line, int last_line, int first_column, int last_column) const {
  Part part{0, 0, {}};
  for (int line = first_line; line <= last_line; ++line) {
    for (int column = first_column; column <= last_column; ++column) {
      const auto light = static_cast<double>(light_.row(line + margin_)[column + margin_]);
      part.sum += light;
      part.pixels += light > 0 ? 1 : 0;
      part.middle.row += light * line;
      part.middle.column += light * column;
    }
  }
  if (part.sum > 0) {
    part.middle = {part.middle.row / part.sum, part.middle.column / part.sum};
  }
  return part;
}

double ProjectedLight::at(PixelPoint p) const {
  const double r = p.row + margin_;
  const double c = p.column + margin_;
  if (!(r > 0 && c > 0 && r < light_.rows - 1 && c < light_.columns - 1)) {
    return 0;
  }
  const int r0 = static_cast<int>(r);
  const int c0 = static_cast<int>(c);
  const double fr = r - r0;
  const double fc = c - c0;
  const float* above = light_.row(r0) + c0;
  const float* below = above + light_.columns;
  return (1 - fr) * ((1 - fc) * static_cast<double>(above[0]) + fc * static_cast<double>(above[1])) +
         fr * ((1 - fc) * static_cast<double>(below[0]) + fc * static_cast<double>(below[1]));
}

MinMaxPyramid::Range ProjectedLight::range(double line_0, double line_1, double column_0, double column_1) const {
  const double last_row = light_.rows - 1.0;
  const double last_column = light_.columns - 1.0;
  const double r0 = std::max(0.0, std::floor(line_0 + margin_));
  const double r1 = std::min(last_row, std::ceil(line_1 + margin_));
  const double c0 = std::max(0.0, std::floor(column_0 + margin_));
  const double c1 = std::min(last_column, std::ceil(column_1 + margin_));
  if (r0 > r1 || c0 > c1) {
    return wider_.empty() ? MinMaxPyramid::Range{0, 0} : wider_.back().range(line_0, line_1, column_0, column_1);
  }
  MinMaxPyramid::Range found =
      ranges_.range(static_cast<int>(r0), static_cast<int>(r1), static_cast<int>(c0), static_cast<int>(c1));
  if (line_0 + margin_ < 0 || line_1 + margin_ > last_row || column_0 + margin_ < 0 ||
      column_1 + margin_ > last_column) {
    found.low = std::min(found.low, 0.0F);  // outside the pattern
  }
  for (const ProjectedLight& light : wider_) {
    const MinMaxPyramid::Range other = light.range(line_0, line_1, column_0, column_1);
    found = {std::min(found.low, other.low), std::max(found.high, other.high)};
  }
  return found;
}

bool ProjectedLight::is_dark(double line_0, double line_1, double column_0, double column_1) const {
  return range(line_0, line_1, column_0, column_1).high <= 0;
}

std::optional<ProjectedLight::Centres> ProjectedLight::line_centres(double first, double last) const {
  if (!(first >= 0 && last < static_cast<double>(centres_.size() - 1))) {
    return std::nullopt;
  }
  const auto begin = centres_.begin() + static_cast<std::ptrdiff_t>(first);
  const auto end = centres_.begin() + static_cast<std::ptrdiff_t>(last) + 2;
  if (std::any_of(begin, end, [](double centre) { return std::isnan(centre); })) {
    return std::nullopt;
  }
  const auto [low, high] = std::minmax_element(begin, end);
  return Centres{*low, *high};
}

double ProjectedLight::line_centre(double column) const {
  const auto last = static_cast<double>(centres_.size() - 1);
  if (!(column >= 0 && column <= last)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const auto c0 = static_cast<std::size_t>(column);
  const std::size_t c1 = std::min(c0 + 1, centres_.size() - 1);
  const double f = column - static_cast<double>(c0);
  return f == 0 ? centres_[c0] : (1 - f) * centres_[c0] + f * centres_[c1];
}

float light_through(const ProjectorGamma& gamma, float wanted) {
  constexpr double kFull = 255;
  const double level = std::round(kFull * std::pow(static_cast<double>(wanted), 1 / gamma.compensated)) / kFull;
  return static_cast<float>(std::pow(level, gamma.gamma));
}

images::FloatImage light_through(const ProjectorGamma& gamma, const images::FloatImage& wanted) {
  images::FloatImage light = wanted;
  std::transform(light.values.begin(), light.values.end(), light.values.begin(),
                 [&](float value) { return light_through(gamma, value); });
  return light;
}

ProjectedLight throw_light(const rig::Rig& rig, const images::FloatImage& pattern, const RenderOptions& options) {
  std::optional<ProjectorFocus> focus;
  if (options.world.projector_defocus) {
    const Defocus& defocus = *options.world.projector_defocus;
    const rig::RigProjector& size = rig.projector;
    const Pinhole projector = Pinhole::of_projector(size);
    const double sharp = projector.depth({0, 0, rig.plane_z_mm - defocus.focus_above_plane_mm});
    constexpr double kHighest = 150;  // mm above the plane: as high as parts are
    const double pitch = std::sqrt(std::abs(size.line_pitch_mm * size.column_pitch_mm));
    focus.emplace(ProjectorFocus{
        {size.focal_length_mm, defocus.f_number, pitch, sharp}, projector, rig.plane_z_mm - kHighest, rig.plane_z_mm});
  }
  const double blur = options.projector_blur ? rig.imaging.projector_blur_px : 0;
  return options.world.gamma ? ProjectedLight(light_through(*options.world.gamma, pattern), blur, focus)
                             : ProjectedLight(pattern, blur, focus);
}

void check_pattern(const images::FloatImage& pattern, const rig::RigProjector& projector, const std::string& source) {
  if (pattern.rows != projector.lines || pattern.columns != projector.columns) {
    throw UserError(source, fmt::format("has {} lines of {} columns; the rig's projector has {} of {}", pattern.rows,
                                        pattern.columns, projector.lines, projector.columns));
  }
  const auto wrong = std::find_if_not(pattern.values.begin(), pattern.values.end(),
                                      [](float value) { return value >= 0 && value <= 1; });
  if (wrong != pattern.values.end()) {
    throw UserError(source, fmt::format("has a value of {}; light is 0 to 1", *wrong));
  }
}

ProjectedLight project_image(const rig::Rig& rig, const images::Image& image, const RenderOptions& options,
                             const std::string& source) {
  constexpr float kFull = 255;
  images::FloatImage light(image.rows, image.columns);
  std::transform(image.pixels.begin(), image.pixels.end(), light.values.begin(),
                 [](std::uint8_t value) { return static_cast<float>(value) / kFull; });
  check_pattern(light, rig.projector, source);
  return throw_light(rig, light, options);
}

PatternSet::PatternSet(const rig::Rig& rig, std::span<const images::Image> images, const RenderOptions& options) {
  if (images.empty()) {
    throw std::invalid_argument("a set of no patterns");
  }
  light_.reserve(images.size());
  for (const images::Image& image : images) {
    light_.push_back(project_image(rig, image, options));
  }
}

// g_2i = floor(2^i Y/H + 1/2) mod 2, in integers. H is 2^m where the lines are fewer, so that line v has code v.
std::vector<images::Image> gray_patterns(const rig::RigProjector& projector, int bits) {
  constexpr int kMaxBits = 12;
  if (bits < 1 || bits > kMaxBits) {
    throw std::invalid_argument("Gray patterns of other than 1..12 bits");
  }
  constexpr std::uint8_t kFull = 255;
  const std::int64_t height = std::max<std::int64_t>(projector.lines, std::int64_t{1} << bits);
  std::vector<images::Image> patterns;
  for (int i = 0; i < bits; ++i) {
    for (const bool positive : {true, false}) {
      images::Image image{projector.lines, projector.columns, {}};
      image.pixels.reserve(static_cast<std::size_t>(projector.lines) * static_cast<std::size_t>(projector.columns));
      for (std::int64_t line = 0; line < projector.lines; ++line) {
        const bool lit = ((2 * (line << i) + height) / (2 * height)) % 2 == 1;
        image.pixels.insert(image.pixels.end(), static_cast<std::size_t>(projector.columns),
                            lit == positive ? kFull : std::uint8_t{0});
      }
      patterns.push_back(std::move(image));
    }
  }
  return patterns;
}

}  // namespace selfproj::sim
