#include "lab/pool_experiment.h"

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
#include <string>
#include <utility>
#include <vector>

#include "host/images/float_image.h"
#include "host/report/report.h"
#include "host/rig/calibration.h"
#include "host/rig/rig.h"
#include "host/structured_light/triangulation.h"
#include "lab/gray_observation.h"
#include "model/gray_decoder.h"
#include "sim/cosim/motion_analysis.h"
#include "sim/cosim/pool_wave.h"
#include "sim/cosim/wave_dispersion.h"
#include "sim/scene/ring_wave.h"
#include "sim/scene/scanner_scenes.h"

namespace selfproj {
namespace {

constexpr double kNoCrest = std::numeric_limits<double>::quiet_NaN();
constexpr double kShortestWave = 60;  // mm; the speed of shorter waves hardly depends on the depth
constexpr double kAfter = 0.56;       // s from the impact to the last frame of the scene
constexpr int kWaveFrames = 486;      // from kWaveFrom until 0.55 s after the impact
constexpr double kMostOff = 0.05;     // greatest relative error of the speed of long waves

// What is measured in one pool, either in the host's depth images or in the true ones.
struct WaveSeen {
  BasinWaves waves{pool_basin(), kShortestWave, kGrayCycle / 2};
  std::vector<double> crest;

