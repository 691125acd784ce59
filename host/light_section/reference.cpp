#include "selfproj/light_section/reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/rig/geometry.h"
#include "selfproj/rig/optics.h"

namespace selfproj::light_section {
namespace {

// The straight pieces of a section, and what of them can be seen from a point.

// Millimetres. A wall that begins where a surface ends does not hide that end.
constexpr double kTouch = 1e-6;

struct SectionPoint {
  double y;
  double z;
};

// The straight piece between two neighbours of a curve.
struct SectionJoin {
  SectionPoint a;
  SectionPoint b;
  bool wall;
};

// Where the join meets the straight line p y + q z = r, if it does.
bool crossing(const SectionJoin& join, double p, double q, double r, SectionPoint& at) {
  const double a = p * join.a.y + q * join.a.z - r;
  const double b = p * join.b.y + q * join.b.z - r;
  if ((a > 0 && b > 0) || (a < 0 && b < 0) || (a == 0 && b == 0)) {
    return false;
  }
  const double t = a / (a - b);
  at = {join.a.y + t * (join.b.y - join.a.y), join.a.z + t * (join.b.z - join.a.z)};
  return true;
}

// The joins of a curve. A curve of a scene has tens of thousands, so groups of neighbours have bounds: a straight line
// that does not meet these meets no join of the group.
class SectionJoins {
 public:
  explicit SectionJoins(const ReferenceCurve& curve);

  // Calls visit(join, point), in the order of the curve, where a join meets p y + q z = r, until it returns false.
  template <class Visit>
  void cross(double p, double q, double r, Visit visit) const {
    for (std::size_t group = 0; group < bounds_.size(); ++group) {
      const Bounds& b = bounds_[group];
      if (p * (p > 0 ? b.high.y : b.low.y) + q * (q > 0 ? b.high.z : b.low.z) - r < 0 ||
          p * (p > 0 ? b.low.y : b.high.y) + q * (q > 0 ? b.low.z : b.high.z) - r > 0) {
        continue;
      }
      const std::size_t end = std::min(joins_.size(), (group + 1) * kGroup);
      for (std::size_t i = group * kGroup; i < end; ++i) {
        SectionPoint at{};
        if (crossing(joins_[i], p, q, r, at) && !visit(joins_[i], at)) {
          return;
        }
      }
    }
  }

 private:
  static constexpr std::size_t kGroup = 64;

  struct Bounds {
    SectionPoint low, high;
  };

