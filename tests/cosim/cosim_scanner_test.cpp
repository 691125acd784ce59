// Tests selfproj-sim cosim with the scenes of rig B: patterns in, depth images and motion out.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"
#include "tests/cli/program.h"

namespace selfproj::test {
namespace {

constexpr int kSide = 128;

class CosimScanner : public ::testing::Test {
 protected:
  // Rig B with a quarter of the pixels along each side.
  void SetUp() override {
    rig::Rig rig = rig::load_rig("scanner");
    rig.name = "small";
    rig.camera.rows = rig.camera.columns = kSide;
    rig.camera.pixel_pitch_mm *= 4;
    rig.projector.lines /= 4;
    rig.projector.columns /= 4;
    rig.projector.line_pitch_mm *= 4;
    rig.projector.column_pitch_mm *= 4;
    rig.measure.max_z_per_line_mm *= 4;
    std::ofstream(folder_ / "small.yaml") << rig::to_yaml(rig);
  }

  Outcome run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"--bits", "6"});
    return run_self(std::move(arguments));
  }

  // Runs with the number of bits that the scene has by default.
  Outcome run_self(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"cosim", "--rig", "small.yaml"});
    return run_program(SELFPROJ_SIM_PROGRAM, arguments, folder_.path());
  }

  void expect_refused(const std::vector<std::string>& arguments, const std::string& about) {
    SCOPED_TRACE(about);
    const std::vector<std::string> before = folder_.names();
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_NE(outcome.err.find(about), std::string::npos) << outcome.err;
    EXPECT_EQ(folder_.names(), before);
  }

  [[nodiscard]] nlohmann::json summary(const std::string& folder) const {
    return nlohmann::json::parse(read_text(folder_ / folder / "summary.json"));
  }

  // The rows of a table without its head, as numbers; NaN for an empty cell.
  [[nodiscard]] std::vector<std::vector<double>> table(const std::string& file) const {
    std::istringstream lines(read_text(folder_ / file));
    std::string line;
    std::getline(lines, line);
    std::vector<std::vector<double>> rows;
    while (std::getline(lines, line)) {
      rows.emplace_back();
      std::istringstream cells(line + ",");
      for (std::string cell; std::getline(cells, cell, ',');) {
        rows.back().push_back(cell.empty() ? std::nan("") : std::stod(cell));
      }
    }
    return rows;
  }

  ScratchFolder folder_;
};

