// What the world adds to the images of one camera: before the noise of its light, and after it.
#ifndef SELFPROJ_SIM_SCENE_DISTURBED_CAMERA_H
#define SELFPROJ_SIM_SCENE_DISTURBED_CAMERA_H

#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "sim/scene/bounce.h"
#include "sim/scene/defect_pixels.h"
#include "sim/scene/fixed_pattern.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/real_rig.h"
#include "sim/scene/scene.h"
#include "sim/scene/world.h"

namespace selfproj {

class DisturbedCamera {
 public:
  // Null if the world does not disturb it. Scene and surface must live as long as the camera.
  static std::unique_ptr<const DisturbedCamera> of(const RealRig& real, const Scene& scene, const LitSurface& surface,
                                                   const World& world);

  // A frame as it is taken. `depths` gives z in mm of what each pixel sees.
  struct Shot {
    int frame;
    double t;  // s, the middle of the exposure
    double exposure_s;
    const ProjectedLight& pattern;
    std::function<void(std::span<float> z)> depths;
  };

  // In the order of the light's way: bounce of light, second reflection, ambient light that flickers, defocus,
  // vibration, exposure and full wells, gains of the pixels.
  void add_light(const Shot& shot, std::span<float> pixels) const;

  // Offsets of pixels and rows, defect pixels.
  void add_faults(int frame, std::span<float> pixels) const;

 private:
  DisturbedCamera(const RealRig& real, const Scene& scene, const LitSurface& surface, const World& world);
  void defocus(const Shot& shot, std::span<float> pixels) const;

  RealRig real_;
  World world_;
  double without_light_;  // grey value of a white surface without projected light
  double speed_;          // of the part, mm/s
  std::optional<BounceLight> bounce_;
  std::optional<FixedPatternMap> fixed_pattern_;
  std::optional<DefectMap> defects_;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_DISTURBED_CAMERA_H
