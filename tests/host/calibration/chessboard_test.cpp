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

struct Size {
  int columns = 640;
  int rows = 512;
  double least_square = 24, most_square = 34;
  int fine = 4;  // a pixel is the mean of so many places along both sides
};

Drawing draw(Random& random, int columns, int rows, double turn, int around, double margin = 0.6,
             const Size& size = {}) {
  const int width = size.columns;
  const int height = size.rows;
  const int fine = size.fine;
  const double square = between(random, size.least_square, size.most_square);
  const double lean = between(random, -0.25, 0.25);
  const cv::Matx33d seen =
      cv::Matx33d(1, 0, width / 2.0, 0, 1, height / 2.0, 0, 0, 1) *
      cv::Matx33d(1, 0, 0, 0, 1, 0, lean / width, -lean / height, 1) *
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
  Drawing drawing{{height, width, {}}, {}};
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      int sum = 0;
      for (int i = 0; i < fine * fine; ++i) {
        const double x = column + (i % fine + 0.5) / fine - 0.5;
        const int down = i / fine;
        const double y = row + (down + 0.5) / fine - 0.5;
        sum += grey_at(through(back, x, y));
      }
      drawing.image.pixels.push_back(static_cast<std::uint8_t>(sum / (fine * fine)));
    }
  }
  cv::Mat pixels(height, width, CV_8UC1, drawing.image.pixels.data());
  cv::GaussianBlur(pixels, pixels, {}, 0.6);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      drawing.corners.push_back(through(seen, column, row));
    }
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

// A board in room light, with the line of a laser across it in any direction: saturated in the middle, with a veil of
// light around it. `light` is what the laser adds to its own colour; a camera of colours sees a share of it in the
// others.
images::Image laser_on(Random& random, const images::Image& board, double scale) {
  const double turn = between(random, 0, kHalfTurn);
  const double at = between(random, -0.1, 0.1) * board.rows;
  const double core = between(random, 1.5, 3.5) * scale;
  const double veil = between(random, 20, 60) * scale;
  const double veil_grey = between(random, 30, 90);
  images::Image light = board;
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      auto& pixel = light.pixels[static_cast<std::size_t>(row * board.columns + column)];
      const double albedo = pixel / 220.0;
      const double away =
          std::abs((row - board.rows / 2.0) * std::cos(turn) - (column - board.columns / 2.0) * std::sin(turn) - at);
      const double lit = albedo * 900 * std::exp(-away * away / (2 * core * core)) + veil_grey * std::exp(-away / veil);
      pixel = static_cast<std::uint8_t>(std::min(255.0, lit));
    }
  }
  return light;
}

images::Image sum_of(const images::Image& a, double of_a, const images::Image& b, double of_b) {
  images::Image sum = a;
  for (std::size_t i = 0; i < sum.pixels.size(); ++i) {
    sum.pixels[i] = static_cast<std::uint8_t>(std::clamp(of_a * a.pixels[i] + of_b * b.pixels[i], 0.0, 255.0));
  }
  return sum;
}

// All of 14 boards are found under the glare of a laser, by a camera of colours and by one without. Corners that the
// line does not hide are where they are without it: root mean square and largest error, in pixels.
TEST(Chessboards, AreFoundUnderTheGlareOfALaser) {
  constexpr int kBoards = 14;
  constexpr Size kSize{.columns = 768, .rows = 512, .least_square = 36, .most_square = 52, .fine = 3};
  int plainly = 0;
  for (const bool colours : {true, false}) {
    double squares = 0;
    double largest = 0;
    int corners = 0;
    for (int board = 0; board < kBoards; ++board) {
      SCOPED_TRACE(board);
      Random random(static_cast<std::uint64_t>(board) + 1);
      const Drawing drawing = draw(random, 9, 6, between(random, -0.4, 0.4), random.between(0, 60), 0.5, kSize);
      const images::Image in_room = sum_of(drawing.image, 0.5, drawing.image, 0);
      const images::Image laser = laser_on(random, drawing.image, 1);
      // The laser's own colour, and the two others, which see a fifth of it.
      const images::Image own = sum_of(in_room, 1, laser, 1);
      const images::Image others = sum_of(in_room, 1, laser, 0.2);
      const images::Image difference = sum_of(own, 1, others, -1);
      const calibration::Chessboard wanted{.columns = 9, .rows = 6, .square_mm = 1};
      plainly += calibration::find_chessboard(own, wanted).corners.empty() ? 0 : 1;
      const calibration::FoundChessboard found =
          colours ? calibration::find_chessboard_under_line(others, difference, wanted)
                  : calibration::find_chessboard_under_line(own, {}, wanted);
      EXPECT_EQ(found.reason, "");
      std::vector<cv::Point2d> expected = drawing.corners;
      if (!found.corners.empty() && cv::norm(found.corners.front() - expected.front()) > 20) {
        std::reverse(expected.begin(), expected.end());
      }
      int used = 0;
      for (std::size_t i = 0; i < found.corners.size(); ++i) {
        if (found.hidden.empty() || !found.hidden[i]) {
          const double off = cv::norm(found.corners[i] - expected[i]);
          squares += off * off;
          largest = std::max(largest, off);
          ++used;
        }
      }
      corners += used;
      EXPECT_GE(used, 54 / 2);
      EXPECT_LT(used, 54) << "the line hides corners";
    }
    EXPECT_LT(std::sqrt(squares / corners), 0.05) << (colours ? "colours" : "grey");
    EXPECT_LT(largest, 0.2) << (colours ? "colours" : "grey");
  }
  EXPECT_LT(plainly, 2 * kBoards) << "the boards are too easy";
}

// Where no line crosses the board, it is found as ever.
TEST(Chessboards, WithoutALaserAreFoundAsEver) {
  Random random(3);
  const Drawing drawing = draw(random, 9, 6, 0.2, 60, 0.5);
  const calibration::Chessboard wanted{.columns = 9, .rows = 6, .square_mm = 1};
  const calibration::FoundChessboard plain = calibration::find_chessboard(drawing.image, wanted);
  const images::Image dark{drawing.image.rows, drawing.image.columns,
                           std::vector<std::uint8_t>(drawing.image.pixels.size(), 3)};
  for (const images::Image& light : {images::Image{}, dark}) {
    const calibration::FoundChessboard found = calibration::find_chessboard_under_line(drawing.image, light, wanted);
    EXPECT_EQ(found.corners, plain.corners);
    EXPECT_TRUE(found.hidden.empty());
  }
}

}  // namespace
}  // namespace selfproj::test
