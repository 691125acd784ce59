// Scans of a reference by the simulated camera before the measurement. Their noise differs from the measurement's: it
// has seed + 1.
#ifndef SELFPROJ_SIM_SCENE_VIRTUAL_SCAN_H
#define SELFPROJ_SIM_SCENE_VIRTUAL_SCAN_H

#include <functional>
#include <span>
#include <vector>

#include "host/images/float_image.h"
#include "host/rig/rig.h"
#include "host/structured_light/point_scan.h"
#include "model/column_moments.h"
#include "sim/scene/real_rig.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"

namespace selfproj {

// How a reference is scanned for structured light.
enum class ScanMethod {
  lines,       // a bright line at each of the projector's lines, then at each of its columns
  gray_codes,  // Gray codes along both axes, those of `selfproj pattern gray`
};

// The number of images in such a scan.
int scan_images(const Rig& rig, ScanMethod method);

// The projector point that each camera pixel sees on the scene. `done` is called after each image.
ProjectorPoints scan_points(const Rig& rig, const Scene& scene, const RenderOptions& options, ScanMethod method,
                            const std::function<void()>& done);

// Centroids C of the light section in each of the modes, rows from 1, one for each column: means over 16 frames in the
// middle of the scene's way, NaN if a column is not lit as the rig asks. `real` is the rig that takes the images, and
// `rig` the one believed to take them; their images have one size.
std::vector<std::vector<double>> scan_centroids(const Rig& rig, const RealRig& real, const Scene& scene,
                                                const FloatImage& pattern, const RenderOptions& options,
                                                std::span<const Mode> modes);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_VIRTUAL_SCAN_H
