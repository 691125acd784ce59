// selfproj calibrate camera.
#ifndef SELFPROJ_HOST_APP_CAMERA_COMMAND_H
#define SELFPROJ_HOST_APP_CAMERA_COMMAND_H

#include <CLI/CLI.hpp>

namespace selfproj {

// Adds it to `calibrate`, and returns it.
CLI::App* add_camera_command(CLI::App& calibrate);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_CAMERA_COMMAND_H
