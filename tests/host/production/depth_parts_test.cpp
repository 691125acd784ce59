// Parts of depth images: cut, laid on an even grid, classified against a reference that is a map.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "host/production/classifier.h"
#include "host/production/cutter.h"
#include "host/production/height_map.h"
#include "host/production/learn.h"
#include "host/production/tolerance.h"
#include "selfproj/model/packet.h"
#include "selfproj/model/pixel_clock.h"
#include "selfproj/rig/rig.h"
#include "tests/support/error_of.h"

namespace selfproj::test {
namespace {

constexpr int kPatterns = 8;
constexpr double kPlane = 550;

// z of the surface at a place (x, y), mm.
using Surface = std::function<double(double, double)>;

rig::Rig small_scanner(rig::PartCut cut = rig::PartCut::image) {
  rig::Rig rig = rig::load_rig("scanner");
  rig.camera.rows = 96;
  rig.camera.columns = 128;  // 117 mm wide on the plane
  rig.parts = rig::RigParts{.cut = cut, .grid_mm = 1, .pause_s = 0.02};
  return rig;
}

// The plane, and a step 30 mm high where y > 10 mm.
double step(double /*x*/, double y) { return y > 10 ? kPlane - 30 : kPlane; }

// What the camera sees, by fixed-point iteration along each ray; the surfaces here are level but at their walls.
images::FloatImage depth_of(const rig::Rig& rig, const Surface& surface, double noise, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> error(0, noise);
  images::FloatImage depth(rig.camera.rows, rig.camera.columns);
  const double scale = rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
  for (int r = 0; r < depth.rows; ++r) {
    for (int c = 0; c < depth.columns; ++c) {
      const double x = (r - 0.5 * (depth.rows - 1)) * scale;
      const double y = (c - 0.5 * (depth.columns - 1)) * scale;
      double z = kPlane;
      for (int i = 0; i < 4; ++i) {
        z = surface(x * z, y * z);
      }
      depth.row(r)[c] = static_cast<float>(z + error(random));
    }
  }
  return depth;
}

model::PacketHeader header_of(std::uint64_t sequence, double seconds) {
  model::PacketHeader header;
  header.sequence = sequence;
  header.time_stamp = static_cast<std::uint64_t>(seconds * model::kDefaultPixelClockHz);
  return header;
}

class DepthParts : public ::testing::Test {
 protected:
  DepthParts() : rig_(small_scanner()), reference_(production::DepthGrid(rig_).cells(depth_of(rig_, step, 0, 1))) {}

  production::CutPart part(const Surface& surface, std::uint64_t seed) {
    production::DepthCutter cutter(rig_, kPatterns);
    return cutter.add(header_of(2 * kPatterns - 1, 1), depth_of(rig_, surface, 0.3, seed), 5).value();
  }

  production::Tolerance learned() {
    production::Learner learner(rig_, reference_, {.min_defect_mm2 = 9, .edge_mm = 3});
    for (std::uint64_t i = 0; i < 8; ++i) {
      learner.add(part(step, i));
    }
    return learner.learn("good");
  }

