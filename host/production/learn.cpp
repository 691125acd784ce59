#include "host/production/learn.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/files/numbers.h"
#include "host/production/placement.h"
#include "selfproj/files/user_error.h"

namespace selfproj::production {
namespace {

constexpr double kSectionStep = 5;         // mm
constexpr double kMinResidual = 0.1;       // mm, and at least
constexpr double kMinResidualCells = 0.4;  // cells of the map
constexpr double kMinMissing = 0.005;
// Of one good part beside the others, in any case.
constexpr double kMostMissing = 0.05;
constexpr double kMostOff = 0.2;  // mm

double widest_of(const rig::Rig& rig) { return 3 * pixel_mm(rig); }

// The spread of few parts is known badly, and may be larger by this factor.
double factor_of_few(std::size_t parts) { return 1 + 3 / static_cast<double>(parts); }

// Notes the parts whose value is not as that of the others. `floor`: a value may be so far from the median in any case.
void leave_out(const std::vector<std::optional<double>>& values, double spreads, double floor, const char* what,
               std::vector<std::string>& reasons) {
  constexpr double kPerMedian = 1.4826;  // standard deviations for a median distance of 1
  std::vector<double> known;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] && reasons[i].empty()) {
      known.push_back(*values[i]);
    }
  }
  if (known.size() < kMinGoodParts) {
    return;
  }
  const double middle = files::median_of(known);
  std::vector<double> off;
  for (const double value : known) {
    off.push_back(std::abs(value - middle));
  }
  const double times = spreads * factor_of_few(known.size());
  const double most = std::max(floor, times * kPerMedian * files::median_of(off));
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] && reasons[i].empty() && std::abs(*values[i] - middle) > most) {
      reasons[i] = fmt::format("{} is {:.4g}, that of the others {:.4g}", what, *values[i], middle);
    }
  }
}

// Where the section first and last is higher than above_mm, if that is not at its ends.
std::pair<std::optional<double>, std::optional<double>> section_edges(const SectionReference& section, double above) {
  std::pair<std::optional<double>, std::optional<double>> edges;
  const std::size_t size = section.height_mm.size();
  for (std::size_t i = 1; i + 1 < size; ++i) {
    if (section.height_mm[i] > above) {
      edges.first = edges.first ? edges.first : section.across_mm[i];
      edges.second = section.across_mm[i];
    }
  }
  return edges;
}

cv::Mat1b block(int side) { return cv::Mat1b(side, side, std::uint8_t{1}); }

std::string name_of(std::size_t number) { return fmt::format("surface {}", number); }

// Along and across the part, mm.
using Places = std::vector<std::pair<double, double>>;

Places places_of(const std::vector<cv::Point>& cells, const MapGrid& grid) {
  Places places;
  for (const cv::Point& cell : cells) {
    places.emplace_back(grid.along_of(cell.y), grid.across_of(cell.x));
  }
  return places;
}

// A region with a band of no meaning.
ToleranceRegion surface(std::size_t number, const Places& corners) {
  ToleranceRegion region;
  region.name = name_of(number);
  for (const auto& [along, across] : corners) {
    region.corners_mm.push_back(files::rounded(along, 2));
    region.corners_mm.push_back(files::rounded(across, 2));
  }
  region.low_mm = -1e6;
  region.high_mm = 1e6;
  region.max_missing = 1;
  return region;
}

// A surface around each set of neighbouring cells; holes in it are not left out.
void add_surfaces(const cv::Mat1b& cells, const MapGrid& grid, double min_area_mm2,
                  std::vector<ToleranceRegion>& regions) {
  std::vector<std::vector<cv::Point>> contours;
  std::vector<cv::Vec4i> places;  // of a contour; the last number is that of the contour around a hole
  cv::findContours(cells, contours, places, cv::RETR_CCOMP, cv::CHAIN_APPROX_SIMPLE);
  for (std::size_t i = 0; i < contours.size(); ++i) {
    std::vector<cv::Point> corners;
    cv::approxPolyDP(contours[i], corners, 1, true);
    const bool hole = places[i][3] >= 0;
    if (corners.size() > 2 && !hole && cv::contourArea(corners) * grid.pitch_mm * grid.pitch_mm >= min_area_mm2) {
      regions.push_back(surface(regions.size() + 1, places_of(corners, grid)));
    }
  }
}

