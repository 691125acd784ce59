#include "sim/cosim/depth_findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include "host/report/report.h"
#include "sim/cosim/motion_analysis.h"
#include "sim/cosim/pool_wave.h"
#include "sim/scene/scanner_scenes.h"
#include "sim/scene/scene_info.h"

namespace selfproj {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::string number_text(double value) { return std::isfinite(value) ? fmt::format("{:.4f}", value) : ""; }

using Get = double (*)(const DepthSample&);

std::vector<double> column(const std::vector<DepthSample>& samples, Get get) {
  std::vector<double> values;
  std::transform(samples.begin(), samples.end(), std::back_inserter(values), get);
  return values;
}

std::vector<double> times(const std::vector<DepthSample>& samples) {
  return column(samples, [](const DepthSample& s) { return s.t; });
}

// Distances in mm of the measured centroid from the true one.
struct Distances {
  double rms = kNone;
  double greatest = kNone;
};

Distances centroid_distances(const std::vector<DepthSample>& samples) {
  double most = 0;
  double squares = 0;
  std::size_t count = 0;
  for (const DepthSample& s : samples) {
    if (s.moved.pixels == 0 || s.true_moved.pixels == 0) {
      continue;
    }
    const double d = std::hypot(s.moved.x - s.true_moved.x, s.moved.y - s.true_moved.y, s.moved.z - s.true_moved.z);
    most = std::max(most, d);
    squares += d * d;
    ++count;
  }
  return count == 0 ? Distances{} : Distances{std::sqrt(squares / static_cast<double>(count)), most};
}

void add_sine(DepthFindings& found, const std::string& key, const std::string& label, const SineFit& fit) {
  if (std::isfinite(fit.frequency)) {
    found.facts.push_back({key + "_hz", label + ": frequency", fit.frequency, "Hz"});
    found.facts.push_back({key + "_amplitude_mm", label + ": amplitude", fit.amplitude, "mm"});
  }
}

DepthFindings moved_findings(const std::vector<DepthSample>& samples) {
  DepthFindings found;
  const std::vector<double> t = times(samples);
  const auto x = column(samples, [](const DepthSample& s) { return s.moved.x; });
  const auto y = column(samples, [](const DepthSample& s) { return s.moved.y; });
  const auto z = column(samples, [](const DepthSample& s) { return s.moved.z; });
  const auto true_x = column(samples, [](const DepthSample& s) { return s.true_moved.x; });
  const auto true_y = column(samples, [](const DepthSample& s) { return s.true_moved.y; });
  const auto true_z = column(samples, [](const DepthSample& s) { return s.true_moved.z; });
  constexpr double kLow = 1;
  constexpr double kHigh = 8;
  for (const auto& [name, measured, truth] : {std::tuple("x", &x, &true_x), {"y", &y, &true_y}, {"z", &z, &true_z}}) {
    add_sine(found, fmt::format("centroid_{}", name), fmt::format("centroid {}", name),
             fit_sine(t, *measured, kLow, kHigh));
    found.plots.push_back({fmt::format("Centroid of what moved: {}", name),
                           "time, s",
                           fmt::format("{}, mm", name),
                           {{t, *measured, "a", "measured"}, {t, *truth, "b", "of the true depths"}}});
  }
  found.plots.push_back({"Path of the centroid, seen along z",
                         "x, mm",
                         "y, mm",
                         {{x, y, "a", "measured"}, {true_x, true_y, "b", "of the true depths"}}});
  const Distances distances = centroid_distances(samples);
  found.facts.push_back({"centroid_rms_mm", "centroid from that of the true depths, RMS", distances.rms, "mm"});
  found.facts.push_back({"centroid_most_mm", "... greatest", distances.greatest, "mm"});
  found.table_name = "moved.csv";
  found.table = "frame,time_s,pixels,x,y,z,true_pixels,true_x,true_y,true_z\n";
  for (const DepthSample& s : samples) {
    fmt::format_to(std::back_inserter(found.table), "{},{:.4f},{},{},{},{},{},{},{},{}\n", s.frame, s.t, s.moved.pixels,
                   number_text(s.moved.x), number_text(s.moved.y), number_text(s.moved.z), s.true_moved.pixels,
                   number_text(s.true_moved.x), number_text(s.true_moved.y), number_text(s.true_moved.z));
  }
  return found;
}

DepthFindings wave_findings(const std::vector<DepthSample>& samples) {
  DepthFindings found;
  const std::vector<double> t = times(samples);
  const auto front = column(samples, [](const DepthSample& s) { return s.front; });
  const auto true_front = column(samples, [](const DepthSample& s) { return s.true_front; });
  const double speed = crest_speed(t, front);
  const double true_speed = crest_speed(t, true_front);
  constexpr double kCmPerMm = 0.1;
  if (std::isfinite(speed)) {
    found.facts.push_back({"front_cm_per_s", "foremost crest", speed * kCmPerMm, "cm/s"});
  }
  if (std::isfinite(true_speed)) {
    found.facts.push_back({"true_front_cm_per_s", "... in the true depths", true_speed * kCmPerMm, "cm/s"});
    found.facts.push_back({"theory_cm_per_s", "long waves, √(g h) at 3 cm", PoolWave::kSpeed * kCmPerMm, "cm/s"});
  }
  // Adds a line with the theory's speed through the middle of the measurement.
  ReportTrace theory{{}, {}, "b", "long waves, 54.2 cm/s"};
  double sum_t = 0;
  double sum_r = 0;
  double count = 0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (std::isfinite(front[i])) {
      sum_t += t[i];
      sum_r += front[i];
      ++count;
    }
  }
  ReportTrace measured{{}, {}, "a", "foremost crest, measured"};
  for (std::size_t i = 0; i < t.size() && count > 0; ++i) {
    if (std::isfinite(front[i])) {
      measured.x.push_back(t[i]);
      measured.y.push_back(front[i]);
      theory.x.push_back(t[i]);
      theory.y.push_back(sum_r / count + PoolWave::kSpeed * (t[i] - sum_t / count));
    }
  }
  found.plots.push_back({"Wave front", "time, s", "distance from the impact, mm", {measured, theory}});
  found.table_name = "front.csv";
  found.table = "frame,time_s,front_mm,true_front_mm\n";
  for (const DepthSample& s : samples) {
    fmt::format_to(std::back_inserter(found.table), "{},{:.4f},{},{}\n", s.frame, s.t, number_text(s.front),
                   number_text(s.true_front));
  }
  return found;
}

