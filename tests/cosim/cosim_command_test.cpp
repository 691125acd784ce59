// Tests selfproj-sim cosim from the command line: frames in, folder and exit status out.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "host/light_section/pattern.h"
#include "selfproj/images/float_image.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"
#include "sim/scene/scenes.h"
#include "tests/cli/program.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

namespace fs = std::filesystem;

// The frames with the middle of A2's part, in which all three marks are visible.
const std::vector<std::string> kMiddle{"--first", "690"};

class Cosim : public ::testing::Test {
 protected:
  Outcome run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "cosim");
    return run_program(SELFPROJ_SIM_PROGRAM, arguments, folder_.path());
  }
  // Runs with the options for the middle of a scene in front.
  Outcome run_middle(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), kMiddle.begin(), kMiddle.end());
    return run(std::move(arguments));
  }

  // Expects status 2, one line about `about`, and nothing left behind.
  void expect_refused(const std::vector<std::string>& arguments, const std::string& about) {
    SCOPED_TRACE(about);
    const std::vector<std::string> before = folder_.names();
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_NE(outcome.err.find(about), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(folder_.names(), before);
  }

  [[nodiscard]] std::string text(const std::string& name) const { return read_text(folder_ / name); }

  void write_image(const std::string& name, int rows, int columns, std::uint64_t seed) const {
    Random random(seed);
    cv::Mat image(rows, columns, CV_8UC1);
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column) {
        image.at<std::uint8_t>(row, column) = static_cast<std::uint8_t>(random.between(0, 255));
      }
    }
    ASSERT_TRUE(cv::imwrite(folder_ / name, image));
  }

  ScratchFolder folder_;
};

// The last printed line.
std::string last_line(const std::string& text) {
  std::istringstream lines(text);
  std::string last;
  for (std::string line; std::getline(lines, line);) {
    last = line;
  }
  return last;
}

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

