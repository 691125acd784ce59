// The marks ○ × ▽ carved on the stairs of experiment A2: strokes of constant width around a centre line.
#ifndef SELFPROJ_SIM_SCENE_MARKS_H
#define SELFPROJ_SIM_SCENE_MARKS_H

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace selfproj {

enum class Mark : std::uint8_t { circle, cross, triangle_down };

constexpr double kMarkSize = 22;   // mm, across and along
constexpr double kMarkStroke = 3;  // mm
constexpr double kMarkDepth = 1;   // mm

// Distance in mm of a point from the centre line of the mark's strokes; right and down are those of the mark, from its
// middle. The point is carved if the distance is at most kMarkStroke / 2. The distance changes by no more than the
// point moves.
inline double distance_from_mark(Mark mark, double right, double down) {
  constexpr double kReach = (kMarkSize - kMarkStroke) / 2;  // reach of the centre lines
  const auto segment = [&](double r0, double d0, double r1, double d1) {
    const double vr = r1 - r0;
    const double vd = d1 - d0;
    const double s = std::clamp(((right - r0) * vr + (down - d0) * vd) / (vr * vr + vd * vd), 0.0, 1.0);
    const double r = right - r0 - s * vr;
    const double d = down - d0 - s * vd;
    return std::sqrt(r * r + d * d);
  };
  switch (mark) {
    case Mark::circle:
      return std::abs(std::sqrt(right * right + down * down) - kReach);
    case Mark::cross:
      return std::min(segment(-kReach, -kReach, kReach, kReach), segment(-kReach, kReach, kReach, -kReach));
    case Mark::triangle_down:
      break;
  }
  return std::min({segment(-kReach, -kReach, kReach, -kReach), segment(kReach, -kReach, 0, kReach),
                   segment(0, kReach, -kReach, -kReach)});
}

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_MARKS_H