  std::vector<SectionJoin> joins_;
  std::vector<Bounds> bounds_;
};

SectionJoins::SectionJoins(const ReferenceCurve& curve) {
  for (std::size_t i = 0; i + 1 < curve.y_mm.size(); ++i) {
    const SectionPoint a{curve.y_mm[i], curve.z_mm[i]};
    const SectionPoint b{curve.y_mm[i + 1], curve.z_mm[i + 1]};
    if (std::isfinite(a.y) && std::isfinite(a.z) && std::isfinite(b.y) && std::isfinite(b.z)) {
      joins_.push_back({a, b, std::abs(b.z - a.z) > kSteepest * std::abs(b.y - a.y)});
    }
  }
  for (std::size_t i = 0; i < joins_.size(); ++i) {
    const auto& [a, b, wall] = joins_[i];
    const SectionPoint low{std::min(a.y, b.y), std::min(a.z, b.z)};
    const SectionPoint high{std::max(a.y, b.y), std::max(a.z, b.z)};
    if (i % kGroup == 0) {
      bounds_.push_back({low, high});
    }
    Bounds& all = bounds_.back();
    all.low = {std::min(all.low.y, low.y), std::min(all.low.z, low.z)};
    all.high = {std::max(all.high.y, high.y), std::max(all.high.z, high.z)};
  }
}

// Whether a part of the curve lies between the viewpoint and the point, seen along x.
bool hidden(const SectionJoins& joins, const SectionPoint& viewpoint, const SectionPoint& point) {
  const double depth = point.z - viewpoint.z;
  const double side = point.y - viewpoint.y;
  bool found = false;
  joins.cross(depth, -side, depth * viewpoint.y - side * viewpoint.z, [&](const SectionJoin&, SectionPoint at) {
    found = at.z > viewpoint.z && at.z < point.z - kTouch;
    return !found;
  });
  return found;
}

// What a camera column sees of the section: the nearest join with y = z tan β, and where. If a surface ends at a wall,
// it is the surface. Null if there is none.
struct SectionSight {
  const SectionJoin* join = nullptr;
  SectionPoint at{0, std::numeric_limits<double>::infinity()};
};
SectionSight sight_along(const SectionJoins& joins, double tan_beta) {
  SectionSight sight;
  joins.cross(1, -tan_beta, 0, [&](const SectionJoin& join, SectionPoint at) {
    const bool nearer = at.z < sight.at.z - kTouch;
    const bool better = sight.join != nullptr && sight.join->wall && !join.wall && at.z < sight.at.z + kTouch;
    if (at.z > 0 && (nearer || better)) {
      sight = {&join, at};
    }
    return true;
  });
  return sight;
}

double middle_of(const rig::Rig& rig) { return 0.5 * (rig.camera.rows - 1); }

// What lights the point that a camera place sees at depth z (corrected), if it is before the projector.
std::optional<rig::ProjectorPlace> light_on(const rig::RigOptics& optics, const rig::CameraPlace& place, double z) {
  const std::optional<cv::Vec2d> ray = optics.ray(place);
  if (!ray) {
    return std::nullopt;
  }
  const double depth = optics.uncorrected(place, z);
  return optics.lit_by({(*ray)[0] * depth, (*ray)[1] * depth, depth});
}

// A place of the camera, what it sees of the section, and what lights that.
struct Sample {
  bool lit = false;
  SectionPoint at{};
  rig::ProjectorPlace light;
};

class Section {
 public:
  Section(const rig::Rig& rig, const ReferenceCurve& curve) : optics_(rig), joins_(curve) {
    if (optics_.has_projector()) {
      const cv::Vec3d centre = optics_.projector_centre();
      projector_ = {centre[1], centre[2]};
    }
  }

  [[nodiscard]] const rig::RigOptics& optics() const { return optics_; }

  // The surface that a camera place sees, if it is no wall.
  [[nodiscard]] std::optional<SectionPoint> surface(const rig::CameraPlace& place) const {
    const std::optional<cv::Vec2d> ray = optics_.ray(place);
    const SectionSight sight = ray ? sight_along(joins_, (*ray)[1]) : SectionSight{};
    return sight.join != nullptr && !sight.join->wall ? std::optional(sight.at) : std::nullopt;
  }

  [[nodiscard]] Sample sample(const rig::CameraPlace& place) const {
    Sample sample;
    const std::optional<SectionPoint> at = surface(place);
    const std::optional<rig::ProjectorPlace> light = at ? light_on(optics_, place, at->z) : std::nullopt;
    if (!light) {
      return sample;
    }
    sample.at = *at;
    sample.light = *light;
    const rig::Rig& rig = optics_.rig();
    const double half = 0.5 * rig.measure.line_width_px;
    sample.lit = light->line - half >= -0.5 && light->line + half <= rig.projector.lines - 0.5 &&
                 light->column >= -0.5 && light->column <= rig.projector.columns - 0.5 &&
                 optics_.z_per_line(*optics_.ray(place), at->z) <= rig.measure.max_z_per_line_mm &&
                 !hidden(joins_, projector_, *at);
    return sample;
  }

