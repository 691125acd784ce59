// The sights and bounds that are kept for the columns of a camera are those of its pixels' edges.
#include "sim/scene/column_views.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <span>

#include "host/rig/rig.h"
#include "sim/scene/lit_surface.h"
#include "sim/scene/pinhole.h"
#include "sim/scene/real_rig.h"

namespace selfproj {
namespace {

// Also where the last part is shorter than the others, and where there is only one part.
TEST(ColumnViews, EdgesAreThoseOfThePixels) {
  for (const int rows : {96, 39, 5}) {
    Rig rig = load_rig("light-section");
    rig.camera.rows = rows;
    rig.camera.columns = 40;
    const Pinhole camera = hidden_rig(rig, 2).camera;
    const ColumnViews views(camera, rig.camera);
    int next = 0;
    for (int part = 0; part < views.parts(); ++part) {
      ASSERT_EQ(views.first_row(part), next) << "parts leave no row out";
      next += views.rows_of(part);
    }
    EXPECT_EQ(next, rows);
    for (int column = 0; column < rig.camera.columns; ++column) {
      for (int part = 0; part < views.parts(); ++part) {
        const std::span<const Point3> edges = views.edges(column, part);
        ASSERT_EQ(edges.size(), static_cast<std::size_t>(views.rows_of(part)) + 1);
        double row = views.first_row(part) - 0.5;
        for (const Point3 edge : edges) {
          const Point3 sight = camera.sight({row, static_cast<double>(column)});
          EXPECT_EQ(edge.x, sight.x);
          EXPECT_EQ(edge.y, sight.y);
          EXPECT_EQ(edge.z, sight.z);
          row += 1;
        }
      }
    }
  }
}

TEST(ColumnViews, TangentsAreTheTightestBoundsOfTheEdges) {
  Rig rig = load_rig("light-section");
  rig.camera.columns = 40;
  const ColumnViews views(hidden_rig(rig, 3).camera, rig.camera);
  for (int column = 0; column < rig.camera.columns; ++column) {
    for (int part = 0; part < views.parts(); ++part) {
      const std::span<const Point3> edges = views.edges(column, part);
      const auto [left, right] =
          std::minmax_element(edges.begin(), edges.end(), [](Point3 a, Point3 b) { return a.x < b.x; });
      const auto [low, high] =
          std::minmax_element(edges.begin(), edges.end(), [](Point3 a, Point3 b) { return a.y < b.y; });
      const Box& tangents = views.tangents(column, part);
      EXPECT_EQ(tangents.x0, left->x);
      EXPECT_EQ(tangents.x1, right->x);
      EXPECT_EQ(tangents.y0, low->y);
      EXPECT_EQ(tangents.y1, high->y);
    }
  }
}

}  // namespace
}  // namespace selfproj
