// The properties of a built-in scene: how it is measured, and against what.
#ifndef SELFPROJ_SIM_SCENE_SCENE_INFO_H
#define SELFPROJ_SIM_SCENE_SCENE_INFO_H

#include <cstdint>
#include <memory>
#include <string>

#include "host/rig/rig.h"
#include "sim/scene/scene.h"

namespace selfproj {

// How a scene is measured.
enum class SceneMethod : std::uint8_t {
  light_section,   // a self-projected line
  gray_codes,      // Gray-code patterns, against a background
  self_projected,  // Gray-code patterns that are straight on the reference
};

// The motion that is followed through the depth images of a gray_codes scene.
enum class SceneAnalysis : std::uint8_t {
  moved_centroid,  // the centroid of the pixels that differ from the background
  wave_front,      // the foremost crest of a ring wave
  key_taps,        // the depth at two pixels
};

struct SceneInfo {
  std::string name;
  std::string description;
  SceneMethod method = SceneMethod::light_section;
  std::string reference = {};  // the scene that is the good part or the background; empty if it is its own
  SceneAnalysis analysis = SceneAnalysis::moved_centroid;
  int cells_below = 0;  // e of (4.20) with which the thesis measures it; for self_projected
  std::unique_ptr<Scene> (*make)(const Rig& rig) = nullptr;
  int frames = 0;  // number of frames with its own rig

  // The built-in rig for which it was made.
  [[nodiscard]] const char* rig() const { return method == SceneMethod::light_section ? "light-section" : "scanner"; }
  [[nodiscard]] const std::string& reference_name() const { return reference.empty() ? name : reference; }
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_SCENE_INFO_H
