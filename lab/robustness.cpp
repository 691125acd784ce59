#include "lab/robustness.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lab/disturbed_measurements.h"
#include "lab/structured_light.h"
#include "selfproj/rig/rig.h"

namespace selfproj::lab {
namespace {

using Json = nlohmann::ordered_json;

// The strengths of a disturbance in its curve: its default first, then those that are left out first.
struct Curve {
  const char* name;
  std::array<double, 5> strengths;
};
constexpr std::array<Curve, 13> kCurves{{{"texture", {0.2, 0.1, 0.4, 0.05, 0.3}},
                                         {"bounce", {1, 0.5, 0.25, 0.75, 0.1}},
                                         {"camera-defocus", {4, 8, 2, 16, 2.8}},
                                         {"projector-defocus", {2, 4, 1.4, 8, 1}},
                                         {"gamma", {2.2, 1.6, 2.8, 1.2, 3.4}},
                                         {"fixed-pattern", {0.01, 0.005, 0.05, 0.0025, 0.02}},
                                         {"defect-pixels", {1e-4, 1e-5, 1e-3, 3e-5, 3e-4}},
                                         {"row-noise", {0.3, 0.1, 1.2, 0.2, 0.6}},
                                         {"saturation", {3, 1.5, 5, 2, 8}},
                                         {"flicker", {10, 5, 20, 2, 15}},
                                         {"vibration", {0.1, 0.05, 0.5, 0.02, 0.2}},
                                         {"jitter", {0.015, 0.005, 0.2, 0.01, 0.05}},
                                         {"second-line", {0.3, 0.15, 0.5, 0.05, 0.4}}}};

// A disturbance of A2, and what helps against it: another way of measuring, another threshold, another world.
struct Remedy {
  const char* disturbance;
  const char* what;
  const char* way = "grey-over";
  int threshold = 0;  // 0: the rig's
  const char* instead = nullptr;
};
constexpr std::array<Remedy, 8> kRemedies{{
    {"second-line", "strongest run", "grey-over, strongest run"},
    {"second-line", "mode binary, strongest run", "binary, strongest run"},
    {"second-line", "mode binary, strongest run, threshold 128 instead of 20", "binary, strongest run", 128},
    {"defect-pixels", "strongest run", "grey-over, strongest run"},
    {"flicker", "threshold 40 instead of 20", "grey-over", 40},
    {"flicker", "strongest run", "grey-over, strongest run"},
    {"saturation", "half the exposure", "grey-over", 0, "saturation=1.5"},
    {"texture", "mode binary", "binary"},
}};

std::string share_text(double share) {
  return std::isnan(share) ? "–"
         : share == 0      ? "0"
         : share < 1e-3    ? fmt::format("{:.1e}", share)
                           : fmt::format("{:.4f}", share);
}

Json json_of(const WayOfMeasuring& way, bool codes) {
  const ErrorSpread& e = way.errors;
  const auto number = [](double value) { return std::isnan(value) ? Json(nullptr) : Json(value); };
  Json json{{"way", way.name},
            {"points", e.points()},
            {"missing", number(e.missing())},
            {"rms_mm", number(e.rms())},
            {"p99_mm", number(e.quantile(0.99))},
            {"largest_mm", number(e.quantile(1))},
            {"beyond_0_3_mm", number(e.beyond(kFalseMm))}};
  if (codes) {
    json["beyond_10_mm"] = number(e.beyond(kFalseCodeMm));
  }
  return json;
}

std::vector<std::string> cells_of(const WayOfMeasuring& way, double most) {
  const ErrorSpread& e = way.errors;
  return {figure_text(e.rms(), 3), figure_text(e.quantile(0.99), 3), figure_text(e.quantile(1), 2),
          share_text(e.missing()), share_text(e.beyond(most))};
}

const std::vector<std::string> kCellNames{"RMS, mm", "99 %, mm", "largest, mm", "without a point", "false"};

class Robustness {
 public:
  Robustness(const RobustnessOptions& options, const std::function<void(std::size_t, std::size_t)>& progress)
      : options_(options),
        progress_(progress),
        stairs_(rig::load_rig("light-section"), options.every, options.reference_frames),
        cuboids_(coarser_rig(rig::load_rig("scanner"), options.coarser)) {
    all_ = 2 * (1 + kCurves.size() * options.strengths + options.world.presets.size()) +
           options.world.presets.size() * (1 + kCurves.size() + 2 * static_cast<std::size_t>(options.cameras)) +
           2 * kRemedies.size();
  }

