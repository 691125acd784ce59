#include "lab/gray_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <opencv2/core/matx.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/report/report.h"
#include "lab/cuboids.h"
#include "lab/structured_light.h"
#include "selfproj/images/float_image.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/rig/calibration.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/foreground.h"
#include "selfproj/structured_light/triangulation.h"
#include "sim/cosim/motion_analysis.h"
#include "sim/cosim/wave_dispersion.h"
#include "sim/scene/optics.h"
#include "sim/scene/random.h"
#include "sim/scene/ring_wave.h"
#include "sim/scene/scenes.h"

namespace selfproj::lab {
namespace {

constexpr double kNoCrest = std::numeric_limits<double>::quiet_NaN();
constexpr double kShortestWave = 60;  // mm; the speed of shorter waves hardly depends on the depth
constexpr double kAfter = 0.56;       // s from the impact to the last frame of the scene
constexpr int kWaveFrames = 486;      // from kWaveFrom until 0.55 s after the impact
constexpr double kMaxOff = 0.05;      // greatest relative error of the speed of long waves

// What is measured in one pool, either in the host's depth images or in the true ones.
struct WaveSeen {
  sim::BasinWaves waves{sim::pool_basin(), kShortestWave, kGrayCycle / 2};
  std::vector<double> crest;

  void take(const Seen& seen, const images::FloatImage& depth, const images::FloatImage& background,
            const sim::RingMeans& rings) {
    waves.add(seen.t, seen.triangulation, depth, background, sim::kMaxWave);
    crest.push_back(sim::is_open_wave(seen.t - sim::PoolWave::kImpact)
                        ? sim::foremost_crest(rings, rings.means(depth, background, sim::kMaxWave), sim::kMinWave)
                        : kNoCrest);
  }
};

// Returns the depth z of the water at rest, mm: the median depth of the borders between codes in the basin.
float level_of(const structured_light::Triangulation& triangulation, const images::FloatImage& borders) {
  constexpr sim::Basin kPool = sim::pool_basin();
  std::vector<float> depths;
  for (std::size_t i = 0; i < borders.values.size(); ++i) {
    const structured_light::Point3f p = triangulation.point(i, borders.values[i]);
    const auto x = static_cast<double>(p.x);
    const auto y = static_cast<double>(p.y);
    if (x > kPool.x0 && x < kPool.x1 && y > kPool.y0 && y < kPool.y1) {  // not if NaN
      depths.push_back(p.z);
    }
  }
  if (depths.empty()) {
    return std::numeric_limits<float>::quiet_NaN();
  }
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return *middle;
}

// Depths rounded to whole codes, as if all bits were taken at once and without noise.
class WholeCodes {
 public:
  explicit WholeCodes(const rig::Rig& rig) : matrix_(rig::depth_matrices(rig, kGrayBits).projector) {}

  [[nodiscard]] images::FloatImage of(const structured_light::Triangulation& triangulation,
                                      const images::FloatImage& depth) const {
    std::vector<std::uint16_t> words(depth.values.size(), 0);
    for (std::size_t i = 0; i < words.size(); ++i) {
      const structured_light::Point3f p = triangulation.point(i, depth.values[i]);
      const cv::Matx<double, 2, 1> line = matrix_ * cv::Vec4d(cv::Vec4f(p.x, p.y, p.z, 1));
      const double code = line(0) / line(1);
      if (code >= 0 && code < 1 << kGrayBits) {  // not if NaN
        words[i] = static_cast<std::uint16_t>(static_cast<int>(code) | model::GrayDecoder::kMeasurable);
      }
    }
    images::FloatImage rounded(depth.rows, depth.columns);
    triangulation.depth(words.data(), rounded.values.data());
    return rounded;
  }

