// The chessboard: its corners in the camera's image, and the modes by which its shape differs from its drawing.
#ifndef SELFPROJ_HOST_CALIBRATION_CHESSBOARD_H
#define SELFPROJ_HOST_CALIBRATION_CHESSBOARD_H

#include <array>
#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "host/images/image_files.h"

namespace selfproj::calibration {

// Inner corners along both sides (at least 3 each), and the side of a square. Corner i is at (i mod columns, i /
// columns) squares.
struct Chessboard {
  int columns = 0;
  int rows = 0;
  double square_mm = 0;

  [[nodiscard]] int corners() const { return columns * rows; }

  // Where a corner is on the drawing: mm, z = 0.
  [[nodiscard]] cv::Point3d place(int corner) const {
    const int row = corner / columns;
    return {square_mm * (corner % columns), square_mm * row, 0};
  }
};

struct FoundChessboard {
  std::vector<cv::Point2d>
      corners;              // in pixels (column, row) from 0, sub-pixel; empty where there is no such chessboard
  std::string reason;       // why it is empty
  double spacing_px = 0;    // median distance from a corner to its nearest neighbour
  bool by_squares = false;  // by OpenCV's findChessboardCorners, after findChessboardCornersSB found no such chessboard
  std::vector<bool> hidden;  // of each corner: under the line of a laser, or so near that it moves the corner; or empty
};

// Finds the corners of the whole chessboard, in any orientation. A chessboard with more corners than asked for is not
// taken for a part of itself. Both of OpenCV's detectors are asked, the older one only where the other finds nothing.
FoundChessboard find_chessboard(const images::Image& image, const Chessboard& chessboard);

// The same where the line of a laser may cross the chessboard: it is filled before (line_removal.h). `light` shows its
// light alone, in the pixels of the same image, such as a difference of channels; empty: what is bright and thin in
// `image`. Where there is no line, this is find_chessboard.
FoundChessboard find_chessboard_under_line(const images::Image& image, const images::Image& light,
                                           const Chessboard& chessboard);

// What a report says of a chessboard that was found by_squares.
inline constexpr const char* kBySquares = "findChessboardCorners; findChessboardCornersSB found none";

inline constexpr int kBendModes = 18;    // along the chessboard's normal: polynomials of degree 2 to 5 in the position
inline constexpr int kStretchModes = 8;  // within the chessboard's plane: aspect, shear and degree 2
inline constexpr int kSharedModes = kBendModes + kStretchModes;
inline constexpr int kOwnModes = 7;  // the first bends, of degree 2 and 3, which may differ from pose to pose

// The modes at one corner. Over all corners, a stretch has a root mean square of 1, and a bend of degree d has one of
// 1 / (d - 1), because long bends of paper are stronger than short ones.
struct CornerModes {
  std::array<double, kBendModes> bend{};
  std::array<cv::Vec2d, kStretchModes> stretch{};
};

// Returns the modes at every corner, in the order of the corners. They contain no motion of the whole chessboard and no
// change of its size. Modes for which the chessboard has too few corners are 0.
std::vector<CornerModes> board_modes(const Chessboard& chessboard);

}  // namespace selfproj::calibration

#endif  // SELFPROJ_HOST_CALIBRATION_CHESSBOARD_H
