#include "lab/section_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <limits>
#include <vector>

#include "host/images/float_image.h"
#include "host/light_section/inspection.h"
#include "host/rig/rig.h"
#include "sim/scene/marks.h"
#include "sim/scene/parallel.h"
#include "sim/scene/pinhole.h"
#include "sim/scene/real_rig.h"

namespace selfproj {
namespace {

constexpr double kTreadWidth = 35;  // mm
constexpr double kHalfLength = 65;  // mm, half the length of the parts
constexpr double kHighest = 39;     // mm, the greatest height of the parts
// mm from one column to the next that make a height step, as hidden rigs are judged
// (lab/scripts/hidden_rig_figures.py). A camera that leans sees the line climb a wall of 1 mm over as many as three
// columns, by 0.33 mm each; the mountain rises by 0.17 mm at most.
constexpr double kColumnStep = 0.3;
constexpr double kFrameStep = 0.05;  // the same from one frame to the next (the parts are uniform along x)
constexpr std::uint8_t kTread = 1;   // labels of regions: tread + kTread, mark + kMark
constexpr std::uint8_t kMark = 11;

const ConveyedScene& conveyed(const Scene& scene) { return dynamic_cast<const ConveyedScene&>(scene); }

// How far from x = 0 the middle row looks, at the plane and at this height: 0 for a rig that leans nowhere.
double lean_of(const RealRig& real, double height) {
  const RigCamera& camera = real.rig.camera;
  double most = 0;
  for (const int column : {0, camera.columns / 2, camera.columns - 1}) {
    for (const double z : {real.rig.plane_z_mm, real.rig.plane_z_mm - height}) {
      const PixelPoint middle{0.5 * (camera.rows - 1), static_cast<double>(column)};
      most = std::max(most, std::abs(real.camera.point_at(middle, z).x));
    }
  }
  return most;
}

// Labels the points on plain parts of the treads, and those in the middle of the marks' strokes, farther from their
// edges than the line is wide.
Mask tread_regions(const FloatImage& x, const FloatImage& y, const Measurement& m, const Rig& rig, const Scene& scene,
                   std::size_t treads) {
  constexpr double kMargin = 2;    // mm from a tread's edge, and from a mark
  constexpr double kInside = 0.6;  // mm from a stroke's centre line; half a stroke is 1.5
  constexpr std::array<Mark, 3> kMarks = {Mark::circle, Mark::cross, Mark::triangle_down};
  Mask mask(x.values.size(), 0);
  for (int r = 0; r < x.rows; ++r) {
    const double position = conveyed(scene).position(m.frames[static_cast<std::size_t>(r)] / rig.camera.frame_rate_hz);
    for (int c = 0; c < x.columns; ++c) {
      const double x_part = static_cast<double>(x.row(r)[c]) - position;
      const auto y_part = static_cast<double>(y.row(r)[c]);
      for (std::size_t i = 0; i < treads; ++i) {
        const double across = y_part - kTreadWidth * (static_cast<double>(i) - 0.5 * static_cast<double>(treads - 1));
        if (!(std::abs(across) < kTreadWidth / 2 - kMargin) || !(std::abs(x_part) < kHalfLength - kMargin)) {
          continue;  // also true without a point
        }
        const double distance = distance_from_mark(kMarks.at(i), across, -x_part);
        auto& label =
            mask[static_cast<std::size_t>(r) * static_cast<std::size_t>(x.columns) + static_cast<std::size_t>(c)];
        if (distance <= kInside) {
          label = static_cast<std::uint8_t>(kMark + i);
        } else if (distance >= kMarkStroke / 2 + kMargin) {
          label = static_cast<std::uint8_t>(kTread + i);
        }
      }
    }
  }
  return mask;
}

// Adds the points that have a step within `reach` mm along x.
void add_steps_along_x(Mask& mask, const Measurement& m, const Renderer& renderer, double reach) {
  constexpr int kSamples = 9;  // samples on each side
  const FloatImage& x = m.true_x;
  const FloatImage& y = m.true_y;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask[i] != 0 || std::isnan(x.values[i])) {
      continue;
    }
    const int frame = m.frames[i / static_cast<std::size_t>(x.columns)];
    const auto at = static_cast<double>(x.values[i]);
    const auto beside = static_cast<double>(y.values[i]);
    const double here = renderer.true_height(frame, at, beside);
    for (int k = -kSamples; k <= kSamples && mask[i] == 0; ++k) {
      mask[i] = std::abs(renderer.true_height(frame, at + reach * k / kSamples, beside) - here) > kFrameStep ? 1 : 0;
    }
  }
}