 private:
  rig::RigOptics optics_;
  SectionJoins joins_;
  SectionPoint projector_{};
};

bool on_one_surface(const SectionPoint& a, const SectionPoint& b) {
  return std::abs(b.z - a.z) <= kSteepest * std::abs(b.y - a.y);
}

void set_invalid(ReferenceProfile& reference, std::size_t i) {
  reference.valid[i] = 0;
  reference.line[i] = reference.slope[i] = reference.z_mm[i] = reference.offset_px[i] = rig::kUnknown;
}

// The slopes of the light from the columns beside each, as far as they are on one surface.
void set_slopes(const rig::RigOptics& optics, ReferenceProfile& reference) {
  constexpr int kReach = 3;
  const int columns = reference.columns();
  std::vector<rig::ProjectorPlace> light(static_cast<std::size_t>(columns));
  std::vector<SectionPoint> at(light.size());
  for (int c = 0; c < columns; ++c) {
    const auto i = static_cast<std::size_t>(c);
    if (reference.valid[i] != 0) {
      const rig::CameraPlace place{middle_of(optics.rig()) + reference.offset_px[i], static_cast<double>(c)};
      light[i] = *light_on(optics, place, reference.z_mm[i]);
      at[i] = {reference.z_mm[i] * (*optics.ray(place))[1], reference.z_mm[i]};
    }
  }
  const auto end_of = [&](int c, int step) {
    int end = c;
    while (std::abs(end - c) < kReach && end + step >= 0 && end + step < columns &&
           reference.valid[static_cast<std::size_t>(end + step)] != 0 &&
           on_one_surface(at[static_cast<std::size_t>(end)], at[static_cast<std::size_t>(end + step)])) {
      end += step;
    }
    return static_cast<std::size_t>(end);
  };
  for (int c = 0; c < columns; ++c) {
    const auto i = static_cast<std::size_t>(c);
    if (reference.valid[i] != 0) {
      const rig::ProjectorPlace& a = light[end_of(c, -1)];
      const rig::ProjectorPlace& b = light[end_of(c, 1)];
      const double across = b.column - a.column;
      reference.slope[i] = std::abs(across) > 1e-6 ? (b.line - a.line) / across : 0;
    }
  }
}

// The row (from 0) at which the camera column sees the laser on the section: where the depth of the laser's plane
// crosses that of the surface. If there are several, that nearest to the camera.
std::optional<rig::CameraPlace> laser_on(const Section& section, int column, double& z) {
  constexpr double kStep = 0.25;
  const rig::RigOptics& optics = section.optics();
  // Depth of the plane less depth of the surface; NaN if there is none of them.
  const auto over = [&](double row, double& depth) {
    const rig::CameraPlace place{row, static_cast<double>(column)};
    const std::optional<cv::Vec2d> ray = optics.ray(place);
    const std::optional<double> plane = ray ? optics.meet(*ray, {}) : std::nullopt;
    const std::optional<SectionPoint> surface = section.surface(place);
    depth = plane ? optics.corrected(place, *plane) : rig::kUnknown;
    return plane && surface ? depth - surface->z : rig::kUnknown;
  };
  std::optional<rig::CameraPlace> best;
  double depth = 0;
  double before = over(0, depth);
  for (double row = kStep; row <= optics.rig().camera.rows - 1; row += kStep) {
    double at_depth = 0;
    const double here = over(row, at_depth);
    if (before * here <= 0) {  // false for NaN
      double low = row - kStep;
      double high = row;
      for (int i = 0; i < 40; ++i) {
        const double middle = 0.5 * (low + high);
        (over(middle, at_depth) * before > 0 ? low : high) = middle;
      }
      const double off = over(low, at_depth);
      if (std::abs(off) < 1e-6 && (!best || at_depth < z)) {
        best = {low, static_cast<double>(column)};
        z = at_depth;
      }
    }
    before = here;
  }
  return best;
}

ReferenceProfile laser_reference_of_curve(const Section& section) {
  const rig::Rig& rig = section.optics().rig();
  ReferenceProfile reference;
  reference.resize_for_lenses(rig.camera.columns);
  for (std::size_t i = 0; i < reference.valid.size(); ++i) {
    double z = 0;
    const std::optional<rig::CameraPlace> place = laser_on(section, static_cast<int>(i), z);
    set_invalid(reference, i);
    if (place) {
      reference.valid[i] = 1;
      reference.line[i] = reference.slope[i] = 0;
      reference.z_mm[i] = z;
      reference.offset_px[i] = place->row - middle_of(rig);
    }
  }
  return reference;
}

ReferenceProfile lens_reference_of_curve(const rig::Rig& rig, const ReferenceCurve& curve) {
  const Section section(rig, curve);
  if (!section.optics().has_projector()) {
    return laser_reference_of_curve(section);
  }
  ReferenceProfile reference;
  reference.resize_for_lenses(rig.camera.columns);
  for (std::size_t i = 0; i < reference.valid.size(); ++i) {
    const Sample sample = section.sample({middle_of(rig), static_cast<double>(i)});
    set_invalid(reference, i);
    if (sample.lit) {
      reference.valid[i] = 1;
      reference.line[i] = sample.light.line;
      reference.z_mm[i] = sample.at.z;
      reference.offset_px[i] = 0;
    }
  }
  set_slopes(section.optics(), reference);
  return reference;
}

// Of columns that see the projector line `line` at the row `row` (from 0); invalid where one of them is NaN.
ReferenceProfile lens_reference_of_places(const rig::RigOptics& optics, const std::vector<double>& row,
                                          const std::vector<double>& line) {
  const rig::Rig& rig = optics.rig();
  ReferenceProfile reference;
  reference.resize_for_lenses(rig.camera.columns);
  for (std::size_t i = 0; i < row.size(); ++i) {
    set_invalid(reference, i);
    const rig::CameraPlace place{row[i], static_cast<double>(i)};
    const std::optional<cv::Vec2d> ray =
        std::isfinite(row[i]) && std::isfinite(line[i]) ? optics.ray(place) : std::nullopt;
    const std::optional<double> z =
        ray ? optics.meet(*ray, {line[i], 0, 0.5 * (rig.projector.columns - 1)}) : std::nullopt;
    if (z) {
      reference.valid[i] = 1;
      reference.line[i] = optics.has_projector() ? line[i] : 0;
      reference.slope[i] = 0;
      reference.z_mm[i] = optics.corrected(place, *z);
      reference.offset_px[i] = row[i] - middle_of(rig);
    }
  }
  return reference;
}

ReferenceProfile lens_without_residual(const rig::Rig& rig, const ReferenceProfile& reference,
                                       std::span<const double> centroid) {
  const rig::RigOptics optics(rig);
  ReferenceProfile result = reference;
  for (std::size_t i = 0; i < centroid.size(); ++i) {
    const rig::CameraPlace place{centroid[i] - 1, static_cast<double>(i)};
    const bool measured = result.valid[i] != 0 && std::isfinite(centroid[i]);
    const std::optional<rig::ProjectorPlace> light =
        measured && optics.has_projector() ? light_on(optics, place, result.z_mm[i]) : std::nullopt;
    if (light) {
      result.line[i] = light->line;
      result.offset_px[i] = place.row - middle_of(rig);
    } else if (measured && !optics.has_projector()) {
      // The laser's plane is known, and says where the reference is.
      const std::optional<cv::Vec2d> ray = optics.ray(place);
      const std::optional<double> z = ray ? optics.meet(*ray, {}) : std::nullopt;
      result.valid[i] = z ? 1 : 0;
      result.z_mm[i] = z ? optics.corrected(place, *z) : rig::kUnknown;
      result.offset_px[i] = place.row - middle_of(rig);
    } else {
      set_invalid(result, i);
    }
  }
  result.measured = selection_of(rig.measure.of_board());
  return result;
}

// The camera's middle row is followed in steps of an eighth of a column, also beyond the image.
std::vector<double> lens_pattern_of_curve(const rig::Rig& rig, const ReferenceCurve& curve) {
  constexpr int kPerColumn = 8;
  constexpr int kBeyond = 16;
  const Section section(rig, curve);
  std::vector<double> lines(static_cast<std::size_t>(rig.projector.columns), rig::kUnknown);
  std::vector<double> nearest(lines.size(), std::numeric_limits<double>::infinity());
  Sample before;
  for (int step = -kBeyond * kPerColumn; step <= (rig.camera.columns - 1 + kBeyond) * kPerColumn; ++step) {
    const Sample here = section.sample({middle_of(rig), static_cast<double>(step) / kPerColumn});
    if (before.lit && here.lit && on_one_surface(before.at, here.at)) {
      const auto [a, b] = std::minmax(
          before, here, [](const Sample& one, const Sample& other) { return one.light.column < other.light.column; });
      const int first = std::max(0, static_cast<int>(std::ceil(a.light.column)));
      const int last = std::min(rig.projector.columns - 1, static_cast<int>(std::floor(b.light.column)));
      for (int p = first; p <= last; ++p) {
        const double t = (p - a.light.column) / (b.light.column - a.light.column);
        const double z = a.at.z + t * (b.at.z - a.at.z);
        const auto i = static_cast<std::size_t>(p);
        if (z < nearest[i]) {
          nearest[i] = z;
          lines[i] = a.light.line + t * (b.light.line - a.light.line);
        }
      }
    }
    before = here;
  }
  return lines;
}

void expect_columns(const rig::Rig& rig, std::size_t given) {
  if (given != static_cast<std::size_t>(rig.camera.columns)) {
    throw std::invalid_argument("reference: as many values are needed as the camera has columns");
  }
}

// Whether a pattern line with this centre lies completely in the projector's image.
bool in_image(const rig::Rig& rig, double line) {
  const double half = 0.5 * rig.measure.line_width_px;
  return line - half >= -0.5 && line + half <= rig.projector.lines - 0.5;
}

// The change of z from one projector line to the next at Xc = 0, mm: the derivative of (3.4).
double z_per_line(const rig::Rig& rig, double tan_theta) {
  const double cosine = std::cos(std::atan(tan_theta) - rig.projector.tilt_rad);
  const double step = std::abs(rig.projector.line_pitch_mm) * (1 + tan_theta * tan_theta) * cosine * cosine /
                      rig.projector.focal_length_mm;  // of tan θ
  return step * rig.projector.x_mm / (tan_theta * tan_theta);
}

// Whether the projector lights the point of the curve.
bool is_lit(const rig::Rig& rig, const SectionJoins& joins, const SectionPoint& point) {
  if (point.z <= rig.projector.z_mm || rig::projector_depth(rig.projector, point.z) <= 0) {
    return false;
  }
  const double column = rig::projector_column_on_middle(rig.projector, point.y, point.z);
  return in_image(rig, rig::line_on_middle(rig.projector, point.z)) && column >= -0.5 &&
         column <= rig.projector.columns - 0.5 && !hidden(joins, {0, rig.projector.z_mm}, point) &&
         z_per_line(rig, rig.projector.x_mm / (point.z - rig.projector.z_mm)) <= rig.measure.max_z_per_line_mm;
}

}  // namespace

MiddleRow::MiddleRow(const rig::Rig& rig) : camera_(rig.camera) {
  if (!rig.is_pinholes()) {
    optics_ = std::make_shared<const rig::RigOptics>(rig);
  }
}

double MiddleRow::tan_beta(double column) const {
  if (!optics_) {
    return selfproj::rig::tan_beta(camera_, column);
  }
  const std::optional<cv::Vec2d> ray = optics_->ray({0.5 * (camera_.rows - 1), column});
  return ray ? (*ray)[1] : rig::kUnknown;
}

std::optional<rig::LightSheet> sheet_of(const rig::RigOptics& optics, const ReferenceProfile& reference, int column) {
  const auto i = static_cast<std::size_t>(column);
  if (reference.valid[i] == 0) {
    return std::nullopt;
  }
  if (!optics.has_projector()) {
    return rig::LightSheet{};
  }
  const rig::CameraPlace place{middle_of(optics.rig()) + reference.offset_px[i], static_cast<double>(column)};
  const std::optional<rig::ProjectorPlace> light = light_on(optics, place, reference.z_mm[i]);
  return light ? std::optional(rig::LightSheet{light->line, reference.slope[i], light->column}) : std::nullopt;
}

namespace {

// y of the laser's light at depth z in a column, where it crosses it; NaN if the column does not see it there.
double laser_across(const rig::RigOptics& optics, int column, double z) {
  const auto off = [&](double row) {
    const rig::CameraPlace place{row, static_cast<double>(column)};
    const std::optional<cv::Vec2d> ray = optics.ray(place);
    const std::optional<double> met = ray ? optics.meet(*ray, {}) : std::nullopt;
    return met ? optics.corrected(place, *met) - z : rig::kUnknown;
  };
  for (int row = 1; row < optics.rig().camera.rows; ++row) {
    double low = row - 1;
    double high = row;
    const double before = off(low);
    if (!(before * off(high) <= 0)) {  // true for NaN
      continue;
    }
    constexpr int kHalvings = 40;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (low + high);
      (off(middle) * before > 0 ? low : high) = middle;
    }
    return z * (*optics.ray({low, static_cast<double>(column)}))[1];
  }
  return rig::kUnknown;
}

}  // namespace

