// Column moments for the production PC: the results of model/column_moments bit for bit, at the speed of memory.
#ifndef SELFPROJ_HOST_LIGHT_SECTION_FAST_MOMENTS_H
#define SELFPROJ_HOST_LIGHT_SECTION_FAST_MOMENTS_H

#include "model/column_moments.h"

namespace selfproj {

// Writes the same moments as column_moments for the same arguments, and throws whenever that throws. Reads the image
// once. Fastest if image.columns is a multiple of 512. Allocates nothing and keeps no state, so any number of threads
// may call it at once.
void fast_column_moments(const ImageView& image, Mode mode, int threshold, const MomentsView& out);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_LIGHT_SECTION_FAST_MOMENTS_H
