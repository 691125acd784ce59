#include "sim/experiment/pool_experiment.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "host/io/float_image.h"
#include "host/report/report.h"
#include "sim/experiment/gray_observation.h"
#include "sim/experiment/motion_analysis.h"
#include "sim/experiment/pool_wave.h"
#include "sim/experiment/wave_dispersion.h"
#include "sim/scene/ring_wave.h"
#include "sim/scene/scanner_scenes.h"

namespace selfproj {
namespace {

constexpr double kNoCrest = std::numeric_limits<double>::quiet_NaN();
constexpr double kShortestWave = 60;  // mm; shorter ones do not feel the ground
constexpr double kAfter = 0.56;       // s that the wave is seen after the impact
constexpr int kWaveFrames = 486;      // from kWaveFrom until 0.55 s after it
constexpr double kMostOff = 0.05;     // of the speed of long waves

// What is measured of the wave in one pool, in the host's depth images and in the true ones.
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

struct PoolSeen {
  std::vector<double> t;
  WaveSeen measured, truth;
};

constexpr double kCmPerMm = 0.1;

std::string cm_text(double mm) { return figure_text(mm * kCmPerMm, 1); }
std::string cm_text(double mm, double deviation) { return fmt::format("{} ± {}", cm_text(mm), cm_text(deviation)); }

// How a pool is observed; without the truth there is none of the wave.
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
  observe(options, {*waves, *pool, first - kGrayCycle, how.frames, how.noise_seed, how.truth}, done,
          [&](const Seen& seen) {
            const RingMeans rings = pool_rings(seen.triangulation, drop.x, drop.y);
            found.t.push_back(seen.t);
            found.measured.take(seen, seen.depth, seen.background, rings);
            if (how.truth) {
              found.truth.take(seen, seen.truth, seen.true_background, rings);
            }
          });
  return found;
}

// Two pools of other depths, and then those that seeds draw.
struct NamedDrop {
  std::string name;
  PoolDrop drop;
};
NamedDrop other_pool(int i) {
  constexpr std::array<double, 2> kOtherDepths{20, 40};
  if (i < static_cast<int>(kOtherDepths.size())) {
    PoolDrop drop;
    drop.depth = kOtherDepths.at(static_cast<std::size_t>(i));
    return {fmt::format("{:g} mm deep", drop.depth), drop};
  }
  const int seed = i - static_cast<int>(kOtherDepths.size()) + 1;
  return {fmt::format("drawn by seed {}", seed), drawn_drop(static_cast<std::uint64_t>(seed))};
}

ReportTable lengths_table(const WaveDispersion& measured, const WaveDispersion& in_truth) {
  constexpr std::array<double, 7> kLengths{500, 240, 160, 120, 95, 75, 60};
  ReportTable table{
      "B2: speed of phases by wavelength",
      {"waves of, mm", "standing waves", "length in the mean, mm", "measured, cm/s", "in the true depths, cm/s",
       "by theory, cm/s"},
      {},
      "Each wave may turn at any frequency. By theory: Airy's waves of the mean length in 3 cm of water."};
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
  ReportTable others{"B2: speed of long waves in other pools",
                     {"pool", "depth, mm", "measured, mm", "√(g h), cm/s", "measured, cm/s", "off, %", "standing waves",
                      "misfit", "foremost crest, cm/s"},
                     {},
                     "Depth, place of the impact and crater are drawn by seeds, with noise of its own in each pool. "
                     "Misfit: what the theory leaves, by what a frequency of its own would leave of each wave."};
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
  const WaveDispersion measured(pool.measured.waves);
  const WaveDispersion in_truth(pool.truth.waves);
  const LongWaves found = measured.long_waves();
  const LongWaves truth = in_truth.long_waves();
  judge("3 cm of water", speed_of({}), found);
  const auto row_of = [&](const std::string& name, const PoolDrop& drop, const PoolSeen& seen) {
    const LongWaves waves = WaveDispersion(seen.measured.waves).long_waves();
    others.rows.push_back({name, figure_text(drop.depth, 1),
                           fmt::format("{} ± {}", figure_text(waves.depth, 1),
                                       figure_text(2 * waves.depth * waves.deviation / waves.speed, 1)),
                           cm_text(speed_of(drop)), cm_text(waves.speed, waves.deviation),
                           judge(name, speed_of(drop), waves), std::to_string(waves.waves), figure_text(waves.misfit),
                           cm_text(crest_speed(seen.t, seen.measured.crest))});
  };
  for (int i = 0; i < options.pools; ++i) {
    const auto [name, drop] = other_pool(i);
    row_of(name, drop, observe_pool(options, drop, {frames, options.rig.imaging.seed + 100 * (i + 1), false}, count));
  }
  result.tables = {
      {"B2: speed of the wave, cm/s",
       {"", "published", "measured", "in the true depths"},
       {{"long waves, √(g h), by the depth that all standing waves give", "54", cm_text(found.speed, found.deviation),
         cm_text(truth.speed, truth.deviation)},
        {"foremost crest", "54", cm_text(crest_speed(pool.t, pool.measured.crest)),
         cm_text(crest_speed(pool.t, pool.truth.crest))}},
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
