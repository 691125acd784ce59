// Tests the light section live, and what ends a capture from outside: Aravis' fake GigE camera looks at a scene that a
// virtual display lights.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/targets.h"
#include "tests/cli/program.h"
#include "tests/host/camera/gige_camera.h"
#include "tests/host/capture/live_world.h"
#include "tests/support/virtual_screen.h"

namespace selfproj::test {
namespace {

class LiveLine : public LiveTest {
 protected:
  LiveLine() : LiveTest(rig::load_rig("light-section")) {}
  void prepare() override { look(good_, {}); }

  // The median difference from the reference in mm of what is before the camera now, under the reference's pattern.
  double difference(const std::string& out) {
    const Outcome inspected = run({"inspect", "--device", "camera:127.0.0.1?rate=50", "--reference", "reference",
                                   "--count", "40", "--json", out + ".json", "--out", out});
    EXPECT_EQ(inspected.status, 0) << inspected.err;
    const auto counters = nlohmann::json::parse(read_text(folder_ / (out + ".json")));
    EXPECT_EQ(counters["delivered"], 40);
    const images::FloatImage map = images::read_float_tiff((folder_ / out / "difference.tiff").string());
    std::vector<float> values;
    std::copy_if(map.values.begin(), map.values.end(), std::back_inserter(values),
                 [](float value) { return !std::isnan(value); });
    EXPECT_GT(values.size(), map.values.size() * 9 / 10) << out;
    std::sort(values.begin(), values.end());
    return values.empty() ? 1e9 : static_cast<double>(values[values.size() / 2]);
  }

  bool black() const {
    const std::vector<std::uint8_t> shown = screen_->picture();
    return std::count(shown.begin(), shown.end(), 0) == static_cast<std::ptrdiff_t>(shown.size());
  }

  sim::FlatPlate good_{0, {}, 0};
  sim::FlatPlate high_{2, {}, 0};
};

// Scan a good part by lines, make its pattern, and watch under this pattern: the good part, and one that is 2 mm
// higher.
TEST_F(LiveLine, DifferenceFromAScannedPart) {
  ASSERT_EQ(run({"pattern", "--sweep", "--every", "16", "--out", "lines"}).status, 0);
  const Outcome captured =
      run({"capture", "--camera", "camera:127.0.0.1?region=512x96", "--patterns", "lines", "--out", "seen"});
  ASSERT_EQ(captured.status, 0) << captured.err;
  const Outcome pattern = run({"pattern", "--scan", "seen", "--every", "16", "--out", "reference"});
  ASSERT_EQ(pattern.status, 0) << pattern.err;
  // The pattern is shown until a file says that it is enough.
  std::thread projector([&] {
    run_program(
        "/bin/sh",
        {"-c", "\"$0\" project reference/pattern.png & while ! test -e enough; do sleep 0.1; done; kill -INT $!; wait",
         SELFPROJ_PROGRAM},
        folder_.path());
  });
  std::this_thread::sleep_for(std::chrono::seconds(1));
  const double same = difference("same");
  world_->look_at(high_);
  const double higher = difference("higher");
  write_text(folder_ / "enough", "");
  projector.join();
  EXPECT_NEAR(same, 0, 0.05);
  EXPECT_NEAR(higher, 2, 0.1);
}

// The camera goes in the middle of a sequence: one line, nothing is written, and the display is black again.
TEST_F(LiveLine, ACameraThatIsUnplugged) {
  ASSERT_EQ(run({"pattern", "--sweep", "--every", "16", "--out", "lines"}).status, 0);
  const std::vector<std::string> before = folder_.names();
  std::thread unplug([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(2500));
    world_.reset();
  });
  const Outcome outcome = run({"capture", "--camera", "camera:127.0.0.1?region=512x96", "--patterns", "lines",
                               "--settle-ms", "300", "--out", "seen"});
  unplug.join();
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_NE(outcome.err.find("camera:127.0.0.1"), std::string::npos) << outcome.err;
  EXPECT_EQ(folder_.names(), before);
  EXPECT_TRUE(black());
}

// The disk is full: one line, nothing is left, and the display is black again.
TEST_F(LiveLine, AFullDisk) {
  std::filesystem::create_directory(folder_ / "full");
  ASSERT_EQ(run({"pattern", "--sweep", "--every", "64", "--out", "lines"}).status, 0);
  const std::string mounted =
      "mount -t tmpfs -o size=64k tmpfs full || exit 77\n" SELFPROJ_PROGRAM
      " capture --camera 'camera:127.0.0.1?region=512x96' --patterns lines --settle-ms 50 --out "
      "full/seen; status=$?; ls -A full; exit $status";
  const Outcome outcome = run_program("/usr/bin/unshare", {"--mount", "/bin/sh", "-c", mounted}, folder_.path());
  if (outcome.status == 77) {
    GTEST_SKIP() << "this system allows no file system of one's own";
  }
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_NE(outcome.err.find("No space left on device"), std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.out.find("seen\n"), std::string::npos) << outcome.out;
  EXPECT_TRUE(black());
}

}  // namespace
}  // namespace selfproj::test