ReferenceCurve curve_of_heights(const rig::Rig& rig, std::span<const double> height_mm) {
  expect_columns(rig, height_mm.size());
  if (rig.light_plane) {
    const rig::RigOptics optics(rig);
    ReferenceCurve curve;
    for (std::size_t i = 0; i < height_mm.size(); ++i) {
      const double z = rig.plane_z_mm - height_mm[i];
      curve.z_mm.push_back(z);
      curve.y_mm.push_back(laser_across(optics, static_cast<int>(i), z));
    }
    return curve;
  }
  const MiddleRow middle(rig);
  ReferenceCurve curve;
  for (std::size_t i = 0; i < height_mm.size(); ++i) {
    const double z = rig.plane_z_mm - height_mm[i];
    curve.z_mm.push_back(z);
    curve.y_mm.push_back(z * middle.tan_beta(static_cast<double>(i)));
  }
  return curve;
}

ReferenceCurve curve_of_reference(const rig::Rig& rig, const ReferenceProfile& reference) {
  expect_columns(rig, reference.valid.size());
  const MiddleRow middle(rig);
  const int columns = rig.camera.columns;
  const auto z_of = [&](int column) {
    const auto i = static_cast<std::size_t>(column);
    return reference.valid[i] != 0 ? reference.z_mm[i] : rig::kUnknown;
  };
  // Continues from the column `border` with the slope of the last `kBeyond` columns, in the direction against `inward`;
  // NaN if one of these two columns is invalid.
  constexpr int kBeyond = 8;
  const auto beyond = [&](int border, int inward, int steps) {
    return columns <= kBeyond ? rig::kUnknown
                              : z_of(border) + (z_of(border) - z_of(border + inward * kBeyond)) * steps / kBeyond;
  };
  ReferenceCurve curve;
  for (int i = -kBeyond; i < columns + kBeyond; ++i) {
    const double z = i < 0 ? beyond(0, 1, -i) : i >= columns ? beyond(columns - 1, -1, i - columns + 1) : z_of(i);
    curve.z_mm.push_back(z);
    curve.y_mm.push_back(z * middle.tan_beta(i));
  }
  return curve;
}

