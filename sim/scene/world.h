// What the world adds to an ideal scene, projector and camera. Each disturbance is off unless it is named; their
// parameters and where they come from stand in world.yaml.
#ifndef SELFPROJ_SIM_SCENE_WORLD_H
#define SELFPROJ_SIM_SCENE_WORLD_H

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/scene/bounce_strength.h"
#include "sim/scene/defect_pixels.h"
#include "sim/scene/defocus.h"
#include "sim/scene/fixed_pattern.h"
#include "sim/scene/flicker.h"
#include "sim/scene/gloss.h"
#include "sim/scene/jitter.h"
#include "sim/scene/projector_gamma.h"
#include "sim/scene/row_noise.h"
#include "sim/scene/saturation.h"
#include "sim/scene/second_line.h"
#include "sim/scene/texture.h"
#include "sim/scene/vibration.h"

namespace selfproj {

struct World {
  std::optional<Gloss> gloss;
  std::optional<Texture> texture;
  std::optional<Bounce> bounce;
  std::optional<Defocus> camera_defocus;
  std::optional<Defocus> projector_defocus;
  std::optional<ProjectorGamma> gamma;
  std::optional<FixedPattern> fixed_pattern;
  std::optional<DefectPixels> defect_pixels;
  std::optional<RowNoise> row_noise;
  std::optional<Saturation> saturation;
  std::optional<Flicker> flicker;
  std::optional<Vibration> vibration;
  std::optional<Jitter> jitter;
  std::optional<SecondLine> second_line;
  std::uint64_t seed = 1;  // of the texture, and of all that belongs to one camera

  [[nodiscard]] bool any() const {
    return disturbs_camera() || gloss || texture || projector_defocus || gamma || jitter;
  }

  // Whether the camera itself adds anything to an image (disturbed_camera.h).
  [[nodiscard]] bool disturbs_camera() const;
};

// The parameters of all disturbances. Every member of `world` is present but the gloss, which has presets.
struct WorldFile {
  World world;
  std::vector<std::pair<std::string, Gloss>> presets;
};

// The built-in world.yaml, or a file like it. Throws UserError with file, line, key and reason.
WorldFile load_world(const std::string& name_or_file);
inline constexpr const char* kBuiltInWorld = "built-in";

// A disturbance by its name, with the parameter that is its strength.
struct WorldSwitch {
  const char* name;
  const char* strength;  // the parameter, with its unit
  double least, most;    // of the strength
  void (*on)(World& to, const World& parameters);
  double& (*parameter)(
      World& of);  // the strength of a disturbance that is on; null for gloss, whose strengths are presets
};
const std::vector<WorldSwitch>& world_switches();
const WorldSwitch& find_world_switch(std::string_view name);

// The world with these disturbances on, each as NAME or NAME=STRENGTH. Throws UserError about --disturb if a name is
// unknown, doubled, or its strength no number within its bounds or no preset.
World world_of(const WorldFile& file, const std::vector<std::string>& disturbances);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_WORLD_H
