// How exactly three ways find the corners of a virtual chessboard, whose places in the image are known.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <span>
#include <vector>

#include "host/calibration/chessboard.h"
#include "host/files/results_file.h"
#include "host/images/image_files.h"
#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/targets.h"
#include "tests/host/structured_light/pinhole.h"
#include "tests/sim/on_board.h"

namespace selfproj::test {
namespace {

constexpr sim::ChessboardShape kShape{9, 7, 21};
constexpr int kPoses = 3;

std::vector<cv::Point2d> true_corners(const rig::Rig& rig, const sim::ChessboardPlace& place) {
  std::vector<cv::Point2d> corners;
  for (int down = 0; down < kShape.down; ++down) {
    for (int across = 0; across < kShape.across; ++across) {
      const sim::Point3 p = on_board(kShape, place, across, down);
      const Pixel seen = camera_sees(rig.camera, {p.x, p.y, p.z});
      corners.emplace_back(seen.column, seen.row);
    }
  }
  return corners;
}

// Distances in pixels from corners to the true ones that are nearest to them.
class Distances {
 public:
  template <class Point>
  void add(const std::vector<Point>& corners, const std::vector<cv::Point2d>& truth) {
    for (const Point& corner : corners) {
      double least = 1e9;
      for (const cv::Point2d& place : truth) {
        least = std::min(least, cv::norm(cv::Point2d(corner) - place));
      }
      sum_ += least * least;
      ++corners_;
    }
  }
  [[nodiscard]] std::size_t corners() const { return corners_; }
  [[nodiscard]] double rms() const { return std::sqrt(sum_ / static_cast<double>(corners_)); }

 private:
  double sum_ = 0;
  std::size_t corners_ = 0;
};

// The board that calibrates rig B in lab/scripts/calibration_chain.sh, fully lit, with the camera's noise.
TEST(ChessboardCorners, TheFitOfCrossingEdgesIsTheMostExact) {
  const rig::Rig rig = rig::load_rig("scanner");
  const sim::ProjectedLight full(images::FloatImage(rig.projector.lines, rig.projector.columns, 1), 1);
  std::array<Distances, 3> ways;  // OpenCV's finder, the same and cornerSubPix, ours
  for (const sim::ChessboardPlace& place : sim::chessboard_places(rig, kShape, kPoses, 30)) {
    const sim::ChessboardScene board(rig, kShape, place);
    const sim::PatternRenderer renderer(rig, board);
    images::Image image{rig.camera.rows, rig.camera.columns, std::vector<std::uint8_t>(rig.camera.pixels())};
    renderer.render(0, full, std::span(image.pixels));
    const std::vector<cv::Point2d> truth = true_corners(rig, place);

    const calibration::FoundChessboard found =
        calibration::find_chessboard(image, {kShape.across, kShape.down, kShape.square_mm});
    ASSERT_EQ(found.corners.size(), truth.size()) << found.reason;
    ways[2].add(found.corners, truth);

    const cv::Mat grey(image.rows, image.columns, CV_8UC1, image.pixels.data());
    std::vector<cv::Point2f> seen;
    ASSERT_TRUE(cv::findChessboardCornersSB(grey, {kShape.across, kShape.down}, seen,
                                            cv::CALIB_CB_EXHAUSTIVE | cv::CALIB_CB_ACCURACY));
    ways[0].add(seen, truth);
    constexpr int kHalfWindow = 5;  // pixels
    cv::cornerSubPix(grey, seen, {kHalfWindow, kHalfWindow}, {-1, -1},
                     {cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 100, 1e-4});
    ways[1].add(seen, truth);
  }
  for (const Distances& way : ways) {
    EXPECT_EQ(way.corners(), std::size_t{kPoses} * 63);
  }
  EXPECT_LT(ways[2].rms(), 0.01);
  EXPECT_LT(ways[2].rms(), ways[1].rms() / 3);
  EXPECT_LT(ways[1].rms(), ways[0].rms());
  files::write_results("chessboard_corners",
                       "RMS errors of a chessboard's corners in simulated images of rig B, in pixels",
                       {{"find_chessboard_corners_sb_px", ways[0].rms()},
                        {"corner_sub_pix_px", ways[1].rms()},
                        {"crossing_edges_px", ways[2].rms()},
                        {"corners", ways[2].corners()}});
}

}  // namespace
}  // namespace selfproj::test
