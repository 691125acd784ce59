#ifndef SELFPROJ_SIM_APP_SCENE_COMMAND_H
#define SELFPROJ_SIM_APP_SCENE_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// Adds the subcommand `scene`: `scene list` and `scene render`, which writes the camera's images of a scene.
void add_scene_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_APP_SCENE_COMMAND_H