  rig::Rig rig_;
  production::HeightCells reference_;
};

TEST_F(DepthParts, MapsAreEvenAndTrue) {
  const production::CutPart cut = part(step, 1);
  EXPECT_EQ(cut.first, 8U);
  EXPECT_EQ(cut.last, 15U);
  EXPECT_EQ(cut.last_ns, 5);
  const production::MapGrid& grid = cut.cells.grid;
  EXPECT_EQ(grid.pitch_mm, 1);
  const double pixel = kPlane * rig_.camera.pixel_pitch_mm / rig_.camera.focal_length_mm;
  int there = 0;
  for (int r = 0; r < grid.rows; ++r) {
    for (int c = 0; c < grid.columns; ++c) {
      const float height = cut.cells.height.row(r)[c];
      const double across = grid.across_of(c);
      // Cells beside the wall have points of both sides.
      if (!std::isnan(height) && std::abs(across - 10) > 2) {
        EXPECT_NEAR(height, across > 10 ? 30 : 0, 2) << r << ", " << c;
        ++there;
      }
    }
  }
  EXPECT_GT(there, 0.85 * rig_.camera.rows * pixel * rig_.camera.columns * pixel);
}

TEST_F(DepthParts, LearnsARegionForEachSurface) {
  const production::Tolerance tolerance = learned();
  EXPECT_FALSE(tolerance.by_edges);
  ASSERT_EQ(tolerance.regions.size(), 2U);
  EXPECT_EQ(production::parse_tolerance(production::to_yaml(tolerance), "text").regions.size(), 2U);
  for (const production::ToleranceRegion& region : tolerance.regions) {
    double left = 1e9;
    double right = -1e9;
    for (std::size_t i = 1; i < region.corners_mm.size(); i += 2) {
      left = std::min(left, region.corners_mm[i]);
      right = std::max(right, region.corners_mm[i]);
    }
    EXPECT_TRUE(right < 10 || left > 10) << left << " to " << right;  // none reaches over the wall
    EXPECT_GT(right - left, 25);
    EXPECT_LT(region.low_mm, 0);
    EXPECT_GT(region.low_mm, -1);
    EXPECT_GT(region.high_mm, 0);
    EXPECT_LT(region.high_mm, 1);
    EXPECT_LT(region.max_missing, 0.05);
  }
}

TEST_F(DepthParts, FindsWhatIsPlanted) {
  const production::Tolerance tolerance = learned();
  const production::Classifier classifier(rig_, reference_, tolerance, "tolerance");
  production::PlacedMaps maps;
  for (std::uint64_t seed = 100; seed < 110; ++seed) {
    const production::PartResult good = classifier.classify(part(step, seed), maps);
    EXPECT_EQ(good.verdict, production::Verdict::good) << good.reason;
  }
  // A dent of 6 mm, 3 mm deep, on the plane at (20, -30).
  const Surface dented = [](double x, double y) { return step(x, y) + (std::hypot(x - 20, y + 30) < 6 ? 3 : 0); };
  const production::PartResult bad = classifier.classify(part(dented, 7), maps);
  ASSERT_EQ(bad.verdict, production::Verdict::bad) << bad.reason;
  ASSERT_EQ(bad.defects.size(), 1U);
  const production::Defect& dent = bad.defects.front();
  const double along = 20 + 0.5 * production::DepthGrid(rig_).length_mm();
  EXPECT_NEAR(dent.along_mm, along, 1);
  EXPECT_NEAR(dent.across_mm, -30, 1);
  EXPECT_NEAR(dent.size_across_mm, 12, 2);
  EXPECT_NEAR(dent.depth_mm, -3, 1);
  EXPECT_NEAR(maps.difference.row(
                  static_cast<int>(std::lround(maps.grid.row_of(along))))[std::lround(maps.grid.column_of(-30))],
              -3, 1.5);
  // A part of which the camera sees too little.
  production::CutPart hidden = part(step, 8);
  for (int r = 20; r < 60; ++r) {
    std::fill_n(hidden.cells.height.row(r), 40, images::kNoValue);
  }
  const production::PartResult unknown = classifier.classify(hidden, maps);
  EXPECT_EQ(unknown.verdict, production::Verdict::inconclusive);
  EXPECT_NE(unknown.reason.find("are missing"), std::string::npos) << unknown.reason;
}

TEST_F(DepthParts, RefusesOtherTolerancesAndRigs) {
  production::Tolerance tolerance = learned();
  const auto refused = [&] {
    return error_of([&] { const production::Classifier classifier(rig_, reference_, tolerance, "file"); });
  };
  EXPECT_EQ(refused(), "none");
  tolerance.by_edges = true;
  EXPECT_NE(refused().find("file: part.place_by is edges"), std::string::npos) << refused();
  tolerance.by_edges = false;
  for (double& height : tolerance.section_mm) {
    height += 50;
  }
  EXPECT_NE(refused().find("file: is for another part"), std::string::npos) << refused();
  tolerance = learned();
  tolerance.right_mm += 30;
  EXPECT_NE(refused().find("file: its part is"), std::string::npos) << refused();
  rig_.parts->grid_mm = 0.5;
  EXPECT_NE(error_of([&] { const production::DepthGrid grid(rig_); }).find("parts.grid_mm is 0.5"), std::string::npos);
}

TEST(DepthCutter, APauseEndsAPartThatIsTheMeanOfItsImages) {
  const rig::Rig rig = small_scanner(rig::PartCut::trigger);
  std::vector<production::CutPart> parts;
  production::DepthCutter cutter(rig, kPatterns);
  const auto keep = [&](std::optional<production::CutPart> part) {
    if (part) {
      parts.push_back(std::move(*part));
    }
  };
  std::uint64_t sequence = kPatterns - 1;
  double seconds = 0;
  const auto show = [&](int images, double z, double hole = 0) {
    for (int i = 0; i < images; ++i, sequence += 2, seconds += 0.002) {
      images::FloatImage depth(rig.camera.rows, rig.camera.columns, static_cast<float>(z + (i % 2 == 0 ? 1 : -1)));
      if (i >= hole) {
        depth.row(40)[50] = images::kNoValue;
      }
      keep(cutter.add(header_of(sequence, seconds), depth, 1000 + static_cast<std::int64_t>(sequence)));
    }
  };
  show(8, 540, 100);
  seconds += 0.1;
  show(4, 500, 100);  // too short: codes of both parts are in all of its images
  seconds += 0.1;
  sequence += 10;  // lost, and no part of what follows
  show(10, 530, 100);
  EXPECT_TRUE(cutter.in_part());
  ASSERT_EQ(parts.size(), 1U);
  keep(cutter.finish());
  keep(cutter.finish());  // there is nothing more
  EXPECT_FALSE(cutter.in_part());
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(cutter.specks(), 1U);
  EXPECT_EQ(parts[0].first, 0U);
  EXPECT_EQ(parts[0].last, 7U + 14);
  EXPECT_EQ(parts[0].last_ns, 1000 + 21);
  // Four pairs of the third part are left out, and 6 images remain.
  EXPECT_EQ(parts[1].last + 1 - parts[1].first, kPatterns + 2 * 5U);
  for (const auto& [part, height] : {std::pair(&parts[0], 10.0), std::pair(&parts[1], 20.0)}) {
    const images::FloatImage& map = part->cells.height;
    EXPECT_NEAR(map.row(map.rows / 2)[map.columns / 2], height, 1e-3);
  }
}

// Frames that are lost take time, too, and are no pause.
TEST(DepthCutter, LostImagesAreNoPause) {
  const rig::Rig rig = small_scanner(rig::PartCut::trigger);
  production::DepthCutter cutter(rig, kPatterns);
  const images::FloatImage depth(rig.camera.rows, rig.camera.columns, 540);
  for (std::uint64_t sequence = 7; sequence < 400; sequence += sequence == 107 ? 102 : 2) {
    EXPECT_FALSE(cutter.add(header_of(sequence, static_cast<double>(sequence) * 0.001), depth, 0));
  }
  const std::optional<production::CutPart> part = cutter.finish();
  ASSERT_TRUE(part);
  EXPECT_EQ(part->missing, 100U);
}

}  // namespace
}  // namespace selfproj::test
