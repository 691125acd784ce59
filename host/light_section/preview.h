// A picture of a reference to look at.
#ifndef SELFPROJ_HOST_LIGHT_SECTION_PREVIEW_H
#define SELFPROJ_HOST_LIGHT_SECTION_PREVIEW_H

#include <string>

#include "host/images/float_image.h"
#include "host/light_section/reference.h"
#include "host/rig/rig.h"

namespace selfproj {

// PNG bytes: the pattern as the projector shows it, and below it the reference's height (plane_z - z) over the camera's
// columns, with gaps at columns without a reference. If `reference` has no columns, only the pattern is drawn.
std::string draw_preview(const Rig& rig, const FloatImage& pattern, const ReferenceProfile& reference);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_LIGHT_SECTION_PREVIEW_H
