// Tests selfproj calibrate from the command line: captures of a small chessboard give a rig that other commands accept.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "host/images/image_files.h"
#include "selfproj/images/float_image.h"
#include "selfproj/rig/calibration.h"
#include "selfproj/rig/calibration_file.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/gray_sequence.h"
#include "tests/cli/program.h"
#include "tests/cli/refusal.h"
#include "tests/support/chessboard_world.h"

namespace selfproj::test {
namespace {

namespace fs = std::filesystem;

// Five poses, rendered once.
class CalibrateCommand : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new ScratchFolder;  // NOLINT: GoogleTest's way
    const World world;
    const structured_light::GraySequence sequence(world.projector_columns, world.projector_rows);
    std::mt19937_64 random(7);
    for (int p = 0; p < kPoses; ++p) {
      const ChessboardImages images(world, world.poses()[static_cast<std::size_t>(p)]);
      const fs::path pose = *folder_ / fmt::format("pose_{}", p);
      fs::create_directory(pose);
      for (int i = 0; i < sequence.count(); ++i) {
        const std::string name = fmt::format("image_{:02}.png", i);
        write_text(pose / name, images::encode_png({world.camera_rows, world.camera_columns,
                                                    images.image(sequence.image(i), 1.5, random)}));
      }
    }
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static Outcome calibrate(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "calibrate");
    return run_program(SELFPROJ_PROGRAM, arguments, folder_->path());
  }

  static std::vector<std::string> usual(const std::string& out, const std::vector<std::string>& poses,
                                        const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"--chessboard", "7x5", "--square", "40", "--projector", "96x80", "--out", out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    arguments.insert(arguments.end(), poses.begin(), poses.end());
    return arguments;
  }
  static std::vector<std::string> all_poses() { return {"pose_0", "pose_1", "pose_2", "pose_3", "pose_4"}; }

  static void expect_refused(const Outcome& outcome, const std::string& begin) {
    expect_refusal(outcome, begin);
    EXPECT_FALSE(fs::exists(*folder_ / "out"));
  }

  static constexpr int kPoses = 5;
  static ScratchFolder* folder_;
};
ScratchFolder* CalibrateCommand::folder_ = nullptr;

TEST_F(CalibrateCommand, BothWaysGiveTheTruth) {
  const World world;
  for (const std::string way : {"homography", "direct"}) {
    SCOPED_TRACE(way);
    const Outcome outcome = calibrate(usual(way, all_poses(), {"--corners", way}));
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    for (const char* file :
         {"rig.yaml", "calibration.yaml", "report.json", "corners.csv", "coverage.png", "residuals.png"}) {
      EXPECT_TRUE(fs::exists(*folder_ / way / file)) << file;
    }
    const rig::Calibration c = rig::read_calibration((*folder_ / way / "calibration.yaml").string());
    EXPECT_NEAR(c.camera.fx, world.camera.fx, 0.01 * world.camera.fx);
    EXPECT_NEAR(c.camera.cx, world.camera.cx, 2.5);
    EXPECT_NEAR(c.camera.cy, world.camera.cy, 2.5);
    EXPECT_NEAR(c.projector.fx, world.projector.fx, 0.015 * world.projector.fx);
    EXPECT_NEAR(c.projector.cy, world.projector.cy, 2.5);
    EXPECT_NEAR(cv::norm(c.translation), cv::norm(world.translation), 2);
    const auto json = nlohmann::json::parse(read_text(*folder_ / way / "report.json"));
    EXPECT_LT(json["rms_px"]["stereo"], 0.2);
    // Errors are as large as said.
    const double sd = json["camera"]["fx"]["sd"];
    EXPECT_LT(std::abs(c.camera.fx - world.camera.fx), 4 * sd);
    EXPECT_EQ(json["camera"]["p1"]["sd"], "fixed");
    EXPECT_EQ(json["poses"].size(), 5U);
    const std::string table = read_text(*folder_ / way / "corners.csv");
    EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 1 + kPoses * 35);
    EXPECT_GT(images::read_image((*folder_ / way / "residuals.png").string(), images::Channel::grey).columns, 500);

    // The rig: other commands take it, and it is the calibration.
    const rig::Rig rig = rig::load_rig((*folder_ / way / "rig.yaml").string());
    EXPECT_NEAR(rig::calibration_of(rig).camera.fx, c.camera.fx, 1e-9);
    const Outcome checked = run_program(SELFPROJ_PROGRAM, {"rig", way + "/rig.yaml"}, folder_->path());
    EXPECT_EQ(checked.status, 0) << checked.err;
    const Outcome pattern = run_program(
        SELFPROJ_PROGRAM, {"pattern", "gray", "--rig", way + "/rig.yaml", "--out", way + "_gray"}, folder_->path());
    EXPECT_EQ(pattern.status, 0) << pattern.err;
  }
}

