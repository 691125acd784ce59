// Points, errors and ranges of structured light (accuracy.h).
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_ACCURACY_TYPES_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_ACCURACY_TYPES_H

namespace selfproj {

// The point at depth z on the ray of a camera pixel (row and column from 0, with fractions); lengths in mm.
struct SeenPoint {
  double row = 0;
  double column = 0;
  double z = 0;
};

// An error of a point's coordinates, mm.
struct PointError {
  double x = 0;
  double y = 0;
  double z = 0;
};

// How errors ΔXp and ΔXc, in mm on the image planes, change a point: the two terms of (4.21) to (4.23), with their
// signs. The first term is the projector's, the second the camera's. In (4.21) tan α / Xc is read as 1 / fc; as printed
// it is singular at Xc = 0. The second term holds at fixed y/z: Δy as if the column were exact.
struct ErrorTerms {
  PointError projector;
  PointError camera;
};
struct DepthRange {
  double low = 0;
  double high = 0;
};
}  // namespace selfproj

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_ACCURACY_TYPES_H
