#include "host/production/tolerance.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "host/files/input_file.h"
#include "host/files/numbers.h"
#include "host/files/user_error.h"
#include "host/rig/geometry.h"
#include "host/rig/yaml.h"

namespace selfproj {
namespace {

const std::vector<std::pair<const char*, bool>> kPlaces = {{"edges", true}, {"belt", false}};
constexpr double kNoSection = -99999;  // stands in files for a place without a reference
constexpr std::size_t kMostRegions = 1000;

template <class ToleranceT, class Visitor>
void visit_part(ToleranceT& tolerance, Visitor& v) {
  v.begin("part");
  v.choice("place_by", tolerance.by_edges, kPlaces);
  v.number("length_mm", tolerance.length_mm, 1, kPositive);
  v.number("left_mm", tolerance.left_mm, 1, kAny);
  v.number("right_mm", tolerance.right_mm, 1, kAny);
  v.number("most_shift_mm", tolerance.most_shift_mm, 1, kNotNegative);
  v.number("most_turn_deg", tolerance.most_turn_deg, 1, {.low = 0, .high = 45});
  v.number("most_residual_mm", tolerance.most_residual_mm, 1, kNotNegative);
  v.number("smallest_defect_mm2", tolerance.smallest_mm2, 1, kPositive);
  v.end();
}

template <class RegionT, class Visitor>
void visit_region(RegionT& region, Visitor& v) {
  v.text("name", region.name);
  v.numbers("corners_mm", region.corners_mm, 1, kAny);
  v.number("low_mm", region.low_mm, 1, kAny);
  v.number("high_mm", region.high_mm, 1, kAny);
  v.number("most_missing", region.most_missing, 1, {.low = 0, .high = 1});
}

// Twice the area of the polygon.
double double_area(const std::vector<double>& corners) {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < corners.size(); i += 2) {
    const std::size_t next = (i + 2) % corners.size();
    sum += corners[i] * corners[next + 1] - corners[next] * corners[i + 1];
  }
  return std::abs(sum);
}

void check_region(const Tolerance& tolerance, const ToleranceRegion& region, const std::string& source) {
  const auto fail = [&](const std::string& reason) {
    throw UserError(source, fmt::format("region '{}' {}", region.name, reason));
  };
  const std::vector<double>& corners = region.corners_mm;
  if (corners.size() < 6 || corners.size() % 2 != 0) {
    fail(fmt::format("has {} numbers as corners_mm; two for each of at least three corners are expected",
                     corners.size()));
  }
  for (std::size_t i = 0; i < corners.size(); i += 2) {
    const double along = corners[i], across = corners[i + 1];
    if (along < -kMapMargin || along > tolerance.length_mm + kMapMargin || across < tolerance.left_mm - kMapMargin ||
        across > tolerance.right_mm + kMapMargin) {
      fail(fmt::format("reaches ({}, {}) mm; the part's map is from ({}, {}) to ({}, {})", along, across, -kMapMargin,
                       tolerance.left_mm - kMapMargin, tolerance.length_mm + kMapMargin,
                       tolerance.right_mm + kMapMargin));
    }
  }
  if (!(double_area(corners) > 0)) {
    fail("has no area");
  }
  if (!(region.low_mm < region.high_mm)) {
    fail(fmt::format("has low_mm {} and high_mm {}; high_mm must be greater", region.low_mm, region.high_mm));
  }
}

void read_section(FieldReader& reader, Tolerance& tolerance) {
  reader.begin("section");
  reader.number("step_mm", tolerance.section_step_mm, 1, kPositive);
  reader.numbers("heights_mm", tolerance.section_mm, 1, kAny);
  reader.end();
  for (double& height : tolerance.section_mm) {
    height = height == kNoSection ? std::numeric_limits<double>::quiet_NaN() : height;
  }
}

std::string indented(const std::string& text) {
  std::string result;
  bool first = true;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin) + 1;
    result += (first ? "  - " : "    ") + text.substr(begin, end - begin);
    first = false;
    begin = end;
  }
  return result;
}

}  // namespace

MapGrid placed_grid(double pitch_mm, double length_mm, double left_mm, double right_mm) {
  MapGrid grid;
  grid.pitch_mm = pitch_mm;
  grid.along_mm = -kMapMargin;
  grid.across_mm = left_mm - kMapMargin;
  grid.rows = static_cast<int>(std::ceil((length_mm + 2 * kMapMargin) / pitch_mm)) + 1;
  grid.columns = static_cast<int>(std::ceil((right_mm - left_mm + 2 * kMapMargin) / pitch_mm)) + 1;
  return grid;
}