 private:
  cv::Matx<double, 2, 4> matrix_;
};

struct PoolSeen {
  std::vector<double> t;
  WaveSeen measured, truth;
  sim::BasinWaves borders{sim::pool_basin(), kShortestWave, 1};
  sim::BasinWaves rounded{sim::pool_basin(), kShortestWave, kGrayCycle / 2};
};

constexpr double kCmPerMm = 0.1;

std::string cm_text(double mm) { return figure_text(mm * kCmPerMm, 1); }
std::string cm_text(double mm, double deviation) { return fmt::format("{} ± {}", cm_text(mm), cm_text(deviation)); }

// How a pool is observed. Without `truth`, nothing is measured in true depths.
struct PoolShot {
  int frames;
  std::int64_t noise_seed;
  bool truth;
};

PoolSeen observe_pool(const GrayMotionOptions& options, sim::PoolDrop drop, const PoolShot& how,
                      const std::function<void()>& done) {
  drop.after = kAfter;
  const auto pool = sim::make_pool(options.rig, drop.depth);
  const auto waves = sim::make_waves(options.rig, drop);
  const int first =
      static_cast<int>(std::lround((sim::PoolWave::kImpact + sim::kWaveFrom) * options.rig.camera.frame_rate_hz));
  PoolSeen found;
  const WholeCodes whole(options.rig);
  images::FloatImage at_rest, rounded_at_rest;
  observe(options, {*waves, *pool, first - kGrayCycle, how.frames, how.noise_seed, how.truth}, done,
          [&](const Seen& seen) {
            const sim::RingMeans rings = sim::pool_rings(seen.triangulation, drop.x, drop.y);
            found.t.push_back(seen.t);
            found.measured.take(seen, seen.depth, seen.background, rings);
            if (at_rest.values.empty()) {
              at_rest = images::FloatImage(seen.depth.rows, seen.depth.columns,
                                           level_of(seen.triangulation, seen.background_borders));
              rounded_at_rest = whole.of(seen.triangulation, seen.true_background);
            }
            if (seen.borders != nullptr) {
              found.borders.add(seen.t, seen.triangulation, *seen.borders, at_rest, sim::kMaxWave);
            }
            if (how.truth) {
              found.rounded.add(seen.t, seen.triangulation, whole.of(seen.triangulation, seen.truth), rounded_at_rest,
                                sim::kMaxWave);
              found.truth.take(seen, seen.truth, seen.true_background, rings);
            }
          });
  return found;
}

struct NamedDrop {
  std::string name;
  sim::PoolDrop drop;
};

// Returns pool i of those in addition to the pool of the thesis. If `first_seed` is 0, two of them have other depths,
// and the seeds 1, 2, ... draw the rest. Otherwise all are drawn, by the seeds from `first_seed` on.
NamedDrop other_pool(int i, std::uint64_t first_seed) {
  constexpr std::array<double, 2> kOtherDepths{20, 40};
  if (first_seed == 0 && i < static_cast<int>(kOtherDepths.size())) {
    sim::PoolDrop drop;
    drop.depth = kOtherDepths.at(static_cast<std::size_t>(i));
    return {fmt::format("{:g} mm deep", drop.depth), drop};
  }
  const auto count = static_cast<std::uint64_t>(i);
  const std::uint64_t seed = first_seed > 0 ? first_seed + count : count - kOtherDepths.size() + 1;
  return {fmt::format("drawn by seed {}", seed), drawn_drop(seed)};
}

report::ReportTable lengths_table(const sim::WaveDispersion& measured, const sim::WaveDispersion& in_truth) {
  constexpr std::array<double, 7> kLengths{500, 240, 160, 120, 95, 75, 60};
  report::ReportTable table{
      "B2: phase speed by wavelength",
      {"waves of, mm", "standing waves", "mean length, mm", "measured, cm/s", "in the true depths, cm/s",
       "by theory, cm/s"},
      {},
      "The frequency of each wave is fitted freely. By theory: Airy's waves of the mean length in 3 cm of water."};
  for (std::size_t i = 0; i + 1 < kLengths.size(); ++i) {
    const sim::WaveSpeed seen = measured.speed(kLengths.at(i), kLengths.at(i + 1));
    const sim::WaveSpeed truth = in_truth.speed(kLengths.at(i), kLengths.at(i + 1));
    const double k = 2 * std::numbers::pi / seen.length;
    table.rows.push_back({fmt::format("{:g} to {:g}", kLengths.at(i + 1), kLengths.at(i)), std::to_string(seen.waves),
                          figure_text(seen.length, 0), cm_text(seen.speed, seen.deviation),
                          cm_text(truth.speed, truth.deviation),
                          cm_text(sim::RingWave::omega(k, sim::PoolWave::kDepth) / k)});
  }
  return table;
}

}  // namespace

StructuredLightResult run_waves(const GrayMotionOptions& options, const ProgressOfImages& progress) {
  const int frames = options.frames > 0 ? options.frames : kWaveFrames;
  std::size_t done = 0;
  const auto count = [&] { progress(++done, images_of(1 + options.pools, frames)); };
  StructuredLightResult result;
  report::ReportTable others{
      "B2: speed of long waves in other pools",
      {"pool", "depth, mm", "measured, mm", "√(g h), cm/s", "measured, cm/s", "off, %", "standing waves", "misfit",
       "off by whole codes, %", "foremost crest, cm/s"},
      {},
      "Depth, place of the impact and crater are drawn by seeds, with noise of its own in each pool. "
      "Misfit: the residual with the theory's frequencies, divided by that with a freely fitted frequency "
      "for each wave."};
  const auto judge = [&](const std::string& name, double true_speed, const sim::LongWaves& waves) {
    const double off = waves.speed / true_speed - 1;
    if (!(std::abs(off) <= kMaxOff)) {
      result.not_reached.push_back(fmt::format("{}: long waves are measured at {} cm/s, within {:g} % of {} wanted",
                                               name, cm_text(waves.speed), 100 * kMaxOff, cm_text(true_speed)));
    }
    return figure_text(100 * off, 1);
  };
  const auto speed_of = [](const sim::PoolDrop& drop) { return std::sqrt(sim::kStandardGravity * drop.depth); };
  const PoolSeen pool = observe_pool(options, {}, {frames, options.rig.imaging.seed, true}, count);
  const sim::WaveDispersion measured(pool.borders);
  const sim::LongWaves by_codes = sim::WaveDispersion(pool.measured.waves).long_waves();
  const sim::LongWaves rounded = sim::WaveDispersion(pool.rounded).long_waves();
  const sim::WaveDispersion in_truth(pool.truth.waves);
  const sim::LongWaves found = measured.long_waves();
  const sim::LongWaves truth = in_truth.long_waves();
  judge("3 cm of water", speed_of({}), found);
  const auto row_of = [&](const std::string& name, const sim::PoolDrop& drop, const PoolSeen& seen) {
    const sim::LongWaves waves = sim::WaveDispersion(seen.borders).long_waves();
    const sim::LongWaves whole_codes = sim::WaveDispersion(seen.measured.waves).long_waves();
    others.rows.push_back({name, figure_text(drop.depth, 1),
                           fmt::format("{} ± {}", figure_text(waves.depth, 1),
                                       figure_text(2 * waves.depth * waves.deviation / waves.speed, 1)),
                           cm_text(speed_of(drop)), cm_text(waves.speed, waves.deviation),
                           judge(name, speed_of(drop), waves), std::to_string(waves.waves), figure_text(waves.misfit),
                           figure_text(100 * (whole_codes.speed / speed_of(drop) - 1), 1),
                           cm_text(sim::crest_speed(seen.t, seen.measured.crest))});
  };
  for (int i = 0; i < options.pools; ++i) {
    const auto [name, drop] = other_pool(i, options.pool_seed);
    row_of(name, drop, observe_pool(options, drop, {frames, options.rig.imaging.seed + 100 * (i + 1), false}, count));
  }
  result.tables = {
      {"B2: speed of the wave, cm/s",
       {"", "published", "measured", "by whole codes", "in the true depths", "in true depths, rounded to codes"},
       {{"long waves, √(g h), by the depth that all standing waves give", "54", cm_text(found.speed, found.deviation),
         cm_text(by_codes.speed, by_codes.deviation), cm_text(truth.speed, truth.deviation),
         cm_text(rounded.speed, rounded.deviation)},
        {"foremost crest", "54", "–", cm_text(sim::crest_speed(pool.t, pool.measured.crest)),
         cm_text(sim::crest_speed(pool.t, pool.truth.crest)), "–"}},
       fmt::format("Published: √(g h) = {} cm/s, which the thesis states and does not measure. Water 3 cm deep "
                   "disperses: only waves much longer than that run so fast, and the crests that are seen are short.",
                   cm_text(speed_of({})))},
      lengths_table(measured, in_truth),
      std::move(others)};
  result.page.plots.push_back(
      {"Foremost crest of the wave",
       "time, s",
       "distance from the impact, mm",
       {{pool.t, pool.measured.crest, "a", "measured"}, {pool.t, pool.truth.crest, "b", "in the true depths"}}});
  return result;
}

namespace {

constexpr double kMaxFrequencyOff = 0.02;  // goals of B1 and B3, of the true one
constexpr double kMaxAmplitudeOff = 0.1;   // goal of B3
constexpr double kMaxCentroidOff = 10;     // goal of B1, mm RMS

// ------------------------------------------------------------------ B1

// What the fist truly shows to the camera in one depth image: all of it, and what is in the projector's image.
struct TrueFist {
  structured_light::Foreground whole, in_view;
};

TrueFist true_fist(const Seen& seen, const LinePlanes& planes, const rig::RigProjector& projector) {
  const auto moved = [&](const images::FloatImage& depth) {
    return structured_light::foreground_of(seen.triangulation, depth.values.data(), seen.true_background.values.data(),
                                           sim::kMovedMm);
  };
  images::FloatImage in_view = seen.truth;
  for (std::size_t i = 0; i < in_view.values.size(); ++i) {
    const auto z = static_cast<double>(in_view.values[i]);
    if (std::abs(z - static_cast<double>(seen.true_background.values[i])) > sim::kMovedMm) {
      const sim::PixelPoint light = planes.light(i, z);
      const bool lit =
          light.row >= 0 && light.row < projector.lines && light.column >= 0 && light.column < projector.columns;
      in_view.values[i] = lit ? in_view.values[i] : std::numeric_limits<float>::quiet_NaN();
    }
  }
  return {moved(seen.truth), moved(in_view)};
}

// The centroids of what moved on a path, by one filter, beside the true ones.
class Following {
 public:
  Following(const rig::Rig& rig, const structured_light::SteadySettings& settings)
      : filter_(rig.camera.rows, rig.camera.columns, settings) {}