DepthFindings key_findings(const std::vector<DepthSample>& samples) {
  DepthFindings found;
  const std::vector<double> t = times(samples);
  constexpr double kLow = 2;
  constexpr double kHigh = 9;
  for (const std::size_t key : {0U, 1U}) {
    const KeyTaps::Pixel pixel = key == 0 ? KeyTaps::kFirst : KeyTaps::kSecond;
    std::vector<double> z;
    std::vector<double> truth;
    for (const DepthSample& s : samples) {
      z.push_back(s.z[key]);
      truth.push_back(s.true_z[key]);
    }
    add_sine(found, fmt::format("key_{}", key + 1), fmt::format("pixel ({}, {})", pixel.row, pixel.column),
             fit_sine(t, z, kLow, kHigh));
    found.plots.push_back({fmt::format("Depth at pixel ({}, {})", pixel.row, pixel.column),
                           "time, s",
                           "z, mm",
                           {{t, z, "a", "measured"}, {t, truth, "b", "true"}}});
  }
  found.table_name = "keys.csv";
  found.table = "frame,time_s,z_1,z_2,true_z_1,true_z_2\n";
  for (const DepthSample& s : samples) {
    fmt::format_to(std::back_inserter(found.table), "{},{:.4f},{},{},{},{}\n", s.frame, s.t, number_text(s.z[0]),
                   number_text(s.z[1]), number_text(s.true_z[0]), number_text(s.true_z[1]));
  }
  return found;
}

}  // namespace

DepthFindings findings_of(SceneAnalysis analysis, const std::vector<DepthSample>& samples) {
  switch (analysis) {
    case SceneAnalysis::wave_front:
      return wave_findings(samples);
    case SceneAnalysis::key_taps:
      return key_findings(samples);
    case SceneAnalysis::moved_centroid:
      break;
  }
  return moved_findings(samples);
}

}  // namespace selfproj
