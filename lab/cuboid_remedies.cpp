#include "lab/cuboid_remedies.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "lab/robustness.h"
#include "lab/structured_light.h"
#include "sim/scene/random.h"

namespace selfproj::lab {
namespace {

struct CuboidRemedy {
  const char* disturbance;  // as --disturb takes it; empty: none
  const char* what;         // with the setting's value
  double CuboidSettings::*setting;
  std::array<double, 3> values;
};

constexpr std::array<CuboidRemedy, 7> kCuboidRemedies{
    {{"second-line", "threshold {:g} instead of 5", &CuboidSettings::threshold, {15, 30, 60}},
     {"second-line", "no point higher than {:g} mm over the plane", &CuboidSettings::highest, {200, 160, 120}},
     {"saturation=5", "{:g} of the exposure", &CuboidSettings::exposure, {0.7, 0.5, 0.25}},
     {"saturation=8", "{:g} of the exposure", &CuboidSettings::exposure, {0.7, 0.5, 0.25}},
     {"gloss=brushed-steel", "{:g} times the exposure", &CuboidSettings::exposure, {2, 4, 8}},
     {"gloss=brushed-steel", "threshold {:g} instead of 5", &CuboidSettings::threshold, {2, 3, 4}},
     {"projector-defocus=1", "stripes {:g} rows wide instead of 2", &CuboidSettings::width, {3, 4, 6}}}};

// The world of a seed.
sim::World drawn_world(const sim::WorldFile& file, const std::string& disturbance, std::uint64_t seed) {
  sim::World world = sim::world_of(file, disturbance.empty() ? std::vector<std::string>{} : std::vector{disturbance});
  world.seed = seed;
  if (world.second_line && seed > 1) {
    sim::SecondLine& line = *world.second_line;
    line.min_rows += (line.max_rows - line.min_rows) * sim::EvenNumbers(seed).next();
    line.max_rows = line.min_rows;
  }
  return world;
}

// The share of places that have a false point or none.
double bad(const ErrorSpread& errors) {
  return errors.points() == 0 ? 1 : errors.missing() + (1 - errors.missing()) * errors.beyond(kFalseCodeMm);
}

// Measurements of the cuboids, of which none is made twice.
class MeasuredWorlds {
 public:
  MeasuredWorlds(const DisturbedCuboids& cuboids, const sim::WorldFile& file, const CuboidRemedy& remedy,
                 std::map<std::string, std::vector<WayOfMeasuring>>& known)
      : cuboids_(cuboids), file_(file), remedy_(remedy), known_(known) {}

  const std::vector<WayOfMeasuring>& with(double value, std::uint64_t seed) {
    CuboidSettings settings;
    const bool as_it_is = value == settings.*remedy_.setting;
    settings.*remedy_.setting = value;
    std::vector<WayOfMeasuring>& ways =
        known_[fmt::format("{} {} {} {}", remedy_.disturbance, as_it_is ? "" : remedy_.what, value, seed)];
    if (ways.empty()) {
      const sim::World world = drawn_world(file_, remedy_.disturbance, seed);
      ways = cuboids_.measure(world, settings, static_cast<std::int64_t>(seed));
    }
    return ways;
  }

 private:
  const DisturbedCuboids& cuboids_;
  const sim::WorldFile& file_;
  const CuboidRemedy& remedy_;
  std::map<std::string, std::vector<WayOfMeasuring>>& known_;
};

constexpr std::size_t kWays = 2;

std::string share_of(double share) {
  return std::isnan(share)              ? "–"
         : share < 0.00005 && share > 0 ? fmt::format("{:.1e}", share)
                                        : fmt::format("{:.4f}", share);
}

}  // namespace

std::vector<TriedRemedy> try_cuboid_remedies(const DisturbedCuboids& cuboids, const sim::WorldFile& file, int seeds,
                                             const std::function<void(std::size_t, std::size_t)>& progress) {
  std::vector<TriedRemedy> tried;
  std::map<std::string, std::vector<WayOfMeasuring>> known;
  std::size_t done = 0;
  const std::size_t all =
      kCuboidRemedies.size() * (kCuboidRemedies[0].values.size() + (1 + kWays) * static_cast<std::size_t>(seeds));
  for (const CuboidRemedy& remedy : kCuboidRemedies) {
    MeasuredWorlds measured(cuboids, file, remedy, known);
    const auto counted = [&](double value, int seed) -> const std::vector<WayOfMeasuring>& {
      const auto& ways = measured.with(value, static_cast<std::uint64_t>(seed));
      progress(++done, all);
      return ways;
    };
    std::array<double, kWays> best{};
    std::array<double, kWays> least{};
    least.fill(std::numeric_limits<double>::infinity());
    for (const double value : remedy.values) {
      const auto& ways = counted(value, 1);
      for (std::size_t w = 0; w < kWays; ++w) {
        if (bad(ways.at(w).errors) < least.at(w)) {
          least.at(w) = bad(ways[w].errors);
          best.at(w) = value;
        }
      }
    }
    std::array<TriedRemedy, kWays> of_ways;
    for (int seed = 2; seed < 2 + seeds; ++seed) {
      const auto& without = counted(CuboidSettings{}.*remedy.setting, seed);
      for (std::size_t w = 0; w < kWays; ++w) {
        of_ways.at(w).way = without[w].name;
        of_ways.at(w).without.add(without[w].errors);
        of_ways.at(w).with.add(counted(best.at(w), seed)[w].errors);
      }
    }
    for (std::size_t w = 0; w < kWays; ++w) {
      of_ways.at(w).disturbance = remedy.disturbance[0] == '\0' ? "none" : remedy.disturbance;
      of_ways.at(w).what = fmt::format(fmt::runtime(remedy.what), best.at(w));
      tried.push_back(of_ways.at(w));
    }
  }
  return tried;
}

report::ReportTable remedies_table(const std::vector<TriedRemedy>& tried, int seeds) {
  report::ReportTable table{
      "B4: what helps",
      {"disturbance", "remedy", "way", "false, without", "with", "no point, without", "with", "RMS, mm, without",
       "with"},
      {},
      fmt::format("False: more than {:g} mm off. Each remedy's setting is that of three which leaves the fewest false "
                  "and missing points on seed 1. The figures are those of {} other seeds.",
                  kFalseCodeMm, seeds)};
  for (const TriedRemedy& t : tried) {
    table.rows.push_back({t.disturbance, t.what, t.way, share_of(t.without.beyond(kFalseCodeMm)),
                          share_of(t.with.beyond(kFalseCodeMm)), share_of(t.without.missing()),
                          share_of(t.with.missing()), figure_text(t.without.rms()), figure_text(t.with.rms())});
  }
  return table;
}

std::string remedies_data(const std::vector<TriedRemedy>& tried) {
  const auto json_of = [](const ErrorSpread& e) {
    const auto number = [](double value) {
      return std::isnan(value) ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(value);
    };
    return nlohmann::ordered_json{{"points", e.points()},
                                  {"missing", number(e.missing())},
                                  {"rms_mm", number(e.rms())},
                                  {"beyond_10_mm", number(e.beyond(kFalseCodeMm))}};
  };
  nlohmann::ordered_json data;
  for (const TriedRemedy& t : tried) {
    data["remedies"].push_back({{"disturbance", t.disturbance},
                                {"remedy", t.what},
                                {"way", t.way},
                                {"without", json_of(t.without)},
                                {"with", json_of(t.with)}});
  }
  return data.dump();
}

}  // namespace selfproj::lab