  void take(const Seen& seen, const TrueFist& truth) {
    const float* kept = seen.depth.values.data();
    if (filter_.is_on()) {
      filter_.apply(seen.depth.values.data(), seen.background.values.data(), sim::kMovedMm);
      filter_.remember(seen.depth.values.data());
      kept = filter_.kept();
    }
    t_.push_back(seen.t);
    found_.push_back(
        structured_light::foreground_of(seen.triangulation, kept, seen.background.values.data(), sim::kMovedMm));
    true_.push_back(truth);
  }

  // Where the fist leaves the light, the centroid is that of a part of it. So an image counts for the frequency if it
  // has at least half as many pixels as nineteen images of twenty have at most.
  [[nodiscard]] double frequency() const {
    constexpr double kMany = 0.95;
    std::vector<std::int64_t> pixels;
    for (const structured_light::Foreground& found : found_) {
      pixels.push_back(found.pixels);
    }
    const auto many = pixels.begin() + static_cast<std::ptrdiff_t>(kMany * static_cast<double>(pixels.size() - 1));
    std::nth_element(pixels.begin(), many, pixels.end());
    std::vector<double> t;
    std::vector<std::vector<double>> places(3);
    for (std::size_t i = 0; i < t_.size(); ++i) {
      if (found_[i].pixels > 0 && 2 * found_[i].pixels >= *many) {
        t.push_back(t_[i]);
        places[0].push_back(found_[i].x);
        places[1].push_back(found_[i].y);
        places[2].push_back(found_[i].z);
      }
    }
    constexpr double kLow = 1;
    constexpr double kHigh = 8;
    return sim::common_frequency(t, places, kLow, kHigh);
  }

