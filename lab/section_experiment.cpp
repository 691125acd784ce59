#include "lab/section_experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/files/user_error.h"
#include "host/report/report.h"
#include "host/rig/rig.h"
#include "lab/section_figures.h"
#include "sim/cosim/light_section.h"
#include "sim/scene/marks.h"
#include "sim/scene/real_rig.h"
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
void add_rows(ReportTable& table, const MethodFigures& figures, const MethodFigures* null_test, const Published& what,
              const char* range, const char* error, const std::vector<const char*>& steps, const char* depth) {
  const auto row = [&](std::string name, const std::string& from_thesis, const auto& value) {
    std::vector<std::string> cells = {std::move(name), from_thesis};
    for (const SectionFigures& f : figures.modes) {
      cells.push_back(value(f));
    }
    if (null_test != nullptr) {
      cells.push_back(value(null_test->modes[0]));
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
  if (!what.treads.empty()) {
    row("places of the marks off, mm", "–", [&](const auto& f) { return mm(f.mark_place); });
  }
  row("points compared", "–", [](const auto& f) { return std::to_string(f.errors.points); });
  row("points left out near steps", "–", [](const auto& f) { return std::to_string(f.errors.left_out); });
  row("columns without a point elsewhere", "–",
      [](const auto& f) { return fmt::format("{:.2f} %", 100 * f.errors.missing_share()); });
}

ReportTable table_of(const std::string& title, const SectionOptions& options, const MethodFigures& figures) {
  const bool learned = options.route == Route::learned;
  ReportTable table{
      fmt::format("{}, {} ({} × {} px)", title, learned ? "rig calibrated from images, good part scanned" : "null test",
                  figures.rows, options.rig.camera.columns),
      {"", "published", "grey-over", "grey", "binary"},
      {},
      ""};
  if (learned) {
    table.header.emplace_back("null test, grey-over");
  }
  return table;
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

// One experiment: what it measures, and how many images and frames are done.
class Course {
 public:
  Course(const Published& what, const SectionOptions& options,
         const std::function<void(std::size_t, std::size_t)>& progress)
      : what_(what),
        scene_(make_scene(what.scene, options.rig)),
        reference_(make_scene(what.reference, options.rig)),
        sources_(options.sources ? sources_of(options) : std::vector<Source>()),
        progress_(progress) {
    const auto frames = static_cast<std::size_t>((scene_->frames() + options.every - 1) / options.every);
    all_ = (2 + sources_.size()) * frames;
    if (options.route == Route::learned) {
      all_ += 2 * frames + 2 * static_cast<std::size_t>(learning_images(options.rig, options.learning)) +
              static_cast<std::size_t>(scanning_images(options.rig, options.learning.every_line));
    }
  }

  // By a rig that is known perfectly, and the good part's true shape.
  MethodFigures self_projected_null(const SectionOptions& options, Measurement& measurement) {
    return figures_of(self_projection(options.rig, options.rig, *reference_, options.render, options.residual), options,
                      measurement);
  }

  MethodFigures conventional_null(const SectionOptions& options) {
    const Rig rig = with_rows(options.rig);
    Measurement unused;
    return figures_of(straight_line(rig, rig, *reference_, options.render, what_.height / 2), options, unused);
  }

  // By a rig that is learned from images, and a scan of the good part.
  MethodFigures self_projected_learned(const SectionOptions& options, SectionResult& result) {
    const RealRig real = hidden_rig(options.rig, options.real_rig_seed);
    const LearnedRig learned = learn(real, options);
    result.checked_mm = learned.checked_mm;
    return figures_of(
        scanned_projection(learned.rig, real, what_.reference,
                           {options.render, options.learning.every_line, options.residual}, [this] { one_more(); }),
        options, result.measurement);
  }

  // The straight line needs more rows of the image, for which rig and camera are learned anew.
  MethodFigures conventional_learned(const SectionOptions& options) {
    const RealRig real = hidden_rig(with_rows(options.rig), options.real_rig_seed);
    Measurement unused;
    return figures_of(straight_line(learn(real, options).rig, real, *reference_, options.render, what_.height / 2),
                      options, unused);
  }

  [[nodiscard]] const std::vector<Source>& sources() const { return sources_; }

 private:
  [[nodiscard]] Rig with_rows(Rig rig) const {
    rig.camera.rows = what_.conventional_rows;
    return rig;
  }

  LearnedRig learn(const RealRig& real, const SectionOptions& options) {
    LearningSettings settings = options.learning;
    settings.seed = options.real_rig_seed;
    return learn_rig(real, options.render, settings, [this] { one_more(); });
  }

  MethodFigures figures_of(const LightSection& setup, const SectionOptions& options, Measurement& measurement) {
    const std::size_t before = done_;
    measurement = measure(setup, *scene_, options.render, options.every, options.threads, [&](std::size_t done) {
      done_ = before + done;
      progress_(done_, all_);
    });
    return section_figures(measurement, setup, *scene_, what_.treads.size(), options.render);
  }

  void one_more() { progress_(++done_, all_); }

  const Published& what_;
  std::unique_ptr<Scene> scene_, reference_;
  std::vector<Source> sources_;
  const std::function<void(std::size_t, std::size_t)>& progress_;
  std::size_t done_ = 0, all_ = 0;
};

ReportTable self_projected_table(const SectionOptions& options, const SectionResult& result, const Published& what) {
  ReportTable table = table_of("Self-projected", options, result.self_projected);
  add_rows(table, result.self_projected, options.route == Route::learned ? &result.null_self_projected : nullptr, what,
           what.range, what.error, what.steps, what.depth);
  table.note = fmt::format(
      "Measured with camera noise, against the truth of the simulation. Points within {} columns ({:.2f} mm) of a "
      "height step or part edge are left out and counted; “edges across the belt included”: only those whose step is "
      "in the same frame. Null test: the rig is known perfectly, and the reference is the good part's true shape.",
      kStepColumns, kStepColumns * result.measurement.by_mode[0].column_spacing_mm());
  return table;
}

ReportTable conventional_table(const SectionOptions& options, const SectionResult& result, const Published& what) {
  ReportTable table = table_of("Conventional, straight line", options, result.conventional);
  add_rows(table, result.conventional, options.route == Route::learned ? &result.null_conventional : nullptr, what,
           what.range_conventional, what.error_conventional, {}, "–");
  return table;
}

// One row for each source; the figures of source k are figures[k].
ReportTable sources_table(const std::vector<Source>& sources, const std::vector<MethodFigures>& figures) {
  ReportTable table = {"Sources of error, self-projected, null tests",
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

std::vector<Fact> conditions_of(const SectionOptions& options, const Published& what, const SectionResult& result) {
  const RigImaging& imaging = options.rig.imaging;
  const double noise = std::sqrt(imaging.read_noise * imaging.read_noise +
                                 (imaging.ambient - imaging.dark) / imaging.electrons_per_grey);
  std::vector<Fact> facts{
      {"experiment", "experiment", std::string(what.name)},
      {"scene", "scene", std::string(what.scene)},
      {"reference", "reference", std::string(what.reference)},
      {"route", "route",
       std::string(options.route == Route::learned ? "rig calibrated from images, good part scanned"
                                                   : "null test: rig and good part known perfectly")},
      {"residual", "residual of the reference", std::string(options.residual ? "measured and removed" : "left")},
      {"line_peak", "line peak (median of the columns)", result.measurement.line_peak, "grey values"},
      {"ambient", "ambient light", imaging.ambient, "grey values"},
      {"noise", "noise of unlit pixels, σ", std::round(noise * 1000) / 1000, "grey values"},
      {"threshold_sigma", "threshold over ambient light",
       std::round((options.rig.measure.threshold - imaging.ambient) / noise * 10) / 10, "σ"},
      {"seed", "seed", imaging.seed}};
  if (options.route == Route::learned) {
    facts.push_back(
        {"real_rig_seed", "seed of the rig that took the images", static_cast<std::int64_t>(options.real_rig_seed)});
    facts.push_back({"checked_mm", fmt::format("a further plate, {:g} mm high, is off by", kCheckedPlate),
                     std::round(result.checked_mm * 1e4) / 1e4, "mm"});
  }
  return facts;
}

// The bounds of the figures of a route.
struct Bounds {
  const char* name;
  double tread_mm;
  double place_mm;  // of marks
};
constexpr Bounds kLearnedBounds{"", 0.03, 0.2};
constexpr Bounds kNullBounds{"null test: ", 0.05, 0.2};

void check(const SectionFigures& f, const Bounds& bounds, const Published& what, SectionResult& result) {
  const auto hold = [&](bool good, const std::string& text) {
    if (!good) {
      result.not_reached.push_back(bounds.name + text);
    }
  };
  hold(f.errors.points > 0, "no point was measured");
  hold(f.range.greatest <= 3 || !what.treads.empty(),
       fmt::format("max - min of C is {:.2f} px, at most 3 wanted", f.range.greatest));
  hold(f.errors.max <= 0.10, fmt::format("the largest height error is {:.3f} mm, at most 0.10 wanted", f.errors.max));
  hold(f.errors.rms <= 0.03, fmt::format("the height error is {:.3f} mm RMS, at most 0.03 wanted", f.errors.rms));
  for (std::size_t i = 0; i < f.steps.size(); ++i) {
    hold(std::abs(f.steps[i] - what.treads[i]) <= bounds.tread_mm,
         fmt::format("the step of {:g} mm is measured as {:.3f} mm, within {} wanted", what.treads[i], f.steps[i],
                     bounds.tread_mm));
    hold(std::abs(f.mark_depth[i] - kMarkDepth) <= 0.1,
         fmt::format("a mark's depth is {:.3f} mm, 1 +- 0.1 wanted", f.mark_depth[i]));
  }
  hold(f.mark_place <= bounds.place_mm,
       fmt::format("marks are {:.3f} mm off, at most {} wanted", f.mark_place, bounds.place_mm));
}

}  // namespace

SectionResult run_section_experiment(const std::string& name, const SectionOptions& options,
                                     const std::function<void(std::size_t, std::size_t)>& progress) {
  const Published& what = published(name);
  Course course(what, options, progress);
  SectionResult result;
  result.name = name;
  if (options.route == Route::learned) {
    result.self_projected = course.self_projected_learned(options, result);
    result.conventional = course.conventional_learned(options);
    Measurement unused;
    result.null_self_projected = course.self_projected_null(options, unused);
    result.null_conventional = course.conventional_null(options);
    check(result.self_projected.modes[0], kLearnedBounds, what, result);
    check(result.null_self_projected.modes[0], kNullBounds, what, result);
  } else {
    result.self_projected = course.self_projected_null(options, result.measurement);
    result.conventional = course.conventional_null(options);
    check(result.self_projected.modes[0], kNullBounds, what, result);
  }
  std::vector<MethodFigures> without;
  for (const Source& source : course.sources()) {
    Measurement unused;
    without.push_back(course.self_projected_null(source.options, unused));
  }
  result.tables = {self_projected_table(options, result, what), conventional_table(options, result, what)};
  if (!without.empty()) {
    result.tables.push_back(sources_table(course.sources(), without));
  }
  result.conditions = conditions_of(options, what, result);
  return result;
}

}  // namespace selfproj
