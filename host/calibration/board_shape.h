// The modes by which the shape of a real chessboard differs from its drawing: smooth bends and stretches. The
// calibration can estimate the amplitude of each mode.
#ifndef SELFPROJ_HOST_CALIBRATION_BOARD_SHAPE_H
#define SELFPROJ_HOST_CALIBRATION_BOARD_SHAPE_H

#include <array>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "host/calibration/chessboard.h"

namespace selfproj {

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

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_BOARD_SHAPE_H
