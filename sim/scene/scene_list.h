// The built-in scenes.
#ifndef SELFPROJ_SIM_SCENE_SCENE_LIST_H
#define SELFPROJ_SIM_SCENE_SCENE_LIST_H

#include <memory>
#include <string>
#include <vector>

#include "host/rig/rig.h"
#include "sim/scene/scene.h"
#include "sim/scene/scene_info.h"

namespace selfproj {

// All of them: those of the light section first.
const std::vector<SceneInfo>& scenes();

// A scene's entry. Throws UserError naming an unknown one.
const SceneInfo& find_scene(const std::string& name);

// A scene by its name, moving as the rig's conveyor does. Throws UserError naming an unknown one, or one that such a
// rig cannot measure.
std::unique_ptr<Scene> make_scene(const std::string& name, const Rig& rig);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_SCENE_LIST_H
