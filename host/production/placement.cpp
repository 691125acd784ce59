#include "host/production/placement.h"

#include <algorithm>
#include <array>
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
#include "host/production/height_map.h"

namespace selfproj::production {
namespace {

constexpr int kInto = 4;            // cells inside an edge that may be only partly filled
constexpr int kFull = 8;            // the next cells, from which a full cell's weight is derived
constexpr int kBorder = 2;          // a side edge within so many cells of the view's border is the view's own
constexpr double kSharpest = 0.05;  // mm: no edge is located better than this
constexpr double kTrim = 0.6;       // cells: places nearer to the line than this always count

// One point of an edge, in cells: `at` across the edge, `beside` along it.
struct Place {
  double beside = 0;
  double at = 0;
};

// A mask of the largest connected thing that is higher than above_mm: nonzero inside.
cv::Mat1b largest_thing(const HeightCells& cells, const rig::RigParts& rule) {
  cv::Mat1b mask(cells.grid.rows, cells.grid.columns, std::uint8_t{0});
  for (int r = 0; r < mask.rows; ++r) {
    for (int c = 0; c < mask.cols; ++c) {
      mask(r, c) = static_cast<double>(cells.height.row(r)[c]) > rule.above_mm ? UINT8_MAX : 0;
    }
  }
  // Cells inside the part that no light reached must not split it: those of single points, and the shadow of a wall.
  const int joins = std::max(5, 2 * static_cast<int>(std::ceil(0.5 * rule.gap_mm / cells.grid.pitch_mm)) + 1);
  cv::Mat1b joined;
  cv::morphologyEx(mask, joined, cv::MORPH_CLOSE, cv::Mat1b(joins, joins, std::uint8_t{1}));
  cv::Mat1i labels;
  cv::Mat1i figures;
  cv::Mat1d middles;
  const int count = cv::connectedComponentsWithStats(joined, labels, figures, middles, 8);
  int largest = 0;
  for (int i = 1; i < count; ++i) {
    if (largest == 0 || figures(i, cv::CC_STAT_AREA) > figures(largest, cv::CC_STAT_AREA)) {
      largest = i;
    }
  }
  cv::compare(labels, largest == 0 ? count : largest, joined, cv::CMP_EQ);
  cv::bitwise_and(joined, mask, mask);
  return mask;
}

// One row or column of cells, read inwards from the edge that is looked for: weights, and 1 inside the thing.
struct Line {
  std::vector<float> weights;
  std::vector<std::uint8_t> inside;
};

// The first cell of the thing itself: those behind it are inside without a hole, but for one far in. Behind an edge
// that throws a shadow, the light lies half on the edge and half on the plane, and what is measured there is sparse.
std::ptrdiff_t first_of(const std::vector<std::uint8_t>& inside) {
  const auto size = static_cast<std::ptrdiff_t>(inside.size());
  for (std::ptrdiff_t first = 0; first + kInto + kFull <= size; ++first) {
    const auto from = inside.begin() + first;
    if (std::find(from, from + kInto, 0) == from + kInto && std::count(from + kInto, from + kInto + kFull, 0) <= 1) {
      return first;
    }
  }
  return size;
}

// Where the thing begins in the line, in cells; the middle of cell 0 is 0. If the points are evenly spread along the
// line, the summed weight up to a cell, divided by a full cell's weight, says how many cells before it the thing
// begins.
std::optional<double> begin_of(const Line& line) {
  const auto size = static_cast<std::ptrdiff_t>(line.inside.size());
  const std::ptrdiff_t first = first_of(line.inside);
  if (first + kInto + kFull > size) {
    return std::nullopt;
  }
  double full = 0;
  for (std::ptrdiff_t i = first + kInto; i < first + kInto + kFull; ++i) {
    full += static_cast<double>(line.weights[static_cast<std::size_t>(i)]) / kFull;
  }
  if (!(full > 0)) {
    return std::nullopt;
  }
  double sum = 0;
  const std::ptrdiff_t last = first + kInto - 1;
  for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(0, first - 1); i <= last; ++i) {
    sum += static_cast<double>(line.weights[static_cast<std::size_t>(i)]);
  }
  const double begin = static_cast<double>(last) + 0.5 - sum / full;
  // What is not even there, as a light that is lost at the edge, is located by the cells alone.
  const double by_cells = static_cast<double>(first) - 0.5;
  return std::clamp(begin, by_cells - 1, by_cells + 1);
}

// The straight line at = a + b beside.
struct Fit {
  double a = 0, b = 0;
  double rms = 0;
  double beside = 0;  // middle of the places that count
  std::size_t count = 0;
};

// Begins with the medians of the first and the last third; then least squares, without what is far off.
std::optional<Fit> fit_line(const std::vector<Place>& places) {
  if (places.size() < kMinPlaces) {
    return std::nullopt;
  }
  const std::size_t third = places.size() / 3;
  std::array<std::vector<double>, 2> at;
  std::array<std::vector<double>, 2> beside;
  for (std::size_t i = 0; i < third + 1; ++i) {
    at[0].push_back(places[i].at);
    beside[0].push_back(places[i].beside);
    at[1].push_back(places[places.size() - 1 - i].at);
    beside[1].push_back(places[places.size() - 1 - i].beside);
  }
  Fit fit;
  const double way = files::median_of(beside[1]) - files::median_of(beside[0]);
  fit.b = way > 0 ? (files::median_of(at[1]) - files::median_of(at[0])) / way : 0;
  fit.a = files::median_of(at[0]) - fit.b * files::median_of(beside[0]);
  for (int pass = 0; pass < 5; ++pass) {
    std::vector<double> off;
    off.reserve(places.size());
    for (const Place& place : places) {
      off.push_back(std::abs(place.at - fit.a - fit.b * place.beside));
    }
    const double limit = std::max(kTrim, 3 * 1.5 * files::median_of(off));  // 1.5 medians: about a standard deviation
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (off[i] <= limit) {
        const double x = places[i].beside, y = places[i].at;
        n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y, syy += y * y;
      }
    }
    const double spread = sxx - sx * sx / n;
    if (n < static_cast<double>(kMinPlaces) || !(spread > 0)) {
      return std::nullopt;
    }
    fit.b = (sxy - sx * sy / n) / spread;
    fit.a = (sy - fit.b * sx) / n;
    fit.beside = sx / n;
    fit.count = static_cast<std::size_t>(n);
    fit.rms = std::sqrt(std::max(0.0, (syy - sy * sy / n - fit.b * (sxy - sx * sy / n)) / n));
  }
  return fit;
}

