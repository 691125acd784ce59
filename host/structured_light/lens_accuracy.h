// Quantization error and range of structured light through the lenses of a calibrated rig, by its whole geometry. The
// functions of accuracy.h call these; what they return is described there.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_LENS_ACCURACY_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_LENS_ACCURACY_H

#include "host/rig/rig.h"
#include "host/structured_light/accuracy_types.h"

namespace selfproj {

// NaN where camera or projector do not see the point.
ErrorTerms lens_error_terms(const Rig& rig, const SeenPoint& point, double delta_xp_mm, double delta_xc_mm);
DepthRange lens_range_of_lines(const Rig& rig, const SeenPoint& reference, double below, double above);
DepthRange lens_range_of_cells(const Rig& rig, const SeenPoint& reference, int width, int bits, int e);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_LENS_ACCURACY_H
