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

// All built-in scenes; those of the light section come first.
const std::vector<SceneInfo>& scenes();

// The entry of a scene. Throws UserError for an unknown name.
const SceneInfo& find_scene(const std::string& name);

// Makes a scene by its name; it moves as the rig's conveyor does. Throws UserError for an unknown name, or for a scene
// that such a rig cannot measure.
std::unique_ptr<Scene> make_scene(const std::string& name, const Rig& rig);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_SCENE_LIST_H
