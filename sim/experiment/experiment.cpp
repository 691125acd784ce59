#include "sim/experiment/experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "host/io/float_image.h"
#include "host/io/user_error.h"
#include "host/light_section/inspection.h"
#include "host/report/report.h"
#include "host/rig/geometry.h"
#include "host/rig/rig.h"
#include "sim/experiment/evaluation.h"
#include "sim/experiment/light_section.h"
#include "sim/scene/marks.h"
#include "sim/scene/parallel.h"
#include "sim/scene/scene.h"
#include "sim/scene/scene_list.h"

namespace selfproj {
namespace {

// An experiment of the thesis. Texts as published; "–" where nothing is.
struct Published {
  const char* name;
  const char* scene;
  const char* reference;
  double height;               // of the part, mm: the straight line is centred between it and the plane
  int conventional_rows;       // of the image that a straight line needs
  std::vector<double> treads;  // heights from left to right, mm
  const char* range;
  const char* range_conventional;
  const char* error;
  const char* error_conventional;
  std::vector<const char*> steps;
  const char* depth;
};

const std::array<Published, 2>& published() {
  static const std::array<Published, 2> all = {
      {{"A1", "mountain", "mountain", 23.6, 96, {}, "3", "70", "0.36", "0.39", {}, "–"},
       {"A2",
        "stairs-marked",
        "stairs",
        39,
        160,
        {30, 39, 21},
        "–",
        "–",
        "0.12",
        "–",
        {"30.12", "38.90", "21.04"},
        "1.09 or less"}}};
  return all;
}

constexpr double kTreadWidth = 35;   // mm
constexpr double kHalfLength = 65;   // mm, of the parts
constexpr double kColumnStep = 0.5;  // mm from one column to the next: a height step
constexpr double kFrameStep = 0.05;  // likewise from one frame to the next (the parts are even along x)
constexpr int kStepColumns = 3;      // columns left out on each side of one
constexpr std::uint8_t kTread = 1;   // labels of regions: tread + kTread, mark + kMark
constexpr std::uint8_t kMark = 11;

const ConveyedScene& conveyed(const Scene& scene) { return dynamic_cast<const ConveyedScene&>(scene); }

// Which points lie on plain parts of the treads, and which in the middle of the marks' strokes, away from their edges
// by more than the line is wide.
Mask tread_regions(const FloatImage& x, const FloatImage& y, const Measurement& m, const Rig& rig, const Scene& scene,
                   std::size_t treads) {
  constexpr double kMargin = 2;    // mm from a tread's edge, and from a mark
  constexpr double kInside = 0.6;  // mm from a stroke's centre line, half a stroke being 1.5
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
          continue;  // also where there is no point
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
  constexpr int kSamples = 9;  // to each side
  const FloatImage x = m.by_mode[0].x();
  const FloatImage y = m.by_mode[0].y();
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

// What the light sheet meets in the measured frames and in those up to `reach` frames before and after them, NaN in the
// others. Rows are the scene's frames.
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

// The points near an edge along x, as `near_steps` finds those near one across: within `reach` mm of a height step of
// the surface, or of what the light sheet meets from frame to frame (`truth`), which also jumps where a shadow ends.
Mask near_steps_along_x(const Measurement& m, const Renderer& renderer, const FloatImage& truth, double frame_mm,
                        double reach) {
  const int frames = static_cast<int>(std::ceil(reach / frame_mm));
  Mask mask;
  for (const int frame : m.frames) {
    const int first = std::max(0, frame - frames);
    const int count = std::min(truth.rows, frame + frames + 1) - first;
    const Mask around = near_steps(rows_of(truth, first, count), kFrameStep, 0, frames);
    const Mask row = rows_of(around, truth.columns, frame - first, 1);
    mask.insert(mask.end(), row.begin(), row.end());
  }
  add_steps_along_x(mask, m, renderer, reach);
  return mask;
}

MethodFigures figures_of(const Measurement& m, const LightSection& setup, const Scene& scene, const Published& what,
                         const RenderOptions& render) {
  const Rig& rig = setup.rig;
  const Renderer renderer(rig, scene, setup.pattern, render);  // for its truth
  const double column_mm = m.by_mode[0].column_spacing_mm();
  const double frame_mm = rig.conveyor.speed_mm_per_s / rig.camera.frame_rate_hz;
  const double reach = kStepColumns * column_mm;
  const FloatImage truth = truth_around(m, renderer, scene.frames(), static_cast<int>(std::ceil(reach / frame_mm)));
  const auto within = [&](int columns) {
    const Mask across = near_steps(m.truth, kColumnStep, columns, 0);
    Mask mask = near_steps_along_x(m, renderer, truth, frame_mm, columns * column_mm);
    std::transform(mask.begin(), mask.end(), across.begin(), mask.begin(), std::bit_or<>());
    return mask;
  };
  const Mask steps = within(kStepColumns);
  const Mask within_2 = within(2);
  const Mask within_1 = within(1);
  const Mask across = near_steps(m.truth, kColumnStep, kStepColumns, 0);
  // Frames in which the line lies on the part; the others count nowhere.
  int first = 0;
  int count = 0;
  for (std::size_t k = 0; k < m.frames.size(); ++k) {
    const bool on_part =
        std::abs(conveyed(scene).position(m.frames[k] / rig.camera.frame_rate_hz)) < kHalfLength - reach;
    if (on_part) {
      first = count == 0 ? static_cast<int>(k) : first;
      ++count;
    }
  }
  MethodFigures result;
  result.rows = rig.camera.rows;
  for (std::size_t mode = 0; mode < kAllModes.size(); ++mode) {
    const Inspection& inspection = m.by_mode[mode];
    const FloatImage height = inspection.height();
    const FloatImage x = inspection.x();
    const FloatImage y = inspection.y();
    ExperimentFigures& figures = result.modes[mode];
    const auto errors_outside = [&](const Mask& left_out) {
      return height_errors(rows_of(height, first, count), rows_of(x, first, count), rows_of(y, first, count),
                           rows_of(left_out, x.columns, first, count), [&](int row, double px, double py) {
                             const auto k = static_cast<std::size_t>(first + row);
                             return renderer.true_height(m.frames[k], px, py);
                           });
    };
    figures.errors = errors_outside(steps);
    figures.errors_beyond_2 = errors_outside(within_2);
    figures.errors_beyond_1 = errors_outside(within_1);
    figures.errors_at_edges = errors_outside(across);
    figures.range = centroid_range(inspection.centroid(), steps, first, count);
    if (what.treads.empty()) {
      continue;
    }
    const Mask regions = tread_regions(x, y, m, rig, scene, what.treads.size());
    const FloatImage difference = inspection.difference();
    for (std::size_t i = 0; i < what.treads.size(); ++i) {
      const auto tread = static_cast<std::uint8_t>(kTread + i);
      figures.steps.push_back(values_in(height, regions, tread).mean);
      figures.mark_depth.push_back(depth_of(difference, regions, static_cast<std::uint8_t>(kMark + i), tread));
    }
  }
  return result;
}

// The rows of a table: a name, the published figure, the measured one of each mode.
void add_rows(ReportTable& table, const MethodFigures& figures, const Published& what, const char* range,
              const char* error, const std::vector<const char*>& steps, const char* depth) {
  const auto row = [&](std::string name, const std::string& from_thesis, const auto& value) {
    std::vector<std::string> cells = {std::move(name), from_thesis};
    for (const ExperimentFigures& f : figures.modes) {
      cells.push_back(value(f));
    }
    table.rows.push_back(cells);
  };
  const auto mm = [](double value) { return fmt::format("{:.3f}", std::abs(value) < 0.0005 ? 0.0 : value); };
  row("max − min of C, px", range, [](const auto& f) { return fmt::format("{:.2f}", f.range.greatest); });
  row("height error, largest, mm", error, [&](const auto& f) { return mm(f.errors.max); });
  row("height error, RMS, mm", "–", [&](const auto& f) { return mm(f.errors.rms); });
  row("height error, mean, mm", "–", [&](const auto& f) { return mm(f.errors.mean); });
  row("largest, edges across the belt included, mm", "–", [&](const auto& f) { return mm(f.errors_at_edges.max); });
  row("RMS, edges across the belt included, mm", "–", [&](const auto& f) { return mm(f.errors_at_edges.rms); });
  for (std::size_t i = 0; i < what.treads.size(); ++i) {
    row(fmt::format("step of {:g} mm", what.treads[i]), i < steps.size() ? steps[i] : "–",
        [&](const auto& f) { return mm(f.steps[i]); });
  }
  constexpr std::array<const char*, 3> kMarkNames = {"○", "×", "▽"};
  for (std::size_t i = 0; i < what.treads.size(); ++i) {
    row(fmt::format("depth of {}, mm (true: 1)", kMarkNames.at(i)), depth,
        [&](const auto& f) { return mm(f.mark_depth[i]); });
  }
  row("points compared", "–", [](const auto& f) { return std::to_string(f.errors.points); });
  row("points left out near steps", "–", [](const auto& f) { return std::to_string(f.errors.left_out); });
  row("columns without a point elsewhere", "–",
      [](const auto& f) { return fmt::format("{:.2f} %", 100 * f.errors.missing_share()); });
}

ReportTable table_of(const std::string& title, const MethodFigures& figures) {
  return {fmt::format("{} ({} × {} px)", title, figures.rows, 512),
          {"", "published", "grey-over", "grey", "binary"},
          {},
          ""};
}

// What is measured by self-projection when one thing is other than it is.
struct Source {
  std::string name;
  ExperimentOptions options;
};

std::vector<Source> sources_of(const ExperimentOptions& as_it_is) {
  std::vector<Source> sources = {{"nothing", as_it_is}};
  const auto add = [&](const std::string& name) -> ExperimentOptions& {
    sources.push_back({name, as_it_is});
    return sources.back().options;
  };
  for (const auto& [name, flag] : kDisturbances) {
    add(name).render.*flag = false;
  }
  ExperimentOptions& noiseless = add("both noises");
  noiseless.render.shot_noise = noiseless.render.read_noise = false;
  ExperimentOptions& thin = add("line's width (1 projector line, white 255)");
  thin.rig.measure.line_width_px = 1;
  thin.rig.imaging.white = 255;
  ExperimentOptions& ideal = add("noises, blurs, line's width");
  ideal = sources[sources.size() - 2].options;
  for (const auto& [name, flag] : kDisturbances) {
    ideal.render.*flag = flag == &RenderOptions::quantization;
  }
  ExperimentOptions& residual = add(as_it_is.residual ? "removal of the residual" : "the residual");
  residual.residual = !as_it_is.residual;
  return sources;
}

MethodFigures measure_self_projected(const ExperimentOptions& options, const Scene& scene, const Scene& reference,
                                     const Published& what, const std::function<void(std::size_t)>& progress,
                                     Measurement& measurement) {
  const LightSection setup = self_projection(options.rig, options.rig, reference, options.render, options.residual);
  measurement = measure(setup, scene, options.render, options.every, options.threads, progress);
  return figures_of(measurement, setup, scene, what, options.render);
}

void check(ExperimentResult& result, const Published& what) {
  const ExperimentFigures& f = result.self_projected.modes[0];
  const auto hold = [&result](bool good, const std::string& text) {
    if (!good) {
      result.not_reached.push_back(text);
    }
  };
  hold(f.errors.points > 0, "no point was measured");
  hold(f.range.greatest <= 3 || !what.treads.empty(),
       fmt::format("max - min of C is {:.2f} px, at most 3 wanted", f.range.greatest));
  hold(f.errors.max <= 0.10, fmt::format("the largest height error is {:.3f} mm, at most 0.10 wanted", f.errors.max));
  hold(f.errors.rms <= 0.03, fmt::format("the height error is {:.3f} mm RMS, at most 0.03 wanted", f.errors.rms));
  for (std::size_t i = 0; i < f.steps.size(); ++i) {
    hold(std::abs(f.steps[i] - what.treads[i]) <= 0.05,
         fmt::format("the step of {:g} mm is measured as {:.3f} mm, within 0.05 wanted", what.treads[i], f.steps[i]));
    hold(std::abs(f.mark_depth[i] - kMarkDepth) <= 0.1,
         fmt::format("a mark's depth is {:.3f} mm, 1 +- 0.1 wanted", f.mark_depth[i]));
  }
}

}  // namespace

ExperimentResult run_experiment(const std::string& name, const ExperimentOptions& options,
                                const std::function<void(std::size_t, std::size_t)>& progress) {
  const Published* what = nullptr;
  for (const Published& entry : published()) {
    what = entry.name == name ? &entry : what;
  }
  if (what == nullptr) {
    throw UserError(name, "is no experiment (there are A1, A2)");
  }
  const std::unique_ptr<Scene> scene = make_scene(what->scene, options.rig);
  const std::unique_ptr<Scene> reference = make_scene(what->reference, options.rig);
  const auto frames = static_cast<std::size_t>((scene->frames() + options.every - 1) / options.every);
  const std::vector<Source> sources = options.sources ? sources_of(options) : std::vector<Source>();
  const std::size_t all = (2 + sources.size()) * frames;
  std::size_t before = 0;
  const auto count = [&](std::size_t done) { progress(before + done, all); };

  ExperimentResult result;
  result.name = name;
  result.self_projected = measure_self_projected(options, *scene, *reference, *what, count, result.measurement);
  before += frames;
  {
    Rig rig = options.rig;
    rig.camera.rows = what->conventional_rows;
    const LightSection setup = straight_line(rig, *reference, options.render, what->height / 2);
    const Measurement measurement = measure(setup, *scene, options.render, options.every, options.threads, count);
    before += frames;
    result.conventional = figures_of(measurement, setup, *scene, *what, options.render);
  }

  ReportTable self = table_of("Self-projected", result.self_projected);
  add_rows(self, result.self_projected, *what, what->range, what->error, what->steps, what->depth);
  self.note = fmt::format(
      "Measured with camera noise, against the truth of the simulation. Points within {} columns ({:.2f} mm) of a "
      "height "
      "step or part edge are left out and counted; “edges across the belt included”: only those whose step is in the "
      "same frame.",
      kStepColumns, kStepColumns * result.measurement.by_mode[0].column_spacing_mm());
  ReportTable conventional = table_of("Conventional, straight line", result.conventional);
  add_rows(conventional, result.conventional, *what, what->range_conventional, what->error_conventional, {}, "–");
  result.tables = {std::move(self), std::move(conventional)};
  if (!sources.empty()) {
    ReportTable table = {
        "Sources of error, self-projected",
        {"mm; switched off", "grey-over: largest", "RMS", "beyond 2", "beyond 1", "grey: largest", "RMS",
         "binary: largest", "RMS"},
        {},
        "Height errors as above. “Beyond 2”, “beyond 1”: the largest where only points within 2 columns "
        "or 1 of a step are left out."};
    for (const Source& source : sources) {
      Measurement unused;
      const MethodFigures figures = measure_self_projected(source.options, *scene, *reference, *what, count, unused);
      before += frames;
      table.rows.push_back({source.name});
      std::vector<double> values;
      for (const ExperimentFigures& f : figures.modes) {
        values.push_back(f.errors.max);
        values.push_back(f.errors.rms);
        if (values.size() == 2) {
          values.push_back(f.errors_beyond_2.max);
          values.push_back(f.errors_beyond_1.max);
        }
      }
      for (const double value : values) {
        table.rows.back().push_back(fmt::format("{:.4f}", value));
      }
    }
    result.tables.push_back(std::move(table));
  }

  const RigImaging& imaging = options.rig.imaging;
  const double noise = std::sqrt(imaging.read_noise * imaging.read_noise +
                                 (imaging.ambient - imaging.dark) / imaging.electrons_per_grey);
  result.conditions = {
      {"experiment", "experiment", name},
      {"scene", "scene", std::string(what->scene)},
      {"reference", "reference", std::string(what->reference)},
      {"residual", "residual of the reference", std::string(options.residual ? "measured and removed" : "left")},
      {"line_peak", "line peak (median of the columns)", result.measurement.line_peak, "grey values"},
      {"ambient", "ambient light", imaging.ambient, "grey values"},
      {"noise", "noise of unlit pixels, σ", std::round(noise * 1000) / 1000, "grey values"},
      {"threshold_sigma", "threshold over ambient light",
       std::round((options.rig.measure.threshold - imaging.ambient) / noise * 10) / 10, "σ"},
      {"seed", "seed", imaging.seed}};
  check(result, *what);
  return result;
}

}  // namespace selfproj
