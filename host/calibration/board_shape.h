// Smooth modes in which a chessboard that is not quite flat departs from its drawing. The calibration can estimate how
// strong each of them is.
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
inline constexpr int kOwnModes = 7;  // the bends of degree 2 and 3, which may differ from pose to pose

// The modes at one corner. A stretch has a root mean square of 1 over all corners. A bend of degree d has one of
// 1 / (d - 1), because paper bends in long waves rather than in short ones.
struct CornerModes {
  std::array<double, kBendModes> bend{};
  std::array<cv::Vec2d, kStretchModes> stretch{};
};

// The modes at every corner, in the order of the corners. They contain no motion of the whole chessboard and no change
// of its size. Modes that a chessboard with few corners cannot have are 0.
std::vector<CornerModes> board_modes(const Chessboard& chessboard);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_BOARD_SHAPE_H
