// How a chessboard that is not quite flat departs from its drawing: smooth modes, so that the calibration can release
// its shape.
#ifndef SELFPROJ_HOST_CALIBRATION_BOARD_SHAPE_H
#define SELFPROJ_HOST_CALIBRATION_BOARD_SHAPE_H

#include <array>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "host/calibration/chessboard.h"

namespace selfproj {

inline constexpr int kBendModes = 18;    // polynomials of degree 2 to 5 in the place, along the chessboard's normal
inline constexpr int kStretchModes = 8;  // aspect, shear and degree 2, within the chessboard's plane
inline constexpr int kSharedModes = kBendModes + kStretchModes;
inline constexpr int kOwnModes = 7;  // the bends of degree 2 and 3, which may differ from pose to pose

// The modes at one corner. A mode has a root mean square of 1 over all corners, and a bend of degree d one of
// 1 / (d - 1), since paper bends in long waves rather than in short ones.
struct CornerModes {
  std::array<double, kBendModes> bend{};
  std::array<cv::Vec2d, kStretchModes> stretch{};
};

// The modes at every corner, in the order of the corners. They contain no motion of the whole chessboard and no change
// of its size. Modes that a chessboard with few corners cannot have are 0.
std::vector<CornerModes> board_modes(const Chessboard& chessboard);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_BOARD_SHAPE_H