// A hole is opened to the nearer end of the part, so that a polygon can leave it out.
void open_holes(cv::Mat1b& cells) {
  std::vector<std::vector<cv::Point>> contours;
  std::vector<cv::Vec4i> places;
  cv::findContours(cells, contours, places, cv::RETR_CCOMP, cv::CHAIN_APPROX_NONE);
  for (std::size_t i = 0; i < contours.size(); ++i) {
    if (places[i][3] >= 0) {
      const cv::Rect hole = cv::boundingRect(contours[i]);
      const bool up = hole.y < cells.rows - hole.y - hole.height;
      cells(cv::Rect(hole.x, up ? 0 : hole.y, hole.width, up ? hole.y + hole.height : cells.rows - hole.y)) =
          std::uint8_t{0};
    }
  }
}

double area_mm2(const std::vector<ToleranceRegion>& regions, const MapGrid& grid) {
  double cells = 0;
  for (const ToleranceRegion& region : regions) {
    cells += cv::countNonZero(region_cells(region, grid));
  }
  return cells * grid.pitch_mm * grid.pitch_mm;
}

}  // namespace

Learner::Learner(const rig::Rig& rig, SectionReference section, const LearnOptions& options)
    : rig_(rig), section_(std::move(section)), options_(options) {}

Learner::Learner(const rig::Rig& rig, HeightCells reference, const LearnOptions& options)
    : rig_(rig), map_(std::move(reference)), options_(options) {}

void Learner::add(CutPart&& part) {
  if (parts_.size() >= kMaxGoodParts) {
    ++not_kept_;
    return;
  }
  parts_.push_back(std::move(part));
}

Tolerance Learner::whole_view() const {
  Tolerance tolerance;
  tolerance.by_edges = false;
  const double pitch = rig_.parts->grid_mm;
  const double pixel = pixel_mm(rig_);
  tolerance.length_mm = std::floor(rig_.camera.rows * pixel / pitch) * pitch;
  tolerance.right_mm = std::floor(0.5 * rig_.camera.columns * pixel / pitch) * pitch;
  tolerance.left_mm = -tolerance.right_mm;
  tolerance.max_shift_mm = options_.max_shift_mm;
  tolerance.max_turn_deg = options_.max_turn_deg;
  tolerance.max_residual_mm = 1e6;
  tolerance.min_defect_mm2 = options_.min_defect_mm2;
  tolerance.edge_mm = options_.edge_mm;
  tolerance.section_step_mm = kSectionStep;
  tolerance.section_mm = middle_section(*map_, tolerance, kSectionStep);
  const MapGrid grid = placed_grid(pitch, tolerance.length_mm, tolerance.left_mm, tolerance.right_mm);
  tolerance.regions = map_regions(without_steep_places(placed_heights(*map_, Placement{}, grid), rig_), grid,
                                  options_.edge_mm, options_.min_defect_mm2);
  return tolerance;
}

Classifier Learner::classifier_of(const Tolerance& tolerance, const std::string& source) const {
  return map_ ? Classifier(rig_, *map_, tolerance, source) : Classifier(rig_, section_, tolerance, source);
}

