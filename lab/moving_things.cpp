#include "lab/moving_things.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "host/report/map_picture.h"
#include "host/report/report.h"
#include "host/structured_light/match_table.h"
#include "host/structured_light/self_reference.h"
#include "lab/structured_light.h"
#include "selfproj/images/float_image.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/scene.h"
#include "sim/scene/scenes.h"

namespace selfproj::lab {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

double quantile(std::vector<float>& values, double share) {
  if (values.empty()) {
    return kNan;
  }
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return static_cast<double>(*at);
}

// The rows and columns over which a thing extends. A pixel counts if at least six of its 3 x 3 pixels belong to the
// thing: with e = 0, noise that moves a code down by one matches single rows of the background at the other end of the
// window. The extent goes from the first to the last row (column) with at least a quarter as many pixels as the fullest
// one, so that single pixels do not count.
std::pair<double, double> extent(const images::FloatImage& difference, const Thing& thing,
                                 const images::FloatImage& true_difference) {
  constexpr int kAround = 30;  // pixels around the true extent in which the thing is looked for
  int row_0 = difference.rows;
  int row_1 = 0;
  int column_0 = difference.columns;
  int column_1 = 0;
  for (int r = 0; r < difference.rows; ++r) {
    for (int c = thing.column_0; c < thing.column_1; ++c) {
      if (static_cast<double>(true_difference.row(r)[c]) > thing.least) {
        row_0 = std::min(row_0, r - kAround);
        row_1 = std::max(row_1, r + kAround);
        column_0 = std::min(column_0, c - kAround);
        column_1 = std::max(column_1, c + kAround);
      }
    }
  }
  std::vector<int> of_row(static_cast<std::size_t>(difference.rows), 0);
  std::vector<int> of_column(static_cast<std::size_t>(difference.columns), 0);
  const auto is_over = [&](int r, int c) { return static_cast<double>(difference.row(r)[c]) > thing.least ? 1 : 0; };
  for (int r = std::max(1, row_0); r < std::min(row_1, difference.rows - 1); ++r) {
    for (int c = std::max({1, thing.column_0, column_0});
         c < std::min({thing.column_1, difference.columns - 1, column_1}); ++c) {
      int count = 0;
      for (int dr = -1; dr <= 1; ++dr) {
        for (int dc = -1; dc <= 1; ++dc) {
          count += is_over(r + dr, c + dc);
        }
      }
      if (is_over(r, c) != 0 && count >= 6) {
        ++of_row[static_cast<std::size_t>(r)];
        ++of_column[static_cast<std::size_t>(c)];
      }
    }
  }
  const auto length = [](const std::vector<int>& counts) {
    const int least = std::max(1, *std::max_element(counts.begin(), counts.end()) / 4);
    const auto in = [least](int count) { return count >= least; };
    const auto first = std::find_if(counts.begin(), counts.end(), in);
    const auto last = std::find_if(counts.rbegin(), counts.rend(), in);
    return first == counts.end() ? 0.0 : static_cast<double>(last.base() - first);
  };
  return {length(of_row), length(of_column)};
}

}  // namespace

ThingFigures figures_of(const Thing& thing, const images::FloatImage& depth, const images::FloatImage& difference,
                        const images::FloatImage& truth, const images::FloatImage& true_difference) {
  ThingFigures f;
  std::vector<float> heights;
  std::vector<float> true_heights;
  for (int r = 0; r < depth.rows; ++r) {
    for (int c = thing.column_0; c < thing.column_1; ++c) {
      if (!(true_difference.row(r)[c] > 1)) {
        continue;
      }
      ++f.pixels;
      true_heights.push_back(true_difference.row(r)[c]);
      const double error = static_cast<double>(depth.row(r)[c]) - static_cast<double>(truth.row(r)[c]);
      if (!std::isnan(error) && !std::isnan(difference.row(r)[c])) {
        ++f.valid;
        f.square += error * error;
        heights.push_back(difference.row(r)[c]);
      }
    }
  }
  constexpr double kShare = 0.95;
  f.height = quantile(heights, kShare);
  f.true_height = quantile(true_heights, kShare);
  std::tie(f.rows, f.columns) = extent(difference, thing, true_difference);
  std::tie(f.true_rows, f.true_columns) = extent(true_difference, thing, true_difference);
  return f;
}

