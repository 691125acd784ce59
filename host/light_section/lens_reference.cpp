#include "host/light_section/lens_reference.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "host/light_section/section_joins.h"
#include "host/rig/geometry.h"

namespace selfproj {
namespace {

double middle_of(const Rig& rig) { return 0.5 * (rig.camera.rows - 1); }

// What lights the point that a camera place sees at depth z (corrected), if it is before the projector.
std::optional<ProjectorPlace> light_on(const RigOptics& optics, const CameraPlace& place, double z) {
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
  ProjectorPlace light;
};

class Section {
 public:
  Section(const Rig& rig, const ReferenceCurve& curve) : optics_(rig), joins_(joins_of(curve)) {
    if (optics_.has_projector()) {
      const cv::Vec3d centre = optics_.projector_centre();
      projector_ = {centre[1], centre[2]};
    }
  }

  [[nodiscard]] const RigOptics& optics() const { return optics_; }

  // The surface that a camera place sees, if it is no wall.
  [[nodiscard]] std::optional<SectionPoint> surface(const CameraPlace& place) const {
    const std::optional<cv::Vec2d> ray = optics_.ray(place);
    const SectionSight sight = ray ? sight_along(joins_, (*ray)[1]) : SectionSight{};
    return sight.join != nullptr && !sight.join->wall ? std::optional(sight.at) : std::nullopt;
  }

  [[nodiscard]] Sample sample(const CameraPlace& place) const {
    Sample sample;
    const std::optional<SectionPoint> at = surface(place);
    const std::optional<ProjectorPlace> light = at ? light_on(optics_, place, at->z) : std::nullopt;
    if (!light) {
      return sample;
    }
    sample.at = *at;
    sample.light = *light;
    const Rig& rig = optics_.rig();
    const double half = 0.5 * rig.measure.line_width_px;
    sample.lit = light->line - half >= -0.5 && light->line + half <= rig.projector.lines - 0.5 &&
                 light->column >= -0.5 && light->column <= rig.projector.columns - 0.5 &&
                 optics_.z_per_line(*optics_.ray(place), at->z) <= rig.measure.max_z_per_line_mm &&
                 !hidden(joins_, projector_, *at);
    return sample;
  }

