// Tests the whole chain: patterns, captures of a virtual chessboard with noise and blur, decoding, calibration, the
// resulting rig, and the depth of a known plane measured with it. The rig has the geometry of rig B with half as many
// pixels along each side; lab/scripts/calibration_chain.sh runs the full size.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "selfproj/rig/calibration.h"
#include "selfproj/rig/calibration_file.h"
#include "selfproj/rig/rig.h"
#include "tests/cli/program.h"

namespace selfproj::test {
namespace {

using Json = nlohmann::json;

class CalibrationChain : public ::testing::Test {
 protected:
  CalibrationChain() {
    rig_ = rig::load_rig("scanner");
    rig_.camera.rows /= 2;
    rig_.camera.columns /= 2;
    rig_.camera.pixel_pitch_mm *= 2;
    rig_.projector.lines /= 2;
    rig_.projector.columns /= 2;
    rig_.projector.line_pitch_mm *= 2;
    rig_.projector.column_pitch_mm *= 2;
    write_text(folder_ / "half.yaml", rig::to_yaml(rig_));
  }

  Outcome host(const std::vector<std::string>& arguments) {
    return run_program(SELFPROJ_PROGRAM, arguments, folder_.path());
  }
  Outcome sim(const std::vector<std::string>& arguments) {
    return run_program(SELFPROJ_SIM_PROGRAM, arguments, folder_.path());
  }

  ScratchFolder folder_;
  rig::Rig rig_;
};

TEST_F(CalibrationChain, ClosesOnItself) {
  ASSERT_EQ(host({"pattern", "gray", "--rig", "half.yaml", "--out", "patterns"}).status, 0);
  const Outcome captured = sim({"capture", "--rig", "half.yaml", "--patterns", "patterns", "--chessboard", "9x7",
                                "--square", "21", "--poses", "6", "--out", "captures"});
  ASSERT_EQ(captured.status, 0) << captured.err;
  std::vector<std::string> calibrate{"calibrate", "--chessboard", "9x7",       "--square", "21",    "--projector",
                                     "512x384",   "--rig",        "half.yaml", "--out",    "result"};
  for (int pose = 1; pose <= 6; ++pose) {
    calibrate.push_back("captures/pose_0" + std::to_string(pose));
  }
  const Outcome calibrated = host(calibrate);
  ASSERT_EQ(calibrated.status, 0) << calibrated.err;

  const Json truth = Json::parse(read_text(folder_ / "captures" / "truth.json"));
  const rig::Calibration c = rig::read_calibration((folder_ / "result" / "calibration.yaml").string());
  const auto near = [](double value, const Json& expected, double tolerance, const char* what) {
    EXPECT_NEAR(value, expected.get<double>(), tolerance) << what;
  };
  constexpr double kFocal = 0.004;  // relative
  constexpr double kCentre = 2;     // pixels, as at full size
  const Json& camera = truth["camera"];
  const Json& projector = truth["projector"];
  near(c.camera.fx, camera["column_focal_px"], kFocal * 300, "camera fx");
  near(c.camera.fy, camera["row_focal_px"], kFocal * 300, "camera fy");
  near(c.camera.cx, camera["column_centre_px"], kCentre, "camera cx");
  near(c.camera.cy, camera["row_centre_px"], kCentre, "camera cy");
  near(c.projector.fx, projector["column_focal_px"], kFocal * 236, "projector fx");
  near(c.projector.fy, projector["row_focal_px"], kFocal * 236, "projector fy");
  near(c.projector.cx, projector["column_centre_px"], kCentre, "projector cx");
  near(c.projector.cy, projector["row_centre_px"], kCentre, "projector cy");
  const std::vector<double> centre = projector["centre_mm"];
  const double baseline = std::hypot(centre[0], centre[1], centre[2]);
  EXPECT_NEAR(cv::norm(c.translation), baseline, 0.8);
  const rig::Rig rig = rig::load_rig((folder_ / "result" / "rig.yaml").string());
  EXPECT_TRUE(rig.calibration.has_value());
  EXPECT_NEAR(rig.projector.tilt_rad, rig_.projector.tilt_rad, 0.005);
  EXPECT_NEAR(rig.projector.line_pitch_mm, rig_.projector.line_pitch_mm, 0.004 * rig_.projector.line_pitch_mm);

  // The plane, from codes of both axes by the full model.
  ASSERT_EQ(
      sim({"capture", "--rig", "half.yaml", "--patterns", "patterns", "--scene", "plane", "--out", "plane"}).status, 0);
  std::vector<std::string> depth{"depth", "--calibration", "result/calibration.yaml", "--bits", "9",       "--row-bits",
                                 "9",     "--strict",      "--max-z-per-line",        "10",     "--plane", "--out",
                                 "depth"};
  for (int i = 0; i < 36; ++i) {
    depth.push_back(i < 10 ? "plane/image_0" + std::to_string(i) + ".png"
                           : "plane/image_" + std::to_string(i) + ".png");
  }
  const Outcome measured = host(depth);
  ASSERT_EQ(measured.status, 0) << measured.err;
  const Json plane = Json::parse(read_text(folder_ / "depth" / "summary.json"))["plane"];
  EXPECT_GT(plane["points"], 10000);                         // strict; and the projector lights part of the image only
  EXPECT_NEAR(plane["z_on_axis_mm"], rig_.plane_z_mm, 0.6);  // twice what is asked for at full size
  EXPECT_LT(plane["tilt_deg"], 0.5);  // 1 mm over the lit part: the calibration's errors with few pixels
  EXPECT_LE(plane["residual_rms_mm"], plane["rounding_rms_mm"]);
  EXPECT_NE(measured.out.find("plane through "), std::string::npos) << measured.out;
}

TEST_F(CalibrationChain, WrongInputIsOneLine) {
  const auto refused = [&](const std::vector<std::string>& arguments, const std::string& begin) {
    const Outcome outcome = sim(arguments);
    EXPECT_EQ(outcome.status, 2) << outcome.out;
    EXPECT_EQ(outcome.err.rfind("selfproj-sim: " + begin, 0), 0U) << outcome.err;
    EXPECT_EQ(outcome.err.find('\n'), outcome.err.size() - 1) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
  };
  ASSERT_EQ(host({"pattern", "gray", "--projector", "8x8", "--out", "small"}).status, 0);
  ASSERT_EQ(host({"pattern", "gray", "--rig", "half.yaml", "--out", "patterns"}).status, 0);
  const std::vector<std::string> usual{"capture", "--rig", "half.yaml", "--out", "out", "--patterns"};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all = usual;
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  refused(with({"patterns"}), "--scene, --chessboard, --plate, --steps: give one of them");
  refused(with({"patterns", "--chessboard", "9x7"}), "--square: is required with --chessboard");
  refused(with({"patterns", "--chessboard", "9x7", "--square", "80"}),
          "--chessboard: camera and projector do not both see all of it in pose 1");
  refused(with({"patterns", "--scene", "nothing"}), "nothing: is not a scene");
  refused(with({"none", "--scene", "plane"}), "none: there is no such folder");
  refused(with({"small", "--scene", "plane"}), "small/pattern_00.png: ");
  std::filesystem::create_directory(folder_ / "there");
  const Outcome outcome = sim({"capture", "--rig", "half.yaml", "--out", "there", "--patterns", "patterns",
                               "--chessboard", "5x5", "--square", "10", "--poses", "1"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.err.rfind("selfproj-sim: there: exists already", 0), 0U) << outcome.err;
}

}  // namespace
}  // namespace selfproj::test