void ThingSummary::add(const ThingFigures& f) {
  ++images_;
  pixels_ += static_cast<double>(f.pixels);
  valid_ += static_cast<double>(f.valid);
  square_ += f.square;
  worst_ = std::max(worst_, f.rms());
  height_ += f.height - f.true_height;
  max_height_ = std::max(max_height_, std::abs(f.height - f.true_height));
  max_size_ = std::max({max_size_, std::abs(f.rows - f.true_rows), std::abs(f.columns - f.true_columns)});
  rows_ += f.rows - f.true_rows;
  columns_ += f.columns - f.true_columns;
}

std::vector<std::string> ThingSummary::cells() const {
  return {std::to_string(images_),
          figure_text(100 * valid_ / pixels_, 1),
          figure_text(rms()),
          figure_text(worst_),
          figure_text(height()),
          figure_text(max_height_),
          figure_text(rows_ / images_, 1),
          figure_text(columns_ / images_, 1),
          figure_text(max_size_, 0)};
}

namespace {

// A scene that stands still as it was at one time.
class Frozen final : public sim::WrappedScene {
 public:
  Frozen(const sim::Scene& scene, double time) : sim::WrappedScene(scene), time_(time) {}
  [[nodiscard]] double height(double x, double y, double /*t*/) const override {
    return sim::WrappedScene::height(x, y, time_);
  }
  [[nodiscard]] sim::HeightRange range(const sim::Box& box, double /*t0*/, double /*t1*/) const override {
    return sim::WrappedScene::range(box, time_, time_);
  }
  [[nodiscard]] double speed() const override { return 0; }
  [[nodiscard]] sim::Bodies bodies(double /*t*/) const override { return sim::WrappedScene::bodies(time_); }
  [[nodiscard]] double body_speed() const override { return 0; }

 private:
  double time_;
};

// One of the experiments: what moves over the scene's reference, and what is measured.
struct MovingExperiment {
  const char* name;
  const char* scene;
  const char* subtitle;
  double max_difference;  // range of the pictures' colours, mm
  std::vector<Thing> (*things)(int columns);
};

const std::array<MovingExperiment, 2> kExperiments{{
    {"B7", "mouse", "Mouse on a slider, 300 mm/s: a film strip, 500 depth images a second", 35.0,
     [](int columns) {
       return std::vector<Thing>{
           {"mouse", 0, columns, 6, kHalfPixelAt109}};  // from 6 mm over the slider on: its plate is 3 mm thick
     }},
    {"B8", "hands", "Two hands at different heights: a film strip, 500 depth images a second", 60.0,
     [](int columns) {
       return std::vector<Thing>{{"left hand, over z = 441 mm", 0, columns / 2, 5, kHalfPixelAt109},
                                 {"right hand, over z = 550 mm", columns / 2, columns, 5, kHalfPixelOnPlane}};
     }},
}};

constexpr int kConventionalBits = 8;
constexpr int kStart = 2 * kConventionalBits - 2;  // frames before the first pair with full windows of both methods

// The results of a method for each thing in one depth image.
struct Instant {
  int frame = 0;  // frame in the middle of the window
  std::vector<ThingFigures> things;
};

// The number of depth images by each method, and which of them are shown.
struct Plan {
  int pairs;
  int still_every;  // shows one in this many; odd, so that each plane takes its turn as the newest

