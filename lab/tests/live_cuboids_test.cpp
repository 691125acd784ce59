// Tests experiment B4 live, by both methods: Aravis' fake GigE camera looks at its cuboids, which a virtual display
// lights. The depth must be as good as that of the same scenes rendered into files and measured from these.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "host/files/results_file.h"
#include "host/images/image_files.h"
#include "lab/cuboids.h"
#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/gray_sequence.h"
#include "sim/scene/scene.h"
#include "sim/scene/scenes.h"
#include "tests/cli/program.h"
#include "tests/host/camera/gige_camera.h"
#include "tests/host/capture/live_world.h"
#include "tests/support/virtual_screen.h"

namespace selfproj::test {
namespace {

namespace fs = std::filesystem;

// The rig's images have their sides divided by four, or by what SELFPROJ_LIVE_CUBOIDS says: 1 is the published rig.
int sides_divided_by() {
  const char* wanted = std::getenv("SELFPROJ_LIVE_CUBOIDS");
  return wanted == nullptr ? 4 : std::max(1, std::atoi(wanted));
}

class LiveCuboids : public testing::Test {
 protected:
  void SetUp() override {
    if (!VirtualScreen::installed()) {
      GTEST_SKIP() << "Xvfb is not installed";
    }
    if (!enter_own_network()) {
      GTEST_SKIP() << "this system allows no network of one's own";
    }
    screen_ = std::make_unique<VirtualScreen>(rig_.projector.columns, rig_.projector.lines, screen_folder_.path());
    write_text(folder_ / "rig.yaml", rig::to_yaml(rig_));
    world_ = std::make_unique<LiveWorld>(rig_, *bare_, *screen_, WorldFaults{.max_delay_ms = 20, .same_noise = true});
  }

  void run(const std::vector<std::string>& arguments) {
    const Outcome outcome = run_program(SELFPROJ_PROGRAM, arguments, folder_.path());
    ASSERT_EQ(outcome.status, 0) << arguments[0] << ": " << outcome.err;
  }

  // Runs the command with the camera.
  void live(std::vector<std::string> arguments) {
    const std::string camera = fmt::format("camera:127.0.0.1?region={}x{}", rig_.camera.columns, rig_.camera.rows);
    arguments.insert(arguments.begin() + 1, {"--camera", camera, "--settle-ms", "30"});
    run(arguments);
  }

  // What the camera sees of the scene under the patterns of a folder, without display, camera and network.
  void record(const std::string& patterns, const std::string& name, int count) {
    fs::create_directory(folder_ / name);
    for (int i = 0; i < count; ++i) {
      const std::string pattern = (folder_ / patterns / fmt::format("pattern_{:02}.png", i)).string();
      write_text(folder_ / name / fmt::format("image_{:02}.png", i),
                 images::encode_png(world_->image_under(images::read_image(pattern, std::nullopt))));
    }
  }

  lab::CuboidFigures figures(const std::string& folder, bool difference) {
    const images::FloatImage depth = images::read_float_tiff((folder_ / folder / "depth.tiff").string());
    const images::FloatImage off = difference ? images::read_float_tiff((folder_ / folder / "difference.tiff").string())
                                              : images::FloatImage(depth.rows, depth.columns, 0);
    return lab::cuboid_figures(rig_, faces_, depth, off, lit_,
                               [](std::size_t /*pixel*/) { return std::numeric_limits<double>::quiet_NaN(); });
  }

