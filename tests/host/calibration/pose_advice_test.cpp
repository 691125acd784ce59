// Tests which poses a calibration is said to need.
#include "host/calibration/pose_advice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace selfproj::test {
namespace {

constexpr int kRows = 480;
constexpr int kColumns = 640;
const calibration::Chessboard kBoard{9, 6, 20};

// A board seen by a camera of 600 px focal length from 600 mm: turned about its rows and columns, and by `roll` in its
// plane; its middle at this place of the image.
calibration::PoseReport seen(double about_rows, double about_columns, double roll, double x, double y) {
  std::vector<cv::Point3d> board;
  for (int i = 0; i < kBoard.corners(); ++i) {
    board.emplace_back((i % 9 - 4.0) * 20, (i / 9 - 2.5) * 20, 0);
  }
  cv::Mat lean;
  cv::Mat in_plane;
  cv::Rodrigues(cv::Vec3d(about_rows, about_columns, 0), lean);
  cv::Rodrigues(cv::Vec3d(0, 0, roll), in_plane);
  cv::Mat rotation;
  cv::Rodrigues(lean * in_plane, rotation);
  const cv::Matx33d camera(600, 0, 319.5, 0, 600, 239.5, 0, 0, 1);
  std::vector<cv::Point2d> image;
  cv::projectPoints(board, rotation, cv::Vec3d((x - 319.5), (y - 239.5), 600), camera, cv::noArray(), image);
  calibration::PoseReport pose;
  pose.rows = kRows;
  pose.columns = kColumns;
  for (const cv::Point2d& point : image) {
    pose.corners.emplace_back().camera = point;
  }
  return pose;
}

// A positive turn about the image's rows (x to the right) takes the lower side away from the camera.
TEST(PoseAdvice, FindsTheFarSideHoweverTheBoardIsTurned) {
  for (const double roll : {0.0, 0.5, 1.57, 3.14, -1.2}) {
    EXPECT_EQ(calibration::lean_of(seen(0.4, 0, roll, 320, 240), kBoard), calibration::Lean::lower) << roll;
    EXPECT_EQ(calibration::lean_of(seen(-0.4, 0, roll, 320, 240), kBoard), calibration::Lean::upper) << roll;
    EXPECT_EQ(calibration::lean_of(seen(0, -0.4, roll, 320, 240), kBoard), calibration::Lean::right) << roll;
    EXPECT_EQ(calibration::lean_of(seen(0, 0.4, roll, 320, 240), kBoard), calibration::Lean::left) << roll;
    EXPECT_EQ(calibration::lean_of(seen(0, 0, roll, 320, 240), kBoard), calibration::Lean::none) << roll;
    EXPECT_EQ(calibration::lean_of(seen(0.4, 0, roll, 420, 160), kBoard), calibration::Lean::lower) << roll;
  }
  EXPECT_EQ(calibration::lean_of({}, kBoard), calibration::Lean::none);
}

TEST(PoseAdvice, AsksForWhatIsMissing) {
  calibration::PoseAdvice advice(kBoard);
  EXPECT_EQ(advice.next(),
            "place the chessboard in the central part of the image, with its left edge farther from the camera than "
            "its right "
            "edge");
  advice.add(seen(0, 0.4, 0, 320, 240));
  EXPECT_EQ(advice.covered().substr(0, 20), "covered: 1 of 9 part");
  EXPECT_EQ(
      advice.next(),
      "place the chessboard in the upper left part of the image, with its right edge farther from the camera than its "
      "left edge");
  advice.add(seen(0, -0.4, 0, 110, 80));
  EXPECT_NE(advice.covered().find("poses with the left edge far 1, right 1, upper 0, lower 0, none 0"),
            std::string::npos)
      << advice.covered();
  EXPECT_TRUE(advice.next().starts_with("place the chessboard in the lower right part of the image")) << advice.next();
  EXPECT_FALSE(advice.enough());
}

TEST(PoseAdvice, WhoFollowsItIsSoonDone) {
  calibration::PoseAdvice advice(kBoard);
  const std::vector<std::string> parts = {"upper left",   "upper middle", "upper right",  "middle left", "central",
                                          "middle right", "lower left",   "lower middle", "lower right"};
  int poses = 0;
  for (; !advice.enough() && poses < 30; ++poses) {
    const std::string next = advice.next();
    const std::string part = next.substr(28, next.find(" part of the image") - 28);
    std::size_t at = 0;
    while (at < parts.size() && parts[at] != part) {
      ++at;
    }
    ASSERT_LT(at, parts.size()) << next;
    const std::string far = next.substr(next.find("with its ") + 9);
    const double about_rows = far.starts_with("lower") ? 0.4 : far.starts_with("upper") ? -0.4 : 0;
    const double about_columns = far.starts_with("left") ? 0.4 : far.starts_with("right") ? -0.4 : 0;
    advice.add(seen(about_rows, about_columns, 0, 110.0 + 210.0 * static_cast<double>(at % 3),
                    80.0 + 160.0 * static_cast<double>(at / 3)));
  }
  EXPECT_TRUE(advice.enough());
  EXPECT_LE(poses, 10);
}

}  // namespace
}  // namespace selfproj::test
