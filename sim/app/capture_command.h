#ifndef SELFPROJ_SIM_APP_CAPTURE_COMMAND_H
#define SELFPROJ_SIM_APP_CAPTURE_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// Adds `selfproj-sim capture`, which renders what the camera sees under each pattern of a folder. The camera looks at a
// scene, at a chessboard in several poses, or at a plate or a block of treads.
void add_capture_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_APP_CAPTURE_COMMAND_H