ReferenceProfile reference_of_curve(const rig::Rig& rig, const ReferenceCurve& curve) {
  if (!rig.is_pinholes()) {
    return lens_reference_of_curve(rig, curve);
  }
  const SectionJoins joins(curve);
  ReferenceProfile reference;
  reference.resize(rig.camera.columns);
  for (std::size_t i = 0; i < reference.valid.size(); ++i) {
    const SectionSight seen = sight_along(joins, rig::tan_beta(rig.camera, static_cast<double>(i)));
    const SectionPoint& nearest = seen.at;
    const bool valid = seen.join != nullptr && !seen.join->wall && is_lit(rig, joins, nearest);
    reference.valid[i] = valid ? 1 : 0;
    reference.z_mm[i] = valid ? nearest.z : rig::kUnknown;
    reference.tan_theta[i] = valid ? rig.projector.x_mm / (nearest.z - rig.projector.z_mm) : rig::kUnknown;  // (3.8)
    reference.offset_px[i] = valid ? 0 : rig::kUnknown;
  }
  return reference;
}

ReferenceProfile reference_of_plane(const rig::Rig& rig) {
  if (rig.light_plane) {         // its line need not lie on the middle row, which sees less of the plane or more
    constexpr double kFar = 10;  // times the plane's distance
    const double far = kFar * rig.plane_z_mm;
    return reference_of_curve(rig, {{-far, far}, {rig.plane_z_mm, rig.plane_z_mm}});
  }
  const std::vector<double> heights(static_cast<std::size_t>(rig.camera.columns), 0.0);
  return reference_of_curve(rig, curve_of_heights(rig, heights));
}