 private:
  RigOptics optics_;
  std::vector<SectionJoin> joins_;
  SectionPoint projector_{};
};

bool on_one_surface(const SectionPoint& a, const SectionPoint& b) {
  return std::abs(b.z - a.z) <= kSteepest * std::abs(b.y - a.y);
}

void set_invalid(ReferenceProfile& reference, std::size_t i) {
  reference.valid[i] = 0;
  reference.line[i] = reference.slope[i] = reference.z_mm[i] = reference.offset_px[i] = kUnknown;
}

// The slopes of the light from the columns beside each, as far as they are on one surface.
void set_slopes(const RigOptics& optics, ReferenceProfile& reference) {
  constexpr int kReach = 3;
  const int columns = reference.columns();
  std::vector<ProjectorPlace> light(static_cast<std::size_t>(columns));
  std::vector<SectionPoint> at(light.size());
  for (int c = 0; c < columns; ++c) {
    const auto i = static_cast<std::size_t>(c);
    if (reference.valid[i] != 0) {
      const CameraPlace place{middle_of(optics.rig()) + reference.offset_px[i], static_cast<double>(c)};
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
      const ProjectorPlace& a = light[end_of(c, -1)];
      const ProjectorPlace& b = light[end_of(c, 1)];
      const double across = b.column - a.column;
      reference.slope[i] = std::abs(across) > 1e-6 ? (b.line - a.line) / across : 0;
    }
  }
}

// The row (from 0) at which the camera column sees the laser on the section: where the depth of the laser's plane
// crosses that of the surface. If there are several, that nearest to the camera.
std::optional<CameraPlace> laser_on(const Section& section, int column, double& z) {
  constexpr double kStep = 0.25;
  const RigOptics& optics = section.optics();
  // Depth of the plane less depth of the surface; NaN if there is none of them.
  const auto over = [&](double row, double& depth) {
    const CameraPlace place{row, static_cast<double>(column)};
    const std::optional<cv::Vec2d> ray = optics.ray(place);
    const std::optional<double> plane = ray ? optics.meet(*ray, {}) : std::nullopt;
    const std::optional<SectionPoint> surface = section.surface(place);
    depth = plane ? optics.corrected(place, *plane) : kUnknown;
    return plane && surface ? depth - surface->z : kUnknown;
  };
  std::optional<CameraPlace> best;
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
  const Rig& rig = section.optics().rig();
  ReferenceProfile reference;
  reference.resize_for_lenses(rig.camera.columns);
  for (std::size_t i = 0; i < reference.valid.size(); ++i) {
    double z = 0;
    const std::optional<CameraPlace> place = laser_on(section, static_cast<int>(i), z);
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

}  // namespace

MiddleRow::MiddleRow(const Rig& rig) : camera_(rig.camera) {
  if (!rig.is_pinholes()) {
    optics_.emplace(rig);
  }
}

double MiddleRow::tan_beta(double column) const {
  if (!optics_) {
    return selfproj::tan_beta(camera_, column);
  }
  const std::optional<cv::Vec2d> ray = optics_->ray({0.5 * (camera_.rows - 1), column});
  return ray ? (*ray)[1] : kUnknown;
}

ReferenceProfile lens_reference_of_curve(const Rig& rig, const ReferenceCurve& curve) {
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

ReferenceProfile lens_reference_of_line(const Rig& rig, double line, std::span<const double> centroid) {
  const RigOptics optics(rig);
  ReferenceProfile reference;
  reference.resize_for_lenses(rig.camera.columns);
  for (std::size_t i = 0; i < centroid.size(); ++i) {
    set_invalid(reference, i);
    const CameraPlace place{centroid[i] - 1, static_cast<double>(i)};  // centroids count from 1
    const std::optional<cv::Vec2d> ray = std::isfinite(centroid[i]) ? optics.ray(place) : std::nullopt;
    const std::optional<double> z =
        ray ? optics.meet(*ray, {line, 0, 0.5 * (rig.projector.columns - 1)}) : std::nullopt;
    if (z) {
      reference.valid[i] = 1;
      reference.line[i] = optics.has_projector() ? line : 0;
      reference.slope[i] = 0;
      reference.z_mm[i] = optics.corrected(place, *z);
      reference.offset_px[i] = place.row - middle_of(rig);
    }
  }
  return reference;
}

ReferenceProfile lens_reference_of_scan(const Rig& rig, std::span<const double> line) {
  const RigOptics optics(rig);
  ReferenceProfile reference;
  reference.resize_for_lenses(rig.camera.columns);
  for (std::size_t i = 0; i < line.size(); ++i) {
    set_invalid(reference, i);
    const CameraPlace place{middle_of(rig), static_cast<double>(i)};
    const std::optional<cv::Vec2d> ray = std::isfinite(line[i]) ? optics.ray(place) : std::nullopt;
    const std::optional<double> z =
        ray ? optics.meet(*ray, {line[i], 0, 0.5 * (rig.projector.columns - 1)}) : std::nullopt;
    if (z) {
      reference.valid[i] = 1;
      reference.line[i] = line[i];
      reference.z_mm[i] = optics.corrected(place, *z);
      reference.offset_px[i] = 0;
    }
  }
  set_slopes(optics, reference);
  return reference;
}

ReferenceProfile lens_without_residual(const Rig& rig, const ReferenceProfile& reference,
                                       std::span<const double> centroid) {
  const RigOptics optics(rig);
  ReferenceProfile result = reference;
  for (std::size_t i = 0; i < centroid.size(); ++i) {
    const CameraPlace place{centroid[i] - 1, static_cast<double>(i)};
    const bool measured = result.valid[i] != 0 && std::isfinite(centroid[i]);
    const std::optional<ProjectorPlace> light =
        measured && optics.has_projector() ? light_on(optics, place, result.z_mm[i]) : std::nullopt;
    if (light) {
      result.line[i] = light->line;
      result.offset_px[i] = place.row - middle_of(rig);
    } else if (measured && !optics.has_projector()) {
      // The laser's plane is known, and says where the reference is.
      const std::optional<cv::Vec2d> ray = optics.ray(place);
      const std::optional<double> z = ray ? optics.meet(*ray, {}) : std::nullopt;
      result.valid[i] = z ? 1 : 0;
      result.z_mm[i] = z ? optics.corrected(place, *z) : kUnknown;
      result.offset_px[i] = place.row - middle_of(rig);
    } else {
      set_invalid(result, i);
    }
  }
  return result;
}

// The camera's middle row is followed in steps of an eighth of a column, also beyond the image.
std::vector<double> lens_pattern_of_curve(const Rig& rig, const ReferenceCurve& curve) {
  constexpr int kParts = 8;
  constexpr int kBeyond = 16;
  const Section section(rig, curve);
  std::vector<double> lines(static_cast<std::size_t>(rig.projector.columns), kUnknown);
  std::vector<double> nearest(lines.size(), std::numeric_limits<double>::infinity());
  Sample before;
  for (int step = -kBeyond * kParts; step <= (rig.camera.columns - 1 + kBeyond) * kParts; ++step) {
    const Sample here = section.sample({middle_of(rig), static_cast<double>(step) / kParts});
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

std::optional<LightSheet> sheet_of(const RigOptics& optics, const ReferenceProfile& reference, int column) {
  const auto i = static_cast<std::size_t>(column);
  if (reference.valid[i] == 0) {
    return std::nullopt;
  }
  if (!optics.has_projector()) {
    return LightSheet{};
  }
  const CameraPlace place{middle_of(optics.rig()) + reference.offset_px[i], static_cast<double>(column)};
  const std::optional<ProjectorPlace> light = light_on(optics, place, reference.z_mm[i]);
  return light ? std::optional(LightSheet{light->line, reference.slope[i], light->column}) : std::nullopt;
}

}  // namespace selfproj