  void take(const Seen& seen, const FloatImage& depth, const FloatImage& background, const RingMeans& rings) {
    waves.add(seen.t, seen.triangulation, depth, background, kMostWave);
    crest.push_back(is_open_wave(seen.t - PoolWave::kImpact)
                        ? foremost_crest(rings, rings.means(depth, background, kMostWave), kLeastWave)
                        : kNoCrest);
  }
};

// Returns the depth z of the water at rest, mm: the median depth of the borders between codes in the basin.
float level_of(const Triangulation& triangulation, const FloatImage& borders) {
  constexpr Basin kPool = pool_basin();
  std::vector<float> depths;
  for (std::size_t i = 0; i < borders.values.size(); ++i) {
    const Point3f p = triangulation.point(i, borders.values[i]);
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
  explicit WholeCodes(const Rig& rig) : matrix_(depth_matrices(rig, kGrayBits, rig.projector.lines).projector) {}

  [[nodiscard]] FloatImage of(const Triangulation& triangulation, const FloatImage& depth) const {
    std::vector<std::uint16_t> words(depth.values.size(), 0);
    for (std::size_t i = 0; i < words.size(); ++i) {
      const Point3f p = triangulation.point(i, depth.values[i]);
      const cv::Matx<double, 2, 1> line = matrix_ * cv::Vec4d(p.x, p.y, p.z, 1);
      const double code = line(0) / line(1);
      if (code >= 0 && code < 1 << kGrayBits) {  // not if NaN
        words[i] = static_cast<std::uint16_t>(static_cast<int>(code) | GrayDecoder::kMeasurable);
      }
    }
    FloatImage rounded(depth.rows, depth.columns);
    triangulation.depth(words.data(), rounded.values.data());
    return rounded;
  }

 private:
  cv::Matx<double, 2, 4> matrix_;
};

struct PoolSeen {
  std::vector<double> t;
  WaveSeen measured, truth;
  BasinWaves borders{pool_basin(), kShortestWave, 1};
  BasinWaves rounded{pool_basin(), kShortestWave, kGrayCycle / 2};
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

PoolSeen observe_pool(const GrayMotionOptions& options, PoolDrop drop, const PoolShot& how,
                      const std::function<void()>& done) {
  drop.after = kAfter;
  const auto pool = make_pool(options.rig, drop.depth);
  const auto waves = make_waves(options.rig, drop);
  const int first = static_cast<int>(std::lround((PoolWave::kImpact + kWaveFrom) * options.rig.camera.frame_rate_hz));
  PoolSeen found;
  const WholeCodes whole(options.rig);
  FloatImage at_rest, rounded_at_rest;
  observe(
      options, {*waves, *pool, first - kGrayCycle, how.frames, how.noise_seed, how.truth}, done, [&](const Seen& seen) {
        const RingMeans rings = pool_rings(seen.triangulation, drop.x, drop.y);
        found.t.push_back(seen.t);
        found.measured.take(seen, seen.depth, seen.background, rings);
        if (at_rest.values.empty()) {
          at_rest =
              FloatImage(seen.depth.rows, seen.depth.columns, level_of(seen.triangulation, seen.background_borders));
          rounded_at_rest = whole.of(seen.triangulation, seen.true_background);
        }
        if (seen.borders != nullptr) {
          found.borders.add(seen.t, seen.triangulation, *seen.borders, at_rest, kMostWave);
        }
        if (how.truth) {
          found.rounded.add(seen.t, seen.triangulation, whole.of(seen.triangulation, seen.truth), rounded_at_rest,
                            kMostWave);
          found.truth.take(seen, seen.truth, seen.true_background, rings);
        }
      });
  return found;
}

struct NamedDrop {
  std::string name;
  PoolDrop drop;
};

// Returns pool i of those in addition to the pool of the thesis. If `first_seed` is 0, two of them have other depths,
// and the seeds 1, 2, ... draw the rest. Otherwise all are drawn, by the seeds from `first_seed` on.
NamedDrop other_pool(int i, std::uint64_t first_seed) {
  constexpr std::array<double, 2> kOtherDepths{20, 40};
  if (first_seed == 0 && i < static_cast<int>(kOtherDepths.size())) {
    PoolDrop drop;
    drop.depth = kOtherDepths.at(static_cast<std::size_t>(i));
    return {fmt::format("{:g} mm deep", drop.depth), drop};
  }
  const auto count = static_cast<std::uint64_t>(i);
  const std::uint64_t seed = first_seed > 0 ? first_seed + count : count - kOtherDepths.size() + 1;
  return {fmt::format("drawn by seed {}", seed), drawn_drop(seed)};
}

ReportTable lengths_table(const WaveDispersion& measured, const WaveDispersion& in_truth) {
  constexpr std::array<double, 7> kLengths{500, 240, 160, 120, 95, 75, 60};
  ReportTable table{
      "B2: phase speed by wavelength",
      {"waves of, mm", "standing waves", "mean length, mm", "measured, cm/s", "in the true depths, cm/s",
       "by theory, cm/s"},
      {},
      "The frequency of each wave is fitted freely. By theory: Airy's waves of the mean length in 3 cm of water."};
  for (std::size_t i = 0; i + 1 < kLengths.size(); ++i) {
    const WaveSpeed seen = measured.speed(kLengths.at(i), kLengths.at(i + 1));
    const WaveSpeed truth = in_truth.speed(kLengths.at(i), kLengths.at(i + 1));
    const double k = 2 * std::numbers::pi / seen.length;
    table.rows.push_back({fmt::format("{:g} to {:g}", kLengths.at(i + 1), kLengths.at(i)), std::to_string(seen.waves),
                          figure_text(seen.length, 0), cm_text(seen.speed, seen.deviation),
                          cm_text(truth.speed, truth.deviation), cm_text(RingWave::omega(k, PoolWave::kDepth) / k)});
  }
  return table;
}

}  // namespace

StructuredLightResult run_waves(const GrayMotionOptions& options, const ProgressOfImages& progress) {
  const int frames = options.frames > 0 ? options.frames : kWaveFrames;
  std::size_t done = 0;
  const auto count = [&] { progress(++done, images_of(1 + options.pools, frames)); };
  StructuredLightResult result;
  ReportTable others{
      "B2: speed of long waves in other pools",
      {"pool", "depth, mm", "measured, mm", "√(g h), cm/s", "measured, cm/s", "off, %", "standing waves", "misfit",
       "off by whole codes, %", "foremost crest, cm/s"},
      {},
      "Depth, place of the impact and crater are drawn by seeds, with noise of its own in each pool. "
      "Misfit: the residual with the theory's frequencies, divided by that with a freely fitted frequency "
      "for each wave."};
  const auto judge = [&](const std::string& name, double true_speed, const LongWaves& waves) {
    const double off = waves.speed / true_speed - 1;
    if (!(std::abs(off) <= kMostOff)) {
      result.not_reached.push_back(fmt::format("{}: long waves are measured at {} cm/s, within {:g} % of {} wanted",
                                               name, cm_text(waves.speed), 100 * kMostOff, cm_text(true_speed)));
    }
    return figure_text(100 * off, 1);
  };
  const auto speed_of = [](const PoolDrop& drop) { return std::sqrt(kStandardGravity * drop.depth); };
  const PoolSeen pool = observe_pool(options, {}, {frames, options.rig.imaging.seed, true}, count);
  const WaveDispersion measured(pool.borders);
  const LongWaves by_codes = WaveDispersion(pool.measured.waves).long_waves();
  const LongWaves rounded = WaveDispersion(pool.rounded).long_waves();
  const WaveDispersion in_truth(pool.truth.waves);
  const LongWaves found = measured.long_waves();
  const LongWaves truth = in_truth.long_waves();
  judge("3 cm of water", speed_of({}), found);
  const auto row_of = [&](const std::string& name, const PoolDrop& drop, const PoolSeen& seen) {
    const LongWaves waves = WaveDispersion(seen.borders).long_waves();
    const LongWaves whole_codes = WaveDispersion(seen.measured.waves).long_waves();
    others.rows.push_back({name, figure_text(drop.depth, 1),
                           fmt::format("{} ± {}", figure_text(waves.depth, 1),
                                       figure_text(2 * waves.depth * waves.deviation / waves.speed, 1)),
                           cm_text(speed_of(drop)), cm_text(waves.speed, waves.deviation),
                           judge(name, speed_of(drop), waves), std::to_string(waves.waves), figure_text(waves.misfit),
                           figure_text(100 * (whole_codes.speed / speed_of(drop) - 1), 1),
                           cm_text(crest_speed(seen.t, seen.measured.crest))});
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
        {"foremost crest", "54", "–", cm_text(crest_speed(pool.t, pool.measured.crest)),
         cm_text(crest_speed(pool.t, pool.truth.crest)), "–"}},
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

}  // namespace selfproj