FloatImage rows_of(const FloatImage& map, int first, int count) {
  FloatImage result(count, map.columns);
  std::copy(map.row(first), map.row(first) + static_cast<std::ptrdiff_t>(count) * map.columns, result.values.begin());
  return result;
}

Mask rows_of(const Mask& mask, int columns, int first, int count) {
  const auto begin = mask.begin() + static_cast<std::ptrdiff_t>(first) * columns;
  return {begin, begin + static_cast<std::ptrdiff_t>(count) * columns};
}

// The surface that the light sheet meets in the measured frames and in those up to `reach` frames before and after
// them; NaN in all others. Rows are the scene's frames.
FloatImage truth_around(const Measurement& m, const Renderer& renderer, int frames, int reach) {
  FloatImage truth(frames, m.truth.columns, std::numeric_limits<float>::quiet_NaN());
  std::vector<int> wanted;
  for (const int frame : m.frames) {
    for (int i = std::max({0, frame - reach, wanted.empty() ? 0 : wanted.back() + 1});
         i <= std::min(frame + reach, frames - 1); ++i) {
      wanted.push_back(i);
    }
  }
  parallel_for(static_cast<int>(wanted.size()), 0, [&](int i) {
    const int frame = wanted[static_cast<std::size_t>(i)];
    renderer.truth(frame, {truth.row(frame), static_cast<std::size_t>(truth.columns)});
  });
  return truth;
}

// The points near a height step. First, as hidden rigs are judged: a step from one column or frame to the next in the
// surface that the light sheet meets (`truth`), within so many columns, and within `reach` mm along x. Besides, along
// x: smaller jumps from frame to frame, such as the end of a shadow, and steps of the surface itself.
Mask points_near_steps(const Measurement& m, const Renderer& renderer, const FloatImage& truth, double frame_mm,
                       int columns, double reach) {
  const int frames = static_cast<int>(std::ceil(reach / frame_mm));
  Mask mask;
  for (const int frame : m.frames) {
    const int first = std::max(0, frame - frames);
    const int count = std::min(truth.rows, frame + frames + 1) - first;
    const FloatImage rows = rows_of(truth, first, count);
    const Mask jumps = rows_of(near_steps(rows, kFrameStep, 0, frames), truth.columns, frame - first, 1);
    const Mask around = rows_of(around_steps(rows, kColumnStep, columns, frames), truth.columns, frame - first, 1);
    std::transform(jumps.begin(), jumps.end(), around.begin(), std::back_inserter(mask), std::bit_or<>());
  }
  add_steps_along_x(mask, m, renderer, reach);
  return mask;
}

// The frames in which the line lies on the part: `count` rows of the maps from `first` on. Other frames never count.
struct FramesOnPart {
  int first = 0;
  int count = 0;

  // `edge`: mm at each end of the part that do not count.
  FramesOnPart(const Measurement& m, const Rig& rig, const Scene& scene, double edge) {
    for (std::size_t k = 0; k < m.frames.size(); ++k) {
      if (std::abs(conveyed(scene).position(m.frames[k] / rig.camera.frame_rate_hz)) < kHalfLength - edge) {
        first = count == 0 ? static_cast<int>(k) : first;
        ++count;
      }
    }
  }
  [[nodiscard]] FloatImage of(const FloatImage& map) const { return rows_of(map, first, count); }
  [[nodiscard]] Mask of(const Mask& mask, int columns) const { return rows_of(mask, columns, first, count); }
};

