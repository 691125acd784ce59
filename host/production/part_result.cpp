#include "host/production/part_result.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "host/files/numbers.h"

namespace selfproj::production {
namespace {

// Rounds to four decimals. No length in mm, share or angle in degrees is as accurate as that.
double short_number(double value) { return files::rounded(value, 4); }

double degrees(double radians) { return radians * 180 / std::numbers::pi; }

// A quoted field of a CSV table.
std::string csv_field(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    quoted += c == '"' ? "\"\"" : std::string(1, c);
  }
  return quoted + "\"";
}

}  // namespace

nlohmann::ordered_json part_json(const PartResult& result) {
  nlohmann::ordered_json json;
  json["part"] = result.number;
  json["verdict"] = verdict_name(result.verdict);
  json["reason"] = result.reason;
  json["begin_mm"] = short_number(result.begin_mm);
  json["belt_length_mm"] = short_number(result.length_mm);
  json["first_frame"] = result.first_frame;
  json["last_frame"] = result.last_frame;
  json["missing_frames"] = result.missing_frames;
  if (result.placement) {
    const Placement& placed = *result.placement;
    nlohmann::ordered_json& placement = json["placement"];
    placement["edges"] = placed.edges;
    placement["along_mm"] = short_number(placed.along_mm);
    placement["across_mm"] = short_number(placed.across_mm);
    placement["turn_deg"] = short_number(degrees(placed.turn_rad));
    placement["residual_mm"] = short_number(placed.residual_mm);
    if (placed.length_mm) {
      placement["length_mm"] = short_number(*placed.length_mm);
    }
    if (placed.width_mm) {
      placement["width_mm"] = short_number(*placed.width_mm);
    }
  }
  json["regions"] = nlohmann::ordered_json::array();
  for (const RegionFigures& region : result.regions) {
    json["regions"].push_back({{"name", region.name},
                               {"missing", short_number(region.missing)},
                               {"mean_mm", short_number(region.mean_mm)},
                               {"lowest_mm", short_number(region.lowest_mm)},
                               {"highest_mm", short_number(region.highest_mm)}});
  }
  json["defects"] = nlohmann::ordered_json::array();
  for (const Defect& defect : result.defects) {
    json["defects"].push_back({{"region", defect.region},
                               {"along_mm", short_number(defect.along_mm)},
                               {"across_mm", short_number(defect.across_mm)},
                               {"size_along_mm", short_number(defect.size_along_mm)},
                               {"size_across_mm", short_number(defect.size_across_mm)},
                               {"area_mm2", short_number(defect.area_mm2)},
                               {"depth_mm", short_number(defect.depth_mm)}});
  }
  if (result.moments) {
    const PartMoments& moments = *result.moments;
    nlohmann::ordered_json& found = json["moments"];
    found = {{"defect", moments.defect()},
             {"frames", moments.frames},
             {"defect_frames", moments.defect_frames},
             {"dark_frames", moments.dark_frames}};
    if (moments.defect()) {
      found["first_frame"] = moments.first_frame;
      found["first_column"] = moments.first_column;
      found["columns"] = moments.columns;
    }
  }
  return json;
}

std::string part_csv_head() {
  return "part,verdict,begin_mm,belt_length_mm,across_mm,turn_deg,residual_mm,max_missing,defects,largest_mm2,"
         "depth_mm,first_frame,last_frame,missing_frames,reason\n";
}

std::string part_csv(const PartResult& result) {
  const Placement placed = result.placement.value_or(Placement{});
  double missing = 0;
  for (const RegionFigures& region : result.regions) {
    missing = std::max(missing, region.missing);
  }
  const Defect worst = result.defects.empty() ? Defect{} : result.defects.front();
  return fmt::format("{},{},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{},{:.4f},{:.4f},{},{},{},{}\n", result.number,
                     verdict_name(result.verdict), short_number(result.begin_mm), result.length_mm,
                     short_number(placed.across_mm), short_number(degrees(placed.turn_rad)), placed.residual_mm,
                     missing, result.defects.size(), worst.area_mm2, worst.depth_mm, result.first_frame,
                     result.last_frame, result.missing_frames, csv_field(result.reason));
}

void add_figures(const PartResult& result, PartStatistics& statistics) {
  if (!result.placement || result.verdict == Verdict::inconclusive) {
    return;
  }
  const Placement& placed = *result.placement;
  statistics["across_mm"].add(placed.across_mm);
  statistics["turn_deg"].add(degrees(placed.turn_rad));
  statistics["residual_mm"].add(placed.residual_mm);
  if (placed.length_mm) {
    statistics["length_mm"].add(*placed.length_mm);
  }
  if (placed.width_mm) {
    statistics["width_mm"].add(*placed.width_mm);
  }
  for (const RegionFigures& region : result.regions) {
    statistics[region.name + " mean_mm"].add(region.mean_mm);
    statistics[region.name + " lowest_mm"].add(region.lowest_mm);
    statistics[region.name + " highest_mm"].add(region.highest_mm);
    statistics[region.name + " missing"].add(region.missing);
  }
}

nlohmann::ordered_json statistics_json(const PartStatistics& statistics) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const auto& [name, figures] : statistics) {
    const std::optional<double> error = figures.trend_error();
    json[name] = {{"parts", figures.count()},
                  {"mean", short_number(figures.mean())},
                  {"spread", short_number(figures.spread())},
                  {"min", short_number(figures.min())},
                  {"max", short_number(figures.max())},
                  {"rise_in_1000_parts", short_number(1000 * figures.trend())},
                  {"rise_error_in_1000_parts", nullptr}};
    if (error) {
      json[name]["rise_error_in_1000_parts"] = short_number(1000 * *error);
    }
  }
  return json;
}

std::string time_text(std::int64_t ns) {
  const auto value = static_cast<double>(ns);
  return ns < 1'000'000 ? fmt::format("{:.1f} µs", value * 1e-3) : fmt::format("{:.2f} ms", value * 1e-6);
}

}  // namespace selfproj::production
