// The reference of self-projected structured light, known before the first frame, and the patterns made from it.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_SELF_REFERENCE_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_SELF_REFERENCE_H

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "host/images/float_image.h"
#include "host/rig/rig.h"
#include "host/structured_light/point_scan.h"
#include "host/structured_light/stripe_code.h"

namespace selfproj {

// Stands for the cell of a projector pixel that has no place f_R.
inline constexpr int kNoCell = std::numeric_limits<int>::min();

// Camera images have the rig's camera's rows x columns, projector images its lines x columns; coordinates count from 0.
struct SelfReference {
  Stripes stripes;
  ProjectorPoints points;  // X_R: the projector point that each camera pixel sees on the reference; A_R says where
                           // there is one (both coordinates or neither)
  FloatImage row;          // f_R: the camera point that each projector pixel lights on the reference (4.12); NaN where
                           // it would be far outside the camera's image
  FloatImage column;
  std::vector<std::uint8_t> seen;  // for each projector pixel: 1 if the camera sees it, 0 if f_R is filled in

  // A_R of a camera pixel.
  [[nodiscard]] bool measurable(std::size_t pixel) const;

  // ⌊Xc(f_R) / (a δc)⌋ of a projector pixel: the cell of the reference to which its light belongs; kNoCell where f_R is
  // NaN.
  [[nodiscard]] int cell(int line, int projector_column) const;

  int camera_rows = 0;  // the size in which Xc is counted
};

// Inverts X_R to f_R. Between the four pixels of a square of the camera image that lie on one surface (no two of them
// more than `jump` = 8 lines or columns apart), f_R is the inverse of X_R, linear in each of two triangles. Elsewhere,
// in shadows and where the camera does not see, it is filled in, so that every projector pixel has a cell. For this the
// depth z of the reference, as the projector sees it, is continued smoothly (Laplace's equation, level across the
// border of the projector's image), and f_R is where the camera would see that surface, even beyond its image. A plane
// that faces the camera continues as that plane, and neighbouring cells follow each other without a gap. A calibrated
// rig does this through its lenses. f_R is NaN, and the patterns are dark, where the lens model has no ray, or the
// camera would see the surface more than four sizes of its image away. Throws std::invalid_argument if sizes are not
// the rig's, the stripes are out of range, or no pixel is seen.
SelfReference make_self_reference(const Rig& rig, const ProjectorPoints& points, const Stripes& stripes);

// Throws std::invalid_argument if the stripes are out of range.
void check_stripes(const Stripes& stripes);

// Self-projected pattern i of (4.13), 0..2m - 1: even for the positive of plane i / 2, odd for its negative. Light 0 or
// 1.
FloatImage self_projected_pattern(const SelfReference& reference, int index);

// Pattern i of a line scan: first the projector's lines, then, from i = lines on, its columns.
FloatImage scan_pattern(const Rig& rig, int index);

// Pattern i of the conventional method (4.1): stripes along the projector's lines, 2^bits codes over the central
// `lines` lines, which may be all. Beyond them positives and negatives are dark.
FloatImage gray_pattern(const Rig& rig, int bits, int lines, int index);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_SELF_REFERENCE_H