  // Over the images in which at least half of the fist is in the projector's image.
  struct Figures {
    int images = 0;
    int lost = 0;              // of them, those in which nothing was found
    double rms = 0, most = 0;  // the centroid from that of what is in view, mm
    double rms_whole = 0;      // the same from that of the whole fist
    double kept = 0;           // pixels, of those in view
  };
  [[nodiscard]] Figures figures() const {
    Figures f;
    double pixels = 0;
    double in_view = 0;
    const auto off = [](const structured_light::Foreground& a, const structured_light::Foreground& b) {
      return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
    };
    for (std::size_t i = 0; i < t_.size(); ++i) {
      if (true_[i].in_view.pixels == 0 || 2 * true_[i].in_view.pixels < true_[i].whole.pixels) {
        continue;
      }
      ++f.images;
      in_view += static_cast<double>(true_[i].in_view.pixels);
      pixels += static_cast<double>(found_[i].pixels);
      if (found_[i].pixels == 0) {
        ++f.lost;
        continue;
      }
      const double distance = off(found_[i], true_[i].in_view);
      f.rms += distance * distance;
      f.most = std::max(f.most, distance);
      f.rms_whole += std::pow(off(found_[i], true_[i].whole), 2);
    }
    f.rms = std::sqrt(f.rms / (f.images - f.lost));
    f.rms_whole = std::sqrt(f.rms_whole / (f.images - f.lost));
    f.kept = pixels / in_view;
    return f;
  }