// How far the points of marks are from their places, as SectionFigures::mark_place says.
double mark_place(const Inspection& inspection, const Measurement& m, const Mask& regions, std::size_t treads) {
  const FloatImage x = inspection.x();
  const FloatImage y = inspection.y();
  std::vector<std::array<double, 3>> sums(treads);  // of x and y, measured less true, and their number
  for (std::size_t i = 0; i < regions.size(); ++i) {
    if (regions[i] >= kMark && !std::isnan(x.values[i])) {
      auto& sum = sums.at(regions[i] - kMark);
      sum[0] += static_cast<double>(x.values[i]) - static_cast<double>(m.true_x.values[i]);
      sum[1] += static_cast<double>(y.values[i]) - static_cast<double>(m.true_y.values[i]);
      sum[2] += 1;
    }
  }
  std::array<double, 2> shift{};
  for (auto& sum : sums) {
    for (std::size_t k = 0; k < shift.size(); ++k) {
      sum.at(k) /= sum[2];
      shift.at(k) += sum.at(k) / static_cast<double>(treads);
    }
  }
  double worst = 0;
  for (const auto& sum : sums) {
    const double off = std::hypot(sum[0] - shift[0], sum[1] - shift[1]);
    worst = std::isnan(off) ? off : std::max(worst, off);
  }
  return worst;
}

// Adds the mean heights of the treads, and depths and places of their marks.
void measure_treads(const Measurement& m, const Inspection& inspection, const Rig& rig, const Scene& scene,
                    std::size_t treads, SectionFigures& figures) {
  const Mask regions = tread_regions(m.true_x, m.true_y, m, rig, scene, treads);
  figures.mark_place = mark_place(inspection, m, regions, treads);
  const FloatImage height = inspection.height();
  const FloatImage difference = inspection.difference();
  for (std::size_t i = 0; i < treads; ++i) {
    const auto tread = static_cast<std::uint8_t>(kTread + i);
    figures.steps.push_back(values_in(height, regions, tread).mean);
    figures.mark_depth.push_back(depth_of(difference, regions, static_cast<std::uint8_t>(kMark + i), tread));
  }
}

}  // namespace

MethodFigures section_figures(const Measurement& m, const LightSection& setup, const Scene& scene, std::size_t treads,
                              const RenderOptions& render) {
  const Rig& rig = setup.rig;
  const Renderer renderer(setup.real, scene, setup.pattern, render.ideal_world());  // needed for its truth
  const double column_mm = m.by_mode[0].column_spacing_mm();
  const double frame_mm = rig.conveyor.speed_mm_per_s / rig.camera.frame_rate_hz;
  const double reach = kStepColumns * column_mm;
  const FloatImage truth = truth_around(m, renderer, scene.frames(), static_cast<int>(std::ceil(reach / frame_mm)));
  const auto within = [&](int columns) {
    return points_near_steps(m, renderer, truth, frame_mm, columns, columns * column_mm);
  };
  const Mask steps = within(kStepColumns);
  const Mask within_2 = within(2);
  const Mask within_1 = within(1);
  const Mask across = near_steps(m.truth, kColumnStep, kStepColumns, 0);
  const FramesOnPart on_part(m, rig, scene, reach + lean_of(setup.real, kHighest));
  MethodFigures result;
  result.rows = rig.camera.rows;
  for (std::size_t mode = 0; mode < kAllModes.size(); ++mode) {
    const Inspection& inspection = m.by_mode[mode];
    const FloatImage height = on_part.of(inspection.height());
    const FloatImage x = on_part.of(m.true_x);
    const FloatImage y = on_part.of(m.true_y);
    const auto true_height = [&](int row, double px, double py) {
      return renderer.true_height(m.frames[static_cast<std::size_t>(on_part.first + row)], px, py);
    };
    const auto errors_outside = [&](const Mask& left_out) {
      return height_errors(height, x, y, on_part.of(left_out, x.columns), true_height);
    };
    SectionFigures& figures = result.modes[mode];
    figures.errors = errors_outside(steps);
    figures.errors_beyond_2 = errors_outside(within_2);
    figures.errors_beyond_1 = errors_outside(within_1);
    figures.errors_at_edges = errors_outside(across);
    figures.range = centroid_range(inspection.centroid(), steps, on_part.first, on_part.count);
    if (treads > 0) {
      measure_treads(m, inspection, rig, scene, treads, figures);
    }
  }
  return result;
}

}  // namespace selfproj
