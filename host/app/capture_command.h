#ifndef SELFPROJ_HOST_APP_CAPTURE_COMMAND_H
#define SELFPROJ_HOST_APP_CAPTURE_COMMAND_H

#include <CLI/CLI.hpp>

namespace selfproj {

// selfproj capture: an image of each pattern of a sequence.
void add_capture_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_CAPTURE_COMMAND_H