// A turn of the fist: 286 frames, of which every second gives a depth image once 12 have come.
TEST_F(CosimScanner, FistGoesRoundAtItsFrequency) {
  const Outcome outcome = run({"--scene", "fist", "--engine", "model", "--count", "300", "--min-difference", "40",
                               "--max-change", "40", "--min-neighbours", "5", "--out", "out"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  // codes of 128 x 128 pixels, 145 times; moments of 128 columns, 300 times
  EXPECT_NE(outcome.out.find("matched 2375680 codes in 145 code images and 38400 columns in 300 frames, 0 mismatches"),
            std::string::npos)
      << outcome.out;
  const nlohmann::json json = summary("out");
  EXPECT_EQ(json["counters"]["mismatches"], 0);
  EXPECT_EQ(json["counters"]["depth_images"], 145);
  EXPECT_NEAR(json["measured"]["centroid_y_hz"].get<double>(), 3.5, 0.4);
  const auto rows = table("out/moved.csv");
  ASSERT_EQ(rows.size(), 145U);
  EXPECT_EQ(rows.front()[0], 12);
  EXPECT_EQ(rows.back()[0], 300);
  // Nothing of the first image is steady, because the image before it is the background's.
  EXPECT_EQ(rows.front()[2], 0);
  std::vector<double> off;
  for (auto row = rows.begin() + 1; row != rows.end(); ++row) {
    EXPECT_GT((*row)[2], 50);  // pixels
    off.push_back(std::hypot((*row)[3] - (*row)[7], (*row)[4] - (*row)[8], (*row)[5] - (*row)[9]));
  }
  std::nth_element(off.begin(), off.begin() + 72, off.end());
  EXPECT_LT(off[72], 25);
  for (const char* file :
       {"depth.tiff", "difference.tiff", "background.tiff", "difference.png", "cloud.ply", "report.html",
        "depth_00048.tiff", "depth_00048.png", "moved_00048.png", "frame_00048.png"}) {
    EXPECT_GT(read_text(folder_ / "out" / file).size(), 100U) << file;
  }
  const images::FloatImage depth = images::read_float_tiff((folder_ / "out" / "depth.tiff").string());
  EXPECT_EQ(depth.rows, kSide);
  EXPECT_EQ(depth.columns, kSide);
}

// The crests are shorter than the water is deep, so that they run more slowly than long waves.
TEST_F(CosimScanner, WaveIsFollowed) {
  const Outcome outcome = run({"--scene", "waves", "--engine", "model", "--first", "1430", "--count", "110", "--out",
                               "out", "--without", "shot-noise,read-noise"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const nlohmann::json json = summary("out");
  EXPECT_GT(json["measured"]["true_front_cm_per_s"].get<double>(), 23);
  EXPECT_LT(json["measured"]["true_front_cm_per_s"].get<double>(), 45);
  EXPECT_NEAR(json["measured"]["theory_cm_per_s"].get<double>(), 54.2, 0.1);
  const auto rows = table("out/front.csv");
  EXPECT_EQ(rows.size(), 50U);
}

// The depth from cosim's driver equals what the host computes from the same frames as images.
TEST_F(CosimScanner, DepthIsThatOfTheRenderedImages) {
  ASSERT_EQ(run({"--scene", "keys", "--engine", "model", "--first", "31", "--count", "12", "--out", "out"}).status, 0);
  const Outcome rendered = run_program(SELFPROJ_SIM_PROGRAM,
                                       {"scene", "render", "keys", "--rig", "small.yaml", "--bits", "6", "--first",
                                        "31", "--count", "12", "--out", "frames", "--truth", "truth.tiff"},
                                       folder_.path());
  ASSERT_EQ(rendered.status, 0) << rendered.err;
  std::vector<std::string> images;
  for (int frame = 31; frame <= 42; ++frame) {
    images.push_back("frames/frame_000" + std::to_string(frame) + ".png");
  }
  std::vector<std::string> depth{"depth",    "--rig",   "small.yaml", "--bits", "6",
                                 "--median", "--max-z", "565",        "--out",  "host"};
  depth.insert(depth.end(), images.begin(), images.end());
  const Outcome host = run_program(SELFPROJ_PROGRAM, depth, folder_.path());
  ASSERT_EQ(host.status, 0) << host.err;
  EXPECT_TRUE(read_text(folder_ / "host" / "depth.tiff") == read_text(folder_ / "out" / "depth.tiff"));
  EXPECT_EQ(table("out/keys.csv").size(), 1U);

  std::vector<std::string> decode{"decode", "--engine", "model", "--bits", "6", "--median", "--out", "codes"};
  decode.insert(decode.end(), images.begin(), images.end());
  EXPECT_EQ(run_program(SELFPROJ_SIM_PROGRAM, decode, folder_.path()).status, 0);
  // The truth, with frames one below the other, is near the measurement wherever that has a depth.
  const images::FloatImage truth = images::read_float_tiff((folder_ / "truth.tiff").string());
  ASSERT_EQ(truth.rows, 12 * kSide);
  const images::FloatImage measured = images::read_float_tiff((folder_ / "out" / "depth.tiff").string());
  std::size_t valid = 0;
  std::size_t near = 0;
  for (int r = 0; r < kSide; ++r) {
    for (int c = 0; c < kSide; ++c) {
      const float error = measured.row(r)[c] - truth.row(6 * kSide + r)[c];
      valid += std::isnan(error) ? 0 : 1;
      near += std::abs(error) < 15 ? 1 : 0;  // half a code of 6 bits is worth 9 mm in the middle of the plane
    }
  }
  EXPECT_GT(valid, 5000U);
  EXPECT_GT(near, valid * 9 / 10);
}

// B4: self-projected patterns of 4 bits, decoded by the board and matched behind it.
TEST_F(CosimScanner, CuboidsAreMatchedAsTheModelDoes) {
  const Outcome model = run_self({"--scene", "cuboids-marked", "--engine", "model", "--out", "model"});
  ASSERT_EQ(model.status, 0) << model.err;
  const std::string matched =
      "matched 81920 codes and 81920 lines in 5 code images and 2048 columns in 16 frames, 0 mismatches";
  EXPECT_NE(model.out.find(matched), std::string::npos) << model.out;
  const nlohmann::json json = summary("model");
  EXPECT_EQ(json["counters"]["matched_lines"], 81920);
  EXPECT_EQ(json["counters"]["mismatches"], 0);
  EXPECT_GT(json["counters"]["with_line"], 40000);
  EXPECT_EQ(json["settings"]["e"], 8);
  // A cell of two rows is worth 18 mm of z on this rig's plane.
  EXPECT_LT(json["measured"]["depth_rms_mm"].get<double>(), 7);
  EXPECT_LT(json["measured"]["depth_far_off"].get<double>(), 8);
  for (const char* file : {"depth.tiff", "difference.tiff", "truth.tiff", "cloud.ply", "report.html", "depth_00016.png",
                           "difference_00016.png", "frame_00016.png"}) {
    EXPECT_GT(read_text(folder_ / "model" / file).size(), 100U) << file;
  }
#ifdef SELFPROJ_HAS_RTL_PLATFORM
  const Outcome rtl = run_self({"--scene", "cuboids-marked", "--engine", "rtl", "--out", "rtl", "--bus-stall", "20"});
  ASSERT_EQ(rtl.status, 0) << rtl.err;
  EXPECT_NE(rtl.out.find(matched), std::string::npos) << rtl.out;
  for (const char* file : {"depth.tiff", "difference.tiff", "cloud.ply"}) {
    EXPECT_TRUE(read_text(folder_ / "model" / file) == read_text(folder_ / "rtl" / file)) << file;
  }
#endif
}

TEST_F(CosimScanner, WhatIsWrongOfSelfProjectedScenesIsSaidInOneLine) {
  const auto refused = [&](const std::vector<std::string>& arguments, const std::string& about) {
    SCOPED_TRACE(about);
    const Outcome outcome = run_self(arguments);
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_NE(outcome.err.find(about), std::string::npos) << outcome.err;
  };
  refused({"--scene", "cuboids-marked", "--e", "16"}, "--e 16: is out of range; 4 bits allow 0 to 15");
  refused({"--scene", "cuboids-marked", "--engine", "model", "--bits", "9"},
          "--bits 9: self-projected codes have at most 8");
  refused({"--scene", "cuboids-marked", "--no-median"}, "--no-median: does not go with scene cuboids-marked");
  refused({"--scene", "cuboids-marked", "--count", "6"}, "--count 6: is too few; codes of 4 bits take 8 frames");
  refused({"--scene", "fist", "--e", "3"}, "--e: does not go with scene fist");
#ifdef SELFPROJ_HAS_RTL_PLATFORM
  refused({"--scene", "cuboids-marked", "--bits", "5"}, "--bits 5: the simulated matching block is built for 4 bits");
#endif
}

TEST_F(CosimScanner, WhatIsWrongIsSaidInOneLine) {
  expect_refused({"--scene", "fist", "--mode", "grey"}, "--mode: does not go with scene fist");
  expect_refused({"--scene", "fist", "--trace", "a.fst"}, "--trace: does not go with scene fist");
  expect_refused({"--scene", "fist", "--count", "11"}, "--count 11: is too few; codes of 6 bits take 12 frames");
  expect_refused({"--scene", "fist", "--first", "1999", "--count", "20"}, "--count 20: scene fist has 2 frames");
  expect_refused({"--scene", "fist", "--first", "2001"}, "--first 2001: scene fist has 2000 frames");
  expect_refused({"--scene", "fist", "--count", "40", "--out", "o", "--picture-frame", "13"},
                 "--picture-frame 13: completes no code image; frames 12, 14, ... 40 do");
  const auto plain = [&](const std::vector<std::string>& arguments) {
    return run_program(SELFPROJ_SIM_PROGRAM, arguments, folder_.path());
  };
  const Outcome wrong_rig = plain({"cosim", "--scene", "fist", "--rig", "light-section"});
  EXPECT_EQ(wrong_rig.status, 2);
  EXPECT_NE(wrong_rig.err.find("--rig light-section: is not a scanner, which scene fist needs"), std::string::npos)
      << wrong_rig.err;
  const Outcome no_scanner = plain({"cosim", "--scene", "stairs", "--bits", "8"});
  EXPECT_EQ(no_scanner.status, 2);
  EXPECT_NE(no_scanner.err.find("--bits: does not go with scene stairs"), std::string::npos) << no_scanner.err;
}

#ifdef SELFPROJ_HAS_RTL_PLATFORM
// The RTL, with and without the SystemC shells of decoder and median, gives the same packets with a bus that stalls,
// and the same files.
TEST_F(CosimScanner, EnginesAreEqual) {
  const std::vector<std::string> what{"--scene", "fist", "--first", "200", "--count", "18"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), what.begin(), what.end());
    return run(std::move(more));
  };
  const Outcome model = with({"--engine", "model", "--out", "model"});
  const Outcome rtl = with({"--engine", "rtl", "--out", "rtl", "--bus-stall", "30", "--packets", "rtl.slfp"});
  ASSERT_EQ(model.status, 0) << model.err;
  ASSERT_EQ(rtl.status, 0) << rtl.err;
  EXPECT_NE(rtl.out.find("matched 65536 codes in 4 code images and 2304 columns in 18 frames, 0 mismatches"),
            std::string::npos)
      << rtl.out;
  for (const char* file : {"depth.tiff", "moved.csv", "difference.tiff", "cloud.ply"}) {
    EXPECT_TRUE(read_text(folder_ / "model" / file) == read_text(folder_ / "rtl" / file)) << file;
  }
  const Outcome hls = with({"--engine", "hls", "--out", "hls", "--bus-stall", "30", "--packets", "hls.slfp"});
  ASSERT_EQ(hls.status, 0) << hls.err;
  EXPECT_TRUE(read_text(folder_ / "rtl.slfp") == read_text(folder_ / "hls.slfp"));
  for (const char* engine : {"rtl", "hls"}) {
    const Outcome raw = with({"--engine", engine, "--no-median"});
    EXPECT_EQ(raw.status, 0) << raw.err;
    EXPECT_NE(raw.out.find("0 mismatches"), std::string::npos);
  }
  // The stream of the board, as the host takes it from a device.
  const Outcome device = run_program(
      SELFPROJ_PROGRAM,
      {"depth", "--rig", "small.yaml", "--bits", "6", "--max-z", "565", "--device", "file:rtl.slfp", "--out", "device"},
      folder_.path());
  ASSERT_EQ(device.status, 0) << device.err;
  EXPECT_TRUE(read_text(folder_ / "device" / "depth.tiff") == read_text(folder_ / "rtl" / "depth.tiff"));
}
#endif

}  // namespace
}  // namespace selfproj::test