ReferenceProfile reference_of_straight_line(const rig::Rig& rig, double line, std::span<const double> centroid) {
  expect_columns(rig, centroid.size());
  if (!rig.is_pinholes()) {
    std::vector<double> rows(centroid.begin(), centroid.end());
    std::for_each(rows.begin(), rows.end(), [](double& row) { row -= 1; });  // centroids count from 1
    return lens_reference_of_places(rig::RigOptics(rig), rows, std::vector<double>(rows.size(), line));
  }
  const double theta = rig::tan_theta(rig.projector, line);
  ReferenceProfile reference;
  reference.resize(rig.camera.columns);
  for (std::size_t i = 0; i < centroid.size(); ++i) {
    const double sum = rig::tan_alpha(rig.camera, centroid[i]) + theta;
    const bool valid = std::isfinite(centroid[i]) && sum > 0;
    reference.valid[i] = valid ? 1 : 0;
    reference.tan_theta[i] = theta;
    reference.z_mm[i] = valid ? (rig.projector.x_mm + rig.projector.z_mm * theta) / sum : rig::kUnknown;  // (3.4)
    reference.offset_px[i] = valid ? centroid[i] - rig::middle_row(rig.camera) : rig::kUnknown;
  }
  return reference;
}

ReferenceProfile reference_of_scan(const rig::Rig& rig, std::span<const double> line) {
  expect_columns(rig, line.size());
  if (!rig.is_pinholes()) {
    const rig::RigOptics optics(rig);
    ReferenceProfile reference =
        lens_reference_of_places(optics, std::vector<double>(line.size(), middle_of(rig)), {line.begin(), line.end()});
    set_slopes(optics, reference);
    return reference;
  }
  ReferenceProfile reference;
  reference.resize(rig.camera.columns);
  for (std::size_t i = 0; i < line.size(); ++i) {
    const bool valid = !std::isnan(line[i]);
    const double theta = valid ? rig::tan_theta(rig.projector, line[i]) : rig::kUnknown;
    reference.valid[i] = valid ? 1 : 0;
    reference.tan_theta[i] = theta;
    reference.z_mm[i] = valid ? rig.projector.x_mm / theta + rig.projector.z_mm : rig::kUnknown;  // (3.8)
    reference.offset_px[i] = valid ? 0 : rig::kUnknown;
  }
  return reference;
}

