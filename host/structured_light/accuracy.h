// Quantization error (4.21 to 4.26) and range (4.27 to 4.33) of structured light, as closed forms.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_ACCURACY_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_ACCURACY_H

#include "host/rig/rig.h"
#include "host/structured_light/accuracy_types.h"

namespace selfproj {

// error_terms and the ranges of a rig with lenses follow from its whole geometry (lens_accuracy.h). approximate_error
// and depth_of_line are those of its pinholes.
ErrorTerms error_terms(const Rig& rig, const SeenPoint& point, double delta_xp_mm, double delta_xc_mm);

// |Δz| of half a pixel of each, added by magnitude as in the published figures.
double half_pixel_error(const Rig& rig, const SeenPoint& point);

// (4.26): Δz for small α, β, θ - θ0, both terms.
ErrorTerms approximate_error(const Rig& rig, double delta_xp_mm, double delta_xc_mm);

// (4.27) to (4.33) with the window of (4.20) as printed: z from `low` (θ_max) to `high` (θ_min) for projector lines X_R
// - below <= line < X_R + above, if the reference is at the point. Corrected: z falls with θ, so z_min belongs to
// θ_max.
DepthRange range_of_lines(const Rig& rig, const SeenPoint& reference, double below, double above);

// The same with the window in cells, -e <= n < 2^m - e, if the reference is a plane z = const through the point. Cells
// are `width` camera rows high and are followed along the pixel's ray. Both ends are ends of whole cells.
DepthRange range_of_cells(const Rig& rig, const SeenPoint& reference, int width, int bits, int e);

// The z at which a pixel of this row sees a projector line (4.8).
double depth_of_line(const Rig& rig, double row, double line);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_ACCURACY_H