// Depth of a pose by the calibration: the chessboard's plane.
TEST_F(CalibrateCommand, DepthClosesTheChain) {
  const World world;
  ASSERT_EQ(calibrate(usual("chain", all_poses())).status, 0);
  std::vector<std::string> arguments{
      "depth", "--calibration", "chain/calibration.yaml", "--bits", "7", "--row-bits", "7", "--strict",
      "--out", "depth"};
  for (int i = 0; i < 28; ++i) {
    arguments.push_back(fmt::format("pose_1/image_{:02}.png", i));
  }
  const Outcome outcome = run_program(SELFPROJ_PROGRAM, arguments, folder_->path());
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const images::FloatImage depth = images::read_float_tiff((*folder_ / "depth" / "depth.tiff").string());
  const ChessboardPose pose = world.poses()[1];
  const cv::Vec3d normal(pose.turn(0, 2), pose.turn(1, 2), pose.turn(2, 2));
  double sum = 0;
  double squares = 0;
  int count = 0;
  for (int r = 0; r < depth.rows; ++r) {
    for (int c = 0; c < depth.columns; ++c) {
      if (std::isnan(depth.row(r)[c])) {
        continue;
      }
      const cv::Vec3d ray((c - world.camera.cx) / world.camera.fx, (r - world.camera.cy) / world.camera.fy, 1);
      const double off = static_cast<double>(depth.row(r)[c]) - normal.dot(pose.at) / normal.dot(ray);
      sum += off;
      squares += off * off;
      ++count;
    }
  }
  // A projector row is about 11 mm of z here; codes are rounded to one.
  ASSERT_GT(count, 3000);
  EXPECT_LT(std::abs(sum / count), 1.5);
  EXPECT_LT(std::sqrt(squares / count), 5);
}

TEST_F(CalibrateCommand, WhatIsLeftOutIsSaid) {
  // One pose without a chessboard, one of which only a part is in the projector's light.
  const World world;
  const structured_light::GraySequence sequence(world.projector_columns, world.projector_rows);
  const ChessboardImages seen(world, world.poses()[2]);
  std::mt19937_64 random(3);
  fs::create_directory(*folder_ / "empty");
  fs::create_directory(*folder_ / "partly");
  for (int i = 0; i < sequence.count(); ++i) {
    const std::string name = fmt::format("{:02}.png", i);
    images::Image image{world.camera_rows, world.camera_columns, {}};
    image.pixels.assign(static_cast<std::size_t>(image.rows * image.columns), 20);
    write_text(*folder_ / "empty" / name, images::encode_png(image));
    // A screen keeps the projector's light from three quarters of the chessboard; only ambient light remains there.
    std::vector<std::uint8_t> pattern = sequence.image(i);
    for (int p = 0; p < static_cast<int>(pattern.size()); ++p) {
      if (p % world.projector_columns > 35) {
        pattern[static_cast<std::size_t>(p)] = 100;
      }
    }
    image.pixels = seen.image(pattern, 1.5, random);
    write_text(*folder_ / "partly" / name, images::encode_png(image));
  }
  const Outcome outcome =
      calibrate(usual("left", {"pose_0", "empty", "pose_1", "partly", "pose_3"}, {"--min-corners", "6"}));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("empty: left out: no chessboard of 7 x 5 inner corners is completely visible\n"),
            std::string::npos)
      << outcome.out;
  EXPECT_NE(outcome.out.find("partly: "), std::string::npos);
  EXPECT_NE(outcome.out.find("too few pixels around it are decoded"), std::string::npos) << outcome.out;
  // The same with many corners demanded.
  const Outcome strict = calibrate(usual("strict", {"pose_0", "partly", "pose_1", "pose_3"}, {"--min-corners", "30"}));
  ASSERT_EQ(strict.status, 0) << strict.err;
  EXPECT_NE(strict.out.find("of 35 corners can be used; 30 are needed\n"), std::string::npos) << strict.out;
  const auto json = nlohmann::json::parse(read_text(*folder_ / "strict" / "report.json"));
  EXPECT_EQ(json["poses"][1]["used"], 0);
}