std::string unlike_reference(const std::optional<Selection>& reference, const Selection& frames, int offset, int rows) {
  if (!reference) {
    return {};
  }
  // Rows of the sensor that the frame has
  const auto with_rows = [&](Selection of, int moved) {
    of.window = {std::max(of.window.first + moved, offset + 1),
                 of.window.last == 0 ? offset + rows : std::min(of.window.last + moved, offset + rows)};
    return of;
  };
  const Selection wanted = with_rows(*reference, 0);
  const Selection found = with_rows(frames, offset);
  if (wanted == found) {
    return {};
  }
  const auto words = [&](const Selection& of) {
    return fmt::format(
        "{}, rows {}..{}",
        of.select == model::Select::all ? "all lit pixels" : fmt::format("the strongest run, gap {}", of.gap),
        of.window.first, of.window.last);
  };
  return fmt::format("of its columns counted {}; in the images of the reference it was {}", words(found),
                     words(wanted));
}

ReferenceProfile without_residual(const rig::Rig& rig, const ReferenceProfile& reference,
                                  std::span<const double> centroid) {
  expect_columns(rig, centroid.size());
  expect_columns(rig, reference.valid.size());
  if (!rig.is_pinholes()) {
    return lens_without_residual(rig, reference, centroid);
  }
  ReferenceProfile result = reference;
  for (std::size_t i = 0; i < centroid.size(); ++i) {
    if (result.valid[i] == 0 || !std::isfinite(centroid[i])) {
      result.valid[i] = 0;
      result.tan_theta[i] = result.z_mm[i] = result.offset_px[i] = rig::kUnknown;
      continue;
    }
    const double x = result.z_mm[i] * rig::tan_alpha(rig.camera, centroid[i]);
    result.tan_theta[i] = (rig.projector.x_mm - x) / (result.z_mm[i] - rig.projector.z_mm);
    result.offset_px[i] = centroid[i] - rig::middle_row(rig.camera);
  }
  result.measured = selection_of(rig.measure.of_board());
  return result;
}

