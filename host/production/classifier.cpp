#include "host/production/classifier.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "host/production/placement.h"
#include "selfproj/files/user_error.h"
#include "selfproj/images/float_image.h"
#include "selfproj/light_section/reference.h"

namespace selfproj::production {
namespace {

constexpr float kFarAway = 1e9F;  // mm: more than any difference

// The difference with this value where it has none.
cv::Mat1f filled(const images::FloatImage& map, float value) {
  cv::Mat1f result(map.rows, map.columns);
  std::transform(map.values.begin(), map.values.end(), result.begin(),
                 [&](float v) { return std::isnan(v) ? value : v; });
  return result;
}

// The cells of both.
cv::Mat1b both(const cv::Mat1b& a, const cv::Mat1b& b) {
  cv::Mat1b result;
  cv::bitwise_and(a, b, result);
  return result;
}

void make_inconclusive(PartResult& result, const std::string& reason) {
  if (result.verdict != Verdict::inconclusive) {
    result.verdict = Verdict::inconclusive;
    result.reason = reason;
  }
}

// Adds a defect for each connected group of cells that reach beyond the band.
void add_defects(const cv::Mat1b& beyond, const cv::Mat1f& levels, bool low, int side, const ToleranceRegion& region,
                 const MapGrid& grid, std::vector<Defect>& defects) {
  cv::Mat1i labels;
  cv::Mat1i figures;
  cv::Mat1d middles;
  const int count = cv::connectedComponentsWithStats(beyond, labels, figures, middles, 8);
  // Where the reference is no good part, the band says what is.
  const bool is_reference = region.low_mm <= 0 && region.high_mm >= 0;
  const double nominal = is_reference ? 0 : 0.5 * (region.low_mm + region.high_mm);
  for (int i = 1; i < count; ++i) {
    const int area = figures(i, cv::CC_STAT_AREA);
    if (area < side * side) {
      continue;
    }
    const cv::Rect box(figures(i, cv::CC_STAT_LEFT), figures(i, cv::CC_STAT_TOP), figures(i, cv::CC_STAT_WIDTH),
                       figures(i, cv::CC_STAT_HEIGHT));
    double least = 0;
    double greatest = 0;
    cv::minMaxLoc(levels(box), &least, &greatest, nullptr, nullptr, labels(box) == i);
    defects.push_back({.region = region.name,
                       .along_mm = grid.along_of(middles(i, 1)),
                       .across_mm = grid.across_of(middles(i, 0)),
                       .size_along_mm = box.height * grid.pitch_mm,
                       .size_across_mm = box.width * grid.pitch_mm,
                       .area_mm2 = area * grid.pitch_mm * grid.pitch_mm,
                       .depth_mm = (low ? least : greatest) - nominal});
  }
}

}  // namespace

DefectLevels defect_levels(const images::FloatImage& difference, int side) {
  const cv::Mat1b square(side, side, std::uint8_t{1});
  DefectLevels levels;
  // A place without a point is low for the opening and high for the closing, so that it makes no defect.
  cv::morphologyEx(filled(difference, -kFarAway), levels.high, cv::MORPH_OPEN, square, {-1, -1}, 1, cv::BORDER_CONSTANT,
                   cv::Scalar(static_cast<double>(-kFarAway)));
  cv::morphologyEx(filled(difference, kFarAway), levels.low, cv::MORPH_CLOSE, square, {-1, -1}, 1, cv::BORDER_CONSTANT,
                   cv::Scalar(static_cast<double>(kFarAway)));
  return levels;
}

int defect_side(double min_defect_mm2, double pitch_mm) {
  return std::max(1, static_cast<int>(std::lround(std::sqrt(min_defect_mm2) / pitch_mm)));
}

cv::Mat1b region_cells(const ToleranceRegion& region, const MapGrid& grid) {
  constexpr int kShift = 8;  // fillPoly takes fractions of a cell
  constexpr double kParts = 1 << kShift;
  std::vector<cv::Point> corners;
  for (std::size_t i = 0; i + 1 < region.corners_mm.size(); i += 2) {
    corners.emplace_back(static_cast<int>(std::lround(kParts * grid.column_of(region.corners_mm[i + 1]))),
                         static_cast<int>(std::lround(kParts * grid.row_of(region.corners_mm[i]))));
  }
  cv::Mat1b cells(grid.rows, grid.columns, std::uint8_t{0});
  cv::fillPoly(cells, std::vector<std::vector<cv::Point>>{corners}, cv::Scalar(UINT8_MAX), cv::LINE_8, kShift);
  return cells;
}

Classifier::Classifier(const rig::Rig& rig, const SectionReference& section, const Tolerance& tolerance,
                       const std::string& source)
    : rule_(rig.parts.value()), tolerance_(tolerance) {
  check_tolerance(tolerance, rig, section, source);
  grid_ = placed_grid(rig.parts->grid_mm, tolerance.length_mm, tolerance.left_mm, tolerance.right_mm);
  const double widest = 3 * pixel_mm(rig);
  reference_ = images::FloatImage(grid_.rows, grid_.columns);
  for (int c = 0; c < grid_.columns; ++c) {
    const auto height = static_cast<float>(section.at(grid_.across_of(c), widest));
    for (int r = 0; r < grid_.rows; ++r) {
      reference_.row(r)[c] = height;
    }
  }
  jumps_ = section.jumps(rig, widest);
  set_regions(source);
}

Classifier::Classifier(const rig::Rig& rig, const HeightCells& reference, const Tolerance& tolerance,
                       const std::string& source)
    : tolerance_(tolerance) {
  check_map_tolerance(tolerance, rig, reference, source);
  grid_ = placed_grid(rig.parts->grid_mm, tolerance.length_mm, tolerance.left_mm, tolerance.right_mm);
  reference_ = without_steep_places(placed_heights(reference, Placement{}, grid_), rig);
  set_regions(source);
}

bool has_room(const cv::Mat1b& cells, int side) {
  cv::Mat1b room;
  cv::erode(cells, room, cv::Mat1b(side, side, std::uint8_t{1}), {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  return cv::countNonZero(room) > 0;
}

void Classifier::set_regions(const std::string& source) {
  const int side = defect_side(tolerance_.min_defect_mm2, grid_.pitch_mm);
  for (const ToleranceRegion& region : tolerance_.regions) {
    regions_.push_back(region_cells(region, grid_));
    if (!has_room(regions_.back(), side)) {
      throw UserError(source, fmt::format("region '{}' has no room for a square of min_defect_mm2, {:g} mm²",
                                          region.name, tolerance_.min_defect_mm2));
    }
  }
}

images::FloatImage Classifier::difference(const images::FloatImage& heights) const {
  images::FloatImage result(heights.rows, heights.columns);
  std::transform(heights.values.begin(), heights.values.end(), reference_.values.begin(), result.values.begin(),
                 std::minus<>());
  return result;
}

void Classifier::place(const CutPart& part, PartResult& result) const {
  if (!tolerance_.by_edges) {
    result.placement.emplace();
    return;
  }
  result.placement = place_by_edges(edges_of(part.cells, rule_), tolerance_.outline());
  if (!result.placement) {
    make_inconclusive(result, "no edges by which it could be placed");
    return;
  }
  const Placement& placed = *result.placement;
  const double turn = placed.turn_rad * 180 / std::numbers::pi;
  if (std::abs(placed.across_mm) > tolerance_.max_shift_mm) {
    make_inconclusive(result, fmt::format("is shifted across by {:.2f} mm", placed.across_mm));
  } else if (std::abs(turn) > tolerance_.max_turn_deg) {
    make_inconclusive(result, fmt::format("is turned by {:.2f}°", turn));
  } else if (placed.residual_mm > tolerance_.max_residual_mm) {
    make_inconclusive(result, fmt::format("its edges do not fit by {:.2f} mm", placed.residual_mm));
  }
}

HeightCells Classifier::without_jumps(HeightCells cells) const {
  if (jumps_.empty()) {
    return cells;
  }
  for (int c = 0; c < cells.grid.columns; ++c) {
    const double across = cells.grid.across_of(c);
    if (std::none_of(jumps_.begin(), jumps_.end(),
                     [&](const auto& jump) { return across > jump.first && across < jump.second; })) {
      continue;
    }
    for (int r = 0; r < cells.grid.rows; ++r) {
      cells.height.row(r)[c] = images::kNoValue;
    }
  }
  return cells;
}

void Classifier::find_defects(const PlacedMaps& maps, PartResult& result) const {
  const int side = defect_side(tolerance_.min_defect_mm2, grid_.pitch_mm);
  const DefectLevels levels = defect_levels(maps.difference, side);
  const cv::Mat1f map = filled(maps.difference, kFarAway);
  const cv::Mat there = map < static_cast<double>(kFarAway);
  for (std::size_t i = 0; i < regions_.size(); ++i) {
    const ToleranceRegion& region = tolerance_.regions[i];
    const cv::Mat1b& cells = regions_[i];
    RegionFigures figures{.name = region.name};
    const cv::Mat seen = there & cells;
    const int count = cv::countNonZero(cells);
    const int points = cv::countNonZero(seen);
    figures.missing = count > 0 ? 1 - static_cast<double>(points) / count : 1;
    if (points > 0) {
      figures.mean_mm = cv::mean(map, seen)[0];
      double unused = 0;
      cv::minMaxLoc(levels.high, &unused, &figures.highest_mm, nullptr, nullptr, seen);
      cv::minMaxLoc(levels.low, &figures.lowest_mm, &unused, nullptr, nullptr, seen);
      // Where neighbouring cells differ by more than the whole surface does, as by whole codes, they come in the other
      // order.
      std::tie(figures.lowest_mm, figures.highest_mm) = std::minmax({figures.lowest_mm, figures.highest_mm});
    }
    cv::Mat1b high;
    cv::compare(levels.high, region.high_mm, high, cv::CMP_GT);
    add_defects(both(high, cells), levels.high, false, side, region, grid_, result.defects);
    cv::Mat1b low;
    cv::compare(levels.low, region.low_mm, low, cv::CMP_LT);
    add_defects(both(low, cells), levels.low, true, side, region, grid_, result.defects);
    if (figures.missing > region.max_missing) {
      make_inconclusive(result, fmt::format("{:.1f} % of region '{}' are missing", 100 * figures.missing, region.name));
    }
    result.regions.push_back(figures);
  }
  std::stable_sort(result.defects.begin(), result.defects.end(),
                   [](const Defect& a, const Defect& b) { return a.area_mm2 > b.area_mm2; });
}

PartResult Classifier::classify(const CutPart& part, PlacedMaps& maps) const {
  PartResult result;
  result.verdict = Verdict::good;
  result.begin_mm = part.begin_mm;
  result.length_mm = part.length_mm;
  result.first_frame = part.first;
  result.last_frame = part.last;
  result.frames = part.frames;
  result.missing_frames = part.missing;
  if (part.restarted) {
    make_inconclusive(result, "the board was restarted in it");
  }
  if (part.cut_off) {
    make_inconclusive(result, "the run began or ended in it");
  }
  if (part.too_long) {
    make_inconclusive(result, "is longer than parts.length_mm");
  }
  place(part, result);
  maps.grid = grid_;
  if (!result.placement) {
    maps.height = maps.difference = images::FloatImage(grid_.rows, grid_.columns, images::kNoValue);
    return result;
  }
  maps.height = placed_heights(without_jumps(part.cells), *result.placement, grid_);
  maps.difference = difference(maps.height);
  // What does not lie as it should differs everywhere, and that is no defect.
  const bool lies_well = result.verdict == Verdict::good;
  find_defects(maps, result);
  if (!lies_well) {
    result.defects.clear();
  } else if (!result.defects.empty()) {
    const Defect& worst = result.defects.front();
    result.verdict = Verdict::bad;
    result.reason =
        fmt::format("{} defect{}; the largest, {:.2f} mm² in region '{}', is {:+.3f} mm off", result.defects.size(),
                    result.defects.size() == 1 ? "" : "s", worst.area_mm2, worst.region, worst.depth_mm);
  }
  return result;
}

}  // namespace selfproj::production