// The cells of row or column `number`, from its beginning or from its end.
Line line_of(const HeightCells& cells, const cv::Mat1b& thing, Edge edge, int number) {
  const bool along = edge == Edge::leading || edge == Edge::trailing;  // the line of cells runs along
  const int size = along ? thing.rows : thing.cols;
  Line line;
  line.weights.reserve(static_cast<std::size_t>(size));
  line.inside.reserve(static_cast<std::size_t>(size));
  for (int i = 0; i < size; ++i) {
    const int k = edge == Edge::trailing || edge == Edge::right ? size - 1 - i : i;
    const int r = along ? k : number;
    const int c = along ? number : k;
    line.inside.push_back(thing(r, c) != 0 ? 1 : 0);
    const bool counts = thing(r, c) != 0 || std::isnan(cells.height.row(r)[c]);
    line.weights.push_back(counts ? cells.weight.row(r)[c] : 0.0F);
  }
  return line;
}

std::optional<EdgeLine> edge_line(const HeightCells& cells, const cv::Mat1b& thing, Edge edge) {
  const bool along = edge == Edge::leading || edge == Edge::trailing;
  const bool back = edge == Edge::trailing || edge == Edge::right;
  const int size = along ? thing.rows : thing.cols;
  std::vector<Place> places;
  for (int number = 0; number < (along ? thing.cols : thing.rows); ++number) {
    if (const std::optional<double> begin = begin_of(line_of(cells, thing, edge, number))) {
      places.push_back({static_cast<double>(number), back ? size - 1 - *begin : *begin});
    }
  }
  // The first and the last tenth may belong to the neighbouring edges.
  const auto tenth = static_cast<std::ptrdiff_t>(places.size() / 10);
  places = {places.begin() + tenth, places.end() - tenth};
  const std::optional<Fit> fit = fit_line(places);
  if (!fit) {
    return std::nullopt;
  }
  const double at = fit->a + fit->b * fit->beside;
  if (!along && (at < kBorder || at > size - 1 - kBorder)) {
    return std::nullopt;
  }
  const double turn = along ? std::atan(fit->b) : -std::atan(fit->b);
  return EdgeLine{cells.grid.along_of(along ? at : fit->beside), cells.grid.across_of(along ? fit->beside : at), turn,
                  fit->rms * std::cos(turn) * cells.grid.pitch_mm, fit->count};
}

// How far two opposite edges lie from where the outline has them, and their distance.
struct Shift {
  double offset = 0;
  std::optional<double> size = {};
  double remains = 0;  // what each of two edges is still off after the shift
};

Shift shift_of(std::optional<double> low, std::optional<double> high, std::optional<double> want_low,
               std::optional<double> want_high) {
  Shift result;
  if (low && high) {
    result.size = *high - *low;
  }
  if (low && high && want_low && want_high) {
    result.offset = 0.5 * (*low + *high - *want_low - *want_high);
    result.remains = 0.5 * std::abs(*high - *low - *want_high + *want_low);
  } else if (low && want_low) {
    result.offset = *low - *want_low;
  } else if (high && want_high) {
    result.offset = *high - *want_high;
  }
  return result;
}

}  // namespace

