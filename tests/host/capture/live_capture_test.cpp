// Tests live captures: Aravis' fake GigE camera looks at a scene that a virtual display lights.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <string>
#include <thread>
#include <vector>

#include "host/capture/grey_curve.h"
#include "host/files/results_file.h"
#include "host/images/image_files.h"
#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/gray_sequence.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/scene.h"
#include "sim/scene/scenes.h"
#include "tests/cli/program.h"
#include "tests/host/camera/gige_camera.h"
#include "tests/host/capture/live_world.h"
#include "tests/host/capture/small_scanner.h"
#include "tests/support/virtual_screen.h"

namespace selfproj::test {
namespace {

constexpr int kBits = 7;  // of 96 lines

class LiveCapture : public LiveTest {
 protected:
  LiveCapture() : LiveTest(small_scanner(8, 8)) {}
  void prepare() override {
    scene_ = sim::make_scene("desk", rig_);
    write_text(folder_ / "small.yaml", rig::to_yaml(rig_));
    std::filesystem::create_directory(folder_ / "gray");
    patterns_ = sim::gray_patterns(rig_.projector, kBits);
    for (std::size_t i = 0; i < patterns_.size(); ++i) {
      write_text(folder_ / "gray" / ("pattern_" + std::to_string(i) + ".png"), images::encode_png(patterns_[i]));
    }
  }

  void look(const WorldFaults& faults) { LiveTest::look(*scene_, faults); }

  Outcome capture(const std::string& settings = "") {
    return run(
        {"capture", "--camera", "camera:127.0.0.1?region=64x64" + settings, "--patterns", "gray", "--out", "seen"});
  }