Tolerance Learner::outline(const std::string& source, Reasons& reasons) const {
  std::vector<std::optional<double>> lengths;
  std::vector<std::optional<double>> widths;
  std::vector<double> middles;
  for (const CutPart& part : parts_) {
    const EdgeLines edges = edges_of(part.cells, *rig_.parts);
    const auto placed = place_by_edges(edges, {});
    lengths.push_back(placed ? placed->length_mm : std::nullopt);
    widths.push_back(placed ? placed->width_mm : std::nullopt);
    middles.push_back(widths.back() ? 0.5 * (edges[2]->across_mm + edges[3]->across_mm) : 0);
  }
  constexpr double kCells = 4;
  leave_out(lengths, options_.spreads, kCells * rig_.parts->grid_mm, "its length in mm", reasons);
  leave_out(widths, options_.spreads, kCells * rig_.parts->grid_mm, "its width in mm", reasons);
  RunningFigures length;
  RunningFigures width;
  RunningFigures middle;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    if (!reasons[i].empty()) {
      continue;
    }
    if (lengths[i]) {
      length.add(*lengths[i]);
    }
    if (widths[i]) {
      width.add(*widths[i]);
      middle.add(middles[i]);
    }
  }
  if (length.count() < kMinGoodParts) {
    std::string why;
    for (std::size_t i = 0; i < parts_.size() && why.empty(); ++i) {
      if (!lengths[i] || !reasons[i].empty()) {
        why =
            fmt::format("; part {}: {}", i + 1, lengths[i] ? reasons[i] : "one of them is not there, or not straight");
      }
    }
    throw UserError(source,
                    fmt::format("{} of {} parts can be used by their leading and trailing edges; at least {} are "
                                "needed{}",
                                length.count(), parts_.size(), kMinGoodParts, why));
  }
  Tolerance tolerance;
  tolerance.length_mm = length.mean();
  const auto [left, right] = section_edges(section_, rig_.parts->above_mm);
  if (width.count() >= kMinGoodParts) {
    // If a side is hidden where a part passes, its edges are not those of the reference, and parts lie as seen.
    const bool as_reference = left && right && std::abs(*right - *left - width.mean()) <= kCells * rig_.parts->grid_mm;
    const double at = as_reference ? 0.5 * (*left + *right) : middle.mean();
    tolerance.left_mm = at - 0.5 * width.mean();
    tolerance.right_mm = at + 0.5 * width.mean();
  } else if (!section_.across_mm.empty()) {
    tolerance.left_mm = section_.across_mm.front();
    tolerance.right_mm = section_.across_mm.back();
  } else {
    throw UserError(source, "neither the parts nor the reference have a width");
  }
  tolerance.max_shift_mm = options_.max_shift_mm;
  tolerance.max_turn_deg = options_.max_turn_deg;
  tolerance.max_residual_mm = 1e6;
  tolerance.min_defect_mm2 = options_.min_defect_mm2;
  tolerance.edge_mm = options_.edge_mm;
  tolerance.section_step_mm = kSectionStep;
  tolerance.section_mm =
      sampled_section(section_, tolerance.left_mm, tolerance.right_mm, kSectionStep, widest_of(rig_));
  return tolerance;
}

std::vector<ToleranceRegion> tolerance_regions(const Tolerance& outline, const SectionReference& section,
                                               double pitch_mm, double widest_mm, double edge_mm) {
  std::vector<ToleranceRegion> regions;
  const double from = outline.left_mm;
  const int columns = static_cast<int>(std::floor((outline.right_mm - outline.left_mm) / pitch_mm));
  int begin = 0;
  for (int c = 0; c <= columns + 1; ++c) {
    const double height = section.at(from + c * pitch_mm, widest_mm);
    const double before = section.at(from + (c - 1) * pitch_mm, widest_mm);
    const bool wall = std::isnan(height) || std::abs(height - before) > light_section::kSteepest * pitch_mm;
    if (!wall && c <= columns) {
      continue;
    }
    const double low = from + begin * pitch_mm + edge_mm;
    const double high = from + (c - 1) * pitch_mm - edge_mm;
    const double first = edge_mm;
    const double last = outline.length_mm - edge_mm;
    if (high > low + edge_mm && last > first + edge_mm) {
      regions.push_back(surface(regions.size() + 1, {{first, low}, {last, low}, {last, high}, {first, high}}));
    }
    begin = std::isnan(height) ? c + 1 : c;
  }
  return regions;
}

