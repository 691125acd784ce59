#include "lab/gray_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/report/report.h"
#include "lab/gray_observation.h"
#include "lab/pool_experiment.h"
#include "sim/cosim/motion_analysis.h"
#include "sim/scene/scanner_scenes.h"
#include "sim/scene/scene_list.h"

namespace selfproj {
namespace {

constexpr double kWrongMm = 15;  // a depth that is more than this off is wrong
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// ------------------------------------------------------------------ B1

// How well a filter follows the fist on a path.
class Following {
 public:
  Following(const Rig& rig, const SteadySettings& settings)
      : settings_(settings), filter_(rig.camera.rows, rig.camera.columns, settings) {}

  void take(const Seen& seen) {
    const float* kept = seen.depth.values.data();
    if (filter_.is_on()) {
      filter_.apply(seen.depth.values.data(), seen.background.values.data(), kMovedMm);
      filter_.remember(seen.depth.values.data());
      kept = filter_.kept();
    }
    const Foreground found = foreground_of(seen.triangulation, kept, seen.background.values.data(), kMovedMm);
    const Foreground truth =
        foreground_of(seen.triangulation, seen.truth.values.data(), seen.true_background.values.data(), kMovedMm);
    for (std::size_t i = 0; i < seen.truth.values.size(); ++i) {
      const double rise = static_cast<double>(seen.background.values[i]) - static_cast<double>(kept[i]);
      const double off = std::abs(static_cast<double>(kept[i]) - static_cast<double>(seen.truth.values[i]));
      wrong_ += std::abs(rise) > kMovedMm && off > kWrongMm ? 1 : 0;
    }
    ++images_;
    pixels_ += static_cast<double>(found.pixels);
    true_pixels_ += static_cast<double>(truth.pixels);
    t_.push_back(seen.t);
    x_.push_back(found.pixels > 0 ? found.x : kNone);
    if (found.pixels > 0 && truth.pixels > 0) {
      const double d = std::hypot(found.x - truth.x, found.y - truth.y, found.z - truth.z);
      squares_ += d * d;
      most_ = std::max(most_, d);
      ++points_;
    }
  }

  [[nodiscard]] const SteadySettings& settings() const { return settings_; }
  [[nodiscard]] double squares() const { return squares_; }
  [[nodiscard]] double points() const { return points_; }
  [[nodiscard]] double rms() const { return std::sqrt(squares_ / points_); }
  [[nodiscard]] double most() const { return points_ > 0 ? most_ : kNone; }
  [[nodiscard]] double pixels() const { return pixels_ / images_; }
  [[nodiscard]] double true_pixels() const { return true_pixels_ / images_; }
  [[nodiscard]] double wrong() const { return wrong_ / images_; }
  [[nodiscard]] double images() const { return images_; }
  [[nodiscard]] double frequency() const { return fit_sine(t_, x_, 1, 8).frequency; }

