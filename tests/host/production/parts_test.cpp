// Parts cut out of a stream of made profiles, placed by their edges, and classified.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "host/production/classifier.h"
#include "host/production/cutter.h"
#include "host/production/learn.h"
#include "host/production/part_reference.h"
#include "host/production/part_result.h"
#include "host/production/placement.h"
#include "host/production/tolerance.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/reference.h"
#include "tests/host/production/made_parts.h"
#include "tests/support/error_of.h"

namespace selfproj::test {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// A box 20 mm high, y from -20 to 20, as a reference that covers all of it.
production::SectionReference box_section(const rig::Rig& rig) {
  const light_section::ReferenceCurve curve{{-60, -20, -20, 20, 20, 60}, {1167, 1167, 1147, 1147, 1167, 1167}};
  const light_section::ReferenceProfile reference = light_section::reference_of_curve(rig, curve);
  return production::section_of(rig, reference, light_section::DifferentialProfiler(rig, reference));
}

TEST(Parts, AreCutByTheProfile) {
  Cut cut(rig_with_parts());
  MadeBelt belt(cut.cutter.rig(), 1);
  belt.jitter = 0.8;  // an encoder on a belt that does not run evenly
  belt.pass(cut, {.length = 30});
  belt.pass(cut, {.length = 2});  // a speck
  belt.pass(cut, {.length = 20, .turn_deg = 2});
  belt.sequence += 7;  // frames between two parts are nobody's
  belt.pass(cut, {.length = 100});
  belt.bare(cut, 5);
  ASSERT_EQ(cut.parts.size(), 4U);
  EXPECT_EQ(cut.cutter.specks(), 1U);
  EXPECT_NEAR(cut.parts[0].length_mm, 30, 0.4);
  EXPECT_NEAR(cut.parts[1].length_mm, 20 + 40 * std::sin(2 * std::numbers::pi / 180), 2.5);  // less its corners
  EXPECT_EQ(cut.parts[1].missing, 0U);
  EXPECT_TRUE(cut.parts[2].too_long);
  EXPECT_FALSE(cut.parts[3].too_long);  // the rest of it
  EXPECT_NEAR(cut.parts[2].length_mm + cut.parts[3].length_mm, 100, 1);
  for (const production::CutPart& part : cut.parts) {
    EXPECT_FALSE(part.restarted);
    // Whatever the belt did, the map is even and full: every cell inside has its height.
    const production::MapGrid& grid = part.cells.grid;
    const int middle = grid.columns / 2;
    int there = 0;
    for (int r = 0; r < grid.rows; ++r) {
      const float height = part.cells.height.row(r)[middle];
      there += std::isnan(height) ? 0 : 1;
      if (!std::isnan(height)) {
        EXPECT_NEAR(height, 20, 1e-3);
      }
    }
    EXPECT_NEAR(there * grid.pitch_mm, std::min(part.length_mm, 60.5), 3);
  }
}

TEST(Parts, ThatARunCutsOffAreTold) {
  const auto cut_off = [](const std::function<void(MadeBelt&, Cut&)>& run) {
    Cut cut(rig_with_parts());
    MadeBelt belt(cut.cutter.rig(), 2);
    run(belt, cut);
    cut.finish();
    EXPECT_EQ(cut.parts.size(), 1U);
    return !cut.parts.empty() && cut.parts[0].cut_off;
  };
  EXPECT_TRUE(cut_off([](MadeBelt& belt, Cut& cut) { belt.pass(cut, {.length = 20}, -2); }));
  EXPECT_TRUE(cut_off([](MadeBelt& belt, Cut& cut) {
    belt.bare(cut, 5);
    belt.pass(cut, {.length = 20}, -2);
  }));
  EXPECT_TRUE(cut_off([](MadeBelt& belt, Cut& cut) {
    belt.pass(cut, {.length = 20}, -2);
    belt.bare(cut, 1);
  }));
  // Both edges have come, though not the gap behind the part.
  EXPECT_FALSE(cut_off([](MadeBelt& belt, Cut& cut) { belt.pass(cut, {.length = 20}, 1); }));
}

TEST(Parts, CornersThatComeBeforeThePartIsWideEnoughAreInItsMap) {
  Cut cut(rig_with_parts());
  MadeBelt belt(cut.cutter.rig(), 1);
  belt.pass(cut, {.length = 20, .width = 40, .turn_deg = 10});
  belt.bare(cut, 5);
  ASSERT_EQ(cut.parts.size(), 1U);
  double area = 0;
  for (const float height : cut.parts[0].cells.height.values) {
    area += std::isnan(height) ? 0 : 0.25 * 0.25;
  }
  EXPECT_NEAR(area, 20 * 40, 20);
}

TEST(Parts, AreCutByDistanceAndByTrigger) {
  rig::Rig rig = rig_with_parts();
  rig.parts->cut = rig::PartCut::distance;
  rig.parts->length_mm = 25;
  Cut cut(rig);
  MadeBelt belt(rig, 1);
  belt.pass(cut, {.length = 110}, 0);
  cut.finish();
  ASSERT_EQ(cut.parts.size(), 4U);
  EXPECT_EQ(cut.cutter.specks(), 1U);  // the fifth was not complete
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(cut.parts[i].begin_mm, 25.0 * static_cast<double>(i), 0.15);
    EXPECT_FALSE(cut.parts[i].too_long);
  }