std::vector<ToleranceRegion> map_regions(const images::FloatImage& comparable, const MapGrid& grid, double edge_mm,
                                         double min_defect_mm2) {
  cv::Mat1b there(comparable.rows, comparable.columns, std::uint8_t{0});
  for (int r = 0; r < there.rows; ++r) {
    for (int c = 0; c < there.cols; ++c) {
      there(r, c) = std::isnan(comparable.row(r)[c]) ? 0 : UINT8_MAX;
    }
  }
  // Single places without a height are no border.
  cv::morphologyEx(there, there, cv::MORPH_CLOSE, block(3));
  cv::erode(there, there, block(2 * static_cast<int>(std::ceil(edge_mm / grid.pitch_mm)) + 1), {-1, -1}, 1,
            cv::BORDER_CONSTANT, cv::Scalar(0));
  constexpr double kMinAreas = 16;
  std::vector<ToleranceRegion> regions;
  add_surfaces(there, grid, kMinAreas * min_defect_mm2, regions);
  return regions;
}

std::vector<ToleranceRegion> without_unseen(const std::vector<ToleranceRegion>& regions, const cv::Mat1b& unseen,
                                            const MapGrid& grid, double edge_mm, int side) {
  cv::Mat1b blind;
  cv::morphologyEx(unseen, blind, cv::MORPH_OPEN, block(side));
  std::vector<ToleranceRegion> result;
  for (const ToleranceRegion& region : regions) {
    cv::Mat1b cells = region_cells(region, grid);
    cv::Mat1b around;  // what is outside has its strip already
    cv::bitwise_and(blind, cells, around);
    if (cv::countNonZero(around) == 0) {
      result.push_back(region);
      result.back().name = name_of(result.size());
      continue;
    }
    cv::dilate(around, around, block(2 * static_cast<int>(std::ceil(edge_mm / grid.pitch_mm)) + 1));
    cells.setTo(0, around);
    open_holes(cells);
    add_surfaces(cells, grid, 0, result);
  }
  return result;
}

cv::Mat1b Learner::unseen(const Classifier& classifier, const MapGrid& grid, const Reasons& reasons) const {
  cv::Mat1i missing(grid.rows, grid.columns, 0);
  int parts = 0;
  PlacedMaps maps;
  for (std::size_t part = 0; part < parts_.size(); ++part) {
    if (!reasons[part].empty() || classifier.classify(parts_[part], maps).verdict != Verdict::good) {
      continue;
    }
    ++parts;
    for (int r = 0; r < grid.rows; ++r) {
      for (int c = 0; c < grid.columns; ++c) {
        missing(r, c) += std::isnan(maps.difference.row(r)[c]) ? 1 : 0;
      }
    }
  }
  cv::Mat1b most;
  cv::compare(2 * missing, parts, most, cv::CMP_GT);
  return most;
}

// Classifies all parts by an outline. Those that are not as the others get a reason; what is seen of those that are
// left is added.
void Learner::compare(const Classifier& classifier, const Tolerance& outline, Reasons& reasons, std::vector<Seen>& seen,
                      RunningFigures& residual) const {
  PlacedMaps maps;
  std::vector<PartResult> results;
  for (std::size_t part = 0; part < parts_.size(); ++part) {
    results.push_back(classifier.classify(parts_[part], maps));
    if (results.back().verdict != Verdict::good && reasons[part].empty()) {
      reasons[part] = parts_[part].cut_off ? "the run began or ended in it" : "it could not be placed";
    }
  }
  const auto look_at = [&](const auto& value_of, double floor, const std::string& what) {
    std::vector<std::optional<double>> values;
    for (const PartResult& result : results) {
      values.push_back(result.verdict == Verdict::good ? std::optional<double>(value_of(result)) : std::nullopt);
    }
    leave_out(values, options_.spreads, floor, what.c_str(), reasons);
  };
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const std::string& region = outline.regions[i].name;
    look_at([&](const PartResult& result) { return result.regions[i].missing; }, kMostMissing,
            fmt::format("the share of {} that is missing", region));
    look_at([&](const PartResult& result) { return result.regions[i].lowest_mm; }, kMostOff,
            fmt::format("the lowest place of {} in mm", region));
    look_at([&](const PartResult& result) { return result.regions[i].highest_mm; }, kMostOff,
            fmt::format("the highest place of {} in mm", region));
  }
  for (std::size_t part = 0; part < parts_.size(); ++part) {
    const PartResult& result = results[part];
    if (!reasons[part].empty()) {
      continue;
    }
    residual.add(result.placement->residual_mm);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      seen[i].low.add(result.regions[i].lowest_mm);
      seen[i].high.add(result.regions[i].highest_mm);
      seen[i].missing.add(result.regions[i].missing);
    }
  }
}

