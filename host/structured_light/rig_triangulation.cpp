#include "host/structured_light/rig_triangulation.h"

#include <memory>

#include "host/rig/rig_calibration.h"
#include "host/structured_light/lens_triangulation.h"

namespace selfproj {

std::unique_ptr<Triangulation> triangulation_of_rig(const Rig& rig, int bits, const DepthLimits& limits) {
  if (rig.is_pinholes()) {
    return std::make_unique<PlaneTriangulation>(rig, bits, limits);
  }
  LensSettings settings{.rows = rig.camera.rows,
                        .columns = rig.camera.columns,
                        .bits = bits,
                        .lines = static_cast<double>(rig.projector.lines),
                        .limits = limits,
                        .rows_are_x = true};
  settings.limits.max_z_per_line_mm = rig.measure.max_z_per_line_mm;
  return std::make_unique<LensTriangulation>(calibration_of(rig), settings);
}

}  // namespace selfproj