// A pose that takes no part, and a chessboard that is said to be flat.
TEST_F(CalibrateCommand, ChecksAgainstAPoseThatTakesNoPart) {
  const Outcome outcome = calibrate(
      usual("checked", {"pose_0", "pose_1", "pose_2", "pose_3"}, {"--board", "flat", "--check", "pose_4", "--"}));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("check      pose_4: 35 corners"), std::string::npos) << outcome.out;
  EXPECT_EQ(outcome.out.find("board      bent"), std::string::npos) << outcome.out;
  const auto json = nlohmann::json::parse(read_text(*folder_ / "checked" / "report.json"));
  EXPECT_EQ(json["poses"].size(), 4U);
  ASSERT_EQ(json["checks"].size(), 1U);
  const nlohmann::json& check = json["checks"][0];
  EXPECT_LT(check["camera_rms_px"], 0.15) << check;
  EXPECT_LT(check["projector_rms_px"], 0.15) << check;
  EXPECT_LT(std::abs(check["scale_off"].get<double>()), 0.01) << check;
  EXPECT_LT(check["point_rms_mm"], 1.5) << check;
  expect_refused(calibrate(usual("out", {"pose_0", "pose_1"}, {"--check", "pose_1", "--"})),
                 "--check: pose_1 is given twice");
  expect_refused(calibrate(usual("out", {"pose_0", "pose_1"}, {"--board", "round"})), "--board: ");
}

// Poses that lean alike determine no focal length.
TEST_F(CalibrateCommand, ParallelPosesEndWithStatusOne) {
  const World world;
  const structured_light::GraySequence sequence(world.projector_columns, world.projector_rows);
  const ChessboardImages images(world, world.pose(5, 6, 575, turn(0, 0, 2)));
  std::mt19937_64 random(9);
  fs::create_directory(*folder_ / "parallel");
  for (int i = 0; i < sequence.count(); ++i) {
    write_text(
        *folder_ / "parallel" / fmt::format("{:02}.png", i),
        images::encode_png({world.camera_rows, world.camera_columns, images.image(sequence.image(i), 1.5, random)}));
  }
  const Outcome outcome = calibrate(usual("out", {"pose_0", "parallel"}));
  EXPECT_EQ(outcome.status, 1) << outcome.out;
  EXPECT_EQ(outcome.err.rfind("selfproj: calibrate: no rig: the poses do not determine the ", 0), 0U) << outcome.err;
  EXPECT_EQ(outcome.err.find('\n'), outcome.err.size() - 1) << outcome.err;
  EXPECT_FALSE(fs::exists(*folder_ / "out"));
}