  [[nodiscard]] int frames() const { return kStart + 2 * pairs; }
  [[nodiscard]] int stills() const { return (pairs - still_every / 2 + still_every - 1) / still_every; }
  // Whether the i-th depth image is shown: the middle one of each group.
  [[nodiscard]] bool is_shown(std::size_t i) const { return static_cast<int>(i) % still_every == still_every / 2; }
};

Plan plan_of(const MovingOptions& options, const sim::Scene& scene) {
  const int most = (scene.frames() - options.first - kStart) / 2;
  if (options.first < 0 || options.pairs < 0 || options.strips < 1 || most < std::max(options.pairs, 1)) {
    throw std::invalid_argument("moving things: the scene has not so many frames");
  }
  const int pairs = options.pairs == 0 ? most : options.pairs;
  const int step = std::max(1, pairs / options.strips);
  return {pairs, step % 2 == 0 ? step + 1 : step};
}

// The things that are measured, and where.
struct Setting {
  const MovingOptions& options;
  const MovingExperiment& experiment;
  const sim::Scene& scene;
  const sim::PatternRenderer& renderer;
  const images::FloatImage& background_z;  // true z of the still surface
  std::vector<Thing> things;
  Plan plan;
  std::function<void()> count;
};

// The results of a method.
struct Observation {
  std::string method;
  int window = 0;  // frames
  std::vector<Instant> moving;
  std::vector<Instant> moving_then;  // those of them that were also measured at rest
  std::vector<Instant> at_rest;
  std::vector<report::ReportPicture> strip;
  images::FloatImage depth, difference, truth;  // those of the last picture
};

Instant look(const Setting& setting, const DepthStream& stream, const sim::PatternRenderer& of, int frame,
             images::FloatImage& truth) {
  of.lit_depth(frame, truth.values);
  const images::FloatImage true_difference = minus(setting.background_z, truth);
  const images::FloatImage difference = stream.difference();
  Instant instant{frame, {}};
  for (const Thing& thing : setting.things) {
    instant.things.push_back(figures_of(thing, stream.depth(), difference, truth, true_difference));
  }
  return instant;
}

report::ReportPicture still_of(const Setting& setting, const Observation& seen) {
  const rig::RigCamera& camera = setting.options.rig.camera;
  const double pixel = setting.options.rig.plane_z_mm * camera.pixel_pitch_mm / camera.focal_length_mm;
  const double most = setting.experiment.max_difference;
  return report::shown_map(
      fmt::format("{}, t = {:.3f} s", seen.method, seen.moving.back().frame / camera.frame_rate_hz), seen.difference,
      {report::ColourMap::diverging, -most, most}, {pixel, pixel}, "difference from the reference, mm");
}

Observation observe(const Setting& setting, DepthStream& stream, const std::string& method) {
  const MovingOptions& options = setting.options;
  const rig::Rig& rig = options.rig;
  Observation seen;
  seen.method = method;
  seen.window = 2 * stream.bits();
  images::FloatImage truth(rig.camera.rows, rig.camera.columns);
  play(
      setting.renderer, stream, options.first, setting.plan.frames(),
      [&](int frame) {
        if (frame < options.first + kStart) {
          return;
        }
        const int middle = frame - stream.bits() + 1;
        seen.moving.push_back(look(setting, stream, setting.renderer, middle, truth));
        if (!setting.plan.is_shown(seen.moving.size() - 1)) {
          return;
        }
        seen.moving_then.push_back(seen.moving.back());
        seen.depth = stream.depth();
        seen.difference = stream.difference();
        seen.truth = truth;
        seen.strip.push_back(still_of(setting, seen));
      },
      setting.count);
  for (const Instant& then : seen.moving_then) {
    const Frozen frozen(setting.scene, then.frame / rig.camera.frame_rate_hz);
    const sim::PatternRenderer still(rig, frozen, options.render);
    play(
        still, stream, 0, seen.window,
        [&](int frame) {
          if (frame == seen.window - 1) {
            seen.at_rest.push_back(look(setting, stream, still, 0, truth));
          }
        },
        setting.count);
  }
  return seen;
}

ThingSummary summary_of(const std::vector<Instant>& instants, std::size_t thing) {
  ThingSummary summary;
  for (const Instant& instant : instants) {
    summary.add(instant.things[thing]);
  }
  return summary;
}

void add_rows(const Setting& setting, const Observation& seen, report::ReportTable& errors,
              report::ReportTable& motion) {
  for (std::size_t k = 0; k < setting.things.size(); ++k) {
    const std::string name = setting.things[k].name + ", " + seen.method;
    errors.rows.push_back({name});
    for (const std::string& cell : summary_of(seen.moving, k).cells()) {
      errors.rows.back().push_back(cell);
    }
    const double moving = summary_of(seen.moving_then, k).rms();
    const double at_rest = summary_of(seen.at_rest, k).rms();
    motion.rows.push_back({name, figure_text(1000 * seen.window / setting.options.rig.camera.frame_rate_hz, 0),
                           figure_text(moving), figure_text(at_rest),
                           figure_text(std::sqrt(std::max(moving * moving - at_rest * at_rest, 0.0)))});
  }
}

// Height and size of a thing over time, beside the truth.
void add_plots(const Setting& setting, const Observation& seen, std::size_t thing,
               std::vector<report::ReportPlot>& plots) {
  struct Quantity {
    const char* title;
    const char* label;
    double ThingFigures::*measured;
    double ThingFigures::*truth;
  };
  constexpr std::array<Quantity, 3> kQuantities{{
      {"height", "mm", &ThingFigures::height, &ThingFigures::true_height},
      {"size along x", "rows", &ThingFigures::rows, &ThingFigures::true_rows},
      {"size along y", "columns", &ThingFigures::columns, &ThingFigures::true_columns},
  }};
  for (const Quantity& quantity : kQuantities) {
    report::ReportPlot plot{fmt::format("{}, {}: {}", setting.things[thing].name, seen.method, quantity.title),
                            "time, s",
                            quantity.label,
                            {{{}, {}, "a", "measured"}, {{}, {}, "b", "truth"}},
                            1};
    for (const Instant& instant : seen.moving) {
      const ThingFigures& f = instant.things[thing];
      const double t = instant.frame / setting.options.rig.camera.frame_rate_hz;
      plot.traces[0].x.push_back(t);
      plot.traces[0].y.push_back(f.*quantity.measured);
      plot.traces[1].x.push_back(t);
      plot.traces[1].y.push_back(f.*quantity.truth);
    }
    plots.push_back(std::move(plot));
  }
}

void add_series(const Setting& setting, const Observation& seen, std::string& series) {
  for (const Instant& instant : seen.moving) {
    for (std::size_t k = 0; k < setting.things.size(); ++k) {
      const ThingFigures& f = instant.things[k];
      fmt::format_to(std::back_inserter(series),
                     "\"{}\",\"{}\",{},{:.4f},{:.4f},{:.3f},{:.3f},{:.3f},{:.0f},{:.0f},{:.0f},{:.0f}\n",
                     setting.things[k].name, seen.method, instant.frame,
                     instant.frame / setting.options.rig.camera.frame_rate_hz, f.share(), f.rms(), f.height,
                     f.true_height, f.rows, f.true_rows, f.columns, f.true_columns);
    }
  }
}

// The goals of the self-projected method.
void check(const Setting& setting, const Observation& seen, std::vector<std::string>& not_reached) {
  for (std::size_t k = 0; k < setting.things.size(); ++k) {
    const Thing& thing = setting.things[k];
    const ThingSummary summary = summary_of(seen.moving, k);
    const auto wanted = [&](const char* what, double value) {
      if (!(std::abs(value) <= thing.max_rms)) {
        not_reached.push_back(fmt::format("{}: {} is {} mm; at most {:g} mm is wanted", thing.name, what,
                                          figure_text(value), thing.max_rms));
      }
    };
    wanted("the error of z, RMS,", summary.rms());
    wanted("the mean error of the height", summary.height());
  }
}

// Makes tables, series, plots and film strip from the measurements.
void report(const Setting& setting, std::vector<Observation>& seen, StructuredLightResult& result) {
  const std::string name = setting.experiment.name;
  report::ReportTable errors{
      fmt::format("{}: every depth image against the truth in the middle of its window", name),
      {"", "depth images", "valid, %", "z RMS, mm", "worst image", "height, mean error", "largest", "rows, mean error",
       "columns", "largest, px"},
      {},
      "Pixels that truly show the object in the projector's light. Height: the 95th of 100 parts of the differences "
      "from the reference. Size: rows and columns that hold at least a quarter as many of its pixels as the fullest "
      "one, within 30 pixels of the true one."};
  report::ReportTable motion{fmt::format("{}: what motion adds", name),
                             {"", "window, ms", "z RMS moving, mm", "z RMS at rest, mm", "added, mm"},
                             {},
                             "Over the same instants. Added: root of the difference of the squares."};
  result.series =
      "thing,method,frame,time_s,valid,z_rms_mm,height_mm,true_height_mm,rows,true_rows,columns,true_columns\n";
  for (Observation& o : seen) {
    add_rows(setting, o, errors, motion);
    add_series(setting, o, result.series);
    for (std::size_t k = 0; k < setting.things.size(); ++k) {
      add_plots(setting, o, k, result.page.plots);
    }
    std::move(o.strip.begin(), o.strip.end(), std::back_inserter(result.page.pictures));
  }
  result.tables = {std::move(errors), std::move(motion)};
  result.page.title = "Experiment " + name;
  result.page.subtitle = setting.experiment.subtitle;
  result.page.tables = result.tables;
  const rig::Rig& rig = setting.options.rig;
  result.page.settings = {
      {"e", "e", static_cast<std::int64_t>(setting.options.e)},
      {"threshold", "threshold of the binarization", static_cast<std::int64_t>(rig.measure.code_threshold)},
      {"seed", "seed", rig.imaging.seed}};
}

}  // namespace

