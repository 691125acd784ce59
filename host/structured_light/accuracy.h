// Quantization error (4.21 to 4.26) and range (4.27 to 4.33) of structured light, as closed forms for pinholes, and by
// the whole geometry of a rig with lenses.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_ACCURACY_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_ACCURACY_H

#include "selfproj/rig/rig.h"

namespace selfproj::structured_light {

// The point at depth z on the ray of a camera pixel (row and column from 0, with fractions); lengths in mm.
struct CameraPoint {
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

// (4.21) to (4.23) at a point, for errors of `delta_xp_mm` and `delta_xc_mm` on the image planes of projector and
// camera. NaN where camera or projector do not see the point. These errors and the ranges below follow from the whole
// geometry of a rig with lenses; approximate_error and depth_of_line are those of its pinholes.
ErrorTerms error_terms(const rig::Rig& rig, const CameraPoint& point, double delta_xp_mm, double delta_xc_mm);

// |Δz| of half a pixel of each, added by magnitude as in the published figures.
double half_pixel_error(const rig::Rig& rig, const CameraPoint& point);

// (4.26): Δz for small α, β, θ - θ0, both terms.
ErrorTerms approximate_error(const rig::Rig& rig, double delta_xp_mm, double delta_xc_mm);

// (4.27) to (4.33) with the window of (4.20) as printed: z from `low` (θ_max) to `high` (θ_min) for projector lines X_R
// - below <= line < X_R + above, if the reference is at the point. Corrected: z falls with θ, so z_min belongs to
// θ_max.
DepthRange range_of_lines(const rig::Rig& rig, const CameraPoint& reference, double below, double above);

// The same with the window in cells, -e <= n < 2^m - e, if the reference is a plane z = const through the point. Cells
// are `width` camera rows high and are followed along the pixel's ray. Both ends are ends of whole cells.
DepthRange range_of_cells(const rig::Rig& rig, const CameraPoint& reference, int width, int bits, int e);

// The z at which a pixel of this row sees a projector line (4.8).
double depth_of_line(const rig::Rig& rig, double row, double line);

}  // namespace selfproj::structured_light

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_ACCURACY_H
