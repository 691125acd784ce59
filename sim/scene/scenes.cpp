#include "sim/scene/scenes.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "selfproj/files/user_error.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/scene.h"

namespace selfproj::sim {

const std::vector<SceneInfo>& scenes() {
  static const std::vector<SceneInfo> all = [] {
    std::vector<SceneInfo> list;
    for (const auto* part : {&light_section_scenes(), &scanner_scenes(), &self_projected_scenes()}) {
      list.insert(list.end(), part->begin(), part->end());
    }
    for (SceneInfo& info : list) {
      info.frames = info.make(rig::load_rig(info.rig()))->frames();
    }
    return list;
  }();
  return all;
}

const SceneInfo& find_scene(const std::string& name) {
  const auto found =
      std::find_if(scenes().begin(), scenes().end(), [&](const SceneInfo& info) { return info.name == name; });
  if (found != scenes().end()) {
    return *found;
  }
  std::string names;
  for (const SceneInfo& info : scenes()) {
    names += (names.empty() ? "" : ", ") + info.name;
  }
  throw UserError(name, fmt::format("is not a scene; the scenes are {}", names));
}

std::unique_ptr<Scene> make_scene(const std::string& name, const rig::Rig& rig) {
  const SceneInfo& info = find_scene(name);
  if (info.method != SceneMethod::light_section && rig.kind != rig::RigKind::scanner) {
    throw UserError(name, fmt::format("needs a rig of kind scanner; {} is not one", rig.name));
  }
  return info.make(rig);
}

}  // namespace selfproj::sim
