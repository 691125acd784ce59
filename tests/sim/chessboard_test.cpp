// Tests the virtual chessboard: its plane, its squares and corners, and its places.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

#include "selfproj/files/user_error.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/optics.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/scene.h"
#include "sim/scene/targets.h"
#include "tests/host/structured_light/pinhole.h"
#include "tests/sim/on_board.h"

namespace selfproj::test {
namespace {

constexpr sim::ChessboardShape kShape{9, 7, 21};

// A board that leans by 30 degrees about an axis in the plane, and is turned by 12 degrees in its own plane.
sim::ChessboardPlace leaning() {
  const double lean = std::numbers::pi / 6;
  const double turn = std::numbers::pi / 15;
  // Turned in the plane, then about the y axis: y stays, and x gains depth.
  const auto tilted = [&](double x, double y) { return sim::Point3{x * std::cos(lean), y, x * std::sin(lean)}; };
  return {{10, -20, 540}, tilted(-std::sin(turn), std::cos(turn)), tilted(std::cos(turn), std::sin(turn))};
}

TEST(Chessboard, EveryPointOfItIsOnItsPlane) {
  const rig::Rig rig = rig::load_rig("scanner");
  const sim::ChessboardPlace place = leaning();
  const sim::ChessboardScene board(rig, kShape, place);
  for (double across = -3; across <= 12; across += 0.7) {
    for (double down = -3; down <= 10; down += 0.7) {
      const sim::Point3 p = on_board(kShape, place, across, down);
      EXPECT_NEAR(board.height(p.x, p.y, 0), rig.plane_z_mm - p.z, 1e-9);
      const sim::Box box{p.x - 2, p.x + 3, p.y - 1, p.y + 4};
      const sim::HeightRange range = board.range(box, 0, 0);
      for (const auto& [x, y] : {std::pair{box.x0, box.y0}, {box.x0, box.y1}, {box.x1, box.y0}, {box.x1, box.y1}}) {
        EXPECT_GE(board.height(x, y, 0), range.low - 1e-9);
        EXPECT_LE(board.height(x, y, 0), range.high + 1e-9);
      }
    }
  }
}

TEST(Chessboard, SquaresAreBlackAndWhiteByTurnsAndWhiteAroundThem) {
  const rig::Rig rig = rig::load_rig("scanner");
  const sim::ChessboardPlace place = leaning();
  const sim::ChessboardScene board(rig, kShape, place);
  // Squares by the corner at their end: 0..across of them, and one more on each side.
  for (int across = -1; across <= kShape.across + 1; ++across) {
    for (int down = -1; down <= kShape.down + 1; ++down) {
      const bool outside = across < 0 || down < 0 || across > kShape.across || down > kShape.down;
      const bool black = !outside && (across + down) % 2 == 0;
      for (const double at : {0.05, 0.5, 0.95}) {
        const sim::Point3 p = on_board(kShape, place, across - 1 + at, down - 1 + 0.5);
        EXPECT_NEAR(board.albedo(p.x, p.y, 0), black ? sim::ChessboardScene::kBlack : 1, 1e-12)
            << across << ' ' << down;
      }
    }
  }
  // Half way between black and white on an edge, and in the corners themselves.
  for (int across = 0; across < kShape.across; ++across) {
    for (int down = 0; down < kShape.down; ++down) {
      for (const auto& [i, j] : {std::pair{0.0, 0.0}, {0.0, 0.5}, {0.5, 0.0}}) {
        if (across + i <= kShape.across - 1 && down + j <= kShape.down - 1) {
          const sim::Point3 p = on_board(kShape, place, across + i, down + j);
          EXPECT_NEAR(board.albedo(p.x, p.y, 0), (1 + sim::ChessboardScene::kBlack) / 2, 1e-9);
        }
      }
    }
  }
}

TEST(Chessboard, TooSteepIsRefused) {
  const double lean = 81 * std::numbers::pi / 180;
  const sim::ChessboardPlace steep{{0, 0, 550}, {0, 1, 0}, {std::cos(lean), 0, std::sin(lean)}};
  EXPECT_THROW(sim::ChessboardScene(rig::load_rig("scanner"), kShape, steep), std::invalid_argument);
}

TEST(BoardPlaces, CameraAndProjectorSeeAllOfItFromManySides) {
  const rig::Rig rig = rig::load_rig("scanner");
  constexpr int kPoses = 8;
  constexpr double kTilt = 30;
  const std::vector<sim::ChessboardPlace> places = sim::chessboard_places(rig, kShape, kPoses, kTilt);
  ASSERT_EQ(places.size(), static_cast<std::size_t>(kPoses));
  std::array<double, 2> rows{1e9, -1e9};
  std::array<double, 2> columns{1e9, -1e9};
  for (std::size_t k = 0; k < places.size(); ++k) {
    const sim::ChessboardPlace& place = places[k];
    EXPECT_NEAR(sim::dot(place.right, place.right), 1, 1e-12);
    EXPECT_NEAR(sim::dot(place.below, place.below), 1, 1e-12);
    EXPECT_NEAR(sim::dot(place.right, place.below), 0, 1e-12);
    const double facing = place.right.x * place.below.y - place.right.y * place.below.x;
    EXPECT_NEAR(std::abs(facing), k == 0 ? 1 : std::cos(kTilt * std::numbers::pi / 180), 1e-9) << k;
    for (const double across : {-1.0, static_cast<double>(kShape.across)}) {
      for (const double down : {-1.0, static_cast<double>(kShape.down)}) {
        const sim::Point3 p = on_board(kShape, place, across, down);
        const Pixel seen = camera_sees(rig.camera, {p.x, p.y, p.z});
        const Pixel lit = projector_lights(rig.projector, {p.x, p.y, p.z});
        EXPECT_TRUE(seen.row >= 0 && seen.row <= rig.camera.rows - 1 && seen.column >= 0 &&
                    seen.column <= rig.camera.columns - 1)
            << k;
        EXPECT_TRUE(lit.row >= 0 && lit.row <= rig.projector.lines - 1 && lit.column >= 0 &&
                    lit.column <= rig.projector.columns - 1)
            << k;
        rows = {std::min(rows[0], seen.row), std::max(rows[1], seen.row)};
        columns = {std::min(columns[0], seen.column), std::max(columns[1], seen.column)};
      }
    }
  }
  // Together they cover most of the part of the image that the projector lights.
  EXPECT_GT(columns[1] - columns[0], 0.8 * rig.camera.columns);
  EXPECT_GT(rows[1] - rows[0], 0.6 * rig.camera.rows);
}

// Height by height, moved by the belt alone, and beside its place by no more than its flaws.
TEST(BoardPlaces, PlatesLieAtTheirHeights) {
  const sim::PerturbedRig actual(rig::load_rig("light-section"));
  const sim::ChessboardShape shape{21, 3, 2.2};
  const sim::PlateVisits visits{{0, 20, 60}, {0, 6}};
  const sim::PlateFlaws flaws{0.005, 0.01, 0.05};
  const std::vector<sim::ChessboardPlace> places = sim::places_on_plates(actual, shape, visits, flaws, 3);
  ASSERT_EQ(places.size(), 6U);
  const double side = shape.square_mm * (shape.across - 1);
  double greatest = 0;
  for (std::size_t k = 0; k < places.size(); ++k) {
    const sim::ChessboardPlace& place = places[k];
    const double height = actual.rig.plane_z_mm - place.middle.z;
    EXPECT_NEAR(height, visits.heights_mm[k / 2], flaws.height_mm);
    EXPECT_NEAR(place.middle.x, k % 2 == 0 ? -3 : 3, flaws.fence_mm + 0.01);
    EXPECT_NEAR(place.middle.y, 0, flaws.fence_mm + 0.01);
    EXPECT_NEAR(side * place.right.z, 0, 1.01 * flaws.parallel_mm);
    EXPECT_NEAR(side * place.below.z, 0, 1.01 * flaws.parallel_mm);
    EXPECT_NEAR(side * place.right.x, 0, 1.01 * flaws.fence_mm);
    EXPECT_NEAR(sim::dot(place.right, place.below), 0, 1e-12);
    if (k % 2 == 1) {
      const sim::Point3 moved = place.middle - places[k - 1].middle;
      EXPECT_NEAR(moved.x, 6, 1e-9);
      EXPECT_EQ(moved.y, 0);
      EXPECT_EQ(moved.z, 0);
      EXPECT_EQ(place.right.x, places[k - 1].right.x);
    }
    greatest = std::max(greatest, std::abs(height - visits.heights_mm[k / 2]));
  }
  EXPECT_GT(greatest, 1e-4);
  EXPECT_THROW(sim::places_on_plates(actual, {61, 3, 2.2}, visits, flaws, 3), UserError);
  EXPECT_THROW(sim::places_on_plates(actual, shape, {{0}, {0, 20}}, flaws, 3), UserError);
}

TEST(BoardPlaces, NoRoomIsRefused) {
  EXPECT_THROW(sim::chessboard_places(rig::load_rig("scanner"), {9, 7, 60}, 8, 30), UserError);
}

}  // namespace
}  // namespace selfproj::test
