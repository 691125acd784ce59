// The scenes of rig A: parts on a conveyor under a projected line. docs/simulation.md has their sizes.
#ifndef SELFPROJ_SIM_SCENE_LIGHT_SECTION_SCENES_H
#define SELFPROJ_SIM_SCENE_LIGHT_SECTION_SCENES_H

#include <vector>

#include "sim/scene/scene_info.h"

namespace selfproj {

// These scenes in the order of the list, without their numbers of frames.
const std::vector<SceneInfo>& light_section_scenes();

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_LIGHT_SECTION_SCENES_H