  rig::Rig rig_ = small_scanner(sides_divided_by(), sides_divided_by());
  structured_light::GraySequence gray_{rig_.projector.columns, rig_.projector.lines};
  std::unique_ptr<sim::Scene> bare_ = sim::make_scene("cuboids", rig_);
  std::unique_ptr<sim::Scene> marked_ = sim::make_scene("cuboids-marked", rig_);
  images::FloatImage lit_;
  std::vector<lab::Face> faces_;
  ScratchFolder screen_folder_;
  ScratchFolder folder_;
  std::unique_ptr<VirtualScreen> screen_;
  std::unique_ptr<LiveWorld> world_;
};

// What experiment B4 asks of the self-projected method, in mm.
void expect_published_heights(const lab::CuboidFigures& figures) {
  EXPECT_NEAR(figures[lab::Face::low].height, sim::Cuboids::kLow, 0.83);
  EXPECT_NEAR(figures[lab::Face::high].height, sim::Cuboids::kHigh, 0.45);
  EXPECT_NEAR(-figures[lab::Face::letter].difference, sim::Cuboids::kLetterDepth, 0.7);
  EXPECT_NEAR(figures[lab::Face::block_3].difference, sim::Cuboids::kBlockHeights[0], 0.22);
  EXPECT_NEAR(figures[lab::Face::block_6].difference, sim::Cuboids::kBlockHeights[1], 0.62);
  EXPECT_NEAR(figures[lab::Face::block_9].difference, sim::Cuboids::kBlockHeights[2], 0.28);
}

nlohmann::ordered_json figures_json(const lab::CuboidFigures& figures) {
  nlohmann::ordered_json json;
  for (std::size_t i = 0; i < lab::kFaceNames.size(); ++i) {
    const lab::FaceFigures& face = figures[static_cast<lab::Face>(i)];
    json[lab::kFaceNames.at(i)] = {{"pixels", face.pixels},    {"valid", face.valid},
                                   {"height_mm", face.height}, {"difference_mm", face.difference},
                                   {"rms_mm", face.rms},       {"99_percent_mm", face.errors.quantile(0.99)},
                                   {"largest_mm", face.most}};
  }
  return json;
}

TEST_F(LiveCuboids, BothMethodsAreAsGoodAsFromFiles) {
  run({"pattern", "gray", "--rig", "rig.yaml", "--out", "codes"});
  live({"capture", "--patterns", "codes", "--out", "bare"});
  record("codes", "known_bare", gray_.count());
  for (const auto& [seen, reference] : {std::pair{"bare", "reference"}, {"known_bare", "known_reference"}}) {
    run({"pattern", "stripes", "--rig", "rig.yaml", "--scan", seen, "--gray-code", "--out", reference});
  }
  world_->look_at(*marked_);
  lit_ = world_->lit();
  faces_ = lab::face_interiors(rig_, lit_);
  live({"scan", "--rig", "rig.yaml", "--out", "scan"});
  live({"scan", "--rig", "rig.yaml", "--self-projected", "reference", "--e", "8", "--out", "part"});

  record("codes", "known_codes", gray_.white());
  run({"depth", "--rig", "rig.yaml", "--bits", std::to_string(gray_.column_bits()), "--row-bits",
       std::to_string(gray_.row_bits()), "--out", "known_scan", "known_codes"});
  constexpr int kStripePatterns = 8;
  record("known_reference", "known_stripes", kStripePatterns);
  std::vector<std::string> match = {"match", "--rig", "rig.yaml", "--reference", "known_reference",
                                    "--e",   "8",     "--out",    "known_part"};
  for (int i = 0; i < kStripePatterns; ++i) {
    match.push_back(fmt::format("known_stripes/image_{:02}.png", i));
  }
  run(match);
  if (HasFatalFailure()) {
    return;
  }
  // Seen under one pattern, the same noise: whatever the images tell is the same, pixel by pixel.
  for (const auto& [live, files] : {std::pair{"scan", "known_scan"}, {"part", "known_part"}}) {
    EXPECT_EQ(read_text(folder_ / live / "depth.tiff"), read_text(folder_ / files / "depth.tiff")) << live;
  }
  EXPECT_EQ(read_text(folder_ / "part" / "difference.tiff"), read_text(folder_ / "known_part" / "difference.tiff"));
  const lab::CuboidFigures gray = figures("scan", false);
  const lab::CuboidFigures self = figures("part", true);
  EXPECT_NEAR(gray[lab::Face::high].height, sim::Cuboids::kHigh, 1);
  EXPECT_NEAR(self[lab::Face::high].height, sim::Cuboids::kHigh, 1);
  if (sides_divided_by() == 1) {
    expect_published_heights(self);
  }
  files::write_results(
      "live_cuboids",
      "Experiment B4 live, with Aravis' fake camera and a virtual display; files of the same images give the "
      "same depths",
      {{"camera", fmt::format("{} x {}", rig_.camera.columns, rig_.camera.rows)},
       {"projector", fmt::format("{} x {}", rig_.projector.columns, rig_.projector.lines)},
       {"gray_codes", figures_json(gray)},
       {"self_projected", figures_json(self)}});
}

}  // namespace
}  // namespace selfproj::test