  RobustnessResult run() {
    curves(
        "A2", [this](const sim::World& world) { return stairs_.measure(world); }, kFalseMm);
    curves(
        "B4", [this](const sim::World& world) { return cuboids_.measure(world); }, kFalseCodeMm);
    met_first();
    false_points();
    what_helps();
    result_.page.title = "Experiment robustness";
    result_.page.subtitle = "A2 and B4 in a world that is not ideal";
    result_.page.tables = result_.tables;
    result_.page.tables.insert(result_.page.tables.end(), result_.curves.begin(), result_.curves.end());
    result_.data = data_.dump();
    return std::move(result_);
  }

 private:
  using Measure = std::function<std::vector<WayOfMeasuring>(const sim::World&)>;

  std::vector<WayOfMeasuring> counted(const Measure& measure, const sim::World& world) {
    std::vector<WayOfMeasuring> ways = measure(world);
    progress_(++done_, all_);
    return ways;
  }

  [[nodiscard]] sim::World with(const std::vector<std::string>& names) const {
    return sim::world_of(options_.world, names);
  }

  // The strengths that are measured, ascending.
  [[nodiscard]] std::vector<double> strengths_of(const Curve& curve) const {
    std::vector<double> strengths(curve.strengths.begin(),
                                  curve.strengths.begin() + static_cast<std::ptrdiff_t>(options_.strengths));
    std::sort(strengths.begin(), strengths.end());
    return strengths;
  }

  // One row for a document: all figures of the first way, and of each other one its share of false points.
  static void summarize(report::ReportTable& summary, const std::string& name, const std::string& strength,
                        const std::vector<WayOfMeasuring>& ways, double most) {
    if (summary.header.empty()) {
      summary.header = {"disturbance", "strength"};
      summary.header.insert(summary.header.end(), kCellNames.begin(), kCellNames.end());
      for (std::size_t i = 1; i < ways.size(); ++i) {
        summary.header.push_back("false, " + ways[i].name);
      }
    }
    summary.rows.push_back({name, strength});
    const std::vector<std::string> cells = cells_of(ways[0], most);
    summary.rows.back().insert(summary.rows.back().end(), cells.begin(), cells.end());
    for (std::size_t i = 1; i < ways.size(); ++i) {
      summary.rows.back().push_back(share_text(ways[i].errors.beyond(most)));
    }
  }

  // Every disturbance over its strength, a table and a plot of false points and of missing ones for each.
  void curves(const std::string& experiment, const Measure& measure, double most) {
    const bool codes = experiment == "B4";
    report::ReportTable table{fmt::format("{}: each disturbance alone", experiment),
                              {"disturbance", "strength", "way"},
                              {},
                              fmt::format("False: points more than {} mm off, of all points.", most)};
    table.header.insert(table.header.end(), kCellNames.begin(), kCellNames.end());
    const auto add = [&](const std::string& name, const std::string& strength,
                         const std::vector<WayOfMeasuring>& ways) {
      Json row{{"experiment", experiment}, {"disturbance", name}, {"strength", strength}, {"ways", Json::array()}};
      for (const WayOfMeasuring& way : ways) {
        table.rows.push_back({name, strength, way.name});
        const std::vector<std::string> cells = cells_of(way, most);
        table.rows.back().insert(table.rows.back().end(), cells.begin(), cells.end());
        row["ways"].push_back(json_of(way, codes));
      }
      data_["curves"].push_back(row);
    };
    report::ReportTable summary{
        fmt::format("{}: each disturbance alone, at its default strength", experiment),
        {},
        {},
        fmt::format("{}. False: more than {} mm off, of all points.",
                    codes ? "4 self-projected bits, reference scanned by Gray codes in the same world"
                          : "Mode grey-over with all lit pixels, then the others",
                    most)};
    const auto ideal = counted(measure, {});
    add("none", "–", ideal);
    summarize(summary, "none", "–", ideal, most);
    for (const auto& [preset, gloss] : options_.world.presets) {
      const auto ways = counted(measure, with({"gloss=" + preset}));
      add("gloss", preset, ways);
      summarize(summary, "gloss", preset, ways, most);
    }
    for (const Curve& curve : kCurves) {
      const sim::WorldSwitch& entry = sim::find_world_switch(curve.name);
      report::ReportPlot wrong{fmt::format("{}: {}", experiment, curve.name),
                               entry.strength,
                               fmt::format("points more than {} mm off, %", most),
                               {},
                               1};
      for (const double strength : strengths_of(curve)) {
        const auto ways = counted(measure, with({fmt::format("{}={}", curve.name, strength)}));
        add(curve.name, fmt::format("{:g}", strength), ways);
        sim::World world = with({curve.name});
        if (entry.parameter(world) == strength) {
          summarize(summary, curve.name, fmt::format("{:g}", strength), ways, most);
        }
        wrong.traces.resize(ways.size());
        for (std::size_t i = 0; i < ways.size(); ++i) {
          wrong.traces[i].name = ways[i].name;
          wrong.traces[i].style = i % 2 == 0 ? "a" : "b";
          wrong.traces[i].x.push_back(strength);
          wrong.traces[i].y.push_back(100 * ways[i].errors.beyond(most));
        }
      }
      result_.page.plots.push_back(std::move(wrong));
    }
    result_.tables.push_back(std::move(summary));
    result_.curves.push_back(std::move(table));
  }