EdgeLines edges_of(const HeightCells& cells, const rig::RigParts& rule) {
  EdgeLines edges;
  if (cells.grid.rows == 0) {
    return edges;
  }
  const cv::Mat1b thing = largest_thing(cells, rule);
  for (std::size_t i = 0; i < kEdges; ++i) {
    edges[i] = edge_line(cells, thing, static_cast<Edge>(i));
  }
  return edges;
}

double Placement::seen_along(double v, double w) const {
  return (v + along_mm) * std::cos(turn_rad) + (w + offset_mm) * std::sin(turn_rad);
}

double Placement::seen_across(double v, double w) const {
  return -(v + along_mm) * std::sin(turn_rad) + (w + offset_mm) * std::cos(turn_rad);
}

std::optional<Placement> place_by_edges(const EdgeLines& edges, const Outline& outline) {
  Placement result;
  double weights = 0;
  double squares = 0;
  double count = 0;
  for (std::size_t i = 0; i < kEdges; ++i) {
    if (edges[i]) {
      const auto n = static_cast<double>(edges[i]->count);
      const double rms = std::max(kSharpest, edges[i]->rms_mm);
      const double weight = n * n * n / (rms * rms);  // the variance of its angle goes with the reciprocal
      result.turn_rad += edges[i]->turn_rad * weight;
      weights += weight;
      squares += edges[i]->rms_mm * edges[i]->rms_mm * n;
      count += n;
      result.edges += (result.edges.empty() ? "" : " ") + std::string(kEdgeNames[i]);
    }
  }
  const auto there = [&](Edge edge) { return edges[static_cast<std::size_t>(edge)].has_value(); };
  if (!(weights > 0) || !(there(Edge::leading) || (there(Edge::trailing) && outline.length_mm))) {
    return std::nullopt;
  }
  result.turn_rad /= weights;
  // Where the edges lie, in axes that are turned with the part.
  std::array<std::optional<double>, kEdges> at;
  for (std::size_t i = 0; i < kEdges; ++i) {
    if (edges[i]) {
      const double s = std::sin(result.turn_rad), c = std::cos(result.turn_rad);
      at[i] =
          i < 2 ? edges[i]->along_mm * c - edges[i]->across_mm * s : edges[i]->along_mm * s + edges[i]->across_mm * c;
    }
  }
  const Shift along = shift_of(at[0], at[1], 0.0, outline.length_mm);
  const Shift across = shift_of(at[2], at[3], outline.left_mm, outline.right_mm);
  result.along_mm = along.offset;
  result.offset_mm = across.offset;
  result.length_mm = along.size;
  result.width_mm = across.size;
  const double middle_v = 0.5 * outline.length_mm.value_or(along.size.value_or(0));
  const double middle_w = 0.5 * (outline.left_mm.value_or(0) + outline.right_mm.value_or(0));
  result.across_mm = result.seen_across(middle_v, middle_w) - middle_w;
  result.residual_mm =
      std::sqrt(squares / count + 0.5 * (along.remains * along.remains + across.remains * across.remains));
  return result;
}

images::FloatImage placed_heights(const HeightCells& cells, const Placement& placement, const MapGrid& grid) {
  images::FloatImage result(grid.rows, grid.columns, images::kNoValue);
  const MapGrid& from = cells.grid;
  for (int r = 0; r < grid.rows; ++r) {
    for (int c = 0; c < grid.columns; ++c) {
      const double v = grid.along_of(r);
      const double w = grid.across_of(c);
      const double row = from.row_of(placement.seen_along(v, w));
      const double column = from.column_of(placement.seen_across(v, w));
      const int r0 = static_cast<int>(std::floor(row));
      const int c0 = static_cast<int>(std::floor(column));
      if (r0 < 0 || c0 < 0 || r0 + 1 >= from.rows || c0 + 1 >= from.columns) {
        continue;
      }
      const auto fr = static_cast<float>(row - r0);
      const auto fc = static_cast<float>(column - c0);
      const float* const above = cells.height.row(r0) + c0;
      const float* const below = cells.height.row(r0 + 1) + c0;
      const std::array<std::pair<float, float>, 4> parts = {
          {{above[0], (1 - fr) * (1 - fc)}, {above[1], (1 - fr) * fc}, {below[0], fr * (1 - fc)}, {below[1], fr * fc}}};
      float sum = 0;
      float weights = 0;
      for (const auto& [height, weight] : parts) {
        if (!std::isnan(height)) {
          sum += height * weight;
          weights += weight;
        }
      }
      if (weights >= 0.5F) {
        result.row(r)[c] = sum / weights;
      }
    }
  }
  return result;
}

}  // namespace selfproj::production
