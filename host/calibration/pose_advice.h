// Which poses of a chessboard a calibration still needs, from those taken so far.
#ifndef SELFPROJ_HOST_CALIBRATION_POSE_ADVICE_H
#define SELFPROJ_HOST_CALIBRATION_POSE_ADVICE_H

#include <array>
#include <cstddef>
#include <string>

#include "host/calibration/calibrate.h"

namespace selfproj::calibration {

// Which side of a chessboard, as seen in the image, is further from the camera than the opposite side.
enum class Lean { none, left, right, upper, lower };
inline constexpr std::size_t kLeans = 5;

// The side towards which the corners recede, by their homography. `none` if the depth differs by less than 3 % across
// the board, or there is no homography.
Lean lean_of(const PoseReport& pose, const Chessboard& chessboard);

// Counts which parts of the camera's image have corners, and to which sides the chessboards lean. The image of a
// chessboard that faces the camera cannot tell the focal length from the distance, because both only scale it. So
// chessboards must lean, to every side. Only poses that are used should be added.
class PoseAdvice {
 public:
  static constexpr int kSide = 3;    // the image has kSide x kSide parts
  static constexpr int kEnough = 8;  // poses

  explicit PoseAdvice(const Chessboard& chessboard) : chessboard_(chessboard) {}

  void add(const PoseReport& pose);

  [[nodiscard]] int poses() const { return poses_; }

  // Whether there are kEnough poses or more, each side was the far one at least once, and at most one part of the image
  // is empty.
  [[nodiscard]] bool enough() const;

  // "covered: 5 of 9 parts of the image (missing: upper left, middle left, lower left, lower middle); poses with the
  // left edge far 1, right 2, upper 0, lower 1, none 0".
  [[nodiscard]] std::string covered() const;

  // "place the chessboard in the upper left part of the image, with its right edge farther from the camera than its
  // left edge": the part with the fewest poses, and among equals the one furthest from where corners were seen; first
  // the middle. The far side is the one that poses had least often.
  [[nodiscard]] std::string next() const;

 private:
  [[nodiscard]] std::size_t next_part() const;

  Chessboard chessboard_;
  int poses_ = 0;
  std::array<int, kSide * kSide> parts_{};  // poses with corners there, row by row
  std::array<int, kLeans> leans_{};
};

}  // namespace selfproj::calibration

#endif  // SELFPROJ_HOST_CALIBRATION_POSE_ADVICE_H