TEST_F(CalibrateCommand, WrongInputIsOneLine) {
  const std::vector<std::string> poses = all_poses();
  expect_refused(calibrate(usual("out", {"pose_0"})), "calibrate: 1 of 1 poses can be used; at least 2 are needed");
  const Outcome smaller =
      calibrate({"--chessboard", "6x5", "--square", "40", "--projector", "96x80", "--out", "out", "pose_0", "pose_2"});
  expect_refused(smaller, "calibrate: 0 of 2 poses can be used; at least 2 are needed");
  EXPECT_NE(smaller.err.find("inner corners is seen, not one of 6 x 5"), std::string::npos) << smaller.err;
  expect_refused(
      calibrate({"--chessboard", "9x8", "--square", "40", "--projector", "96x80", "--out", "out", "pose_0", "pose_1"}),
      "calibrate: 0 of 2 poses can be used");
  expect_refused(calibrate({"--chessboard", "2x5", "--square", "40", "--projector", "96x80", "--out", "out", "pose_0"}),
                 "--chessboard: is 2x5");
  expect_refused(
      calibrate({"--chessboard", "7x5", "--square", "40", "--projector", "128x128", "--out", "out", "pose_0"}),
      "");  // codes mean other pixels, the number of images is the same: too few decode to the chessboard's place
  expect_refused(
      calibrate({"--chessboard", "7x5", "--square", "40", "--projector", "256x80", "--out", "out", "pose_0"}),
      "pose_0: has 30 images; 32 are expected for a projector of 256 x 80: 8 pairs for columns, 7 for rows");
  expect_refused(calibrate(usual("out", {"pose_0", "nowhere"})), "nowhere: there is no such folder");
  expect_refused(calibrate(usual("out", {"pose_0", "pose_0"})), "POSE: a folder is given twice");
  fs::create_directory(*folder_ / "short");
  for (const fs::directory_entry& entry : fs::directory_iterator(*folder_ / "pose_0")) {
    if (entry.path().filename() != "image_07.png") {
      fs::copy(entry.path(), *folder_ / "short" / entry.path().filename());
    }
  }
  expect_refused(calibrate(usual("out", {"short", "pose_1"})), "short: has 29 images; 30 are expected");
  write_text(*folder_ / "short" / "image_07.png", "no image");
  expect_refused(calibrate(usual("out", {"short", "pose_1"})), "short/image_07.png: is not an image");
  fs::copy_file(*folder_ / "pose_1" / "image_07.png", *folder_ / "short" / "image_07.png",
                fs::copy_options::overwrite_existing);
  write_text(*folder_ / "short" / "image_03.png", images::encode_png({3, 4, std::vector<std::uint8_t>(12)}));
  expect_refused(calibrate(usual("out", {"short", "pose_1"})), "short/image_03.png: is 4 x 3, but short/image_00.png");
  expect_refused(calibrate(usual("out", poses, {"--rig", "none.yaml"})), "none.yaml: ");
  expect_refused(calibrate(usual("out", poses, {"--camera-distortion", "3"})), "--camera-distortion: ");
  expect_refused(calibrate(usual("short/image_03.png/out", poses)),
                 "short/image_03.png/out: short/image_03.png is not a folder");
}