 private:
  SteadySettings settings_;
  SteadyFilter filter_;
  double images_ = 0, points_ = 0;
  double squares_ = 0, most_ = 0, pixels_ = 0, true_pixels_ = 0, wrong_ = 0;
  std::vector<double> t_, x_;
};

constexpr std::array<float, 4> kChanges{std::numeric_limits<float>::infinity(), 20, 10, 5};
constexpr std::array<int, 4> kNeighbours{0, 4, 6, 8};

std::string change_text(const SteadySettings& s) {
  return std::isinf(s.max_change_mm) ? "any" : fmt::format("{:g}", s.max_change_mm);
}

// The least RMS among those that keep at least half as many pixels as truly moved.
std::size_t best_of(const std::vector<Following>& filters) {
  std::size_t best = 0;
  for (std::size_t i = 0; i < filters.size(); ++i) {
    const bool keeps = 2 * filters[i].pixels() >= filters[i].true_pixels();
    best = keeps && filters[i].rms() < filters[best].rms() ? i : best;
  }
  return best;
}

StructuredLightResult run_fist(const GrayMotionOptions& options, const ProgressOfImages& progress) {
  const Rig& rig = options.rig;
  const int frames = options.frames > 0 ? options.frames : 300;  // a turn at 3.5 Hz and a cycle
  std::size_t done = 0;
  const std::size_t all = images_of(1 + options.paths, frames);
  const auto count = [&] { progress(++done, all); };
  const auto desk = make_scene("desk", rig);

  std::vector<Following> filters;
  for (const float change : kChanges) {
    for (const int neighbours : kNeighbours) {
      filters.emplace_back(rig, SteadySettings{change, neighbours});
    }
  }
  const auto path = make_fist(rig, {});
  observe(options, {*path, *desk, 0, frames, rig.imaging.seed}, count, [&](const Seen& seen) {
    for (Following& filter : filters) {
      filter.take(seen);
    }
  });
  const std::size_t best = best_of(filters);
  StructuredLightResult result;
  ReportTable tuned{"B1: filters on the path of the thesis, on which one is chosen",
                    {"change, mm", "neighbours", "centroid, RMS, mm", "largest, mm", "pixels", "wrong", "chosen"},
                    {},
                    fmt::format("What differs from the background by more than {:g} mm, has changed by no more than "
                                "`change` since the depth image before, and has so many neighbours of which the same "
                                "holds. Pixels for each depth image; in truth {:.0f}. Wrong: more than {:g} mm off. "
                                "Chosen: the least RMS among those that keep at least half of the true pixels.",
                                kMovedMm, filters[0].true_pixels(), kWrongMm)};
  for (std::size_t i = 0; i < filters.size(); ++i) {
    const Following& f = filters[i];
    tuned.rows.push_back({change_text(f.settings()), std::to_string(f.settings().min_neighbours),
                          figure_text(f.rms(), 1), figure_text(f.most(), 0), figure_text(f.pixels(), 0),
                          figure_text(f.wrong(), 0), i == best ? "yes" : ""});
  }
  ReportTable others{"B1: the chosen filter on paths on which it was not chosen",
                     {"path", "true Hz", "measured Hz", "centroid, RMS, mm", "largest, mm", "pixels", "in truth",
                      "wrong", "RMS without the filter"},
                     {},
                     "Paths, and the camera's noise, are drawn by seeds: place, size, slant, direction, speed and "
                     "phase of the circle."};
  std::array<double, 4> pooled{};  // squares and points, with and without
  for (int k = 1; k <= options.paths; ++k) {
    const FistPath drawn = drawn_path(static_cast<std::uint64_t>(k));
    const auto scene = make_fist(rig, drawn);
    std::vector<Following> two;
    two.emplace_back(rig, filters[best].settings());
    two.emplace_back(rig, SteadySettings{});
    observe(options, {*scene, *desk, 0, frames, rig.imaging.seed + 100 * k}, count, [&](const Seen& seen) {
      two[0].take(seen);
      two[1].take(seen);
    });
    const Following& f = two[0];
    others.rows.push_back({std::to_string(k), figure_text(drawn.frequency), figure_text(f.frequency()),
                           figure_text(f.rms(), 1), figure_text(f.most(), 0), figure_text(f.pixels(), 0),
                           figure_text(f.true_pixels(), 0), figure_text(f.wrong(), 0), figure_text(two[1].rms(), 1)});
    for (std::size_t i = 0; i < 2; ++i) {
      pooled.at(2 * i) += two[i].squares();
      pooled.at(2 * i + 1) += two[i].points();
    }
  }
  others.rows.push_back({"all", "", "", figure_text(std::sqrt(pooled[0] / pooled[1]), 1), "", "", "", "",
                         figure_text(std::sqrt(pooled[2] / pooled[3]), 1)});
  result.tables = {std::move(tuned), std::move(others)};
  return result;
}

// ------------------------------------------------------------------ B3

StructuredLightResult run_keys(const GrayMotionOptions& options, const ProgressOfImages& progress) {
  const int frames = options.frames > 0 ? options.frames : 1016;  // five taps and a cycle
  const Rig& rig = options.rig;
  const auto keyboard = make_scene("keyboard", rig);
  // The second set differs in all that can differ. It was written down before anything was measured with it.
  const std::array<Taps, 2> sets{{{}, {.frequency = {3.6, 6.4}, .stroke = {13, 7}, .phase = {1.1, 4.4}}}};
  std::size_t done = 0;
  StructuredLightResult result;
  ReportTable table{"B3: depth at the two keys",
                    {"taps, key", "true Hz", "measured Hz", "true amplitude, mm", "measured, mm", "z RMS, mm",
                     "depth images with a depth, %"},
                    {},
                    "At pixels (220, 247) and (249, 224) of what moved. Amplitude: half a stroke."};
  for (std::size_t set = 0; set < sets.size(); ++set) {
    const Taps& taps = sets.at(set);
    const auto scene = make_keys(rig, taps);
    std::vector<double> t;
    std::array<std::vector<double>, 2> z, truth;
    SteadyFilter filter(rig.camera.rows, rig.camera.columns, kSteady);
    observe(
        options, {*scene, *keyboard, 0, frames, rig.imaging.seed + static_cast<std::int64_t>(set)},
        [&] { progress(++done, images_of(2, frames)); },
        [&](const Seen& seen) {
          filter.apply(seen.depth.values.data(), seen.background.values.data(), kMovedMm);
          filter.remember(seen.depth.values.data());
          t.push_back(seen.t);
          for (std::size_t key = 0; key < 2; ++key) {
            const KeyTaps::Pixel pixel = (key == 0 ? KeyTaps::kFirst : KeyTaps::kSecond).of(rig.camera);
            const auto at = static_cast<std::size_t>(pixel.row) * static_cast<std::size_t>(rig.camera.columns) +
                            static_cast<std::size_t>(pixel.column);
            z.at(key).push_back(static_cast<double>(filter.kept()[at]));
            truth.at(key).push_back(static_cast<double>(seen.truth.values[at]));
          }
        });
    for (std::size_t key = 0; key < 2; ++key) {
      const std::string name = fmt::format("{}, key {}", set == 0 ? "of the thesis" : "second set", key + 1);
      const SineFit fit = fit_sine(t, z.at(key), 2, 9);
      double squares = 0;
      double points = 0;
      for (std::size_t i = 0; i < t.size(); ++i) {
        const double off = z.at(key)[i] - truth.at(key)[i];
        squares += std::isnan(off) ? 0 : off * off;
        points += std::isnan(off) ? 0 : 1;
      }
      table.rows.push_back({name, figure_text(taps.frequency.at(key)), figure_text(fit.frequency),
                            figure_text(taps.stroke.at(key) / 2), figure_text(fit.amplitude),
                            figure_text(std::sqrt(squares / points)),
                            figure_text(100 * points / static_cast<double>(t.size()), 0)});
      result.page.plots.push_back({fmt::format("Depth, {}", name),
                                   "time, s",
                                   "z, mm",
                                   {{t, z.at(key), "a", "measured"}, {t, truth.at(key), "b", "true"}}});
    }
  }
  result.tables = {std::move(table)};
  return result;
}

}  // namespace

StructuredLightResult run_gray_motion(const std::string& name, const GrayMotionOptions& options,
                                      const ProgressOfImages& progress) {
  if (options.frames != 0 && (options.frames < kGrayCycle || options.frames % 2 != 0)) {
    throw std::invalid_argument("gray motion: a cycle of the patterns takes 16 frames");
  }
  StructuredLightResult result = name == "B1"   ? run_fist(options, progress)
                                 : name == "B2" ? run_waves(options, progress)
                                                : run_keys(options, progress);
  result.page.title = "Experiment " + name;
  result.page.subtitle = name == "B1"   ? "A fist over a desk: the centroid of what moved"
                         : name == "B2" ? "Waves on water 3 cm deep"
                                        : "Two fingers on keys";
  result.page.tables = result.tables;
  result.page.settings = {{"bits", "bits of the Gray codes", std::int64_t{kGrayBits}},
                          {"seed", "seed", options.rig.imaging.seed}};
  return result;
}

}  // namespace selfproj
