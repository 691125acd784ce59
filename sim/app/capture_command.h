#ifndef SELFPROJ_SIM_APP_CAPTURE_COMMAND_H
#define SELFPROJ_SIM_APP_CAPTURE_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// selfproj-sim capture: what the camera sees under each pattern of a folder, of a scene or of a chessboard in poses.
void add_capture_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_APP_CAPTURE_COMMAND_H
