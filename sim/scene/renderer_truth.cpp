// The truth of a line's renderer.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "sim/scene/parallel.h"
#include "sim/scene/renderer.h"

namespace selfproj {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

// The distance, in projector lines, between the light sheet and the point that a ray meets: negative on one side of the
// sheet; NaN where there is no light.
double Renderer::miss(Point3 sight, double t, HeightRange heights) const {
  const Hit h = surface_.hit_along(sight, t, heights);
  if (projector_.depth(h.point) <= 0) {
    return kNan;
  }
  const PixelPoint p = projector_.project(h.point);
  return p.row - light_.line_centre(p.column);
}

// 1 or -1 if all points at which the rays between these bounds of sights meet heights in this range certainly lie on
// one side of the sheet, with the sign that miss() has there; otherwise nothing.
std::optional<double> Renderer::side_of_sheet(const Box& tangents, HeightRange heights) const {
  constexpr double kRounding = 1e-3;  // mm, and more than the tolerance of heights
  const Point3 centre = camera_.centre();
  std::array<Point3, 8> points{};
  std::size_t count = 0;
  for (const double x : {tangents.x0, tangents.x1}) {
    for (const double y : {tangents.y0, tangents.y1}) {
      for (const double h : {heights.low - kRounding, heights.high + kRounding}) {
        points.at(count++) = centre + (rig_.plane_z_mm - h - centre.z) * Point3{x, y, 1};
      }
    }
  }
  if (!std::all_of(points.begin(), points.end(), [&](Point3 p) { return projector_.sees(p); })) {
    return std::nullopt;
  }
  const std::optional<PixelBounds> b = projector_.bounds(points);
  constexpr double kLines = 1e-6;
  const auto centres = b ? light_.line_centres(b->column_0 - kLines, b->column_1 + kLines) : std::nullopt;
  if (!centres || (b->row_0 - kLines <= centres->high && b->row_1 + kLines >= centres->low)) {
    return std::nullopt;
  }
  return b->row_0 > centres->high ? 1 : -1;
}

// Whether the surface at this place of a column, between two of its rows, is on the light sheet and in the light.
std::optional<LitSurface::Hit> Renderer::hit_on_sheet(double row, int column, double above, double t,
                                                      HeightRange heights) const {
  constexpr int kHalvings = 24;
  const auto sight = [&](double at) { return surface_.sight({at, column + 0.0}); };
  double low = row - 0.5;
  double high = row + 0.5;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (low + high) / 2;
    ((miss(sight(middle), t, heights) < 0) == (above < 0) ? low : high) = middle;
  }
  constexpr double kThere = 0.01;  // a jump of the surface across the sheet is no crossing
  const Hit hit = surface_.hit_along(sight(low), t, heights);
  return std::abs(miss(sight(low), t, heights)) < kThere && surface_.lit_share(hit, t, heights.high) > 0
             ? std::optional(hit)
             : std::nullopt;
}

// Where a column's rays cross the sheet. Parts of the column whose rays all end on one side of it are left out.
void Renderer::truth(int frame, std::span<float> heights, std::span<Point3> points) const {
  const double t = time_of(frame);
  const HeightRange all = surface_.all_heights(t, t);
  const ColumnViews& views = *column_views_;
  for (int column = 0; column < rig_.camera.columns; ++column) {
    int seen = 0;
    double height = kNan;
    std::optional<double> above;  // the miss at the upper edge of the row; nothing above the first one
    for (int part = 0; part < views.parts(); ++part) {
      const Box& tangents = views.tangents(column, part);
      const HeightRange near = surface_.heights_between(tangents, t, t, all);
      if (const auto side = side_of_sheet(tangents, near)) {
        above = side;
        continue;
      }
      const std::span<const Point3> edges = views.edges(column, part);
      for (int i = 0; i < views.rows_of(part); ++i) {
        const auto edge = static_cast<std::size_t>(i);
        above = above ? above : miss(edges[edge], t, all);
        const double below = miss(edges[edge + 1], t, all);
        if ((*above < 0) != (below < 0) && !std::isnan(*above) && !std::isnan(below)) {
          if (const auto hit = hit_on_sheet(views.first_row(part) + i, column, *above, t, all)) {
            ++seen;
            height = hit->height;
            if (!points.empty()) {
              points[static_cast<std::size_t>(column)] = hit->point;
            }
          }
        }
        above = below;
      }
    }
    heights[static_cast<std::size_t>(column)] = static_cast<float>(seen == 1 ? height : kNan);
  }
}

FloatImage Renderer::truth(int first, int count, int threads) const {
  FloatImage result(count, rig_.camera.columns);
  parallel_for(count, threads, [&](int i) {
    truth(first + i, {result.row(i), static_cast<std::size_t>(result.columns)});
  });
  return result;
}

}  // namespace selfproj