  [[nodiscard]] std::size_t images() const { return t_.size(); }

  // x, y and z over time, beside those of all that the camera sees of the fist.
  [[nodiscard]] std::vector<report::ReportPlot> plots() const {
    using structured_light::Foreground;
    std::vector<report::ReportPlot> plots;
    for (const auto& [axis, place] : {std::pair{"x", &Foreground::x}, {"y", &Foreground::y}, {"z", &Foreground::z}}) {
      std::vector<double> found;
      std::vector<double> truth;
      for (std::size_t i = 0; i < t_.size(); ++i) {
        found.push_back(found_[i].*place);
        truth.push_back(true_[i].whole.*place);
      }
      plots.push_back({fmt::format("Centroid of what moved, {}", axis),
                       "time, s",
                       fmt::format("{}, mm", axis),
                       {{t_, std::move(found), "a", "measured"}, {t_, std::move(truth), "b", "true"}}});
    }
    return plots;
  }

 private:
  structured_light::SteadyFilter filter_;
  std::vector<double> t_;
  std::vector<structured_light::Foreground> found_;
  std::vector<TrueFist> true_;
};

StructuredLightResult run_fist(const GrayMotionOptions& options, const ProgressOfImages& progress) {
  const rig::Rig& rig = options.rig;
  // Two turns at 2.5 Hz, the slowest drawn, and a cycle. In one turn the light may reach a short arc only.
  constexpr int kTwoTurns = 816;
  const int frames = options.frames > 0 ? options.frames : kTwoTurns;
  std::size_t done = 0;
  const bool with_thesis = options.path_seed == 0;
  const std::size_t all = images_of((with_thesis ? 1 : 0) + options.paths, frames);
  const auto count = [&] { progress(++done, all); };
  const auto desk = sim::make_scene("desk", rig);
  const LinePlanes planes(rig);
  StructuredLightResult result;
  report::ReportTable table{
      "B1: the centroid of the fist",
      {"path", "true Hz", "measured Hz", "off, %", "images", "half in view", "nothing found", "centroid, RMS, mm",
       "largest, mm", "from the whole fist, RMS, mm", "pixels kept, %", "RMS without the filter, mm"},
      {},
      fmt::format(
          "What differs from the background by more than {:g} mm, has changed by no more than {:g} mm since the "
          "depth image before, and has {} neighbours of which the same holds. Figures right of “half in view” "
          "are of the images in which at least half of what the camera sees of the fist is in the projector's "
          "image. Centroid: from the true one of what is in view. Drawn paths, and the camera's noise, are "
          "drawn by seeds: place, size, slant, direction, speed and phase of the circle.",
          sim::kMovedMm, sim::kSteady.max_change_mm, sim::kSteady.min_neighbours)};
  double worst_off = 0;
  Following::Figures worst{.kept = 1};
  const int first = with_thesis ? 0 : static_cast<int>(options.path_seed);
  const int last = with_thesis ? options.paths : first + options.paths - 1;
  for (int k = first; k <= last; ++k) {  // the seed; 0: the path of the thesis
    const sim::FistPath path = k == 0 ? sim::FistPath{} : drawn_path(static_cast<std::uint64_t>(k));
    const auto scene = sim::make_fist(rig, path);
    Following filtered(rig, sim::kSteady);
    Following unfiltered(rig, {});
    observe(options, {*scene, *desk, 0, frames, rig.imaging.seed + 100 * k}, count, [&](const Seen& seen) {
      const TrueFist truth = true_fist(seen, planes, rig.projector);
      filtered.take(seen, truth);
      unfiltered.take(seen, truth);
    });
    const Following::Figures f = filtered.figures();
    const double frequency = filtered.frequency();
    const double off = frequency / path.frequency - 1;
    const std::string name = k == 0 ? "of the thesis" : std::to_string(k);
    table.rows.push_back({name, figure_text(path.frequency), figure_text(frequency), figure_text(100 * off, 1),
                          std::to_string(filtered.images()), std::to_string(f.images), std::to_string(f.lost),
                          figure_text(f.rms, 1), figure_text(f.most, 1), figure_text(f.rms_whole, 1),
                          figure_text(100 * f.kept, 0), figure_text(unfiltered.figures().rms, 1)});
    if (k == 0) {
      result.page.plots = filtered.plots();
      continue;  // the filter was chosen on it
    }
    const auto wanted = [&](const char* what, double value, double most) {
      if (!(std::abs(value) <= most)) {
        result.not_reached.push_back(
            fmt::format("path {}: {} is {}; at most {:g} is wanted", k, what, figure_text(value, 3), most));
      }
    };
    wanted("the frequency's relative error", off, kMaxFrequencyOff);
    wanted("the centroid's error, mm RMS,", f.rms, kMaxCentroidOff);
    wanted("the number of images without a centroid", f.lost, 0);
    worst_off = std::abs(off) <= worst_off ? worst_off : std::abs(off);  // NaN is worst
    worst.rms = f.rms <= worst.rms ? worst.rms : f.rms;
    worst.most = std::max(worst.most, f.most);
    worst.rms_whole = f.rms_whole <= worst.rms_whole ? worst.rms_whole : f.rms_whole;
    worst.kept = std::min(worst.kept, f.kept);
    worst.lost += f.lost;
  }
  table.rows.push_back({"worst of those drawn", "", "", figure_text(100 * worst_off, 1), "", "",
                        std::to_string(worst.lost), figure_text(worst.rms, 1), figure_text(worst.most, 1),
                        figure_text(worst.rms_whole, 1), figure_text(100 * worst.kept, 0), ""});
  result.tables = {std::move(table)};
  return result;
}

// ------------------------------------------------------------------ B3

StructuredLightResult run_keys(const GrayMotionOptions& options, const ProgressOfImages& progress) {
  const int frames = options.frames > 0 ? options.frames : 1016;  // five taps and a cycle
  const rig::Rig& rig = options.rig;
  const auto keyboard = sim::make_scene("keyboard", rig);
  // The second set differs in all that can differ. It was written down before anything was measured with it.
  const std::array<sim::Taps, 2> sets{{{}, {.frequency = {3.6, 6.4}, .stroke = {13, 7}, .phase = {1.1, 4.4}}}};
  std::size_t done = 0;
  StructuredLightResult result;
  report::ReportTable table{"B3: depth at the two keys",
                            {"taps, key", "true Hz", "measured Hz", "true amplitude, mm", "measured, mm", "z RMS, mm",
                             "depth images with a depth, %"},
                            {},
                            "At pixels (220, 247) and (249, 224) of what moved. Amplitude: half a stroke."};
  for (std::size_t set = 0; set < sets.size(); ++set) {
    const sim::Taps& taps = sets.at(set);
    const auto scene = sim::make_keys(rig, taps);
    std::vector<double> t;
    std::array<std::vector<double>, 2> z, truth;
    structured_light::SteadyFilter filter(rig.camera.rows, rig.camera.columns, sim::kSteady);
    observe(
        options, {*scene, *keyboard, 0, frames, rig.imaging.seed + static_cast<std::int64_t>(set)},
        [&] { progress(++done, images_of(2, frames)); },
        [&](const Seen& seen) {
          filter.apply(seen.depth.values.data(), seen.background.values.data(), sim::kMovedMm);
          filter.remember(seen.depth.values.data());
          t.push_back(seen.t);
          for (std::size_t key = 0; key < 2; ++key) {
            const sim::KeyTaps::Pixel pixel = (key == 0 ? sim::KeyTaps::kFirst : sim::KeyTaps::kSecond).of(rig.camera);
            const auto at = static_cast<std::size_t>(pixel.row) * static_cast<std::size_t>(rig.camera.columns) +
                            static_cast<std::size_t>(pixel.column);
            z.at(key).push_back(static_cast<double>(filter.kept()[at]));
            truth.at(key).push_back(static_cast<double>(seen.truth.values[at]));
          }
        });
    for (std::size_t key = 0; key < 2; ++key) {
      const std::string name = fmt::format("{}, key {}", set == 0 ? "of the thesis" : "second set", key + 1);
      const sim::SineFit fit = sim::fit_sine(t, z.at(key), 2, 9);
      double squares = 0;
      double points = 0;
      for (std::size_t i = 0; i < t.size(); ++i) {
        const double off = z.at(key)[i] - truth.at(key)[i];
        squares += std::isnan(off) ? 0 : off * off;
        points += std::isnan(off) ? 0 : 1;
      }
      const double rms = std::sqrt(squares / points);
      const auto wanted = [&](const char* what, double off, double most) {
        if (!(std::abs(off) <= most)) {
          result.not_reached.push_back(
              fmt::format("{}: {} is {} off; at most {:g} is wanted", name, what, figure_text(off, 3), most));
        }
      };
      wanted("the frequency", fit.frequency / taps.frequency.at(key) - 1, kMaxFrequencyOff);
      wanted("the amplitude", 2 * fit.amplitude / taps.stroke.at(key) - 1, kMaxAmplitudeOff);
      wanted("z, mm RMS,", rms, kHalfPixelOnPlane);
      table.rows.push_back({name, figure_text(taps.frequency.at(key)), figure_text(fit.frequency),
                            figure_text(taps.stroke.at(key) / 2), figure_text(fit.amplitude), figure_text(rms),
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

sim::FistPath drawn_path(std::uint64_t seed) {
  sim::EvenNumbers random(seed);
  sim::FistPath path;
  path.x = 5 + random.within(15);
  path.y = random.within(15);
  path.height = 135 + random.within(10);
  path.radius = 55 + random.within(10);
  path.rise = 0.65 * path.radius + random.within(0.2 * path.radius);
  path.towards = random.within(std::numbers::pi);
  path.frequency = 3.5 + random.within(1);
  path.phase = random.within(std::numbers::pi);
  return path;
}

sim::PoolDrop drawn_drop(std::uint64_t seed) {
  sim::EvenNumbers random(seed);
  sim::PoolDrop drop;
  drop.depth = 30 + random.within(15);
  drop.x += random.within(30);
  drop.y += random.within(40);
  drop.crater += random.within(3);
  drop.size += random.within(2);
  return drop;
}

}  // namespace selfproj::lab
