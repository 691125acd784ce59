#include "host/production/tolerance.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "host/files/input_file.h"
#include "host/files/numbers.h"
#include "host/files/text.h"
#include "host/rig/yaml.h"
#include "selfproj/files/user_error.h"

namespace selfproj::production {
namespace {

const std::vector<std::pair<const char*, bool>> kPlaces = {{"edges", true}, {"belt", false}};
constexpr double kNoSection = -99999;  // stands in files for a place without a reference
constexpr std::size_t kMaxRegions = 1000;

template <class ToleranceT, class Visitor>
void visit_part(ToleranceT& tolerance, Visitor& v) {
  v.begin("part");
  v.choice("place_by", tolerance.by_edges, kPlaces);
  v.number("length_mm", tolerance.length_mm, 1, rig::kPositive);
  v.number("left_mm", tolerance.left_mm, 1, rig::kAny);
  v.number("right_mm", tolerance.right_mm, 1, rig::kAny);
  v.number("max_shift_mm", tolerance.max_shift_mm, 1, rig::kNotNegative);
  v.number("max_turn_deg", tolerance.max_turn_deg, 1, {.low = 0, .high = 45});
  v.number("max_residual_mm", tolerance.max_residual_mm, 1, rig::kNotNegative);
  v.number("min_defect_mm2", tolerance.min_defect_mm2, 1, rig::kPositive);
  if (v.has_any({"edge_mm"}, tolerance.edge_mm)) {
    v.number("edge_mm", *tolerance.edge_mm, 1, rig::kNotNegative);
  }
  v.end();
}

template <class RegionT, class Visitor>
void visit_region(RegionT& region, Visitor& v) {
  v.text("name", region.name);
  v.numbers("corners_mm", region.corners_mm, 1, rig::kAny);
  v.number("low_mm", region.low_mm, 1, rig::kAny);
  v.number("high_mm", region.high_mm, 1, rig::kAny);
  v.number("max_missing", region.max_missing, 1, {.low = 0, .high = 1});
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
      fail(fmt::format("reaches ({:.6g}, {:.6g}) mm; the part's map is from ({:.6g}, {:.6g}) to ({:.6g}, {:.6g})",
                       along, across, -kMapMargin, tolerance.left_mm - kMapMargin, tolerance.length_mm + kMapMargin,
                       tolerance.right_mm + kMapMargin));
    }
  }
  if (!(double_area(corners) > 0)) {
    fail("has no area");
  }
  if (std::any_of(tolerance.regions.begin(), tolerance.regions.end(),
                  [&](const ToleranceRegion& earlier) { return earlier.name == region.name; })) {
    fail("is there twice; results tell regions by their names");
  }
  if (!(region.low_mm < region.high_mm)) {
    fail(fmt::format("has low_mm {} and high_mm {}; high_mm must be greater", region.low_mm, region.high_mm));
  }
}

void read_section(rig::FieldReader& reader, Tolerance& tolerance) {
  reader.begin("section");
  reader.number("step_mm", tolerance.section_step_mm, 1, rig::kPositive);
  reader.numbers("heights_mm", tolerance.section_mm, 1, rig::kAny);
  reader.end();
  for (double& height : tolerance.section_mm) {
    height = height == kNoSection ? std::numeric_limits<double>::quiet_NaN() : height;
  }
}

// Keys of earlier files, which are read for one version more.
constexpr std::array<std::pair<const char*, const char*>, 5> kOldKeys = {{{"most_shift_mm", "max_shift_mm"},
                                                                          {"most_turn_deg", "max_turn_deg"},
                                                                          {"most_residual_mm", "max_residual_mm"},
                                                                          {"smallest_defect_mm2", "min_defect_mm2"},
                                                                          {"most_missing", "max_missing"}}};