void Learner::keep_regions_with_room(Tolerance& tolerance, const MapGrid& grid, const std::string& source) const {
  const int side = defect_side(tolerance.min_defect_mm2, grid.pitch_mm);
  std::erase_if(tolerance.regions,
                [&](const ToleranceRegion& region) { return !has_room(region_cells(region, grid), side); });
  if (tolerance.regions.empty()) {
    throw UserError(source,
                    fmt::format("within the strips of {:g} mm at its edges, no surface of the part has room for "
                                "a square of the smallest defect's area, {:g} mm²",
                                options_.edge_mm, tolerance.min_defect_mm2));
  }
}

void Learner::set_limits(Tolerance& tolerance, const std::vector<Seen>& seen, const RunningFigures& residual) const {
  const auto far = [&](const RunningFigures& figures, double least) {
    return std::max(least, options_.spreads * factor_of_few(figures.count()) * figures.spread());
  };
  for (std::size_t i = 0; i < seen.size(); ++i) {
    ToleranceRegion& region = tolerance.regions[i];
    // The closing that looks for dents lifts noise, and the opening that looks for bumps lowers it. So in a small
    // region of noisy maps the limit for dents may come out higher than that for bumps.
    constexpr double kLeastBand = 1e-3;
    const auto [low, high] = std::minmax({seen[i].low.mean() - far(seen[i].low, options_.min_band_mm),
                                          seen[i].high.mean() + far(seen[i].high, options_.min_band_mm)});
    region.low_mm = files::rounded(low, 4);
    region.high_mm = files::rounded(std::max(high, low + kLeastBand), 4);
    region.max_missing = files::rounded(std::min(1.0, seen[i].missing.mean() + far(seen[i].missing, kMinMissing)), 4);
  }
  const double least_residual = std::max(kMinResidual, kMinResidualCells * rig_.parts->grid_mm);
  tolerance.max_residual_mm = files::rounded(residual.mean() + far(residual, least_residual), 3);
  const auto round_mm = [&](double& mm) { mm = files::rounded(mm, 3); };
  round_mm(tolerance.length_mm);
  round_mm(tolerance.left_mm);
  round_mm(tolerance.right_mm);
}