ReferenceProfile without_walls(const rig::Rig& rig, ReferenceProfile reference) {
  expect_columns(rig, reference.valid.size());
  const MiddleRow middle(rig);
  const std::vector<double>& light = rig.is_pinholes() ? reference.tan_theta : reference.line;
  const auto at = [&](int column) {
    const double z = reference.z_mm[static_cast<std::size_t>(column)];
    return SectionPoint{z * middle.tan_beta(column), z};
  };
  std::vector<int> lit;
  for (int c = 0; c < reference.columns(); ++c) {
    if (reference.valid[static_cast<std::size_t>(c)] != 0) {
      lit.push_back(c);
    }
  }
  for (std::size_t k = 1; k < lit.size(); ++k) {
    const int left = lit[k - 1];
    const int right = lit[k];
    const bool apart = right - left > 1 || !on_one_surface(at(left), at(right));
    if (apart && light[static_cast<std::size_t>(left)] != light[static_cast<std::size_t>(right)]) {
      const int first = std::max(0, static_cast<int>(std::ceil(left - kBesideWalls)));
      const int last = std::min(reference.columns() - 1, static_cast<int>(std::floor(right + kBesideWalls)));
      std::fill(reference.valid.begin() + first, reference.valid.begin() + last + 1, std::uint8_t{0});
    }
  }
  return reference;
}

std::vector<double> pattern_of_curve(const rig::Rig& rig, const ReferenceCurve& curve) {
  if (!rig.is_pinholes()) {
    return lens_pattern_of_curve(rig, curve);
  }
  const rig::RigProjector& projector = rig.projector;
  const SectionJoins joins(curve);
  std::vector<double> lines(static_cast<std::size_t>(projector.columns), rig::kUnknown);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const double yp =
        projector.center_yp_mm + projector.column_pitch_mm * (static_cast<double>(i) - 0.5 * (projector.columns - 1));
    // The points of the plane x = 0 that the column lights: y fp = Yp ((z - z0) cos θ0 + x0 sin θ0).
    const double slope = yp * std::cos(projector.tilt_rad);
    const double level = yp * rig::projector_depth(projector, 0);
    double nearest = std::numeric_limits<double>::infinity();
    joins.cross(projector.focal_length_mm, -slope, level, [&](const SectionJoin& join, SectionPoint at) {
      if (!join.wall && at.z < nearest && is_lit(rig, joins, at) && !hidden(joins, {0, 0}, at)) {
        nearest = at.z;
        lines[i] = rig::line_on_middle(projector, at.z);
      }
      return true;
    });
  }
  return lines;
}

}  // namespace selfproj::light_section
