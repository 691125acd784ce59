// Tests experiment B4 live, by both methods: a GigE camera of Aravis looks at its cuboids, which a virtual display
// lights. The depth is as good as by the recorded route: the same scenes by the renderer, measured from files.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/io/float_image.h"
#include "host/io/image_files.h"
#include "host/io/results_file.h"
#include "host/rig/rig.h"
#include "host/structured_light/gray_sequence.h"
#include "sim/experiment/cuboid_faces.h"
#include "sim/scene/scene.h"
#include "sim/scene/scene_list.h"
#include "tests/cli/program.h"
#include "tests/host/camera/gige_camera.h"
#include "tests/host/capture/live_world.h"
#include "tests/support/virtual_screen.h"

namespace selfproj::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCamera = "camera:127.0.0.1";

// The rig has its sides divided by two, or by what SELFPROJ_LIVE_CUBOIDS says: 1 is the published rig.
int sides_divided_by() {
  const char* wanted = std::getenv("SELFPROJ_LIVE_CUBOIDS");
  return wanted == nullptr ? 2 : std::max(1, std::atoi(wanted));
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
    write_text(folder_ / "rig.yaml", to_yaml(rig_));
    world_ = std::make_unique<LiveWorld>(rig_, *bare_, *screen_, WorldFaults{.most_delay_ms = 20, .lost = 0.001});
  }

  Outcome run(std::vector<std::string> arguments) { return run_program(SELFPROJ_PROGRAM, arguments, folder_.path()); }

  // Runs the command with the camera and this rig.
  void live(std::vector<std::string> arguments) {
    const std::string camera = fmt::format("{}?region={}x{}", kCamera, rig_.camera.columns, rig_.camera.rows);
    arguments.insert(arguments.begin() + 1, {"--camera", camera});
    const Outcome outcome = run(arguments);
    ASSERT_EQ(outcome.status, 0) << arguments[0] << ": " << outcome.err;
    fmt::print("{}", outcome.out);
  }

  void files(const std::vector<std::string>& arguments) {
    const Outcome outcome = run(arguments);
    ASSERT_EQ(outcome.status, 0) << arguments[0] << ": " << outcome.err;
  }

  // What the camera sees of the scene under the patterns of a folder, without display, camera and network.
  void record(const std::string& patterns, const std::string& name, int count) {
    fs::create_directory(folder_ / name);
    for (int i = 0; i < count; ++i) {
      const std::string pattern = (folder_ / patterns / fmt::format("pattern_{:02}.png", i)).string();
      write_text(folder_ / name / fmt::format("image_{:02}.png", i),
                 encode_png(world_->image_under(read_image(pattern, std::nullopt), i)));
    }
  }

  CuboidFigures figures(const std::string& folder, bool difference) {
    const FloatImage depth = read_float_tiff((folder_ / folder / "depth.tiff").string());
    const FloatImage off =
        difference ? read_float_tiff((folder_ / folder / "difference.tiff").string())
                   : FloatImage(depth.rows, depth.columns, 0);
    return cuboid_figures(rig_, faces_, depth, off, lit_,
                          [](std::size_t /*pixel*/) { return std::numeric_limits<double>::quiet_NaN(); });
  }

  Rig rig_ = small_scanner(sides_divided_by(), sides_divided_by());
  GraySequence gray_{rig_.projector.columns, rig_.projector.lines};
  std::unique_ptr<Scene> bare_ = make_scene("cuboids", rig_);
  std::unique_ptr<Scene> marked_ = make_scene("cuboids-marked", rig_);
  FloatImage lit_;
  std::vector<Face> faces_;
  ScratchFolder screen_folder_;
  ScratchFolder folder_;
  std::unique_ptr<VirtualScreen> screen_;
  std::unique_ptr<LiveWorld> world_;
};

void compare(const char* method, const CuboidFigures& live, const CuboidFigures& known) {
  for (std::size_t i = 0; i < kFaceNames.size(); ++i) {
    const FaceFigures& a = live[static_cast<Face>(i)];
    const FaceFigures& b = known[static_cast<Face>(i)];
    fmt::print("{} {}: pixels {} valid {} {}, height {:.3f} {:.3f}, difference {:.3f} {:.3f}, rms {:.3f} {:.3f}, 99% {:.3f} {:.3f}, most {:.3f} {:.3f}\n",
      method, kFaceNames.at(i), a.pixels, a.valid, b.valid, a.height, b.height, a.difference, b.difference, a.rms, b.rms,
      a.errors.quantile(0.99), b.errors.quantile(0.99), a.most, b.most);
  }
}

TEST_F(LiveCuboids, BothMethodsAreAsGoodAsFromFiles) {
  files({"pattern", "gray", "--rig", "rig.yaml", "--out", "codes"});
  live({"capture", "--patterns", "codes", "--out", "bare"});
  record("codes", "known_bare", gray_.count());
  for (const auto& [seen, reference] : {std::pair{"bare", "reference"}, {"known_bare", "known_reference"}}) {
    files({"pattern", "stripes", "--rig", "rig.yaml", "--scan", seen, "--gray-code", "--out", reference});
  }
  world_->look_at(*marked_);
  lit_ = world_->lit();
  faces_ = face_interiors(rig_, lit_);
  live({"scan", "--rig", "rig.yaml", "--images", "--out", "scan"});
  live({"scan", "--rig", "rig.yaml", "--self-projected", "reference", "--e", "8", "--out", "part"});
  record("codes", "known_codes", gray_.white());
  record("known_reference", "known_stripes", 8);
  files({"depth", "--rig", "rig.yaml", "--bits", std::to_string(gray_.column_bits()), "--row-bits",
         std::to_string(gray_.row_bits()), "--out", "known_scan", "known_codes"});
  std::vector<std::string> match = {"match", "--rig", "rig.yaml", "--reference", "known_reference", "--e", "8", "--out", "known_part"};
  for (int i = 0; i < 8; ++i) { match.push_back(fmt::format("known_stripes/image_{:02}.png", i)); }
  files(match);
  /* "--rig", "rig.yaml", "--reference", "known_reference", "--e", "8", "--out", "known_part", "known_stripes"});*/
  std::system(("cp -r " + folder_.path().string() + " /tmp/live_b4").c_str());
  compare("gray", figures("scan", false), figures("known_scan", false));
  compare("self", figures("part", true), figures("known_part", true));
}

}  // namespace
}  // namespace selfproj::test
