// A camera that sends only a region of its sensor, more often and with a shorter exposure (rig::RigRegion).
#ifndef SELFPROJ_SIM_SCENE_REGION_H
#define SELFPROJ_SIM_SCENE_REGION_H

#include <algorithm>
#include <span>

#include "selfproj/rig/rig.h"

namespace selfproj::sim {

// Makes the light of `actual` that of the camera's exposure while it measures: a shorter exposure collects less light;
// noise and dark level of the sensor stay.
inline void expose_as_sent(const rig::RigCamera& camera, rig::Rig& actual) {
  if (camera.region) {
    const double share = camera.region->exposure_s / camera.exposure_s;
    actual.camera.exposure_s = camera.region->exposure_s;
    actual.imaging.white *= share;
    actual.imaging.ambient *= share;
  }
}

// Copies what is sent out of an image of the whole sensor.
template <class Pixel>
void crop_as_sent(const rig::RigCamera& camera, std::span<const Pixel> sensor, std::span<Pixel> sent) {
  const rig::RigRegion region = camera.sent();
  for (int row = 0; row < region.rows; ++row) {
    std::copy_n(sensor.begin() + (region.row_offset + row) * camera.columns + region.column_offset, region.columns,
                sent.begin() + row * region.columns);
  }
}

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_SCENE_REGION_H