  // With each preset of gloss, each disturbance at its default: what costs most in A2, mode grey-over.
  void met_first() {
    report::ReportTable table{
        "A2, grey-over: the disturbances with each preset, the worst first",
        {"surface", "alone, bad", "first", "second", "third"},
        {},
        "Each disturbance at its default strength: points more than 0.3 mm off, and RMS where there are "
        "none. Columns without a point count as off."};
    const Measure measure = [this](const sim::World& world) { return stairs_.measure(world); };
    for (const auto& [preset, gloss] : options_.world.presets) {
      const std::string on = "gloss=" + preset;
      struct Found {
        std::string name;
        double bad, rms;
      };
      const auto found_with = [&](const std::string& name, const sim::World& world) {
        const ErrorSpread errors = counted(measure, world)[0].errors;
        return Found{name, errors.missing() + (1 - errors.missing()) * errors.beyond(kFalseMm), errors.rms()};
      };
      const auto text = [](const Found& f) {
        return fmt::format("{}{}{}, {} mm", f.name, f.name.empty() ? "" : ": ", share_text(f.bad),
                           figure_text(f.rms, 3));
      };
      const Found alone = found_with("", with({on}));
      std::vector<Found> all;
      Json list = Json::array();
      for (const Curve& curve : kCurves) {
        all.push_back(found_with(curve.name, with({on, curve.name})));
        list.push_back({{"disturbance", curve.name}, {"bad", all.back().bad}, {"rms_mm", all.back().rms}});
      }
      std::stable_sort(all.begin(), all.end(), [](const Found& a, const Found& b) {
        return std::pair(a.bad, a.rms) > std::pair(b.bad, b.rms);
      });
      table.rows.push_back({preset, text(alone), text(all[0]), text(all[1]), text(all[2])});
      data_["with_presets"].push_back({{"surface", preset}, {"bad", alone.bad}, {"rms_mm", alone.rms}, {"with", list}});
    }
    result_.tables.push_back(std::move(table));
  }

