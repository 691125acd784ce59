// Which poses of a chessboard a calibration still needs, from those taken so far.
#ifndef SELFPROJ_HOST_CALIBRATION_POSE_ADVICE_H
#define SELFPROJ_HOST_CALIBRATION_POSE_ADVICE_H

#include <array>
#include <cstddef>
#include <string>

#include "host/calibration/calibration_report.h"

namespace selfproj {

// Which side of a chessboard is further from the camera than the opposite one, in the image.
enum class Lean { none, left, right, upper, lower };
inline constexpr std::size_t kLeans = 5;

// How a chessboard leans, from the homography of its corners: the direction in which they recede, and `none` where the
// far side is less than 3 % further away than the near one, or the pose has no corners.
Lean lean_of(const PoseReport& pose, const Chessboard& chessboard);

// Counts what usable poses cover. A calibration wants corners in every part of the image, and chessboards that lean to
// every side, for focal length and distance change a chessboard that stands square in the same way.
class PoseAdvice {
 public:
  static constexpr int kSide = 3;    // the image has kSide x kSide parts
  static constexpr int kEnough = 8;  // poses

  explicit PoseAdvice(const Chessboard& chessboard) : chessboard_(chessboard) {}

  void add(const PoseReport& pose);

  [[nodiscard]] int poses() const { return poses_; }

  // Whether there are kEnough poses, each side was once the far one, and no more than one part of the image is empty.
  [[nodiscard]] bool enough() const;

  // "covered: 5 of 9 parts of the image (missing: upper left, left, lower left, lower middle); far side: left 1, ...".
  [[nodiscard]] std::string covered() const;

  // "put it into the upper left of the image, with its right side further away than its left": the empty part that is
  // furthest from the others that are covered, and the far side that was least often.
  [[nodiscard]] std::string next() const;

 private:
  [[nodiscard]] std::size_t next_part() const;

  Chessboard chessboard_;
  int poses_ = 0;
  std::array<int, kSide * kSide> parts_{};  // poses with corners there, row by row
  std::array<int, kLeans> leans_{};
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_POSE_ADVICE_H