StructuredLightResult run_moving(const std::string& name, const MovingOptions& options,
                                 const ProgressOfImages& progress) {
  const rig::Rig& rig = options.rig;
  const MovingExperiment& experiment = kExperiments.at(name == "B7" ? 0 : 1);
  const auto background = sim::make_scene(sim::find_scene(experiment.scene).reference_name(), rig);
  const auto scene = sim::make_scene(experiment.scene, rig);
  const Plan plan = plan_of(options, *scene);
  const int all = sim::scan_images(rig, options.scan) + 2 * kConventionalBits + 2 * plan.frames() +
                  plan.stills() * 2 * (structured_light::Stripes{}.bits + kConventionalBits);
  std::size_t done = 0;
  const auto count = [&] { progress(++done, static_cast<std::size_t>(all)); };

  const structured_light::SelfReference reference = structured_light::make_self_reference(
      rig, sim::scan_points(rig, *background, options.render, options.scan, count), {});
  const structured_light::MatchTable table(rig, reference, {.e = options.e});
  const sim::PatternRenderer background_renderer(rig, *background, options.render);
  const sim::PatternRenderer renderer(rig, *scene, options.render);
  images::FloatImage background_z(rig.camera.rows, rig.camera.columns);
  background_renderer.depth(0, background_z.values);
  const Setting setting{options, experiment, *scene, renderer, background_z, experiment.things(rig.camera.columns),
                        plan,    count};

  std::vector<Observation> seen;
  {
    SelfProjectedStream stream(rig, reference, table);
    seen.push_back(observe(setting, stream, "self-projected, 4 bits"));
  }
  {
    ConventionalStream stream(rig, kConventionalBits);
    play(
        background_renderer, stream, 0, 2 * kConventionalBits, [](int) {}, count);
    stream.set_reference(stream.depth());
    seen.push_back(observe(setting, stream, "conventional, 8 bits"));
  }
  StructuredLightResult result;
  report(setting, seen, result);
  check(setting, seen.front(), result.not_reached);
  result.depth = std::move(seen.front().depth);
  result.difference = std::move(seen.front().difference);
  result.truth = std::move(seen.front().truth);
  return result;
}

}  // namespace selfproj::lab