  // Defect pixels and a second reflection together, with many cameras.
  void false_points() {
    report::ReportTable table{
        "A2: hot pixels (10 in 100,000) and a second reflection of 30 %",
        {"surface", "way", "points", "false", "without a point", "RMS, mm", "99 %, mm", "largest, mm"},
        {},
        fmt::format("{} cameras with defect pixels of their own. False: more than 0.3 mm off. In mode binary a "
                    "reflection that is lit counts as much as the line. The last way has a threshold above it: half of "
                    "the brightness of the line on the good part.",
                    options_.cameras)};
    const std::string binary = "binary, strongest run";
    for (const auto& [preset, gloss] : options_.world.presets) {
      rig::Rig above = stairs_.rig();
      above.measure.threshold = stairs_.half_of_the_line(with({"gloss=" + preset}));
      const DisturbedStairs stairs_above(above, options_.every, options_.reference_frames);
      std::vector<WayOfMeasuring> sum;
      for (int camera = 1; camera <= options_.cameras; ++camera) {
        sim::World world = with({"gloss=" + preset, "defect-pixels", "second-line"});
        world.seed = static_cast<std::uint64_t>(camera);
        auto ways = counted([&](const sim::World& with) { return stairs_.measure(with, camera); }, world);
        for (const auto& way :
             counted([&](const sim::World& with) { return stairs_above.measure(with, camera); }, world)) {
          if (way.name == binary) {
            ways.push_back({way.name + ", half of the line", way.errors});
          }
        }
        sum.resize(ways.size());
        for (std::size_t i = 0; i < ways.size(); ++i) {
          sum[i].name = ways[i].name;
          sum[i].errors.add(ways[i].errors);
        }
      }
      for (const WayOfMeasuring& way : sum) {
        const ErrorSpread& e = way.errors;
        table.rows.push_back({preset, way.name, std::to_string(e.points()), share_text(e.beyond(kFalseMm)),
                              share_text(e.missing()), figure_text(e.rms(), 3), figure_text(e.quantile(0.99), 3),
                              figure_text(e.quantile(1), 2)});
        data_["false_points"][preset][way.name] = json_of(way, false);
        data_["false_points"][preset][way.name]["threshold"] =
            (way.name.ends_with("half of the line") ? above : stairs_.rig()).measure.threshold;
        const bool wanted = way.name.find("strongest run") != std::string::npos && preset != "brushed-steel";
        if (wanted && e.beyond(kFalseMm) > kMaxFalse) {
          result_.not_reached.push_back(fmt::format("{}, {}: {} of the points are false, at most {:g} wanted", preset,
                                                    way.name, share_text(e.beyond(kFalseMm)), kMaxFalse));
        }
        if (wanted && way.name != binary && !(e.missing() < 1)) {
          result_.not_reached.push_back(fmt::format("{}, {}: no column has a point", preset, way.name));
        }
      }
    }
    result_.tables.push_back(std::move(table));
  }

  // Each remedy, with the figures without and with it.
  void what_helps() {
    report::ReportTable table{
        "A2: what helps",
        {"disturbance", "remedy", "false, without", "with", "no point, without", "with", "RMS, mm, without", "with"},
        {},
        "Disturbances at their defaults, on an evenly scattering surface, mode grey-over."};
    for (const Remedy& remedy : kRemedies) {
      const auto errors = [&](const DisturbedStairs& stairs, const char* disturbance, const std::string& way) {
        const auto ways = counted([&](const sim::World& world) { return stairs.measure(world); }, with({disturbance}));
        return std::find_if(ways.begin(), ways.end(), [&](const auto& entry) { return entry.name == way; })->errors;
      };
      rig::Rig rig = stairs_.rig();
      rig.measure.threshold = remedy.threshold > 0 ? remedy.threshold : rig.measure.threshold;
      const ErrorSpread before = errors(stairs_, remedy.disturbance, "grey-over");
      std::optional<DisturbedStairs> other;
      if (remedy.threshold > 0) {
        other.emplace(rig, options_.every, options_.reference_frames);
      }
      const ErrorSpread after =
          errors(other ? *other : stairs_, remedy.instead != nullptr ? remedy.instead : remedy.disturbance, remedy.way);
      table.rows.push_back({remedy.disturbance, remedy.what, share_text(before.beyond(kFalseMm)),
                            share_text(after.beyond(kFalseMm)), share_text(before.missing()),
                            share_text(after.missing()), figure_text(before.rms(), 3), figure_text(after.rms(), 3)});
      data_["remedies"].push_back({{"disturbance", remedy.disturbance},
                                   {"remedy", remedy.what},
                                   {"before", json_of({"", before}, false)},
                                   {"after", json_of({"", after}, false)}});
    }
    result_.tables.push_back(std::move(table));
  }

  const RobustnessOptions& options_;
  const std::function<void(std::size_t, std::size_t)>& progress_;
  DisturbedStairs stairs_;
  DisturbedCuboids cuboids_;
  std::size_t done_ = 0;
  std::size_t all_ = 0;
  RobustnessResult result_;
  Json data_;
};

}  // namespace

RobustnessResult run_robustness(const RobustnessOptions& options,
                                const std::function<void(std::size_t, std::size_t)>& progress) {
  return Robustness(options, progress).run();
}

}  // namespace selfproj::lab
