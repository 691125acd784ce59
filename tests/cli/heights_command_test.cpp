// Tests selfproj calibrate heights from the command line.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/images/image_files.h"
#include "host/light_section/scan.h"
#include "host/rig/geometry.h"
#include "selfproj/rig/rig.h"
#include "tests/cli/program.h"
#include "tests/cli/refusal.h"

namespace selfproj::test {
namespace {

constexpr int kEvery = 16;

// The camera images of a sweep over a plate at this height of a rig whose projector is tilted by 0.1 degrees more: one
// line in five rows of light, from (3.4).
void write_sweep(const std::filesystem::path& folder, double height) {
  std::filesystem::create_directory(folder);
  rig::Rig real = rig::load_rig("light-section");
  real.projector.tilt_rad += 0.1 * 3.14159265 / 180;
  const double z = real.plane_z_mm - height;
  for (const int line : light_section::sweep_lines(real, kEvery)) {
    const double theta = rig::tan_theta(real.projector, line);
    const double alpha = (real.projector.x_mm - (z - real.projector.z_mm) * theta) / z;
    const double row = rig::centroid_of(real.camera, alpha) - 1;
    images::Image image{real.camera.rows, real.camera.columns, std::vector<std::uint8_t>(real.camera.pixels(), 0)};
    for (int r = 0; r < image.rows; ++r) {
      const double grey = 220 * std::exp(-0.5 * (r - row) * (r - row) / 2.5);
      for (int c = 0; c < image.columns; ++c) {
        image.pixels[static_cast<std::size_t>(r * image.columns + c)] = static_cast<std::uint8_t>(std::lround(grey));
      }
    }
    write_text(folder / ("line_" + std::to_string(line) + ".png"), images::encode_png(image));
  }
}

Outcome heights(const ScratchFolder& folder, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"calibrate", "heights", "--every", std::to_string(kEvery)});
  return run_program(SELFPROJ_PROGRAM, arguments, folder.path());
}

// One line that begins with this text, and nothing written.
void expect_refused(const ScratchFolder& folder, const Outcome& outcome, const std::string& begin, int status = 2) {
  expect_refusal(outcome, begin, {}, status);
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST(HeightsCommand, CorrectsARigAndChecksIt) {
  const ScratchFolder folder;
  for (const int height : {0, 10, 15, 20, 30}) {
    write_sweep(folder / ("at" + std::to_string(height)), height);
  }
  expect_refused(folder, heights(folder, {"--heights", "15", "--check", "at15"}), "--check: at15: in columns ", 1);
  const Outcome made = heights(folder, {"--heights", "0,10,20,30", "--out", "line", "at0", "at10", "at20", "at30"});
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_NE(made.out.find("left open: "), std::string::npos) << made.out;
  const rig::Rig rig = rig::load_rig((folder / "line" / "rig.yaml").string());
  ASSERT_TRUE(rig.heights);
  EXPECT_TRUE(std::filesystem::exists(folder / "line" / "report.json"));
  const Outcome good = heights(folder, {"--rig", "line/rig.yaml", "--heights", "15", "--check", "at15"});
  EXPECT_EQ(good.status, 0) << good.err;
  // Other commands take the rig.
  const Outcome pattern = run_program(
      SELFPROJ_PROGRAM,
      {"pattern", "--rig", "line/rig.yaml", "--scan", "at20", "--every", std::to_string(kEvery), "--out", "part"},
      folder.path());
  ASSERT_EQ(pattern.status, 0) << pattern.err;
  // The wrong order, and other bad input.
  expect_refused(folder, heights(folder, {"--heights", "0,10,20", "--out", "out", "at0", "at20", "at10"}),
                 "at20: is given as 10 mm above at0, but the rig sees it");
  expect_refused(folder, heights(folder, {"--heights", "0,20,10", "--out", "out", "at0", "at20", "at10"}),
                 "--heights: 10 follows 20; numbers are expected in ascending order");
  expect_refused(folder, heights(folder, {"--heights", "0,20", "--out", "out", "at0", "at20"}),
                 "heights: 2 are too few; 3 or more are needed, 5 are good");
  expect_refused(folder, heights(folder, {"--heights", "0,20", "--out", "out", "at0"}),
                 "--heights: has 2 heights for 1 folders");
  expect_refused(folder, heights(folder, {"--out", "out", "at0"}), "--heights, --steps: exactly one of them is needed");
  expect_refused(folder, heights(folder, {"--heights", "0,5,20", "--out", "out", "at0", "at10", "at20"}),
                 "at10: is given as 5 mm above at0, but the rig sees it");
  expect_refused(folder, heights(folder, {"--heights", "0,13.4,26.8", "--out", "out", "at0", "at10", "at20"}),
                 "heights: the rig sees 0.7", 1);
  std::filesystem::remove(folder / "at20" / "line_64.png");
  expect_refused(folder, heights(folder, {"--heights", "0,10,20", "--out", "out", "at0", "at10", "at20"}),
                 "at20: has 30 images; a sweep of this rig with --every 16 has 31");
}

}  // namespace
}  // namespace selfproj::test
