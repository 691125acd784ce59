// Chessboards drawn at random: found in every position and on narrow paper, with their true corners; a larger board is
// not taken for its part.

#include "host/calibration/chessboard.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

double between(Random& random, double low, double high) {
  return low + (high - low) * random.between(0, 10000) / 10000.0;
}

// A board seen from a random side. `around` is the grey value of what lies around it, `margin` that of its paper in
// squares.
struct Drawing {
  images::Image image;
  std::vector<cv::Point2d> corners;  // of the board's own order
};

Drawing draw(Random& random, int columns, int rows, double turn, int around, double margin = 0.6) {
  constexpr int kColumns = 640;
  constexpr int kRows = 512;
  constexpr int kFine = 4;  // a pixel is the mean of so many places along both sides
  const double square = between(random, 24, 34);
  const double lean = between(random, -0.25, 0.25);
  const cv::Matx33d seen =
      cv::Matx33d(1, 0, kColumns / 2.0, 0, 1, kRows / 2.0, 0, 0, 1) *
      cv::Matx33d(1, 0, 0, 0, 1, 0, lean / kColumns, -lean / kRows, 1) *
      cv::Matx33d(std::cos(turn), -std::sin(turn), 0, std::sin(turn), std::cos(turn), 0, 0, 0, 1) *
      cv::Matx33d(square, 0, -square * (columns - 1) / 2.0, 0, square, -square * (rows - 1) / 2.0, 0, 0, 1);
  const cv::Matx33d back = seen.inv();
  const auto through = [](const cv::Matx33d& map, double x, double y) {
    const cv::Vec3d p = map * cv::Vec3d(x, y, 1);
    return cv::Point2d(p[0] / p[2], p[1] / p[2]);
  };
  const auto grey_at = [&](const cv::Point2d& at) {  // corner (0, 0) is at the origin
    if (at.x < -1 - margin || at.x > columns + margin || at.y < -1 - margin || at.y > rows + margin) {
      return around;
    }
    const bool square_is = at.x >= -1 && at.x < columns && at.y >= -1 && at.y < rows;
    return square_is && static_cast<int>(std::floor(at.x) + std::floor(at.y)) % 2 == 0 ? 30 : 220;
  };
  Drawing drawing{{kRows, kColumns, {}}, {}};
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      int sum = 0;
      for (int i = 0; i < kFine * kFine; ++i) {
        const double x = column + (i % kFine + 0.5) / kFine - 0.5;
        const double y = row + (i / kFine + 0.5) / kFine - 0.5;
        sum += grey_at(through(back, x, y));
      }
      drawing.image.pixels.push_back(static_cast<std::uint8_t>(sum / (kFine * kFine)));
    }
  }
  cv::Mat pixels(kRows, kColumns, CV_8UC1, drawing.image.pixels.data());
  cv::GaussianBlur(pixels, pixels, {}, 0.6);
  for (int i = 0; i < columns * rows; ++i) {
    drawing.corners.push_back(through(seen, i % columns, i / columns));
  }
  return drawing;
}

// The largest distance of a corner from its true place, in the order of the board or in that of the board turned by 180
// degrees.
double largest_error(const std::vector<cv::Point2d>& found, std::vector<cv::Point2d> expected) {
  double best = 1e9;
  for (int turns = 0; turns < 2 && found.size() == expected.size(); ++turns) {
    double largest = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      largest = std::max(largest, cv::norm(found[i] - expected[i]));
    }
    best = std::min(best, largest);
    std::reverse(expected.begin(), expected.end());
  }
  return best;
}

constexpr double kHalfTurn = 3.14159265358979;

TEST(Chessboards, AreFoundInEveryPosition) {
  for (const std::uint64_t seed : seeds(6)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const int columns = random.between(5, 10);
    const int rows = random.between(4, 7);
    const double turn = random.between(0, 1) * kHalfTurn + between(random, -0.5, 0.5);
    const Drawing drawing = draw(random, columns, rows, turn, random.between(0, 255));
    const calibration::FoundChessboard found =
        calibration::find_chessboard(drawing.image, {.columns = columns, .rows = rows, .square_mm = 1});
    EXPECT_EQ(found.reason, "") << columns << " x " << rows;
    EXPECT_LT(largest_error(found.corners, drawing.corners), 0.2);
    EXPECT_EQ(calibration::find_chessboard(drawing.image, {.columns = columns - 1, .rows = rows, .square_mm = 1})
                  .corners.size(),
              0U)
        << "a part of a larger board";
  }
}

// On a narrow margin a detector may add a line of corners at the paper's edge, or number them as in a mirror.
TEST(Chessboards, AreFoundOnNarrowPaper) {
  for (const std::uint64_t seed : seeds(8)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const Drawing drawing = draw(random, 9, 6, between(random, -0.3, 0.3), 90, between(random, 0.08, 0.16));
    const calibration::FoundChessboard found =
        calibration::find_chessboard(drawing.image, {.columns = 9, .rows = 6, .square_mm = 1});
    EXPECT_EQ(found.reason, "");
    EXPECT_LT(largest_error(found.corners, drawing.corners), 0.2);
  }
}

}  // namespace
}  // namespace selfproj::test