TEST_F(Cosim, TheModelWritesAllFilesOfTheContract) {
  const Outcome outcome =
      run_middle({"--engine", "model", "--count", "4", "--out", "out", "--picture-frame", "2", "4"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(last_line(outcome.out), "matched 2048 columns in 4 frames, 0 mismatches");
  EXPECT_EQ(names_in(folder_ / "out"),
            (std::vector<std::string>{"cloud.ply", "difference.png", "difference.tiff", "frame_2.png", "frame_4.png",
                                      "height.png", "height.tiff", "moments.csv", "profile.csv", "report.html",
                                      "summary.json"}));
  const std::string moments = text("out/moments.csv");
  EXPECT_EQ(std::count(moments.begin(), moments.end(), '\n'), 1 + 4 * 512);
  EXPECT_NE(moments.find("\n4,512,"), std::string::npos);
  EXPECT_NE(text("out/summary.json").find("\"matched_columns\": 2048"), std::string::npos);
  EXPECT_EQ(folder_.names(), std::vector<std::string>{"out"});
}

// Marks are 1 mm deep, the treads beside them equal the reference, and the treads are 30, 39 and 21 mm high.
TEST_F(Cosim, MarksShowInTheDifference) {
  ASSERT_EQ(run_middle({"--engine", "model", "--count", "20", "--out", "out"}).status, 0);
  const images::FloatImage difference = images::read_float_tiff(folder_ / "out/difference.tiff");
  const images::FloatImage height = images::read_float_tiff(folder_ / "out/height.tiff");
  ASSERT_EQ(difference.rows, 20);
  ASSERT_EQ(difference.columns, 512);
  const auto share = [](const images::FloatImage& image, double low, double high) {
    const auto inside = std::count_if(image.values.begin(), image.values.end(), [&](float value) {
      return static_cast<double>(value) > low && static_cast<double>(value) < high;
    });
    return static_cast<double>(inside) / static_cast<double>(image.values.size());
  };
  EXPECT_GT(share(difference, -1.1, -0.9), 0.05);
  EXPECT_GT(share(difference, -0.1, 0.1), 0.6);
  EXPECT_EQ(share(difference, 0.2, 100), 0);
  EXPECT_EQ(share(difference, -100, -1.3), 0);
  for (const double tread : {0.0, 21.0, 30.0, 39.0}) {
    EXPECT_GT(share(height, tread - 0.1, tread + 0.1), 0.05) << tread;
  }
}

TEST_F(Cosim, SeedAndDisturbancesAreTheUsers) {
  const auto packets = [&](const std::vector<std::string>& arguments) {
    std::vector<std::string> all{"--engine", "model", "--count", "1", "--packets", "packets"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const Outcome outcome = run_middle(all);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return text("packets");
  };
  const std::string plain = packets({});
  EXPECT_EQ(packets({}), plain);
  EXPECT_NE(packets({"--seed", "5"}), plain);
  const std::string quiet = packets({"--without", "shot-noise,read-noise"});
  EXPECT_NE(quiet, plain);
  EXPECT_EQ(packets({"--without", "shot-noise,read-noise", "--seed", "5"}), quiet);
  EXPECT_NE(packets({"--mode", "binary"}), plain);
  EXPECT_NE(packets({"--threshold", "50"}), plain);
}

TEST_F(Cosim, PacketsAreTheStreamOfTheBoard) {
  ASSERT_EQ(run_middle({"--engine", "model", "--count", "3", "--packets", "packets"}).status, 0);
  const std::string stream = text("packets");
  std::span<const std::uint8_t> left(reinterpret_cast<const std::uint8_t*>(stream.data()), stream.size());
  for (std::uint64_t frame = 0; frame < 3; ++frame) {
    model::PacketView packet;
    ASSERT_EQ(model::parse_packet(left, packet), model::PacketError::none);
    EXPECT_EQ(packet.header.sequence, frame);
    EXPECT_EQ(packet.header.encoder, 10 * frame);
    left = left.subspan(packet.size);
  }
  EXPECT_TRUE(left.empty());
}

// The perturbed rig differs from the assumed one: its projector is turned by 0.02 degrees. Measuring the reference part
// once with its own pattern removes the error.
TEST_F(Cosim, ResidualTakesOutAWrongRig) {
  std::string yaml = rig::to_yaml(rig::load_rig("light-section"));
  const std::size_t at = yaml.find("tilt_deg: 20");
  ASSERT_NE(at, std::string::npos);
  yaml.insert(at + std::string("tilt_deg: 20").size(), ".02");
  write_text(folder_ / "perturbed.yaml", yaml);
  std::vector<double> rms;
  for (const bool residual : {false, true}) {
    std::vector<std::string> arguments{"--engine",
                                       "model",
                                       "--scene",
                                       "mountain",
                                       "--first",
                                       "650",
                                       "--count",
                                       "8",
                                       "--out",
                                       "out",
                                       residual ? "--real-rig" : "--perturbed-rig",
                                       "perturbed.yaml"};
    if (residual) {
      arguments.emplace_back("--residual");
    }
    const Outcome outcome = run(arguments);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.err.find("note: --real-rig is now --perturbed-rig") != std::string::npos, residual);
    double square = 0;
    std::size_t count = 0;
    for (const float value : images::read_float_tiff(folder_ / "out/difference.tiff").values) {
      if (!std::isnan(value)) {
        square += static_cast<double>(value) * static_cast<double>(value);
        ++count;
      }
    }
    ASSERT_EQ(count, 8U * 512);
    rms.push_back(std::sqrt(square / static_cast<double>(count)));
  }
  EXPECT_GT(rms[0], 0.3);  // one row, 0.39 mm
  EXPECT_LT(rms[1], 0.01);
  expect_refused({"--frames", "perturbed.yaml", "--threshold", "9", "--residual"}, "--residual");
}

// A pattern that the shell did not resolve, without a rig: moments, centroids and pictures.
TEST_F(Cosim, RecordedImagesWithoutARig) {
  for (const int i : {1, 2, 3}) {
    write_image("image_" + std::to_string(i) + ".png", 20, 64, static_cast<std::uint64_t>(i));
  }
  const Outcome outcome = run({"--engine", "model", "--frames", "image_*.png", "--threshold", "200", "--out", "out"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(last_line(outcome.out), "matched 192 columns in 3 frames, 0 mismatches");
  EXPECT_EQ(names_in(folder_ / "out"),
            (std::vector<std::string>{"centroid.tiff", "frame_1.png", "frame_2.png", "frame_3.png", "moments.csv",
                                      "report.html", "summary.json"}));
  // The page shows the line in each image, and no lengths.
  const std::string page = text("out/report.html");
  for (const char* part : {"Camera image of frame 1", "Camera image of frame 3", "median", "no rig"}) {
    EXPECT_NE(page.find(part), std::string::npos) << part;
  }
  for (const char* part : {"Height", "Difference", " mm<"}) {
    EXPECT_EQ(page.find(part), std::string::npos) << part;
  }
  // The same table as that of the command `moments`.
  const Outcome moments = run_program(SELFPROJ_SIM_PROGRAM,
                                      {"moments", "--engine", "model", "--mode", "grey-over", "--threshold", "200",
                                       "--out", "moments.csv", "image_1.png", "image_2.png", "image_3.png"},
                                      folder_.path());
  ASSERT_EQ(moments.status, 0) << moments.err;
  EXPECT_EQ(text("out/moments.csv"), text("moments.csv"));
  const images::FloatImage centroid = images::read_float_tiff(folder_ / "out/centroid.tiff");
  EXPECT_EQ(centroid.rows, 3);
  EXPECT_EQ(centroid.columns, 64);
  for (const float row : centroid.values) {
    EXPECT_TRUE(std::isnan(row) || (row >= 1 && row <= 20)) << row;
  }
}

// The background is subtracted, and the picture shows the image as it was taken.
TEST_F(Cosim, BackgroundIsTakenAway) {
  cv::Mat off(20, 64, CV_8UC1, cv::Scalar(90));
  off.rowRange(0, 5).setTo(250);  // brighter than the line, with and without it
  cv::Mat on = off.clone();
  on.rowRange(0, 5).setTo(240);
  on.row(12).setTo(200);
  ASSERT_TRUE(cv::imwrite(folder_ / "on.png", on));
  ASSERT_TRUE(cv::imwrite(folder_ / "off.png", off));
  const Outcome outcome =
      run({"--engine", "model", "--frames", "on.png", "--background", "off.png", "--threshold", "30", "--out", "out"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const images::FloatImage centroid = images::read_float_tiff(folder_ / "out/centroid.tiff");
  EXPECT_TRUE(std::all_of(centroid.values.begin(), centroid.values.end(), [](float row) { return row == 13; }));
  const cv::Mat picture = cv::imread(folder_ / "out/frame_1.png", cv::IMREAD_GRAYSCALE);
  double most = 0;
  cv::minMaxLoc(picture(cv::Rect(70, 40, 20, 10)), nullptr, &most);  // within the first five rows of the image
  EXPECT_EQ(most, 240);
  expect_refused({"--frames", "on.png", "off.png", "on.png", "--background", "off.png", "on.png", "--threshold", "30"},
                 "--background");
  expect_refused({"--frames", "on.png", "--background", "none*.png", "--threshold", "30"}, "none*.png");
}

// Images of the bare plane as the rig's camera takes them are measured as the plane.
TEST_F(Cosim, RecordedImagesWithARig) {
  const rig::Rig rig = rig::load_rig("light-section");
  const double far = rig.plane_z_mm;
  const auto plane = sim::make_scene("plane", rig);
  const sim::LineRenderer renderer(
      rig, *plane, light_section::draw_pattern(rig, light_section::pattern_of_curve(rig, {{-far, far}, {far, far}})));
  cv::Mat image(rig.camera.rows, rig.camera.columns, CV_8UC1);
  renderer.render(0, {image.data, image.total()});
  ASSERT_TRUE(cv::imwrite(folder_ / "plane.png", image));
  const Outcome outcome = run({"--engine", "model", "--frames", "plane.png", "--rig", "light-section", "--out", "out"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const images::FloatImage height = images::read_float_tiff(folder_ / "out/height.tiff");
  ASSERT_EQ(height.columns, 512);
  EXPECT_TRUE(std::all_of(height.values.begin(), height.values.end(),
                          [](float value) { return std::abs(static_cast<double>(value)) < 0.1; }));
}

// The circuits take groups of four columns, so images of other widths get dark columns at the right.
TEST_F(Cosim, AnyWidthIsPaddedForTheCircuits) {
  write_image("odd.png", 20, 66, 3);
  const Outcome outcome = run({"--frames", "odd.png", "--threshold", "9"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(last_line(outcome.out), "matched 68 columns in 1 frames, 0 mismatches");
}

TEST_F(Cosim, WhatIsWrongIsSaidInOneLine) {
  write_image("a.png", 20, 64, 1);
  write_image("b.png", 21, 64, 2);
  write_text(folder_ / "text.png", "no image");
  write_text(folder_ / "file", "");
  expect_refused({"--scene", "nowhere"}, "nowhere");
  expect_refused({"--scene", "plane", "--frames", "a.png"}, "--frames");
  expect_refused({"--frames", "c*.png", "--threshold", "9"}, "c*.png");
  expect_refused({"--frames", "a.png", "b.png", "--threshold", "9", "--engine", "model", "--out", "out"}, "b.png");
  expect_refused({"--frames", "a.png", "text.png", "--threshold", "9"}, "text.png");
  expect_refused({"--frames", "a.png"}, "--threshold");
  expect_refused({"--frames", "a.png", "--channel", "red", "--threshold", "9"}, "a.png");
  expect_refused({"--frames", "a.png", "--rig", "light-section"}, "a.png");
  expect_refused({"--frames", "a.png", "--threshold", "9", "--without", "shot-noise"}, "--without");
  expect_refused({"--scene", "plane", "--transpose"}, "--transpose: does not go with scene plane");
  expect_refused({"--scene", "plane", "--bits", "4"}, "--bits: does not go with scene plane");
  expect_refused({"--rig", "scanner"}, "scanner");
  expect_refused({"--rig", "nothing.yaml"}, "nothing.yaml");
  expect_refused({"--count", "1401"}, "--count");
  expect_refused({"--count", "0"}, "--count");
  expect_refused({"--first", "1401"}, "--first");
  expect_refused({"--without", "fog"}, "--without");
  expect_refused({"--out", "file/out"}, "file");
  expect_refused({"--packets", "file/packets"}, "file");
  expect_refused({"--count", "2", "--picture-frame", "3", "--out", "out"}, "--picture-frame");
  expect_refused({"--engine", "model", "--trace", "a.fst"}, "--trace");
  expect_refused({"--select", "strongest", "--engine", "hls"}, "--select strongest");
  expect_refused({"--select", "strongest", "--trace", "a.fst"}, "--select strongest");
  expect_refused({"--bus-stall", "96"}, "--bus-stall");
}

#ifdef SELFPROJ_HAS_RTL_PLATFORM

// Packets and tables of all engines, byte for byte, with a bus that is often not ready.
TEST_F(Cosim, EnginesAreEqual) {
  for (const char* mode : {"binary", "grey", "grey-over"}) {
    SCOPED_TRACE(mode);
    for (const std::string engine : {"rtl", "hls", "model"}) {
      const Outcome outcome = run_middle({"--engine", engine, "--count", "5", "--mode", mode, "--bus-stall", "60",
                                          "--out", engine, "--packets", engine + ".packets"});
      ASSERT_EQ(outcome.status, 0) << outcome.err;
      EXPECT_EQ(last_line(outcome.out), "matched 2560 columns in 5 frames, 0 mismatches");
    }
    for (const std::string engine : {"hls", "model"}) {
      EXPECT_EQ(text("rtl.packets"), text(engine + ".packets")) << engine;
      for (const char* file : {"moments.csv", "profile.csv", "cloud.ply", "height.tiff", "difference.tiff"}) {
        EXPECT_EQ(text(std::string("rtl/") + file), text(engine + "/" + file)) << engine << ": " << file;
      }
    }
  }
}

// A stretch of A2's frames, from the plane over the part's edge into the marks. All 1400: scripts/demo.sh.
TEST_F(Cosim, EdgeAndMarksThroughTheRtl) {
  const Outcome outcome = run({"--first", "440", "--count", "60"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(last_line(outcome.out), "matched 30720 columns in 60 frames, 0 mismatches");
}

TEST_F(Cosim, WaveformOfTheLastFrame) {
  const Outcome outcome = run_middle({"--count", "3", "--trace", "wave.fst", "--trace-from", "3"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(folder_.names(), std::vector<std::string>{"wave.fst"});
  EXPECT_GT(fs::file_size(folder_ / "wave.fst"), 10000U);
  expect_refused({"--count", "3", "--trace", "wave.fst", "--trace-from", "4"}, "--trace-from");
}

TEST_F(Cosim, RealCaptures) {
  const fs::path captures = SELFPROJ_CAPTURES;
  if (!fs::exists(captures)) {
    GTEST_SKIP() << "the real captures are not there: " << captures;
  }
  const Outcome outcome =
      run({"--frames", captures / "sample*/sample*-b-0.jpg", "--background", captures / "sample*/sample*-a-0.jpg",
           "--channel", "red", "--threshold", "30", "--out", "out"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(last_line(outcome.out), "matched 3200 columns in 10 frames, 0 mismatches");
  EXPECT_TRUE(fs::exists(folder_ / "out/frame_10.png"));
  // Where both found the line, it is where the captures' owner found it: one white pixel for each column in a picture
  // of his. The first sample is left out. Its two images were not exposed alike, so their difference is light
  // everywhere.
  const images::FloatImage centroid = images::read_float_tiff(folder_ / "out/centroid.tiff");
  ASSERT_EQ(centroid.rows, 10);
  int both = 0;
  int near = 0;
  for (int i = 1; i < 10; ++i) {
    const std::string name = "sample" + std::to_string(i + 1);
    const cv::Mat owner = cv::imread(captures / name / ("_" + name + "-line-3.jpg"), cv::IMREAD_GRAYSCALE);
    ASSERT_EQ(owner.cols, 320) << name;
    for (int column = 0; column < owner.cols; ++column) {
      double most = 0;
      cv::Point at;
      cv::minMaxLoc(owner.col(column), nullptr, &most, nullptr, &at);
      const auto row = static_cast<double>(centroid.row(i)[column]);
      if (most > 128 && !std::isnan(row)) {
        ++both;
        near += std::abs(row - 1 - at.y) <= 2 ? 1 : 0;
      }
    }
  }
  RecordProperty("columns", both);
  RecordProperty("near", near);
  EXPECT_GT(both, 1000);
  EXPECT_GE(near, both * 96 / 100);  // 1848 of 1908 as measured
}

#endif

}  // namespace
}  // namespace selfproj::test