// Reasons to think that the reference is not that of these parts, or that little of them is inspected.
std::vector<std::string> Learner::doubts_about(const Tolerance& tolerance, const std::vector<Seen>& seen,
                                               const LearnRemarks& remarks) const {
  constexpr double kMostOfIt = 0.5;
  constexpr double kMostOfWidth = 0.25;
  std::vector<std::string> doubts;
  if (remarks.unseen_mm2 > kMostOfIt * remarks.regions_mm2) {
    doubts.emplace_back("more than half of the surfaces is not inspected");
  }
  const double pitch = rig_.parts->grid_mm;
  const int columns = static_cast<int>((tolerance.right_mm - tolerance.left_mm) / pitch);
  int without = 0;
  for (int c = 0; c < columns; ++c) {
    without += std::isnan(section_.at(tolerance.left_mm + (c + 0.5) * pitch, widest_of(rig_))) ? 1 : 0;
  }
  if (without > kMostOfWidth * columns) {
    doubts.push_back(
        fmt::format("in {:.0f} % of the parts' width the reference shows nothing, so nothing is inspected there",
                    100.0 * without / columns));
  }
  // From the empty belt all parts are far, and may be compared with it all the same.
  const bool of_a_part = std::ranges::any_of(section_.height_mm, [&](double h) { return h > rig_.parts->above_mm; });
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const double low = seen[i].low.mean();
    const double high = seen[i].high.mean();
    // Good parts lie around their reference. 0 may be outside of their band by as much as it is wide.
    const ToleranceRegion& region = tolerance.regions[i];
    const bool off = of_a_part && std::max(region.low_mm, -region.high_mm) > region.high_mm - region.low_mm;
    if (high - low > rig_.parts->above_mm || off) {
      doubts.push_back(fmt::format(
          "in region '{}' each good part is {:+.3f} to {:+.3f} mm from the reference, and defects are only what is "
          "outside of all of it; is the reference (--reference) that of these parts?",
          region.name, low, high));
    }
  }
  return doubts;
}

Tolerance Learner::learn(const std::string& source, LearnRemarks* remarks) const {
  if (parts_.size() < kMinGoodParts) {
    throw UserError(source, fmt::format("{} good parts came; at least {} are needed", parts_.size(), kMinGoodParts));
  }
  Reasons reasons(parts_.size());
  Tolerance tolerance;
  std::vector<Seen> seen;
  RunningFigures residual;
  // A part that is left out when it has been compared with the outline must not have been in that either.
  for (bool again = true; again;) {
    const auto left = std::count(reasons.begin(), reasons.end(), "");
    tolerance = map_ ? whole_view() : outline(source, reasons);
    const MapGrid grid = placed_grid(rig_.parts->grid_mm, tolerance.length_mm, tolerance.left_mm, tolerance.right_mm);
    if (!map_) {
      tolerance.regions =
          tolerance_regions(tolerance, section_, rig_.parts->grid_mm, widest_of(rig_), options_.edge_mm);
      keep_regions_with_room(tolerance, grid, source);
      const double whole = area_mm2(tolerance.regions, grid);
      tolerance.regions = without_unseen(tolerance.regions, unseen(classifier_of(tolerance, source), grid, reasons),
                                         grid, options_.edge_mm, defect_side(tolerance.min_defect_mm2, grid.pitch_mm));
      if (remarks != nullptr) {
        remarks->unseen_mm2 = whole - area_mm2(tolerance.regions, grid);
        remarks->regions_mm2 = whole;
      }
    }
    keep_regions_with_room(tolerance, grid, source);
    seen.assign(tolerance.regions.size(), {});
    residual = {};
    compare(classifier_of(tolerance, source), tolerance, reasons, seen, residual);
    again = !map_ && std::count(reasons.begin(), reasons.end(), "") < left && residual.count() >= kMinGoodParts;
  }
  for (std::size_t part = 0; part < parts_.size() && remarks != nullptr; ++part) {
    if (!reasons[part].empty()) {
      remarks->left_out.push_back(fmt::format("part {} of {}: {}", part + 1, parts_.size(), reasons[part]));
    }
  }
  if (residual.count() < kMinGoodParts) {
    const auto odd =
        std::find_if(reasons.begin(), reasons.end(), [](const std::string& text) { return !text.empty(); });
    throw UserError(
        source,
        fmt::format("{} of {} parts could be placed and are alike; at least {} are needed{}", residual.count(),
                    parts_.size(), kMinGoodParts,
                    odd == reasons.end() ? "" : fmt::format("; of part {}, {}", odd - reasons.begin() + 1, *odd)));
  }
  set_limits(tolerance, seen, residual);
  if (remarks != nullptr && !map_) {
    remarks->doubts = doubts_about(tolerance, seen, *remarks);
  }
  return tolerance;
}

}  // namespace selfproj::production