// A camera alone from the white images, and as a laser one row of the projector, which is a plane.
TEST_F(CalibrateCommand, CameraAndLaser) {
  constexpr int kRow = 44;
  const World world;
  const structured_light::GraySequence sequence(world.projector_columns, world.projector_rows);
  std::vector<std::uint8_t> line(static_cast<std::size_t>(world.projector_columns * world.projector_rows), 0);
  std::fill_n(line.begin() + static_cast<std::ptrdiff_t>(kRow) * world.projector_columns, world.projector_columns, 255);
  fs::create_directory(*folder_ / "lines");
  std::mt19937_64 random(4);
  std::vector<std::string> plain{"calibrate", "camera", "--chessboard", "7x5", "--square", "40"};
  for (int p = 0; p < kPoses; ++p) {
    const ChessboardImages images(world, world.poses()[static_cast<std::size_t>(p)]);
    write_text(*folder_ / "lines" / fmt::format("{}.png", p),
               images::encode_png({world.camera_rows, world.camera_columns, images.image(line, 1.5, random)}));
    plain.push_back(fmt::format("pose_{}/image_{}.png", p, sequence.white()));
  }
  const auto camera = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all = plain;
    all.insert(all.end(), more.begin(), more.end());
    return run_program(SELFPROJ_PROGRAM, all, folder_->path());
  };
  const Outcome outcome = camera({"--laser", "lines", "--out", "camera"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(fs::exists(*folder_ / "camera" / "camera.yaml"));
  const rig::Rig rig = rig::load_any_rig((*folder_ / "camera" / "rig.yaml").string());
  ASSERT_TRUE(rig.calibration && rig.light_plane);
  EXPECT_NEAR(rig.calibration->camera.fx_px, world.camera.fx, 0.01 * world.camera.fx);
  const cv::Vec3d in_projector(0, 1, -(kRow - world.projector.cy) / world.projector.fy);
  cv::Vec3d normal = world.rotation.t() * in_projector;
  double distance = -in_projector.dot(world.translation) / cv::norm(normal);
  normal = cv::normalize(normal);
  if (distance < 0) {
    normal = -normal;
    distance = -distance;
  }
  const std::array<double, 3>& found = rig.light_plane->normal;
  EXPECT_LT(cv::norm(cv::Vec3d(found[0], found[1], found[2]) - normal), 0.02);
  EXPECT_NEAR(rig.light_plane->distance_mm, distance, 5);

  expect_refused(camera({"--laser", "lines/0.png", "lines/1.png", "--out", "out"}),
                 "--laser: has 2 images for 5 of the chessboard; one of each pose is needed");
  expect_refused(run_program(SELFPROJ_PROGRAM,
                             {"calibrate", "camera", "--chessboard", "7x5", "--square", "40", "--out", "out", plain[6]},
                             folder_->path()),
                 "calibrate camera: 1 of 1 images can be used; at least 2 are needed");
  expect_refused(
      run_program(SELFPROJ_PROGRAM,
                  {"calibrate", "camera", "--chessboard", "7x4", "--square", "40", "--out", "out", plain[6], plain[7]},
                  folder_->path()),
      "calibrate camera: 0 of 2 images can be used");
}

// The images of two poses from the last to the first: the chessboard is seen, its codes are not.
TEST_F(CalibrateCommand, AWrongOrderIsNamed) {
  for (const std::string pose : {"pose_0", "pose_2"}) {
    fs::create_directory(*folder_ / ("turned_" + pose));
    for (int i = 0; i < 30; ++i) {
      fs::copy_file(*folder_ / pose / fmt::format("image_{:02}.png", i),
                    *folder_ / ("turned_" + pose) / fmt::format("{}.png", 29 - i));
    }
  }
  const Outcome outcome = calibrate(usual("out", {"turned_pose_0", "turned_pose_2"}));
  expect_refused(outcome, "calibrate: 0 of 2 poses can be used");
  EXPECT_NE(outcome.err.find("turned_pose_0: its chessboard is seen, but no corner has codes; the images are likely in "
                             "another order than the patterns"),
            std::string::npos)
      << outcome.err;
}

TEST_F(CalibrateCommand, WrongPlatesAreOneLine) {
  const auto plates = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all{"--rig", "light-section"};
    all.insert(all.end(), more.begin(), more.end());
    return calibrate(usual("out", all_poses(), all));
  };
  expect_refused(plates({"--moves", "0,6"}), "--moves: is for --plates");
  expect_refused(plates({"--plates", "0,20,10"}), "--plates: 10 follows 20; numbers are expected in ascending order");
  expect_refused(plates({"--plates", "0,low,10"}), "--plates: 'low' is not a number of mm");
  expect_refused(plates({"--plates", "0,20"}), "--plates: 2 are too few; 3 or more heights are needed");
  expect_refused(plates({"--plates", "0,20,40", "--moves", "6"}), "--moves: two places of the belt are needed");
  expect_refused(plates({"--plates", "0,20,40", "--moves", "0,6"}),
                 "--plates: 3 heights with 2 places of the belt are 6 poses; 5 are given");
  expect_refused(plates({"--plates", "0,20,40"}), "--rig: its projector has 512 x 512, not 96x80");
  expect_refused(plates({"--plates", "0,20,40", "--fence", "-1"}), "--fence: ");
}

}  // namespace
}  // namespace selfproj::test
