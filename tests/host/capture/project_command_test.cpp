// Tests selfproj project on a virtual display, by reading its frame buffer, and the curve of a projector.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "host/capture/grey_curve.h"
#include "host/images/image_files.h"
#include "tests/cli/program.h"
#include "tests/support/error_of.h"
#include "tests/support/random_cases.h"
#include "tests/support/virtual_screen.h"

namespace selfproj::test {
namespace {

using Pixels = std::vector<std::uint8_t>;

constexpr int kColumns = 90;
constexpr int kRows = 40;

class ProjectCommand : public testing::Test {
 protected:
  void SetUp() override {
    if (!VirtualScreen::installed()) {
      GTEST_SKIP() << "Xvfb is not installed";
    }
    screen_ = std::make_unique<VirtualScreen>(kColumns, kRows, screen_folder_.path());
  }

  // A random pattern as a file.
  Pixels pattern(const std::string& name, std::uint64_t seed, int columns = kColumns) {
    const images::Image image{kRows, columns, Random(seed).bytes(static_cast<std::size_t>(columns) * kRows)};
    write_text(folder_ / name, images::encode_png(image));
    return image.pixels;
  }

  // Runs it while it notes each picture that differs from the one before.
  Outcome run(const std::vector<std::string>& arguments, std::vector<Pixels>& seen) {
    std::atomic<bool> done = false;
    Outcome outcome;
    std::thread program([&] {
      outcome = run_program(SELFPROJ_PROGRAM, arguments, folder_.path());
      done = true;
    });
    seen = {screen_->picture()};
    while (!done) {
      bool grey = false;
      const Pixels now = screen_->picture(&grey);
      if (now != seen.back() && now == screen_->picture()) {  // no picture that is just being drawn
        EXPECT_TRUE(grey);
        seen.push_back(now);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    program.join();
    return outcome;
  }

  ScratchFolder screen_folder_;
  ScratchFolder folder_;
  std::unique_ptr<VirtualScreen> screen_;
};

TEST_F(ProjectCommand, ShowsEveryPixelOfASequenceBetweenBlack) {
  const std::vector<Pixels> patterns = {pattern("p1.png", 1), pattern("p2.png", 2), pattern("p10.png", 3)};
  std::vector<Pixels> seen;
  const Outcome outcome = run({"project", "--seconds", "0.3", "."}, seen);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "3 patterns shown on display 0\n");
  // The root window of the server is black, too, so that black before and after adds no picture.
  const Pixels black(patterns[0].size(), 0);
  EXPECT_EQ(seen, (std::vector<Pixels>{black, patterns[0], patterns[1], patterns[2], black}));
}

TEST_F(ProjectCommand, CurveIsApplied) {
  const Pixels shown = pattern("p.png", 5);
  capture::GreyCurve curve;
  for (int grey = 0; grey <= 255; grey += 5) {
    curve.points.push_back({static_cast<double>(grey), 3 + std::pow(grey / 255.0, 2.2)});
  }
  write_text(folder_ / "gamma.csv", capture::grey_curve_text(curve));
  std::vector<Pixels> seen;
  const Outcome outcome = run({"project", "--seconds", "0.3", "--gamma", "gamma.csv", "p.png"}, seen);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  ASSERT_EQ(seen.size(), 3U);
  for (std::size_t i = 0; i < shown.size(); ++i) {
    const double light = std::pow(seen[1][i] / 255.0, 2.2);
    ASSERT_NEAR(light, shown[i] / 255.0, 0.006) << static_cast<int>(shown[i]);
  }
}

TEST_F(ProjectCommand, Refusals) {
  pattern("wide.png", 1, kColumns + 1);
  pattern("good.png", 1);
  std::vector<Pixels> seen;
  EXPECT_EQ(run({"project", "--seconds", "0.3", "wide.png"}, seen).err,
            "selfproj: wide.png: has 91 x 40 pixels, but --display 0 has 90 x 40\n");
  EXPECT_EQ(run({"project", "--display", "1", "good.png"}, seen).err,
            "selfproj: --display 1: there is no such display, only display 0\n");
  EXPECT_EQ(seen.size(), 1U) << "nothing is shown";
  write_text(folder_ / "bad.csv", "grey,light\n0,1\n255,0.5\n");
  EXPECT_EQ(run({"project", "--gamma", "bad.csv", "good.png"}, seen).err,
            "selfproj: bad.csv: line 3: grey must rise and light must not fall\n");
  screen_->end();
  const Outcome none = run_program(SELFPROJ_PROGRAM, {"project", "good.png"}, folder_.path());
  EXPECT_EQ(none.status, 2);
  EXPECT_TRUE(none.err.starts_with("selfproj: --display 0: no screen can be reached: ")) << none.err;
}

TEST(GreyCurve, LightBecomesProportionalToGrey) {
  capture::GreyCurve straight{{{0, 10}, {255, 20}}};
  EXPECT_EQ(capture::linear_greys(straight), capture::plain_greys());
  capture::GreyCurve bent{{{0, 0}, {128, 0}, {255, 100}}};  // nothing up to 128
  const capture::GreyTable table = capture::linear_greys(bent);
  EXPECT_EQ(table[0], 0);
  EXPECT_EQ(table[255], 255);
  for (int grey = 1; grey < 256; ++grey) {
    const double wanted = 100.0 * grey / 255;
    double best = 1e9;
    for (int level = 0; level < 256; ++level) {
      best = std::min(best, std::abs(bent.light_at(level) - wanted));
    }
    EXPECT_LE(std::abs(bent.light_at(table[static_cast<std::size_t>(grey)]) - wanted), best + 1e-9) << grey;
  }
}

TEST(GreyCurve, RefusesWhatIsNoCurve) {
  const ScratchFolder folder;
  const auto refusal = [&](const std::string& text) {
    const std::string file = folder / "c.csv";
    write_text(file, text);
    const std::string error = error_of([&] { capture::load_grey_curve(file); });
    return error.starts_with(file) ? error.substr(file.size()) : error;
  };
  EXPECT_EQ(refusal("grey,light\n0,1\n255,2\n"), "none");
  EXPECT_EQ(refusal("0,1\n255,2\n"), ": does not begin with the line grey,light");
  EXPECT_EQ(refusal("grey,light\n0,1\n254,2\n"), ": grey does not go from 0 to 255");
  EXPECT_EQ(refusal("grey,light\n0,1\nx,2\n"), ": line 3: is no pair grey,light");
  EXPECT_EQ(refusal("grey,light\n0,1\n255,1\n"), ": light does not rise");
  EXPECT_EQ(refusal("grey,light\n"), ": grey does not go from 0 to 255");
}

}  // namespace
}  // namespace selfproj::test
