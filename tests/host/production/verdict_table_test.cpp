// Tables for the verdict of the circuit: against the profiler's own heights; files; the verdict on the host.
#include "host/production/verdict_table.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "host/production/height_map.h"
#include "host/production/part_reference.h"
#include "host/production/verdict_file.h"
#include "host/production/verdict_run.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/rig/rig.h"
#include "tests/host/production/made_parts.h"
#include "tests/support/error_of.h"

namespace selfproj::test {
namespace {

using production::Tolerance;
using production::ToleranceRegion;
using production::VerdictOptions;
using production::VerdictTable;
using production::VerdictTables;

ToleranceRegion rectangle(const std::string& name, double along0, double along1, double across0, double across1,
                          double low, double high) {
  return {.name = name,
          .corners_mm = {along0, across0, along1, across0, along1, across1, along0, across1},
          .low_mm = low,
          .high_mm = high,
          .max_missing = 0.1};
}

// A rig, the reference of a good part, and its tolerance.
struct GoodPart {
  rig::Rig rig;
  light_section::ReferenceProfile reference;
  Tolerance tolerance;
};

Tolerance tolerance_of(std::vector<ToleranceRegion> regions, double half_width) {
  Tolerance tolerance;
  tolerance.length_mm = 40;
  tolerance.left_mm = -half_width;
  tolerance.right_mm = half_width;
  tolerance.max_shift_mm = 2;
  tolerance.max_turn_deg = 3;
  tolerance.max_residual_mm = 1;
  tolerance.min_defect_mm2 = 0.5;
  tolerance.regions = std::move(regions);
  return tolerance;
}

// Two treads, one of which rises across, under their own pattern.
GoodPart treads() {
  GoodPart setup;
  setup.rig = rig_with_parts();
  std::vector<double> heights(static_cast<std::size_t>(setup.rig.camera.columns), 0.0);
  for (std::size_t i = 0; i < heights.size(); ++i) {
    const double y = 0.2334 * (static_cast<double>(i) - 255.5);
    heights[i] = std::abs(y) > 22 ? 0 : y < 0 ? 12 + 0.2 * y : 20;
  }
  setup.reference = light_section::reference_of_curve(setup.rig, light_section::curve_of_heights(setup.rig, heights));
  setup.tolerance =
      tolerance_of({rectangle("slope", 2, 38, -20, -2, -0.04, 0.05), rectangle("top", 2, 38, 2, 20, -0.03, 0.02),
                    rectangle("seat", 15, 25, 8, 12, -0.01, 0.3)},
                   22);
  return setup;
}

// A part of 8 mm on the plane, whose straight line is projected, seen by few rows of the sensor.
GoodPart block_in_region() {
  GoodPart setup;
  setup.rig = rig_with_parts();
  setup.rig.camera.region = rig::RigRegion{
      .row_offset = 50, .rows = 40, .column_offset = 64, .columns = 400, .frame_rate_hz = 10000, .exposure_s = 9e-5};
  setup.reference = light_section::reference_of_plane(setup.rig);
  setup.tolerance = tolerance_of({rectangle("block", 2, 38, -18, 18, 7.95, 8.04)}, 20);
  return setup;
}

// Under a laser, with lens and leaning camera.
GoodPart laser() {
  GoodPart setup;
  setup.rig = rig::load_any_rig("laser");
  setup.rig.parts = production::usual_parts(setup.rig, true);
  setup.reference = light_section::reference_of_plane(setup.rig);
  const production::BeltView view = production::belt_view(setup.rig);
  const double half = 0.4 * std::min(-view.left_mm, view.right_mm);
  setup.rig.parts->length_mm = 60;
  setup.tolerance = tolerance_of({rectangle("block", 2, 38, -half, half, 4.9, 5.2)}, half + 1);
  return setup;
}

VerdictOptions evenly() { return {.start = 5500, .pitch = 9000}; }

// Random centroids of all columns, beside the limits above all. Returns how many were judged.
std::uint64_t compare_with_profiler(const GoodPart& setup, const VerdictTable& table, double shift_mm,
                                    std::uint64_t seed) {
  rig::Rig rig = setup.rig;
  rig.camera.region.reset();
  const light_section::DifferentialProfiler profiler(rig, setup.reference);
  const production::SectionReference section = production::section_of(rig, setup.reference, profiler);
  const double widest = 3 * production::pixel_mm(rig);
  const int columns = rig.camera.columns;
  model::Moments moments;
  moments.resize(columns);
  light_section::Profile profile;
  profile.resize(columns);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> beside(-0.05, 0.05);
  std::uint64_t judged = 0;
  for (const VerdictTable::Section& limits_of : table.sections) {
    for (int round = 0; round < 40; ++round) {
      for (int c = 0; c < table.columns; ++c) {
        const model::ColumnLimits& limits = limits_of.limits[static_cast<std::size_t>(c)];
        const std::uint32_t edge = round % 2 == 0 ? limits.low : limits.high;
        const double row = static_cast<double>(edge) / model::kRowParts + beside(random) + table.row_offset;
        const auto m0 = static_cast<std::uint32_t>(1000 + random() % 100'000);
        const auto at = static_cast<std::size_t>(c + table.column_offset);
        moments.m0[at] = m0;
        moments.m1[at] = static_cast<std::uint32_t>(std::lround(m0 * std::max(1.0, row)));
        moments.n[at] = static_cast<std::uint32_t>(rig.measure.min_lit_px);
      }
      profiler.profile(moments.view(), profile.view());
      for (int c = 0; c < table.columns; ++c) {
        const model::ColumnLimits& limits = limits_of.limits[static_cast<std::size_t>(c)];
        const auto at = static_cast<std::size_t>(c + table.column_offset);
        if (!limits.judged) {
          continue;
        }
        ++judged;
        // As the host has it: the height, less that of the reference there
        const double across = static_cast<double>(profile.y[at]) - shift_mm;
        const double difference = rig.plane_z_mm - static_cast<double>(profile.z[at]) - section.at(across, widest);
        // Of the frame, as the circuit has it
        const auto m1 = moments.m1[at] - static_cast<std::uint32_t>(table.row_offset) * moments.m0[at];
        const model::ColumnState state = model::column_state(limits, 0, moments.m0[at], m1);
        const bool out = state == model::ColumnState::above || state == model::ColumnState::below;
        bool within = true;   // of all regions that have this place
        bool outside = true;  // by more than limits are rounded by, of one that has it
        double low = -1e9;
        double high = 1e9;
        for (const ToleranceRegion& region : setup.tolerance.regions) {
          if (across >= region.corners_mm[1] && across <= region.corners_mm[5] &&
              // the middle of the part; the seat is not along all of it
              (region.name != "seat" || &limits_of == &table.sections[table.sections.size() / 2])) {
            low = std::max(low, region.low_mm);
            high = std::min(high, region.high_mm);
          }
        }
        within = difference >= low && difference <= high;
        const double rounding = 2.0 / model::kRowParts * std::abs(table.row_mm) + 0.002;
        outside = difference < low - rounding || difference > high + rounding;
        EXPECT_FALSE(within && out) << "column " << c << ": " << difference << " of " << low << " to " << high;
        if (table.play_across_mm == 0 && setup.tolerance.regions.size() == 1) {
          EXPECT_FALSE(outside && !out) << "column " << c << ": " << difference << " of " << low << " to " << high;
        }
        if (out) {
          EXPECT_EQ(state == model::ColumnState::below, (difference > 0.5 * (low + high)) == (table.row_mm > 0));
        }
      }
    }
  }
  return judged;
}

TEST(VerdictTables, WhatIsWithinTheToleranceIsNeverOut) {
  for (const GoodPart& setup : {treads(), block_in_region(), laser()}) {
    for (const double play : {0.0, 0.25}) {
      for (const double shift : {0.0, -1.3, 2.0}) {
        VerdictOptions options = evenly();
        options.play_across_mm = play;
        const VerdictTables tables(setup.rig, setup.reference, setup.tolerance, options, "tolerance");
        const VerdictTable table = tables.table(shift);
        EXPECT_GT(compare_with_profiler(setup, table, shift, 1), 1000U) << setup.rig.name;
        // A part that lies beside its place, as far as there is play, has other differences, but none of them is out.
        compare_with_profiler(setup, table, shift + play, 2);
        compare_with_profiler(setup, table, shift - play, 3);
      }
    }
  }
}

// On a belt that runs askew, columns meet the part one after another, and each is judged while it sees the region.
TEST(VerdictTables, ShortSectionsJudgeMoreOnABeltThatRunsAskew) {
  GoodPart setup = laser();
  const auto& [nx, ny, nz] = setup.rig.belt_pose->normal;
  auto& direction = setup.rig.belt_pose->direction;
  const auto [dx, dy, dz] = direction;
  const double c = std::cos(0.2), s = std::sin(0.2);
  direction = {c * dx + s * (ny * dz - nz * dy), c * dy + s * (nz * dx - nx * dz), c * dz + s * (nx * dy - ny * dx)};
  VerdictOptions options = evenly();
  const VerdictTables whole(setup.rig, setup.reference, setup.tolerance, options, "tolerance");
  options.section_mm = 2;
  const VerdictTables tables(setup.rig, setup.reference, setup.tolerance, options, "tolerance");
  const VerdictTable table = tables.table(0);
  EXPECT_GT(tables.facts(table).judged, 1.3 * whole.facts(whole.table(0)).judged);
  EXPECT_LT(tables.facts(table).judged, 1);
  EXPECT_GT(compare_with_profiler(setup, table, 0, 1), 1000U);

  // Where the columns that are judged see the part while a section lasts
  const light_section::DifferentialProfiler profiler(setup.rig, setup.reference);
  model::Moments moments;
  moments.resize(table.columns);
  light_section::Profile profile;
  profile.resize(table.columns);
  const double count_mm = setup.rig.conveyor.encoder_mm_per_count;
  // Sections are counted from where parts are judged on.
  const double meets = production::belt_view(setup.rig).along_mm + tables.leading_edge_mm({}) -
                       (table.rule.start - *options.start) * count_mm;
  const std::vector<double>& corners = setup.tolerance.regions[0].corners_mm;
  for (std::size_t i = 0; i + 1 < table.sections.size(); ++i) {
    for (std::size_t at = 0; at < static_cast<std::size_t>(table.columns); ++at) {
      const model::ColumnLimits& limits = table.sections[i].limits[at];
      moments.m0[at] = 2 * model::kRowParts;
      moments.m1[at] = limits.low + limits.high;
      moments.n[at] = static_cast<std::uint32_t>(setup.rig.measure.min_lit_px);
    }
    profiler.profile(moments.view(), profile.view());
    for (std::size_t at = 0; at < static_cast<std::size_t>(table.columns); ++at) {
      if (table.sections[i].limits[at].judged) {
        const double behind = static_cast<double>(profile.x[at]) - meets;
        EXPECT_GE(table.sections[i].begin * count_mm - behind, corners[0]) << i << ", column " << at;
        EXPECT_LE(table.sections[i + 1].begin * count_mm - behind, corners[2]) << i << ", column " << at;
      }
    }
  }
  options.section_mm = 0.01;
  EXPECT_EQ(error_of([&] {
              (void)VerdictTables(setup.rig, setup.reference, setup.tolerance, options, "tolerance").table(0);
            }).rfind("--section: is 0.01 mm; it must be two frames or more, ", 0),
            0U);
}

TEST(VerdictTables, BoardsForMoreRowsGiveNoVerdicts) {
  GoodPart setup = treads();
  setup.rig.camera.rows = 1500;
  EXPECT_EQ(
      error_of([&] { (void)VerdictTables(setup.rig, setup.reference, setup.tolerance, evenly(), "tolerance"); }),
      setup.rig.name + ": sends 1500 rows; boards for more than 1023 give no verdicts (camera.region takes fewer)");
}

TEST(VerdictTables, WallsAndPlacesOutsideOfRegionsAreNotJudged) {
  const GoodPart setup = treads();
  const VerdictTable table =
      VerdictTables(setup.rig, setup.reference, setup.tolerance, evenly(), "tolerance").table(1.5);
  // By the encoder, parts begin with the first limits and end behind the last; by light, sections without limits say
  // so. With 2 mm of strip and the plays, along and across.
  const auto none = [](const VerdictTable::Section& section) {
    return std::none_of(section.limits.begin(), section.limits.end(), [](const auto& limits) { return limits.judged; });
  };
  ASSERT_GE(table.sections.size(), 3U);
  EXPECT_FALSE(none(table.sections.front()) || none(table.sections.back()));
  const double play = table.play_along_mm;
  const double count_mm = setup.rig.conveyor.encoder_mm_per_count;
  EXPECT_EQ(table.sections.front().begin, 0U);
  EXPECT_NEAR((table.rule.start - *evenly().start) * count_mm, 2 + play, 0.5);
  EXPECT_NEAR((table.rule.start - *evenly().start + table.rule.length) * count_mm, 38 - play, 0.5);
  const VerdictTable by_light = VerdictTables(setup.rig, setup.reference, setup.tolerance, {}, "tolerance").table(1.5);
  ASSERT_EQ(by_light.sections.size(), table.sections.size() + 2);
  EXPECT_TRUE(none(by_light.sections.front()) && none(by_light.sections.back()));
  for (std::size_t i = 0; i < table.sections.size(); ++i) {
    EXPECT_EQ(by_light.sections[i + 1].limits, table.sections[i].limits);
    EXPECT_EQ(by_light.sections[i + 1].begin, table.sections[i].begin + by_light.sections[1].begin);
  }
  for (const VerdictTable::Section& section : table.sections) {
    for (int c = 0; c < table.columns; ++c) {
      // Heights of 8 to 20 mm: columns are 0.229 to 0.232 mm apart.
      const double across = 0.2305 * (c - 255.5) - 1.5;
      const bool in_region = (across > -20 + 0.25 && across < -2 - 0.25) || (across > 2.25 && across < 20 - 0.25);
      // The pattern's wall is where it was.
      const bool beside_wall = std::abs(0.2305 * (c - 255.5)) < 3 * 0.23;
      const bool judged = section.limits[static_cast<std::size_t>(c)].judged;
      EXPECT_FALSE(judged && (!in_region || beside_wall)) << c;
    }
  }
  EXPECT_GT(table.judged(), 140);
  // The seat is lower by less: while it passes, limits are narrower there than before.
  const auto band = [&](std::size_t section, int column) {
    const model::ColumnLimits& limits = table.sections[section].limits[static_cast<std::size_t>(column)];
    return limits.judged ? static_cast<int>(limits.high - limits.low) : -1;
  };
  const int seat = 255 + static_cast<int>(std::lround(11.5 / 0.2294));
  EXPECT_LT(band(table.sections.size() / 2, seat), band(0, seat));
  EXPECT_GT(band(table.sections.size() / 2, seat), 0);
}

// Where the tolerance says how wide the strip is that its regions leave out along edges and walls, half of it is judged
// as they are, but not where another region is, where the pattern jumps, or by a user's region at the part's edge.
TEST(VerdictTables, HalfOfTheStripAroundARegionIsJudged) {
  GoodPart setup = treads();
  setup.tolerance.regions.push_back(rectangle("to the edge", 2, 38, -21.9, -20.5, -0.04, 0.05));
  const auto table_of = [&] {
    return VerdictTables(setup.rig, setup.reference, setup.tolerance, evenly(), "t").table();
  };
  const VerdictTable plain = table_of();
  setup.tolerance.edge_mm = 2;
  const VerdictTable table = table_of();
  ASSERT_GE(table.sections.size(), 3U);
  const double count_mm = setup.rig.conveyor.encoder_mm_per_count;
  EXPECT_NEAR((table.rule.start - *evenly().start) * count_mm, 1 + table.play_along_mm, 0.5);
  EXPECT_NEAR((table.rule.start - *evenly().start + table.rule.length) * count_mm, 39 - table.play_along_mm, 0.5);
  // Before the seat: there is nothing but the treads.
  const std::vector<model::ColumnLimits>& limits = table.sections.front().limits;
  const std::vector<model::ColumnLimits>& without = plain.sections.front().limits;
  int more = 0;
  for (int c = 0; c < table.columns; ++c) {
    const auto at = static_cast<std::size_t>(c);
    const double across = 0.2305 * (c - 255.5);
    if (without[at].judged) {
      EXPECT_TRUE(limits[at].judged) << across;
      EXPECT_EQ(limits[at].low, without[at].low);
      EXPECT_EQ(limits[at].high, without[at].high);
      continue;
    }
    more += limits[at].judged ? 1 : 0;
    // 1 mm of the strip, less the play of 0.25 mm, and not at the wall
    const bool in_strip =
        (across > -2.25 && across < -1.25) || (across > 1.25 && across < 2.25) || (across > 19.75 && across < 20.75);
    const bool between = across > -20.75 && across < -19.5;  // two regions
    EXPECT_TRUE(in_strip || between || !limits[at].judged) << across;
  }
  EXPECT_GE(more, 10);
  EXPECT_EQ(production::parse_tolerance(production::to_yaml(setup.tolerance), "t").edge_mm, 2);
  setup.tolerance.edge_mm = {};
  EXPECT_EQ(production::parse_tolerance(production::to_yaml(setup.tolerance), "t").edge_mm, std::nullopt);
}

// Limits that are made for shifts hold for each of them.
TEST(VerdictTables, LimitsForShiftsHoldForEachShift) {
  const GoodPart setup = treads();
  VerdictOptions options = evenly();
  options.max_shift_mm = 1;
  const VerdictTable all = VerdictTables(setup.rig, setup.reference, setup.tolerance, options, "t").table();
  EXPECT_EQ(all.max_shift_columns, 5);
  const VerdictTables one(setup.rig, setup.reference, setup.tolerance, evenly(), "t");
  std::uint64_t compared = 0;
  for (int s = -all.max_shift_columns; s <= all.max_shift_columns; ++s) {
    const VerdictTable exact = one.table(s * all.column_mm);
    for (const VerdictTable::Section& of_all : all.sections) {
      // The section of the exact table that is in force in its middle
      const auto next = &of_all == &all.sections.back() ? of_all.begin : (&of_all + 1)->begin;
      const std::uint32_t middle = (of_all.begin + next) / 2 + all.rule.start - exact.rule.start;
      const auto after = std::find_if(exact.sections.begin(), exact.sections.end(),
                                      [&](const auto& section) { return section.begin > middle; });
      ASSERT_NE(after, exact.sections.begin());
      const VerdictTable::Section& of_one = *(after - 1);
      for (int c = 0; c < all.columns; ++c) {
        const int from = c - s;
        if (from < 0 || from >= all.columns || !of_all.limits[static_cast<std::size_t>(from)].judged) {
          continue;
        }
        ++compared;
        const model::ColumnLimits& wide = of_all.limits[static_cast<std::size_t>(from)];
        const model::ColumnLimits& narrow = of_one.limits[static_cast<std::size_t>(c)];
        ASSERT_TRUE(narrow.judged) << s << ' ' << c;
        EXPECT_LE(wide.low, narrow.low);
        EXPECT_GE(wide.high, narrow.high);
      }
    }
  }
  EXPECT_GT(compared, 3000U);
  const model::VerdictSettings shifted = production::shifted_settings(all, 0.95, -0.2, "t");
  EXPECT_EQ(shifted.shift_columns, 4);
  EXPECT_EQ(shifted.shift_rows, -static_cast<int>(std::lround(0.2 / all.row_mm * model::kRowParts)));
  EXPECT_THROW(production::shifted_settings(all, 1.5, 0, "t"), UserError);
  EXPECT_THROW(production::shifted_settings(all, 0, 90, "t"), UserError);
}

TEST(VerdictTables, SettingsFollowTheDefect) {
  GoodPart setup = block_in_region();
  VerdictOptions options = evenly();
  const auto table_of = [&] {
    return VerdictTables(setup.rig, setup.reference, setup.tolerance, options, "t").table().settings;
  };
  const model::VerdictSettings usual = table_of();  // a square of 0.5 mm², at 0.23 mm a column and 0.1 mm a frame
  EXPECT_EQ(usual.width, 2);
  EXPECT_EQ(usual.hits, 6);
  EXPECT_EQ(usual.history, 6);
  EXPECT_TRUE(usual.above && usual.below);
  // One of 12 values is beyond 3.77 deviations once in 1000 times.
  const VerdictTables tables(setup.rig, setup.reference, setup.tolerance, options, "t");
  const production::VerdictFacts facts = tables.facts(tables.table());
  EXPECT_GT(facts.noise_mm, 0);
  EXPECT_NEAR((facts.found_depth_mm - 2 * facts.widest_mm) / facts.noise_mm, 3.77, 0.02);
  options.defect_across_mm = 0.5;
  options.defect_along_mm = 0.5;
  options.look_for = production::TooFar::high;
  const model::VerdictSettings small = table_of();
  EXPECT_EQ(small.width, 1);
  EXPECT_EQ(small.hits, 3);
  EXPECT_TRUE(small.below && !small.above);  // higher places are seen at larger rows
  options.defect_across_mm = 10;
  setup.tolerance.regions = {rectangle("block", 2, 38, -18, 18, 7.99, 8.01)};
  options.false_alarms = 1e-300;
  EXPECT_GT(table_of().width, 3);
}

TEST(VerdictTables, SayWhatIsWrong) {
  const GoodPart setup = treads();
  const auto error = [&](const GoodPart& of, const VerdictOptions& options, double shift = 0) {
    try {
      static_cast<void>(VerdictTables(of.rig, of.reference, of.tolerance, options, "t.yaml").table(shift));
    } catch (const UserError& e) {
      return std::string(e.what());
    }
    return std::string("no error");
  };
  GoodPart other = setup;
  other.rig.parts->by_encoder = false;
  EXPECT_NE(error(other, {}).find("needs parts along a belt with an encoder"), std::string::npos);
  other = block_in_region();  // its line is lit with and without a part
  other.rig.camera.region.reset();
  EXPECT_NE(error(other, {}).find("--start: is needed: "), std::string::npos) << error(other, {});
  EXPECT_NE(error(setup, {.start = 0, .pitch = 4000}).find("--pitch: is 4000 counts; a part takes "),
            std::string::npos);
  other = setup;
  other.tolerance.regions.push_back(rectangle("hole", 10, 20, 5, 15, -3, -2));
  EXPECT_NE(error(other, evenly()).find("region 'hole' has no height in common"), std::string::npos);
  other = setup;
  other.tolerance.regions = {rectangle("thin", 2, 4, -10, -5, -0.1, 0.1)};
  EXPECT_NE(error(other, evenly()).find("t.yaml: no column of light-section can be judged"), std::string::npos);
  other = setup;
  for (int i = 0; i < 44; ++i) {
    const double along = 3 + 0.8 * i;
    other.tolerance.regions.push_back(rectangle("rung", along, along + 0.4, -10, -8, -0.1, 0.01));
  }
  VerdictOptions fine = evenly();
  fine.play_along_mm = 0;
  EXPECT_NE(error(other, fine).find("sections along the part; a table has at most 64"), std::string::npos);
}

TEST(VerdictFile, IsReadBackAndChecked) {
  const GoodPart setup = treads();
  VerdictTable table = VerdictTables(setup.rig, setup.reference, setup.tolerance, evenly(), "t").table();
  const std::string text = production::to_yaml(table);
  EXPECT_EQ(production::parse_verdict_table(text, "v.yaml"), table);
  table.rule = {.lit = 200, .dark_frames = 9};
  EXPECT_EQ(production::parse_verdict_table(production::to_yaml(table), "v.yaml"), table);
  EXPECT_NE(text.find("  shift_mm: 0\n"), std::string::npos);
  table.shift_mm = {};  // a file of an earlier version
  EXPECT_EQ(production::parse_verdict_table(production::to_yaml(table), "v.yaml"), table);
  EXPECT_NO_THROW(production::check_verdict_table(table, setup.rig, "v.yaml"));
  EXPECT_THROW(production::check_verdict_table(table, block_in_region().rig, "v.yaml"), UserError);
  rig::Rig other = setup.rig;
  other.conveyor.encoder_mm_per_count *= 1.005;
  EXPECT_NO_THROW(production::check_verdict_table(table, other, "v.yaml")) << "calibrated anew";
  other.conveyor.encoder_mm_per_count *= 5;
  EXPECT_THROW(production::check_verdict_table(table, other, "v.yaml"), UserError);

  EXPECT_EQ(production::never(table), std::vector<std::string>());
  VerdictTable dead = table;
  dead.settings.width = 250;
  dead.settings.most_unlit = 4094;
  EXPECT_EQ(production::never(dead).size(), 2U);
  dead.settings.width = 1;
  dead.settings.above = dead.settings.below = false;
  EXPECT_EQ(production::never(dead).at(0), "there is never a defect: neither above nor below is asked for");

  const auto error = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    const std::size_t at = changed.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    changed.replace(at, from.size(), to);
    try {
      production::parse_verdict_table(changed, "v.yaml");
    } catch (const UserError& e) {
      return std::string(e.what());
    }
    return std::string("no error: ") + to;
  };
  const auto number_after = [&](const std::string& key) {
    const std::size_t at = text.find(key) + key.size();
    return key + text.substr(at, text.find_first_of(",]\n", at) - at);
  };
  const std::string low = number_after("low: [");
  const std::string high = number_after("high: [");
  const std::vector<std::array<std::string, 3>> wrong = {
      {"  columns: 512", "  columns: 511", "frames.columns is 511; it must be a multiple of 4"},
      {high, "high: [99999", "; a board takes them no more than 16383 apart"},
      {"  rows: 96", "  rows: 20", "; the frames have rows 1 to 20"},
      {"  shift_rows: 0", "  shift_rows: 8191", ", shifted; the frames have rows 1 to 96"},
      {"  columns: 512", "  columns: 100", "entry 1: line"},
      {number_after("  hits: "), "  hits: 8", "defect.hits is 8, and history "},
      {number_after("  shift_columns: "), "  shift_columns: 3",
       "defect.shift_columns is 3; the limits hold for up to 0"},
      {"pitch_counts: 9000", "pitch_counts: 100", "parts.pitch_counts is 100, and length_counts "},
      {"begin_by: encoder", "begin_by: light", "parts.lit_columns is missing"},
      {"begin_counts: 0", "begin_counts: 5", "section 1: begins at count 5; the first one must begin at 0"},
      {fmt::format("begin_counts: {}", table.sections[1].begin), "begin_counts: 0",
       "section 2: begins at count 0; the one before"},
      {number_after("first_column: "), "first_column: 0", "first_column is "},
      {low, "low: [200000", "low has an entry, number 1, that is not a number from 0 to 131071"},
      {low, "low: [5.5", "has the limits 5.5 and "},
      {low, "low: [131071", "has the limits 131071 and "},
      {low, low + ", 4", "numbers and high "},
      {"high: [", "hihg: [", "high is missing"},
      {"sections:", "sectoins:", "is no verdict table: sections must be a list"},
      {"above: yes", "above: maybe", "defect.above is 'maybe'; one of yes, no is expected"},
      {"row_mm: ", "row_cm: ", "frames.row_cm: unknown key; the key is row_mm"},
  };
  for (const auto& [from, to, expected] : wrong) {
    const std::string said = error(from, to);
    EXPECT_NE(said.find(expected), std::string::npos) << from << " -> " << to << ": " << said;
    EXPECT_EQ(said.rfind("v.yaml: ", 0), 0U) << said;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  }
}

// A verdict at once is the model's on the same moments; what the host says of a part is what was in its frames.
TEST(VerdictRun, IsTheModel) {
  const GoodPart setup = treads();
  VerdictTable table = VerdictTables(setup.rig, setup.reference, setup.tolerance, evenly(), "t").table();
  table.settings.width = 4;
  table.settings.history = 3;
  table.settings.hits = 2;
  model::Verdict model(table.columns, static_cast<int>(table.sections.size()));
  model.write(0, table.sections);
  production::VerdictRun run(setup.rig, table, "t", 100);
  std::mt19937_64 random(4);
  model::PacketHeader header;
  header.columns = static_cast<std::uint16_t>(table.columns);
  header.rows = static_cast<std::uint16_t>(table.rows);
  std::vector<std::uint32_t> m0(512);
  std::vector<std::uint32_t> m1(512);
  std::vector<production::JudgedFrame> expected;
  std::uint64_t defects = 0;
  for (int frame = 0; frame < 2000; ++frame) {
    header.sequence = static_cast<std::uint64_t>(frame);
    header.encoder = static_cast<std::uint32_t>(5000 + 10 * frame);
    for (std::size_t i = 0; i < m0.size(); ++i) {
      m0[i] = static_cast<std::uint32_t>(random() % 50 == 0 ? 0 : 1000 + random() % 1000);
      const model::ColumnLimits& limits = table.sections[table.sections.size() / 2].limits[i];
      const double row = 0.5 * (limits.low + limits.high) / model::kRowParts + (random() % 3 == 0 ? 0.3 : 0.0);
      m1[i] = static_cast<std::uint32_t>(m0[i] * row);
    }
    const model::FrameVerdict found =
        model.frame(table.settings, false, table.rule, header.encoder & model::kCountMask, m0, m1, true);
    run.add(header, m0, m1, found);
    if (found.in_part) {
      expected.push_back({header.sequence, found});
      defects += found.defect ? 1 : 0;
    }
  }
  EXPECT_GT(defects, 100U);
  EXPECT_EQ(run.judged_frames(), expected.size());
  EXPECT_EQ(run.defect_frames(), defects);
  ASSERT_EQ(run.frames().size(), 100U);
  for (std::size_t i = 0; i < 100; ++i) {
    EXPECT_EQ(run.frames()[i].sequence, expected[i].sequence);
    EXPECT_EQ(run.frames()[i].verdict, expected[i].verdict);
  }
  production::CutPart part;
  part.first = expected[50].sequence;
  part.last = expected[700].sequence;
  const auto in_part = run.judge(part, {});
  ASSERT_TRUE(in_part);
  const auto begin = expected.begin() + 50;
  const auto end = std::find_if(begin, expected.end(), [&](const auto& frame) { return frame.sequence > part.last; });
  const auto first = std::find_if(begin, end, [](const auto& frame) { return frame.verdict.defect; });
  EXPECT_EQ(in_part->frames, static_cast<std::uint64_t>(end - begin));
  ASSERT_NE(first, end);
  EXPECT_EQ(in_part->first_frame, first->sequence);
  EXPECT_EQ(in_part->first_column, first->verdict.first_column);
  header.columns = 400;
  EXPECT_THROW(run.add(header, m0, m1), UserError);

  // The board has said the same.
  EXPECT_EQ(run.board().frames, 2000U);
  EXPECT_EQ(run.board().defects, defects);
  EXPECT_EQ(run.board().disagree, 0U);
}

// What a board says otherwise is told, but not behind frames that are missing here.
TEST(VerdictRun, ABoardThatSaysOtherwise) {
  const GoodPart setup = treads();
  const VerdictTable table = VerdictTables(setup.rig, setup.reference, setup.tolerance, evenly(), "t").table();
  model::Verdict model(table.columns, static_cast<int>(table.sections.size()));
  model.write(0, table.sections);
  production::VerdictRun run(setup.rig, table, "t", 0);
  model::PacketHeader header;
  header.columns = static_cast<std::uint16_t>(table.columns);
  header.rows = static_cast<std::uint16_t>(table.rows);
  std::vector<std::uint32_t> m0(512, 100);
  std::vector<std::uint32_t> m1(512, 100 * 40);
  std::uint64_t in_parts = 0;
  std::uint64_t changed = 0;
  for (int frame = 0; frame < 2000; ++frame) {
    if (frame == 1000) {
      continue;  // lost on the way
    }
    header.sequence = static_cast<std::uint64_t>(frame);
    header.encoder = static_cast<std::uint32_t>(5000 + 10 * frame);
    model::FrameVerdict board =
        model.frame(table.settings, false, table.rule, header.encoder & model::kCountMask, m0, m1, true);
    in_parts += board.in_part ? 1 : 0;
    if (board.in_part && frame % 100 == 7) {
      board.unlit += 1;
      ++changed;
    }
    run.add(header, m0, m1, board);
  }
  ASSERT_GT(changed, 3U);
  EXPECT_EQ(run.board().frames, 1999U);
  EXPECT_GT(run.board().after_gap, 0U);
  EXPECT_LT(run.board().after_gap, in_parts / 2);
  EXPECT_GT(run.board().disagree, 0U);
  EXPECT_LE(run.board().disagree, changed);
  EXPECT_NE(run.board().first.find("1 unlit"), std::string::npos) << run.board().first;
}

}  // namespace
}  // namespace selfproj::test