  rig.parts->cut = rig::PartCut::trigger;
  rig.parts->by_encoder = false;  // speed and time stamps
  Cut triggered(rig);
  MadeBelt other(rig, 1);
  for (int part = 0; part < 3; ++part) {
    other.pass(triggered, {.length = 15}, 1);
    other.pause(0.05);
  }
  ASSERT_EQ(triggered.parts.size(), 2U);  // the third is not known to have ended
  triggered.finish();
  ASSERT_EQ(triggered.parts.size(), 3U);
  EXPECT_NEAR(triggered.parts[1].length_mm, 17, 0.2);
  EXPECT_EQ(triggered.parts[1].missing, 0U);
}

TEST(Parts, LostFramesAndRestartsAreTold) {
  Cut cut(rig_with_parts());
  MadeBelt belt(cut.cutter.rig(), 1);
  belt.bare(cut, 5);
  for (int i = 0; i < 300; ++i) {
    belt.send(
        cut, [](double y) { return std::abs(y) < 20 ? 20 : kNone; }, 0);
    if (i == 100) {
      belt.sequence += 3;
      belt.belt_mm += 0.3;
    }
  }
  belt.sequence = 0;  // a restart
  for (int i = 0; i < 50; ++i) {
    belt.send(
        cut, [](double y) { return std::abs(y) < 20 ? 20 : kNone; }, 0);
  }
  belt.bare(cut, 5);
  ASSERT_EQ(cut.parts.size(), 1U);
  EXPECT_EQ(cut.parts[0].missing, 3U);
  EXPECT_TRUE(cut.parts[0].restarted);
  EXPECT_NEAR(cut.parts[0].length_mm, 35.3, 0.2);
}

// Without them the part would only look shorter.
TEST(Parts, FramesLostAtAnEdgeAreMissing) {
  const auto missing = [](bool leading) {
    Cut cut(rig_with_parts());
    MadeBelt belt(cut.cutter.rig(), 1);
    const auto lose = [&belt] {
      belt.sequence += 30;
      belt.belt_mm += 3;
    };
    const auto box = [](double y) { return std::abs(y) < 20 ? 20 : kNone; };
    belt.bare(cut, 5);
    if (leading) {
      lose();
    }
    for (int i = 0; i < 200; ++i) {
      belt.send(cut, box, 0);
    }
    if (!leading) {
      lose();
    }
    belt.bare(cut, 5);
    EXPECT_EQ(cut.parts.size(), 1U);
    return cut.parts.empty() ? 0 : cut.parts[0].missing;
  };
  EXPECT_EQ(missing(true), 30U);
  EXPECT_EQ(missing(false), 30U);
}