  std::unique_ptr<sim::Scene> scene_;
  std::vector<images::Image> patterns_;
};

TEST_F(LiveCapture, DepthThroughRandomDelaysAndLostPackets) {
  look({.min_delay_ms = 0, .max_delay_ms = 60, .lost = 0.005});
  const Outcome captured = capture();
  ASSERT_EQ(captured.status, 0) << captured.err;
  const auto record = nlohmann::json::parse(read_text(folder_ / "seen" / "capture.json"));
  EXPECT_EQ(record["trigger"], "software");
  EXPECT_GE(record["settle_ms"], 60.0) << captured.out;
  ASSERT_EQ(record["images"].size(), patterns_.size());
  EXPECT_EQ(record["images"][13]["image"], "image_0014.png");
  EXPECT_EQ(record["images"][13]["pattern"], "pattern_13.png");
  // The recorded route: the same images by the renderer, without display, camera and network.
  std::filesystem::create_directory(folder_ / "recorded");
  std::vector<images::Image> recorded;
  for (std::size_t i = 0; i < patterns_.size(); ++i) {
    recorded.push_back(world_->image_under(patterns_[i]));
    write_text(folder_ / "recorded" / ("image_" + std::to_string(i) + ".png"), images::encode_png(recorded.back()));
  }
  for (std::size_t i = 0; i < recorded.size(); ++i) {
    const images::Image seen =
        images::read_image((folder_ / "seen" / record["images"][i]["image"].get<std::string>()).string(), std::nullopt);
    for (std::size_t k = 0; k < recorded.size(); ++k) {
      const double off = mean_difference(seen, recorded[k]);
      EXPECT_EQ(off < kOtherPattern, k == i) << "image " << i << " under pattern " << k << ": " << off;
    }
  }
  const std::string bits = std::to_string(kBits);
  for (const auto& [out, taken] : {std::pair("live", "seen"), std::pair("known", "recorded")}) {
    const Outcome outcome = run({"depth", "--rig", "small.yaml", "--bits", bits, "--out", out, taken});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
  }
  const DepthErrors live = depth_errors(folder_ / "live" / "depth.tiff", world_->truth());
  const DepthErrors known = depth_errors(folder_ / "known" / "depth.tiff", world_->truth());
  EXPECT_GT(known.pixels, 2000U);
  EXPECT_NEAR(static_cast<double>(live.pixels), static_cast<double>(known.pixels), 40);
  EXPECT_NEAR(live.median_mm, known.median_mm, 0.02 * known.median_mm);
}

// How many scans the next test makes: one, or what SELFPROJ_LIVE_SCANS says.
int scans_wanted() {
  const char* wanted = std::getenv("SELFPROJ_LIVE_SCANS");
  return wanted == nullptr ? 1 : std::max(1, std::atoi(wanted));
}

// Projects, captures and measures in one run, through random delays, lost packets and torn pictures. Each image is the
// one of its pattern, and the depth that of the recorded route: the same images by the renderer.
TEST_F(LiveCapture, ScanByGrayCodes) {
  const structured_light::GraySequence gray(rig_.projector.columns, rig_.projector.lines);
  std::vector<images::Image> recorded;
  std::uint64_t wrong_images = 0;
  std::uint64_t lost = 0;
  std::uint64_t mixed = 0;
  int torn = 0;
  double most_off = 0;
  const int scans = scans_wanted();
  for (int scan = 1; scan <= scans; ++scan) {
    SCOPED_TRACE(fmt::format("scan {}", scan));
    world_.reset();
    look({.min_delay_ms = 0,
          .max_delay_ms = 120,
          .lost = 0.005,
          .torn_percent = 1,
          .torn_ms = 300,
          .seed = static_cast<std::uint64_t>(scan)});
    for (int i = 0; recorded.size() < static_cast<std::size_t>(gray.white()); ++i) {
      recorded.push_back(world_->image_under({gray.rows(), gray.columns(), gray.image(i)}));
    }
    const Outcome outcome =
        run({"scan", "--camera", "camera:127.0.0.1?region=64x64", "--rig", "small.yaml", "--images", "--out", "scan"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    for (std::size_t i = 0; i < recorded.size(); ++i) {
      const std::string seen = (folder_ / "scan" / fmt::format("image_{:04}.png", i + 1)).string();
      const double off = mean_difference(images::read_image(seen, std::nullopt), recorded[i]);
      most_off = std::max(most_off, off);
      wrong_images += off < kOtherPattern ? 0 : 1;
    }
    const auto record = nlohmann::json::parse(read_text(folder_ / "scan" / "capture.json"));
    lost += record["retaken_incomplete"].get<std::uint64_t>() + record["retaken_missing"].get<std::uint64_t>();
    mixed += record["retaken_mixed"].get<std::uint64_t>();
    torn += world_->torn();
  }
  EXPECT_EQ(wrong_images, 0U);
  const std::string column_bits = std::to_string(gray.column_bits());
  const std::string row_bits = std::to_string(gray.row_bits());
  std::vector<std::string> known = {"depth",      "--rig",  "small.yaml", "--bits", column_bits,
                                    "--row-bits", row_bits, "--out",      "known"};
  for (std::size_t i = 0; i < recorded.size(); ++i) {
    known.push_back("recorded_" + std::to_string(i) + ".png");
    write_text(folder_ / known.back(), images::encode_png(recorded[i]));
  }
  ASSERT_EQ(run(known).status, 0);
  const DepthErrors live = depth_errors(folder_ / "scan" / "depth.tiff", world_->truth());
  const DepthErrors files = depth_errors(folder_ / "known" / "depth.tiff", world_->truth());
  EXPECT_GT(files.pixels, 2000U);
  EXPECT_NEAR(static_cast<double>(live.pixels), static_cast<double>(files.pixels), 40);
  EXPECT_NEAR(live.median_mm, files.median_mm, 0.02 * files.median_mm);
  EXPECT_NE(read_text(folder_ / "scan" / "report.html").find("The camera under white light"), std::string::npos);
  EXPECT_FALSE(read_text(folder_ / "scan" / "cloud.ply").empty());
  files::write_results(
      "live_scans",
      "Live scans with Aravis' fake camera and a virtual display: random delays of 0 to 120 ms, 0.5 % of the network "
      "packets lost, 1 % of the pictures torn for 300 ms",
      {{"scans", scans},
       {"images", static_cast<std::uint64_t>(scans) * recorded.size()},
       {"images_of_another_pattern", wrong_images},
       {"pictures_torn", torn},
       {"images_taken_again_for_lost_packets", lost},
       {"images_taken_again_for_two_patterns", mixed},
       {"largest_mean_difference", most_off},
       {"median_depth_error_mm", live.median_mm},
       {"median_depth_error_of_files_mm", files.median_mm}});
}

// A quarter of the pictures appear in parts, for longer than the settle time that is given. Every image is the one of
// its pattern all the same, and what was taken again is counted.
TEST_F(LiveCapture, TornPicturesAreTakenAgain) {
  look({.max_delay_ms = 10, .torn_percent = 25, .torn_ms = 150, .same_noise = true});
  const Outcome captured = run({"capture", "--camera", "camera:127.0.0.1?region=64x64", "--patterns", "gray",
                                "--settle-ms", "30", "--out", "seen"});
  ASSERT_EQ(captured.status, 0) << captured.err;
  for (std::size_t i = 0; i < patterns_.size(); ++i) {
    const images::Image seen =
        images::read_image((folder_ / "seen" / fmt::format("image_{:04}.png", i + 1)).string(), std::nullopt);
    EXPECT_EQ(seen.pixels, world_->image_under(patterns_[i]).pixels) << i;
  }
  EXPECT_GT(world_->torn(), 0);
  const auto record = nlohmann::json::parse(read_text(folder_ / "seen" / "capture.json"));
  EXPECT_GT(record["retaken_mixed"], 0);
}

// Under blurred stripes a camera with a bent curve sees less light than half of white. That is so each time, and
// counts.
TEST_F(LiveCapture, ABentCurveOfTheCameraIsNoTearing) {
  look({.gain = 2, .bend = 3});
  std::filesystem::create_directory(folder_ / "fine");
  images::Image lines = patterns_[0];
  for (const char* file : {"0.png", "1.png"}) {
    for (std::size_t i = 0; i < lines.pixels.size(); ++i) {
      const std::size_t line = i / static_cast<std::size_t>(lines.columns);
      lines.pixels[i] = line % 2 == (file[0] == '0' ? 0 : 1) ? 255 : 0;
    }
    write_text(folder_ / "fine" / file, images::encode_png(lines));
  }
  const Outcome captured = run({"capture", "--camera", "camera:127.0.0.1?region=64x64", "--patterns", "fine",
                                "--settle-ms", "30", "--out", "seen"});
  ASSERT_EQ(captured.status, 0) << captured.err;
  const auto record = nlohmann::json::parse(read_text(folder_ / "seen" / "capture.json"));
  EXPECT_GE(record["retaken_mixed"], 4) << "the images that count are those of the third time";
}

// The reference is scanned by the same display and camera, then measured itself: no difference.
TEST_F(LiveCapture, ScanWithTheReferencesOwnPatterns) {
  look({.min_delay_ms = 20, .max_delay_ms = 20, .tick_ms = 40});
  const std::vector<std::string> camera = {"--camera", "camera:127.0.0.1?region=64x64"};
  ASSERT_EQ(run({"pattern", "gray", "--rig", "small.yaml", "--out", "codes"}).status, 0);
  ASSERT_EQ(run({"capture", camera[0], camera[1], "--patterns", "codes", "--out", "reference_seen"}).status, 0);
  // The tick of the camera makes it seem that the light follows at once.
  const auto record = nlohmann::json::parse(read_text(folder_ / "reference_seen" / "capture.json"));
  EXPECT_GE(record["settle_ms"], 20.0);
  EXPECT_LE(record["settle_ms"], 20.0 + world_->look_ms() + 20);
  const Outcome stripes = run(
      {"pattern", "stripes", "--rig", "small.yaml", "--scan", "reference_seen", "--gray-code", "--out", "reference"});
  ASSERT_EQ(stripes.status, 0) << stripes.err;
  const Outcome scan = run({"scan", camera[0], camera[1], "--rig", "small.yaml", "--self-projected", "reference", "--e",
                            "8", "--out", "scan"});
  ASSERT_EQ(scan.status, 0) << scan.err;
  const images::FloatImage difference = images::read_float_tiff((folder_ / "scan" / "difference.tiff").string());
  std::vector<float> off;
  std::copy_if(difference.values.begin(), difference.values.end(), std::back_inserter(off),
               [](float value) { return !std::isnan(value); });
  ASSERT_GT(off.size(), 1500U);
  for (float& value : off) {
    value = std::abs(value);
  }
  std::sort(off.begin(), off.end());
  // A projector line of this rig is worth 16 mm of depth; a code is three lines wide on the reference.
  EXPECT_LT(off[off.size() / 2], 16);
}

TEST_F(LiveCapture, ScansOfAnotherRigAreRefusedBeforeAnythingIsShown) {
  look({});
  const std::vector<std::string> before = folder_.names();
  const Outcome other = run({"scan", "--camera", "camera:127.0.0.1?region=64x64", "--rig", "scanner", "--out", "scan"});
  EXPECT_EQ(other.status, 2);
  EXPECT_EQ(other.err, "selfproj: --rig scanner: its projector has 1024 x 768, but display 0 has 128 x 96\n");
  const Outcome region =
      run({"scan", "--camera", "camera:127.0.0.1?region=32x32", "--rig", "small.yaml", "--out", "scan"});
  EXPECT_EQ(region.status, 2);
  EXPECT_NE(region.err.find("is for images of"), std::string::npos) << region.err;
  const Outcome both =
      run({"scan", "--camera", "camera:127.0.0.1", "--rig", "small.yaml", "--calibration", "c.yaml", "--out", "scan"});
  EXPECT_EQ(both.status, 2);
  EXPECT_EQ(both.err, "selfproj: --rig, --calibration: exactly one of them is needed\n");
  EXPECT_EQ(folder_.names(), before);
}

TEST_F(LiveCapture, GammaIsMeasuredAndCompensated) {
  constexpr double kGamma = 2.2;
  look({.gain = 0.9, .gamma = kGamma});
  const std::vector<std::string> measure = {"measure",     "gamma", "--camera", "camera:127.0.0.1?region=64x64",
                                            "--settle-ms", "30",    "--out",    "gamma.csv"};
  const Outcome measured = run(measure);
  ASSERT_EQ(measured.status, 0) << measured.err;
  const capture::GreyCurve curve = capture::load_grey_curve((folder_ / "gamma.csv").string());
  ASSERT_EQ(curve.points.size(), 18U);
  for (const capture::GreyCurve::Point& point : curve.points) {
    EXPECT_NEAR(point.light / curve.points.back().light, std::pow(point.grey / 255, kGamma), 0.02) << point.grey;
  }
  std::smatch found;
  ASSERT_TRUE(std::regex_search(measured.out, found, std::regex("gamma ([0-9.]+),"))) << measured.out;
  EXPECT_NEAR(std::stod(found[1]), kGamma, 0.02 * kGamma);
  std::vector<std::string> check = measure;
  check.back() = "check.csv";
  check.insert(check.end(), {"--gamma", "gamma.csv"});
  const Outcome checked = run(check);
  ASSERT_EQ(checked.status, 0) << checked.err;
  const capture::GreyCurve straight = capture::load_grey_curve((folder_ / "check.csv").string());
  for (const capture::GreyCurve::Point& point : straight.points) {
    EXPECT_NEAR(point.light / straight.points.back().light, point.grey / 255, 0.02) << point.grey;
  }
}

// A projector that triggers the camera: image k shows pattern k modulo 14. The camera's images are decoded as they
// come, and the depth is that of the same images as files.
TEST_F(LiveCapture, DepthOfACameraThatTheProjectorTriggers) {
  look({});
  std::vector<images::Image> images;
  std::vector<std::string> known = {"depth", "--rig", "small.yaml", "--bits", std::to_string(kBits), "--out", "known"};
  for (const images::Image& pattern : patterns_) {
    images.push_back(world_->image_under(pattern));
    known.push_back("known_" + std::to_string(images.size()) + ".png");
    write_text(folder_ / known.back(), images::encode_png(images.back()));
  }
  world_.reset();
  const GigeCamera camera([&](const Picture& picture) {
    const images::Image& image = images[picture.number % images.size()];
    const std::size_t pixels = static_cast<std::size_t>(picture.rows) * static_cast<std::size_t>(picture.columns);
    std::copy_n(image.pixels.begin(), std::min(pixels, image.pixels.size()), picture.pixels);
  });
  const Outcome live = run({"depth", "--rig", "small.yaml", "--bits", std::to_string(kBits), "--device",
                            "camera:127.0.0.1?region=64x64&rate=100", "--count", "20", "--out", "live"});
  ASSERT_EQ(live.status, 0) << live.err;
  const Outcome as_files = run(known);
  ASSERT_EQ(as_files.status, 0) << as_files.err;
  const images::FloatImage seen = images::read_float_tiff((folder_ / "live" / "depth.tiff").string());
  const images::FloatImage expected = images::read_float_tiff((folder_ / "known" / "depth.tiff").string());
  ASSERT_EQ(seen.values.size(), expected.values.size());
  for (std::size_t i = 0; i < seen.values.size(); ++i) {
    ASSERT_EQ(std::isnan(seen.values[i]), std::isnan(expected.values[i])) << i;
    ASSERT_TRUE(std::isnan(seen.values[i]) || seen.values[i] == expected.values[i]) << i;
  }
}

// The camera runs free: the fake one takes a triggered image up to 40 ms after the trigger, so that there the truth is
// not known.
TEST_F(LiveCapture, SettleTimeIsFoundWithinTenMilliseconds) {
  look({.min_delay_ms = 70, .max_delay_ms = 70, .gain = 2});
  const Outcome captured = capture("&trigger=free&rate=100&exposure-us=1000");
  ASSERT_EQ(captured.status, 0) << captured.err;
  const auto record = nlohmann::json::parse(read_text(folder_ / "seen" / "capture.json"));
  // At most: a busy machine makes display and camera late, too.
  const double truth = 70 + world_->look_ms() + std::max(world_->image_ms() - 10, 0.0);
  EXPECT_LE(record["delay_min_ms"], truth + 10);
  EXPECT_GE(record["delay_max_ms"], 70.0);
  EXPECT_LE(record["delay_max_ms"], truth + 10);
  EXPECT_NE(captured.out.find("; try 0.5 times the exposure\n"), std::string::npos) << captured.out;
}

TEST_F(LiveCapture, PatternsAreNotOverwritten) {
  look({});
  std::filesystem::create_directory(folder_ / "shown");
  const std::string pattern = images::encode_png(patterns_[0]);
  write_text(folder_ / "shown" / "image_0001.png", pattern);
  const Outcome onto = run({"capture", "--camera", "camera:127.0.0.1?region=64x64", "--patterns", "shown",
                            "--settle-ms", "50", "--out", "shown"});
  EXPECT_EQ(onto.status, 2);
  EXPECT_NE(onto.err.find("shown: is the folder whose files are read"), std::string::npos) << onto.err;
  EXPECT_EQ(read_text(folder_ / "shown" / "image_0001.png"), pattern);
  const std::filesystem::directory_iterator shown(folder_ / "shown");
  EXPECT_EQ(std::distance(begin(shown), end(shown)), 1);
}

// Whatever ends a capture, there is one line, nothing is written, and the display is black again.
TEST_F(LiveCapture, CtrlCAndADisplayThatGoesLeaveNothing) {
  look({});
  const std::vector<std::string> before = folder_.names();
  const std::vector<std::string> words = {"capture",    "--camera", "camera:127.0.0.1?region=64x64",
                                          "--patterns", "gray",     "--settle-ms",
                                          "300",        "--out",    "seen"};
  // Without --foreground the signal goes to the group, too, and the program gets it twice.
  std::vector<std::string> timed = {"--foreground", "--preserve-status", "-s", "INT", "3", SELFPROJ_PROGRAM};
  timed.insert(timed.end(), words.begin(), words.end());
  const Outcome stopped = run_program("/usr/bin/timeout", timed, folder_.path());
  EXPECT_EQ(stopped.status, 1);
  EXPECT_EQ(stopped.err, "selfproj: seen: stopped before the end, and nothing is written\n");
  EXPECT_EQ(folder_.names(), before);
  const std::vector<std::uint8_t> shown = screen_->picture();
  EXPECT_EQ(std::count(shown.begin(), shown.end(), 0), static_cast<std::ptrdiff_t>(shown.size()));

  std::thread unplug([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(2500));
    screen_->end();
  });
  const Outcome unplugged = run(words);
  unplug.join();
  EXPECT_NE(unplugged.status, 0);
  EXPECT_EQ(std::count(unplugged.err.begin(), unplugged.err.end(), '\n'), 1) << unplugged.err;
  EXPECT_EQ(folder_.names(), before);
}

// While one sets up, a browser sees what the camera sees under white, and how it is exposed. Ctrl-C ends it.
TEST_F(LiveCapture, Preview) {
  look({.gain = 3});
  const std::string script =
      "\"$0\" capture --camera 'camera:127.0.0.1?region=64x64&rate=50' --preview 8080 > said & program=$!\n"
      "for i in $(seq 100); do grep -q http: said && break; sleep 0.1; done; sleep 1\n"
      "fetch() { python3 -c 'import sys, urllib.request as u; "
      "sys.stdout.buffer.write(u.urlopen(\"http://127.0.0.1:8080\" + sys.argv[1], timeout=10).read())' \"$1\"; }\n"
      "fetch / > page.html; fetch /preview.js > page.js; fetch /figures > figures.json; fetch /image.png > image.png\n"
      "kill -INT $program; wait $program";
  const Outcome outcome = run_program("/bin/bash", {"-c", script, SELFPROJ_PROGRAM}, folder_.path());
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(read_text(folder_ / "said"), "camera:127.0.0.1 at http://127.0.0.1:8080/; Esc or Ctrl-C ends it\n");
  EXPECT_NE(read_text(folder_ / "page.html").find("preview.js"), std::string::npos);
  EXPECT_NE(read_text(folder_ / "page.js").find("image.png"), std::string::npos);
  const auto figures = nlohmann::json::parse(read_text(folder_ / "figures.json"));
  EXPECT_EQ(figures["pixels"], "64 x 64");
  EXPECT_NE(figures["saturated (255)"], "0.0 %") << figures;
  const images::Image white{96, 128, std::vector<std::uint8_t>(std::size_t{96} * 128, 255)};
  images::Image expected = world_->image_under(white);
  for (std::uint8_t& pixel : expected.pixels) {
    pixel = static_cast<std::uint8_t>(std::min(255, 3 * pixel));
  }
  EXPECT_LT(mean_difference(images::read_image((folder_ / "image.png").string(), std::nullopt), expected), 6);
  const std::vector<std::uint8_t> shown = screen_->picture();
  EXPECT_EQ(std::count(shown.begin(), shown.end(), 0), static_cast<std::ptrdiff_t>(shown.size()));
  const Outcome both = run({"capture", "--camera", "camera:127.0.0.1", "--preview", "8080", "--out", "seen"});
  EXPECT_EQ(both.err, "selfproj: --preview: captures nothing; leave out --patterns and --out\n");
}

TEST_F(LiveCapture, ACameraThatDoesNotSeeTheProjector) {
  look({.gain = 0});
  const Outcome blind = capture();
  EXPECT_EQ(blind.status, 2);
  EXPECT_EQ(blind.err,
            "selfproj: camera:127.0.0.1: sees no light from the projector: the mean grey is 0.0 under black and 0.0 "
            "under white\n");
}

}  // namespace
}  // namespace selfproj::test
