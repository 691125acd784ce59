// The samples of a calibration of heights: where the camera saw which line, at which true height.
#ifndef SELFPROJ_HOST_LIGHT_SECTION_HEIGHT_SAMPLES_H
#define SELFPROJ_HOST_LIGHT_SECTION_HEIGHT_SAMPLES_H

#include <cstddef>
#include <vector>

#include "host/light_section/height_fit_types.h"
#include "host/rig/optics.h"
#include "host/rig/rig.h"

namespace selfproj {

struct HeightSample {
  double row = 0;  // from 0
  int column = 0;
  double line = 0;
  std::size_t position = 0;
  std::size_t level = 0;
  double height_mm = 0;        // true
  double x = 0, y = 0, z = 0;  // by the geometry alone
};

// All samples that the geometry can place. With steps, each gets the height of its tread; samples that belong to none,
// or lie within three columns of a step, are left out.
std::vector<HeightSample> height_samples(const Rig& rig, const std::vector<HeightPosition>& positions,
                                         const HeightSettings& settings);

// Places the samples anew by the geometry of another rig.
void place_samples(const RigOptics& optics, std::vector<HeightSample>& samples);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_LIGHT_SECTION_HEIGHT_SAMPLES_H
