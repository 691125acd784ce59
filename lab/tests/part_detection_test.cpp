// Parts with planted defects on a running line, few of them.
#include "lab/part_detection.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "lab/planted_parts.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"
#include "sim/cosim/light_section.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/random.h"
#include "tests/sim/traced.h"

namespace selfproj::test {
namespace {

TEST(PlantedPart, BlocksAreThoseOfTracedRays) {
  const rig::Rig rig = rig::load_rig("light-section");
  expect_images_of_traced_rays(rig, lab::PlantedPart(rig, {0.1, 0.3, 0.7}, {{1, 8, 10, 4, -0.5}, {0, 8, -10, 2, 0.3}}));
  expect_shadows_of_points(sim::hidden_rig(rig, 1), lab::PlantedPart(rig, {0.1, 0.3, 0.7}, {{1, 8, 10, 4, -0.5}}),
                           {0, 21}, 20000);
}

TEST(PlantedPart, RangesHoldAndConverge) {
  const rig::Rig rig = lab::rig_of_planted_parts(rig::load_rig("light-section"));
  sim::EvenNumbers numbers(1);
  int sharp = 0;
  for (std::uint64_t i = 0; i < 50; ++i) {
    const lab::DrawnPart drawn = lab::draw_part(rig, 7, i, true);
    ASSERT_EQ(drawn.defects.size(), 2U);
    const lab::PlantedPart part(rig, drawn.pose, drawn.defects);
    // Within its tread, with its depth: in the middle of each defect and nowhere else is the surface higher or lower.
    for (int box = 0; box < 200; ++box) {
      const double x = numbers.within(11), y = numbers.within(25);
      const double size = box % 2 == 0 ? 2 * numbers.next() : 1e-6;
      const sim::HeightRange range = part.part_range({x, x + size, y, y + size});
      for (int k = 0; k < 5; ++k) {
        const double height = part.part_height(x + size * numbers.next(), y + size * numbers.next());
        EXPECT_GE(height, range.low);
        EXPECT_LE(height, range.high);
      }
      sharp += box % 2 == 1 && range.low == range.high ? 1 : 0;
    }
  }
  EXPECT_GT(sharp, 4950);
}

// Images with noise that is added afterwards are those that are rendered with it.
TEST(PlantedParts, NoiseAfterwardsIsThatOfRendering) {
  const rig::Rig rig = lab::rig_of_planted_parts(rig::load_rig("light-section"));
  const sim::LightSection setup =
      sim::self_projection(rig, sim::PerturbedRig(rig), lab::PlantedPart(rig, {}, {}), {}, false);
  lab::DrawnPart drawn = lab::draw_part(rig, 3, 1, false, 2);
  using Seen = std::vector<std::vector<std::uint32_t>>;
  const auto keep = [](Seen& seen) {
    return [&seen](const model::PacketHeader& header, const light_section::ProfileView& /*profile*/,
                   const model::Moments& moments) {
      seen.push_back({static_cast<std::uint32_t>(header.sequence), header.encoder});
      seen.push_back(moments.m0);
      seen.push_back(moments.m1);
    };
  };
  Seen rendered;
  Seen added;
  lab::PlantedParts(setup, {}).pass({drawn}, 1, keep(rendered));
  lab::PlantedParts belt(setup, {});
  belt.pass(belt.clean(drawn), {drawn.noise}, 1, keep(added));
  EXPECT_EQ(rendered.size(), 240U);
  EXPECT_EQ(rendered, added);
}

// Each part judged by moments where the host has placed it, as the host judges it.
TEST(PartDetection, MomentsFindWhatHeightsFind) {
  lab::PartDetectionOptions options;
  options.null_test = true;
  options.verdict = true;
  options.learn_parts = 5;
  options.parts = 4;
  options.good_parts = 6;
  options.line_parts = 2;
  const lab::PartDetectionResult result = lab::run_part_detection(options, [](std::size_t, std::size_t) {});
  EXPECT_EQ(result.line.good.size(), 256U);
  EXPECT_EQ(result.line.bad.size(), 256U);
  EXPECT_NE(result.line.good[70].pixels, result.line.good[198].pixels) << "each part has its own noise";
  EXPECT_TRUE(rig::parse_rig(result.line.rig_yaml, "the line's rig").parts.has_value());
  EXPECT_GT(result.moments.of_host.planted, 1U);
  EXPECT_EQ(result.moments.of_host.found, result.moments.of_host.planted);
  EXPECT_EQ(result.moments.of_host.planted + result.moments.of_host_at_edges.planted + result.moments.of_others.planted,
            4U);
  EXPECT_EQ(result.moments.good_parts, 6U);
  EXPECT_EQ(result.moments.false_parts, 0U);
  EXPECT_EQ(nlohmann::json::parse(result.data).at("moments").at("missed").size(),
            result.moments.of_host_at_edges.planted - result.moments.of_host_at_edges.found);
}

TEST(PartDetection, FindsWhatWasPlantedAndNothingElse) {
  lab::PartDetectionOptions options;
  options.null_test = true;
  options.learn_parts = 5;
  options.parts = 3;
  options.good_parts = 1;
  std::size_t done = 0, all = 0;
  const lab::PartDetectionResult result =
      lab::run_part_detection(options, [&](std::size_t d, std::size_t a) { done = d, all = a; });
  EXPECT_EQ(done, all);
  EXPECT_EQ(result.parts, 4U);
  EXPECT_EQ(result.goal.planted + result.goal_at_edges.planted, 3U);
  EXPECT_GT(result.goal.planted, 0U);
  EXPECT_EQ(result.goal.found, result.goal.planted);
  EXPECT_EQ(result.false_defects, 0U);
  EXPECT_EQ(result.inconclusive, 0U);
  EXPECT_TRUE(result.not_reached.empty());
  const auto data = nlohmann::json::parse(result.data);
  EXPECT_EQ(data.at("bands").size(), 2U);
  for (const auto& band : data.at("bands")) {  // noise is on, and the parts lie anyhow
    EXPECT_GT(band.at("high_mm"), 0.02);
    EXPECT_LT(band.at("high_mm"), 0.1);
  }
}

}  // namespace
}  // namespace selfproj::test
