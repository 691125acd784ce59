// A chessboard to print.
#ifndef SELFPROJ_HOST_CALIBRATION_CHESSBOARD_DRAWING_H
#define SELFPROJ_HOST_CALIBRATION_CHESSBOARD_DRAWING_H

#include <optional>
#include <string>
#include <vector>

#include "host/calibration/chessboard.h"

namespace selfproj::calibration {

// A sheet of paper, lying.
struct Paper {
  std::string name;
  double width_mm = 0;
  double height_mm = 0;
};

// A4, A3, A2, A1, A0.
const std::vector<Paper>& papers();

// The side in mm of the largest squares with which the board fits on the paper, in whole mm, or below 10 mm in tenths.
// None if they would be smaller than 1 mm. Around the board there is a margin of 15 mm at least, which printers leave
// white, and which holds the text.
std::optional<double> largest_square(const Chessboard& chessboard, const Paper& paper);

// The board in the middle of the paper as SVG, in millimetres. Below it stand the number of its inner corners, the side
// of its squares, its size and a line of 100 mm, by which a print is checked. Throws std::invalid_argument if it does
// not fit.
std::string chessboard_svg(const Chessboard& chessboard, const Paper& paper);

}  // namespace selfproj::calibration

#endif  // SELFPROJ_HOST_CALIBRATION_CHESSBOARD_DRAWING_H