std::string to_yaml(const Tolerance& tolerance) {
  FieldWriter writer;
  visit_part(tolerance, writer);
  if (!tolerance.section_mm.empty()) {
    std::vector<double> heights = tolerance.section_mm;
    for (double& height : heights) {
      height = std::isnan(height) ? kNoSection : height;
    }
    writer.begin("section");
    writer.number("step_mm", tolerance.section_step_mm, 1, kPositive);
    writer.numbers("heights_mm", heights, 1, kAny);
    writer.end();
  }
  std::string text = writer.yaml() + "regions:\n";
  for (const ToleranceRegion& region : tolerance.regions) {
    FieldWriter one;
    visit_region(region, one);
    text += indented(one.yaml());
  }
  return text;
}

Tolerance parse_tolerance(const std::string& yaml, const std::string& source) {
  const YAML::Node root = parse_yaml(yaml, source);
  if (!root.IsMap()) {
    throw UserError(source, "is not a tolerance; keys and values are expected");
  }
  Tolerance tolerance;
  // The lists that FieldReader has no word for are taken out first.
  const YAML::Node regions = root["regions"];
  if (!regions.IsDefined() || !regions.IsSequence() || regions.size() == 0 || regions.size() > kMostRegions) {
    throw UserError(source, fmt::format("regions must be a list of 1 to {} regions", kMostRegions));
  }
  YAML::Node rest(YAML::NodeType::Map);
  for (const auto& entry : root) {
    if (!entry.first.IsScalar() || entry.first.Scalar() != "regions") {
      rest[entry.first] = entry.second;
    }
  }
  FieldReader reader(source, rest);
  visit_part(tolerance, reader);
  if (rest["section"].IsDefined()) {
    read_section(reader, tolerance);
  }
  reader.end();
  if (!(tolerance.left_mm < tolerance.right_mm)) {
    throw UserError(source, fmt::format("part.left_mm is {}, part.right_mm {}; it must be greater", tolerance.left_mm,
                                        tolerance.right_mm));
  }
  for (const auto& node : regions) {
    if (!node.IsMap()) {
      throw UserError(source, fmt::format("region {} is not a map of keys", tolerance.regions.size() + 1));
    }
    ToleranceRegion region;
    FieldReader one(fmt::format("{}: region {}", source, tolerance.regions.size() + 1), node);
    visit_region(region, one);
    one.end();
    check_region(tolerance, region, source);
    tolerance.regions.push_back(std::move(region));
  }
  return tolerance;
}

Tolerance load_tolerance(const std::string& file) { return parse_tolerance(read_input(file, kMostTextBytes), file); }

std::vector<double> sampled_section(const SectionReference& section, double left_mm, double right_mm, double step_mm,
                                    double widest_mm) {
  std::vector<double> result;
  for (double across = left_mm; across <= right_mm; across += step_mm) {
    const double height = section.at(across, widest_mm);
    result.push_back(rounded(height, 3));
  }
  return result;
}

void check_tolerance(const Tolerance& tolerance, const Rig& rig, const SectionReference& section,
                     const std::string& source) {
  const double across = rig.plane_z_mm * tan_beta(rig.camera, rig.camera.columns - 0.5);
  if (tolerance.left_mm < -across || tolerance.right_mm > across) {
    throw UserError(source, fmt::format("its part is from {} to {} mm across; the camera of {} sees from {:.1f} to "
                                        "{:.1f}",
                                        tolerance.left_mm, tolerance.right_mm, rig.name, -across, across));
  }
  if (rig.parts && tolerance.length_mm > rig.parts->length_mm) {
    throw UserError(source, fmt::format("its part is {} mm long; parts.length_mm of {} is {}", tolerance.length_mm,
                                        rig.name, rig.parts->length_mm));
  }
  const double widest = 3 * rig.plane_z_mm * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
  for (std::size_t i = 0; i < tolerance.section_mm.size(); ++i) {
    const double place = tolerance.left_mm + static_cast<double>(i) * tolerance.section_step_mm;
    const double here = section.at(place, widest);
    const double there = tolerance.section_mm[i];
    if (std::abs(here - there) > kOtherPart) {
      throw UserError(source,
                      fmt::format("is for another part: at {:.4g} mm across, its section is {:.4g} mm high, that "
                                  "of the reference {:.4g}",
                                  place, there, here));
    }
  }
}

}  // namespace selfproj