// A wall between two halves of a part hides a strip along it, here one of 2 mm. It is one part while the strip is
// narrower than gap_mm.
TEST(Parts, AShadowDoesNotSplitThem) {
  const auto height = [](double /*v*/, double w) { return std::abs(w) < 1 ? kNone : w < 0 ? 12.0 : 20.0; };
  for (const double gap : {3.0, 1.0}) {
    Cut cut(rig_with_parts());
    MadeBelt belt(cut.cutter.rig(), 7);
    belt.pass(cut, {.length = 30, .height = height});
    belt.bare(cut, 5);
    ASSERT_EQ(cut.parts.size(), 1U);
    rig::RigParts rule = *cut.cutter.rig().parts;
    rule.gap_mm = gap;
    const auto placed = production::place_by_edges(production::edges_of(cut.parts[0].cells, rule), {30.0, -20.0, 20.0});
    ASSERT_TRUE(placed);
    EXPECT_EQ(placed->width_mm && std::abs(*placed->width_mm - 40) < 0.3, gap > 2) << gap;
  }
}

TEST(Parts, ArePlacedByTheirEdges) {
  const production::Outline outline{30.0, -20.0, 20.0};
  for (const double turn : {-3.0, -0.4, 0.0, 1.5}) {
    for (const double across : {-1.3, 0.1, 2.0}) {
      SCOPED_TRACE(std::to_string(turn) + " degrees, " + std::to_string(across) + " mm");
      Cut cut(rig_with_parts());
      MadeBelt belt(cut.cutter.rig(), 7);
      // A corner is chipped off, and a bump says where everything lies.
      const auto height = [](double v, double w) {
        return v + w < -16 ? kNone : std::hypot(v - 10, w - 5) < 2 ? 21.0 : 20.0;
      };
      belt.pass(cut, {.length = 30, .height = height, .across = across, .turn_deg = turn});
      belt.bare(cut, 5);
      ASSERT_EQ(cut.parts.size(), 1U);
      const auto placed =
          production::place_by_edges(production::edges_of(cut.parts[0].cells, *cut.cutter.rig().parts), outline);
      ASSERT_TRUE(placed);
      EXPECT_EQ(placed->edges, "leading trailing left right");
      // A side edge that is turned by less than a camera column over its length looks straight.
      EXPECT_NEAR(placed->turn_rad * 180 / std::numbers::pi, turn, 0.15);
      EXPECT_NEAR(placed->across_mm, across, 0.12);
      EXPECT_NEAR(*placed->length_mm, 30, 0.15);
      EXPECT_NEAR(*placed->width_mm, 40, 0.3);
      EXPECT_LT(placed->residual_mm, 0.2);
      const production::MapGrid grid = production::placed_grid(0.25, 30, -20, 20);
      const images::FloatImage map = production::placed_heights(cut.parts[0].cells, *placed, grid);
      double along = 0, beside = 0, count = 0;
      for (int r = 0; r < grid.rows; ++r) {
        for (int c = 0; c < grid.columns; ++c) {
          if (map.row(r)[c] > 20.5F) {
            along += grid.along_of(r), beside += grid.across_of(c), count += 1;
          }
        }
      }
      EXPECT_NEAR(along / count, 10, 0.15);
      EXPECT_NEAR(beside / count, 5, 0.15);
      EXPECT_NEAR(count / 16, 4 * std::numbers::pi, 1.5);
    }
  }
}

