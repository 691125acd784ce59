// The chessboard and its corners in the camera's image.
#ifndef SELFPROJ_HOST_CALIBRATION_CHESSBOARD_H
#define SELFPROJ_HOST_CALIBRATION_CHESSBOARD_H

#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "host/images/image_files.h"

namespace selfproj {

// Inner corners along both sides (at least 3 each), and the side of a square. Corner i is at (i mod columns, i /
// columns) squares.
struct Chessboard {
  int columns = 0;
  int rows = 0;
  double square_mm = 0;

  [[nodiscard]] int corners() const { return columns * rows; }
};

struct FoundChessboard {
  std::vector<cv::Point2d>
      corners;            // in pixels (column, row) from 0, sub-pixel; empty where there is no such chessboard
  std::string reason;     // why it is empty
  double spacing_px = 0;  // median distance from a corner to its nearest neighbour
};

// Finds the corners of the whole chessboard, in any orientation. A chessboard with more corners than asked for is not
// taken for a part of itself.
FoundChessboard find_chessboard(const Image& image, const Chessboard& chessboard);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_CHESSBOARD_H