// Gives old keys of a map their new names, and returns whether there were any.
bool rename_old_keys(YAML::Node node) {
  bool any = false;
  for (const auto& [old, key] : kOldKeys) {
    if (node.IsMap() && std::as_const(node)[old].IsDefined() && !std::as_const(node)[key].IsDefined()) {
      node[key] = node[old];
      node.remove(old);
      any = true;
    }
  }
  return any;
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

// The height at a place, of the nearest cell; NaN outside.
float height_at(const HeightCells& cells, double along, double across) {
  const auto row = std::lround(cells.grid.row_of(along));
  const auto column = std::lround(cells.grid.column_of(across));
  const bool there = row >= 0 && column >= 0 && row < cells.height.rows && column < cells.height.columns;
  return there ? cells.height.row(static_cast<int>(row))[column] : images::kNoValue;
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
  rig::FieldWriter writer;
  visit_part(tolerance, writer);
  if (!tolerance.section_mm.empty()) {
    std::vector<double> heights = tolerance.section_mm;
    for (double& height : heights) {
      height = std::isnan(height) ? kNoSection : height;
    }
    writer.begin("section");
    writer.number("step_mm", tolerance.section_step_mm, 1, rig::kPositive);
    writer.numbers("heights_mm", heights, 1, rig::kAny);
    writer.end();
  }
  std::string text = writer.yaml() + "regions:\n";
  if (std::any_of(tolerance.section_mm.begin(), tolerance.section_mm.end(), [](double mm) { return std::isnan(mm); })) {
    text.insert(text.find("section:"),
                fmt::format("# Of heights_mm, {} stands for a place where the reference is not known.\n", kNoSection));
  }
  for (const ToleranceRegion& region : tolerance.regions) {
    rig::FieldWriter one;
    visit_region(region, one);
    text += indented(one.yaml());
  }
  return text;
}

Tolerance parse_tolerance(const std::string& yaml, const std::string& source) {
  const YAML::Node root = rig::parse_yaml(yaml, source);
  if (!root.IsMap()) {
    throw UserError(source, "is not a tolerance; keys and values are expected");
  }
  Tolerance tolerance;
  // The lists that FieldReader has no word for are removed first.
  const YAML::Node regions = root["regions"];
  if (!regions.IsDefined() || !regions.IsSequence() || regions.size() == 0 || regions.size() > kMaxRegions) {
    throw UserError(source,
                    fmt::format("regions must be a list of 1 to {} regions, as `selfproj tolerance learn` writes them",
                                kMaxRegions));
  }
  YAML::Node rest(YAML::NodeType::Map);
  for (const auto& entry : root) {
    if (!entry.first.IsScalar() || entry.first.Scalar() != "regions") {
      rest[entry.first] = entry.second;
    }
  }
  bool old = std::as_const(rest)["part"].IsDefined() && rename_old_keys(rest["part"]);
  for (const auto& node : regions) {
    old = rename_old_keys(node) || old;
  }
  if (old) {
    fmt::print(stderr, "note: {}: keys most_... and smallest_... are now max_... and min_...\n", source);
  }
  rig::FieldReader reader(source, rest);
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
    rig::FieldReader one(fmt::format("{}: region {}", source, tolerance.regions.size() + 1), node);
    visit_region(region, one);
    one.end();
    check_region(tolerance, region, source);
    tolerance.regions.push_back(std::move(region));
  }
  return tolerance;
}

Tolerance load_tolerance(const std::string& file) {
  return parse_tolerance(files::read_text(file, files::kMostTextBytes), file);
}

std::vector<double> sampled_section(const SectionReference& section, double left_mm, double right_mm, double step_mm,
                                    double widest_mm) {
  std::vector<double> result;
  for (double across = left_mm; across <= right_mm; across += step_mm) {
    const double height = section.at(across, widest_mm);
    result.push_back(files::rounded(height, 3));
  }
  return result;
}

void check_tolerance(const Tolerance& tolerance, const rig::Rig& rig, const SectionReference& section,
                     const std::string& source) {
  const BeltView view = belt_view(rig);
  if (tolerance.left_mm < view.left_mm || tolerance.right_mm > view.right_mm) {
    throw UserError(source, fmt::format("its part is from {} to {} mm across; the camera of {} sees from {:.1f} to "
                                        "{:.1f}",
                                        tolerance.left_mm, tolerance.right_mm, rig.name, view.left_mm, view.right_mm));
  }
  if (rig.parts && tolerance.length_mm > rig.parts->length_mm) {
    throw UserError(source, fmt::format("its part is {} mm long; parts.length_mm of {} is {}", tolerance.length_mm,
                                        rig.name, rig.parts->length_mm));
  }
  const double widest = 3 * pixel_mm(rig);
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

std::vector<double> middle_section(const HeightCells& reference, const Tolerance& outline, double step_mm) {
  std::vector<double> result;
  for (double across = outline.left_mm; across <= outline.right_mm; across += step_mm) {
    result.push_back(files::rounded(static_cast<double>(height_at(reference, 0.5 * outline.length_mm, across)), 3));
  }
  return result;
}

void check_map_tolerance(const Tolerance& tolerance, const rig::Rig& rig, const HeightCells& reference,
                         const std::string& source) {
  if (tolerance.by_edges) {
    throw UserError(source, "part.place_by is edges; structured light classifies parts where they lie: belt");
  }
  const double slack = rig.parts.value().grid_mm;
  const double length = rig.camera.rows * pixel_mm(rig);
  const double across = 0.5 * rig.camera.columns * pixel_mm(rig);
  if (tolerance.left_mm < -across - slack || tolerance.right_mm > across + slack ||
      tolerance.length_mm > length + 2 * slack) {
    throw UserError(
        source,
        fmt::format("its part is {} mm long and from {} to {} mm across; the camera of {} sees {:.1f} "
                    "mm, from {:.1f} to {:.1f}",
                    tolerance.length_mm, tolerance.left_mm, tolerance.right_mm, rig.name, length, -across, across));
  }
  const std::vector<double> here = tolerance.section_step_mm > 0
                                       ? middle_section(reference, tolerance, tolerance.section_step_mm)
                                       : std::vector<double>();
  std::size_t compared = 0;
  std::size_t other = 0;
  const double most = std::max(kOtherPart, 0.01 * rig.plane_z_mm);
  for (std::size_t i = 0; i < std::min(here.size(), tolerance.section_mm.size()); ++i) {
    if (!std::isnan(here[i]) && !std::isnan(tolerance.section_mm[i])) {
      ++compared;
      other += std::abs(here[i] - tolerance.section_mm[i]) > most ? 1 : 0;
    }
  }
  if (2 * other > compared) {
    throw UserError(source, fmt::format("is for another part: in {} of {} places across its middle, the reference is "
                                        "more than {:.3g} mm higher or lower",
                                        other, compared, most));
  }
}

}  // namespace selfproj::production