// The part of the reference, learned from good ones.
class Classified : public ::testing::Test {
 protected:
  static production::Tolerance learned(const rig::Rig& rig, int parts, std::uint64_t seed) {
    production::Learner learner(rig, box_section(rig), {});
    Cut cut(rig);
    MadeBelt belt(rig, seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> any(-1, 1);
    for (int i = 0; i < parts; ++i) {
      belt.pass(cut, {.length = 30, .across = any(random), .turn_deg = any(random), .noise = 0.03});
    }
    belt.bare(cut, 5);
    for (production::CutPart& part : cut.parts) {
      learner.add(std::move(part));
    }
    return learner.learn("good");
  }

  production::PartResult classify(const MadePart& part) {
    Cut cut(rig_);
    MadeBelt belt(rig_, 99);
    belt.pass(cut, part);
    belt.bare(cut, 5);
    EXPECT_EQ(cut.parts.size(), 1U);
    return cut.parts.size() == 1 ? classifier_.classify(cut.parts[0], maps_) : production::PartResult{};
  }

  rig::Rig rig_ = rig_with_parts();
  production::Tolerance tolerance_ = learned(rig_, 12, 5);
  production::Classifier classifier_{rig_, box_section(rig_), tolerance_, "t.yaml"};
  production::PlacedMaps maps_;
};

TEST_F(Classified, GoodPartsAreOk) {
  ASSERT_EQ(tolerance_.regions.size(), 1U);
  EXPECT_NEAR(tolerance_.length_mm, 30, 0.2);
  EXPECT_NEAR(tolerance_.right_mm - tolerance_.left_mm, 40, 0.4);
  EXPECT_LT(tolerance_.regions[0].high_mm, 0.12);
  EXPECT_GT(tolerance_.regions[0].low_mm, -0.12);
  for (const double turn : {-0.9, 0.0, 0.7}) {
    const production::PartResult result = classify({.length = 30, .across = turn, .turn_deg = turn, .noise = 0.03});
    EXPECT_EQ(result.verdict, production::Verdict::good) << result.reason;
    EXPECT_TRUE(result.defects.empty());
    EXPECT_NEAR(result.regions.at(0).mean_mm, 0, 0.01);
  }
}

TEST_F(Classified, DefectsAreFoundWithPlaceSizeAndDepth) {
  const auto height = [](double v, double w) {
    if (std::hypot(v - 8, w + 10) < 1.5) {
      return 19.7;
    }
    return std::abs(v - 20) < 2 && std::abs(w - 12) < 1 ? 20.4 : 20.0;
  };
  const production::PartResult result =
      classify({.length = 30, .height = height, .across = 0.8, .turn_deg = -0.9, .noise = 0.02});
  EXPECT_EQ(result.verdict, production::Verdict::bad);
  ASSERT_EQ(result.defects.size(), 2U);
  const production::Defect& bump = result.defects[0];
  EXPECT_NEAR(bump.along_mm, 20, 0.2);
  EXPECT_NEAR(bump.across_mm, 12, 0.25);
  EXPECT_NEAR(bump.area_mm2, 8, 2.5);
  EXPECT_NEAR(bump.size_along_mm, 4, 0.6);
  EXPECT_NEAR(bump.depth_mm, 0.4, 0.06);
  const production::Defect& dent = result.defects[1];
  EXPECT_NEAR(dent.along_mm, 8, 0.2);
  EXPECT_NEAR(dent.across_mm, -10, 0.25);
  EXPECT_NEAR(dent.area_mm2, 2.25 * std::numbers::pi, 2.5);
  EXPECT_NEAR(dent.depth_mm, -0.3, 0.06);
  EXPECT_EQ(result.reason.rfind("2 defects; the largest, ", 0), 0U) << result.reason;
}

// A pattern jumps where its part has a wall, and then lights the surface of a part that lies shifted. The line of a
// laser jumps nowhere: columns in which the good part hid it take nothing from a part that lies elsewhere.
TEST_F(Classified, OnlyAPatternJumpsOnAShiftedPart) {
  production::SectionReference gap = box_section(rig_);
  for (std::size_t i = gap.across_mm.size(); i-- > 0;) {
    if (gap.across_mm[i] > -22 && gap.across_mm[i] < -18.8) {
      gap.across_mm.erase(gap.across_mm.begin() + static_cast<std::ptrdiff_t>(i));
      gap.height_mm.erase(gap.height_mm.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }
  rig::Rig laser = rig_;
  laser.light_plane = rig::RigLightPlane{.normal = {0, 0.6, 0.8}, .distance_mm = 0.8 * rig_.plane_z_mm};
  const auto shifted = [&](const rig::Rig& rig) {
    Cut cut(rig_);
    MadeBelt belt(rig_, 99);
    belt.pass(cut, {.length = 30, .across = -1.5, .noise = 0.02});
    belt.bare(cut, 5);
    return production::Classifier(rig, gap, tolerance_, "t.yaml").classify(cut.parts.at(0), maps_);
  };
  const production::PartResult by_pattern = shifted(rig_);
  EXPECT_EQ(by_pattern.verdict, production::Verdict::inconclusive);
  EXPECT_GT(by_pattern.regions.at(0).missing, 0.03);
  const production::PartResult by_laser = shifted(laser);
  EXPECT_EQ(by_laser.verdict, production::Verdict::good) << by_laser.reason;
  EXPECT_EQ(by_laser.regions.at(0).missing, 0);
}

TEST_F(Classified, WhatCannotBeSeenCannotBeTold) {
  const production::PartResult holes =
      classify({.length = 30, .height = [](double v, double w) { return v > 10 && v < 14 && w > 0 ? kNone : 20.0; }});
  EXPECT_EQ(holes.verdict, production::Verdict::inconclusive);
  EXPECT_NE(holes.reason.find("of region 'surface 1' are missing"), std::string::npos) << holes.reason;
  const production::PartResult shifted = classify({.length = 30, .across = 4});
  EXPECT_EQ(shifted.verdict, production::Verdict::inconclusive);
  EXPECT_EQ(shifted.reason.rfind("is shifted across by ", 0), 0U) << shifted.reason;
  const production::PartResult turned = classify({.length = 30, .turn_deg = 5});
  EXPECT_EQ(turned.reason.rfind("is turned by ", 0), 0U) << turned.reason;
  const production::PartResult short_one = classify({.length = 25});
  EXPECT_EQ(short_one.reason.rfind("its edges do not fit by ", 0), 0U) << short_one.reason;
  EXPECT_EQ(short_one.verdict, production::Verdict::inconclusive);
}

TEST_F(Classified, ToleranceIsReadBackAndItsFaultsAreNamed) {
  const std::string yaml = production::to_yaml(tolerance_);
  EXPECT_EQ(production::to_yaml(production::parse_tolerance(yaml, "t.yaml")), yaml);
  // Keys of earlier files.
  std::string old = yaml;
  for (const auto& [key, before] :
       {std::pair{"max_shift_mm", "most_shift_mm"}, std::pair{"max_turn_deg", "most_turn_deg"},
        std::pair{"max_residual_mm", "most_residual_mm"}, std::pair{"min_defect_mm2", "smallest_defect_mm2"},
        std::pair{"max_missing", "most_missing"}}) {
    old.replace(old.find(key), std::string(key).size(), before);
  }
  EXPECT_EQ(production::to_yaml(production::parse_tolerance(old, "t.yaml")), yaml);
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = yaml;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, text.find('\n', at) - at, to);
    return error_of([&] { production::parse_tolerance(text, "t.yaml"); });
  };
  EXPECT_NE(with("length_mm: ", "length_mm: -3").find("part.length_mm is -3"), std::string::npos);
  EXPECT_NE(with("corners_mm: ", "corners_mm: [0, 0, 300, 0, 0, 10]")
                .find("region 'surface 1' reaches (300, 0) mm; the part's map is from (-2, "),
            std::string::npos);
  EXPECT_NE(with("corners_mm: ", "corners_mm: [0, 0, 5, 5, 10, 10]").find("has no area"), std::string::npos);
  EXPECT_NE(with("corners_mm: ", "corners_mm: [0, 0, 5]").find("three corners"), std::string::npos);
  EXPECT_NE(with("low_mm: ", "low_mm: 7").find("high_mm must be greater"), std::string::npos);
  EXPECT_NE(with("max_missing: ", "max_mising: 0").find("unknown key"), std::string::npos);
  EXPECT_NE(error_of([] { production::parse_tolerance("part: 3", "t.yaml"); }).find("regions must be a list"),
            std::string::npos);
  EXPECT_EQ(error_of([] { production::parse_tolerance("[1]", "t.yaml"); }),
            "t.yaml: is not a tolerance; keys and values are expected");

  const light_section::ReferenceProfile plane =
      light_section::reference_of_curve(rig_, {{-60, 60}, {rig_.plane_z_mm, rig_.plane_z_mm}});
  const production::SectionReference other =
      production::section_of(rig_, plane, light_section::DifferentialProfiler(rig_, plane));
  EXPECT_NE(error_of([&] {
              production::Classifier(rig_, other, tolerance_, "t.yaml");
            }).find("t.yaml: is for another part: at "),
            std::string::npos);
  EXPECT_EQ(error_of([&] { learned(rig_, 3, 1); }), "good: 3 good parts came; at least 5 are needed");
}

// A side that light or camera never reaches where parts pass is not where the reference has it.
TEST(Parts, AHiddenSideIsLearned) {
  const rig::Rig rig = rig_with_parts();
  production::Learner learner(rig, box_section(rig), {});
  Cut cut(rig);
  MadeBelt belt(rig, 7);
  for (const double across : {-0.5, -0.3, 0.0, 0.2, 0.4, 0.5}) {
    const auto height = [](double, double w) { return w > 15 ? kNone : 20.0; };
    belt.pass(cut, {.length = 30, .height = height, .across = across, .noise = 0.03});
  }
  belt.bare(cut, 5);
  ASSERT_EQ(cut.parts.size(), 6U);
  for (const production::CutPart& part : cut.parts) {
    learner.add(production::CutPart(part));
  }
  const production::Tolerance tolerance = learner.learn("good");
  EXPECT_NEAR(tolerance.left_mm, -20, 0.3);
  EXPECT_NEAR(tolerance.right_mm, 15, 0.3);
  production::PlacedMaps maps;
  const production::Classifier classifier(rig, box_section(rig), tolerance, "t.yaml");
  for (const production::CutPart& part : cut.parts) {
    const production::PartResult result = classifier.classify(part, maps);
    EXPECT_EQ(result.verdict, production::Verdict::good) << result.reason;
  }
}

// Where good parts show no height, as by a shadow or a second line in the column, there is no region. Around it there
// is: what is behind the shadow is inspected, and no points may be missing there.
TEST(Parts, WhatGoodPartsDoNotShowIsNoRegion) {
  const rig::Rig rig = rig_with_parts();
  const auto from_an_end = [](double v, double w) { return v < 12 && w > 6 && w < 10; };
  const auto in_the_middle = [](double v, double w) { return v > 9 && v < 12 && w > 6 && w < 10; };
  const auto slanting = [](double v, double w) { return std::abs(v - w - 12) < 2 && v < 16; };
  const std::vector<std::pair<std::function<bool(double, double)>, double>> shadows = {
      {from_an_end, 12 * (4 + 3)}, {in_the_middle, 12 * (4 + 3)}, {slanting, 150}};
  for (const auto& [shadow, area] : shadows) {
    const auto part = [&unseen = shadow](double bump, double across) {
      const auto height = [=](double v, double w) {
        const bool speck = std::hypot(v - 20, w + 10) < 0.4;
        return unseen(v, w) || speck ? kNone : 20 + (std::hypot(v - 22, w - 8) < 1.5 ? bump : 0);
      };
      return MadePart{.length = 30, .height = height, .across = across, .noise = 0.02};
    };
    Cut cut(rig);
    MadeBelt belt(rig, 7);
    for (const double across : {-0.5, -0.3, 0.0, 0.2, 0.4, 0.5}) {
      belt.pass(cut, part(0, across));
    }
    belt.pass(cut, part(0.4, 0.3));
    belt.bare(cut, 5);
    ASSERT_EQ(cut.parts.size(), 7U);
    production::Learner learner(rig, box_section(rig), {});
    for (std::size_t i = 0; i < 6; ++i) {
      learner.add(production::CutPart(cut.parts[i]));
    }
    production::LearnRemarks remarks;
    const production::Tolerance tolerance = learner.learn("good", &remarks);
    EXPECT_NEAR(remarks.unseen_mm2, area, 15);
    EXPECT_NEAR(remarks.regions_mm2, 27 * 37, 25);
    EXPECT_TRUE(remarks.doubts.empty());
    for (const production::ToleranceRegion& region : tolerance.regions) {
      EXPECT_LT(region.max_missing, 0.02);  // the speck stays in its region
    }
    production::PlacedMaps maps;
    const production::Classifier classifier(rig, box_section(rig), tolerance, "t.yaml");
    for (std::size_t i = 0; i < 6; ++i) {
      EXPECT_EQ(classifier.classify(cut.parts[i], maps).verdict, production::Verdict::good);
    }
    const production::PartResult bad = classifier.classify(cut.parts[6], maps);
    EXPECT_EQ(bad.verdict, production::Verdict::bad);
    ASSERT_EQ(bad.defects.size(), 1U);
    EXPECT_NEAR(bad.defects[0].along_mm, 22, 0.3);
    EXPECT_NEAR(bad.defects[0].across_mm, 8, 0.3);
  }
}

// Parts with two levels, compared with a box: the band of the region holds both.
TEST(Parts, AReferenceOfOtherPartsIsTold) {
  const rig::Rig rig = rig_with_parts();
  const auto doubts = [&](const production::SectionReference& section,
                          const std::function<double(double, double)>& height) {
    production::Learner learner(rig, section, {});
    Cut cut(rig);
    MadeBelt belt(rig, 7);
    for (int i = 0; i < 6; ++i) {
      belt.pass(cut, {.length = 30, .height = height, .noise = 0.03});
    }
    belt.bare(cut, 5);
    for (production::CutPart& part : cut.parts) {
      learner.add(std::move(part));
    }
    production::LearnRemarks remarks;
    (void)learner.learn("good", &remarks);
    return remarks.doubts;
  };
  const production::SectionReference box = box_section(rig);
  EXPECT_TRUE(doubts(box, [](double, double) { return 20.0; }).empty());
  for (const double left : {12.0, 13.0}) {  // with a step, and all of it further away
    const std::vector<std::string> told =
        doubts(box, [&](double, double w) { return left == 12.0 && w > 0 ? 20.0 : left; });
    ASSERT_EQ(told.size(), 1U);
    EXPECT_TRUE(told[0].starts_with("in region 'surface 1' each good part is -")) << told[0];
  }
  // A reference that shows the left half of the parts alone
  production::SectionReference half = box;
  for (std::size_t i = 0; i < half.height_mm.size(); ++i) {
    half.height_mm[i] = half.across_mm[i] > 0 ? kNone : half.height_mm[i];
  }
  const std::vector<std::string> told = doubts(half, [](double, double) { return 20.0; });
  ASSERT_EQ(told.size(), 1U);
  EXPECT_NE(told[0].find("% of the parts' width the reference shows nothing"), std::string::npos) << told[0];
}

// Eleven good parts, and one that is not whole, first or last.
TEST(Parts, APartCutShortIsLeftOutOfTheTolerance) {
  const rig::Rig rig = rig_with_parts();
  const auto from = [](double first, double last) {
    return [=](double v, double) { return v >= first && v <= last ? 20.0 : kNone; };
  };
  const auto learn = [&](const MadePart& odd, int place, production::LearnRemarks& remarks) {
    production::Learner learner(rig, box_section(rig), {});
    Cut cut(rig);
    MadeBelt belt(rig, 7);
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> any(-1, 1);
    for (int i = 0; i < 12; ++i) {
      MadePart part{.length = 30, .noise = 0.03};
      if (i == place) {
        part.length = odd.length, part.width = odd.width, part.height = odd.height;
      }
      part.across = any(random), part.turn_deg = any(random);
      belt.pass(cut, part);
    }
    belt.bare(cut, 5);
    for (production::CutPart& part : cut.parts) {
      learner.add(std::move(part));
    }
    return learner.learn("good", &remarks);
  };
  const std::vector<MadePart> odd_ones = {{.length = 28},
                                          {.length = 15},
                                          {.length = 6},
                                          {.length = 30, .width = 20},
                                          {.length = 30, .height = from(0, 15)},
                                          {.length = 30, .height = from(15, 30)},
                                          {.length = 45}};
  for (const MadePart& odd : odd_ones) {
    for (const int place : {0, 11}) {
      SCOPED_TRACE(std::to_string(odd.length) + " x " + std::to_string(odd.width) + " in place " +
                   std::to_string(place));
      production::LearnRemarks remarks;
      const production::Tolerance tolerance = learn(odd, place, remarks);
      ASSERT_EQ(remarks.left_out.size(), 1U);
      const std::string& reason = remarks.left_out[0];
      EXPECT_EQ(reason.rfind("part " + std::to_string(place + 1) + " of 12: ", 0), 0U) << reason;
      EXPECT_EQ(remarks.unseen_mm2, 0);
      EXPECT_NEAR(tolerance.length_mm, 30, 0.2);
      EXPECT_NEAR(tolerance.right_mm - tolerance.left_mm, 40, 0.4);
      ASSERT_EQ(tolerance.regions.size(), 1U);
      EXPECT_LT(tolerance.regions[0].high_mm, 0.12);
      EXPECT_GT(tolerance.regions[0].low_mm, -0.12);
      EXPECT_LT(tolerance.regions[0].max_missing, 0.05);
    }
  }
}

TEST(Parts, FiguresOverParts) {
  production::RunningFigures figures;
  for (int i = 0; i < 1000; ++i) {
    figures.add(1e6 + 0.5 * i + (i % 2 == 0 ? 1 : -1));
  }
  EXPECT_NEAR(figures.mean(), 1e6 + 0.5 * 499.5, 1e-6);
  EXPECT_NEAR(figures.trend(), 0.5, 1e-4);
  EXPECT_NEAR(*figures.trend_error(), std::sqrt(12 / (1000.0 * 1000 * 1000)), 1e-6);  // of residuals of ±1
  EXPECT_NEAR(figures.spread(), std::sqrt(0.25 * 1000 * 1001 / 12 + 1), 0.1);
}

TEST(Parts, RigsSayHowTheyAreCut) {
  const rig::Rig rig = rig_with_parts();
  const std::string yaml = rig::to_yaml(rig);
  EXPECT_EQ(rig::to_yaml(rig::parse_rig(yaml, "rig.yaml")), yaml);
  const auto error_with = [&](const std::string& from, const std::string& to) {
    std::string text = yaml;
    text.replace(text.find(from), from.size(), to);
    return error_of([&] { production::ProfileCutter(rig::parse_rig(text, "rig.yaml")); });
  };
  EXPECT_NE(error_with("cut: profile", "cut: time").find("parts.cut is 'time'"), std::string::npos);
  EXPECT_NE(error_with("grid_mm: 0.25", "grid_mm: 0.2").find("columns are 0.2334 mm apart"), std::string::npos);
  EXPECT_NE(error_with("  min_length_mm: 5", "  min_length_mm: 70").find("it must be greater"), std::string::npos);
  EXPECT_NE(error_of([] { production::ProfileCutter(rig::load_rig("light-section")); }).find("has no section `parts`"),
            std::string::npos);
}

}  // namespace
}  // namespace selfproj::test
