#include "sim/experiment/section_experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/io/user_error.h"
#include "host/report/report.h"
#include "host/rig/rig.h"
#include "sim/experiment/light_section.h"
#include "sim/experiment/section_figures.h"
#include "sim/scene/marks.h"
#include "sim/scene/scene.h"
#include "sim/scene/scene_list.h"

namespace selfproj {
namespace {

// Published figures of an experiment, as printed in the thesis; "–" if there are none.
struct Published {
  const char* name;
  const char* scene;
  const char* reference;
  double height;               // height of the part, mm; the straight line is centred between its top and the plane
  int conventional_rows;       // rows of the image that a straight line needs
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

const Published& published(const std::string& name) {
  const auto found =
      std::find_if(published().begin(), published().end(), [&](const Published& entry) { return entry.name == name; });
  if (found == published().end()) {
    throw UserError(name, "is not an experiment of light section; these are A1 and A2");
  }
  return *found;
}

// Adds a row of a table: a name, the published figure, and the measured one in each mode.
void add_rows(ReportTable& table, const MethodFigures& figures, const Published& what, const char* range,
              const char* error, const std::vector<const char*>& steps, const char* depth) {
  const auto row = [&](std::string name, const std::string& from_thesis, const auto& value) {
    std::vector<std::string> cells = {std::move(name), from_thesis};
    for (const SectionFigures& f : figures.modes) {
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

// A self-projected measurement with one thing changed.
struct Source {
  std::string name;
  SectionOptions options;
};

std::vector<Source> sources_of(const SectionOptions& as_it_is) {
  std::vector<Source> sources = {{"nothing", as_it_is}};
  const auto add = [&](const std::string& name) -> SectionOptions& {
    sources.push_back({name, as_it_is});
    return sources.back().options;
  };
  for (const auto& [name, flag] : kDisturbances) {
    add(name).render.*flag = false;
  }
  SectionOptions& noiseless = add("both noises");
  noiseless.render.shot_noise = noiseless.render.read_noise = false;
  SectionOptions& thin = add("line's width (1 projector line, white 255)");
  thin.rig.measure.line_width_px = 1;
  thin.rig.imaging.white = 255;
  SectionOptions& ideal = add("noises, blurs, line's width");
  ideal = sources[sources.size() - 2].options;
  for (const auto& [name, flag] : kDisturbances) {
    ideal.render.*flag = flag == &RenderOptions::quantization;
  }
  SectionOptions& residual = add(as_it_is.residual ? "removal of the residual" : "the residual");
  residual.residual = !as_it_is.residual;
  return sources;
}

// The common settings of all measurements of an experiment.
struct Course {
  const Published& what;
  std::unique_ptr<Scene> scene, reference;
  std::function<void(std::size_t)> count;  // gets the number of frames done in the running measurement
};

MethodFigures measure_self_projected(const Course& course, const SectionOptions& options, Measurement& measurement) {
  const LightSection setup =
      self_projection(options.rig, options.rig, *course.reference, options.render, options.residual);
  measurement = measure(setup, *course.scene, options.render, options.every, options.threads, course.count);
  return section_figures(measurement, setup, *course.scene, course.what.treads.size(), options.render);
}

MethodFigures measure_conventional(const Course& course, const SectionOptions& options) {
  Rig rig = options.rig;
  rig.camera.rows = course.what.conventional_rows;
  const LightSection setup = straight_line(rig, *course.reference, options.render, course.what.height / 2);
  const Measurement measurement =
      measure(setup, *course.scene, options.render, options.every, options.threads, course.count);
  return section_figures(measurement, setup, *course.scene, course.what.treads.size(), options.render);
}

ReportTable self_projected_table(const SectionResult& result, const Published& what) {
  ReportTable table = table_of("Self-projected", result.self_projected);
  add_rows(table, result.self_projected, what, what.range, what.error, what.steps, what.depth);
  table.note = fmt::format(
      "Measured with camera noise, against the truth of the simulation. Points within {} columns ({:.2f} mm) of a "
      "height step or part edge are left out and counted; “edges across the belt included”: only those whose step is "
      "in the same frame.",
      kStepColumns, kStepColumns * result.measurement.by_mode[0].column_spacing_mm());
  return table;
}

ReportTable conventional_table(const SectionResult& result, const Published& what) {
  ReportTable table = table_of("Conventional, straight line", result.conventional);
  add_rows(table, result.conventional, what, what.range_conventional, what.error_conventional, {}, "–");
  return table;
}

// One row for each source; the figures of source k are figures[k].
ReportTable sources_table(const std::vector<Source>& sources, const std::vector<MethodFigures>& figures) {
  ReportTable table = {"Sources of error, self-projected",
                       {"mm; switched off", "grey-over: largest", "RMS", "beyond 2", "beyond 1", "grey: largest", "RMS",
                        "binary: largest", "RMS"},
                       {},
                       "Height errors as above. “Beyond 2”, “beyond 1”: the largest where only points within 2 columns "
                       "or 1 of a step are left out."};
  for (std::size_t k = 0; k < sources.size(); ++k) {
    std::vector<double> values;
    for (const SectionFigures& f : figures[k].modes) {
      values.push_back(f.errors.max);
      values.push_back(f.errors.rms);
      if (values.size() == 2) {
        values.push_back(f.errors_beyond_2.max);
        values.push_back(f.errors_beyond_1.max);
      }
    }
    table.rows.push_back({sources[k].name});
    for (const double value : values) {
      table.rows.back().push_back(fmt::format("{:.4f}", value));
    }
  }
  return table;
}

std::vector<Fact> conditions_of(const SectionOptions& options, const Published& what, double line_peak) {
  const RigImaging& imaging = options.rig.imaging;
  const double noise = std::sqrt(imaging.read_noise * imaging.read_noise +
                                 (imaging.ambient - imaging.dark) / imaging.electrons_per_grey);
  return {{"experiment", "experiment", std::string(what.name)},
          {"scene", "scene", std::string(what.scene)},
          {"reference", "reference", std::string(what.reference)},
          {"residual", "residual of the reference", std::string(options.residual ? "measured and removed" : "left")},
          {"line_peak", "line peak (median of the columns)", line_peak, "grey values"},
          {"ambient", "ambient light", imaging.ambient, "grey values"},
          {"noise", "noise of unlit pixels, σ", std::round(noise * 1000) / 1000, "grey values"},
          {"threshold_sigma", "threshold over ambient light",
           std::round((options.rig.measure.threshold - imaging.ambient) / noise * 10) / 10, "σ"},
          {"seed", "seed", imaging.seed}};
}

void check(SectionResult& result, const Published& what) {
  const SectionFigures& f = result.self_projected.modes[0];
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

SectionResult run_section_experiment(const std::string& name, const SectionOptions& options,
                                     const std::function<void(std::size_t, std::size_t)>& progress) {
  const Published& what = published(name);
  Course course{what, make_scene(what.scene, options.rig), make_scene(what.reference, options.rig), {}};
  const auto frames = static_cast<std::size_t>((course.scene->frames() + options.every - 1) / options.every);
  const std::vector<Source> sources = options.sources ? sources_of(options) : std::vector<Source>();
  const std::size_t all = (2 + sources.size()) * frames;
  std::size_t before = 0;
  course.count = [&](std::size_t done) { progress(before + done, all); };

  SectionResult result;
  result.name = name;
  result.self_projected = measure_self_projected(course, options, result.measurement);
  before += frames;
  result.conventional = measure_conventional(course, options);
  before += frames;
  std::vector<MethodFigures> without;
  for (const Source& source : sources) {
    Measurement unused;
    without.push_back(measure_self_projected(course, source.options, unused));
    before += frames;
  }
  result.tables = {self_projected_table(result, what), conventional_table(result, what)};
  if (!sources.empty()) {
    result.tables.push_back(sources_table(sources, without));
  }
  result.conditions = conditions_of(options, what, result.measurement.line_peak);
  check(result, what);
  return result;
}

}  // namespace selfproj
