// selfproj calibrate heights
#ifndef SELFPROJ_HOST_APP_HEIGHTS_COMMAND_H
#define SELFPROJ_HOST_APP_HEIGHTS_COMMAND_H

#include <CLI/CLI.hpp>

namespace selfproj {

// Adds the command to `calibrate`.
CLI::App* add_heights_command(CLI::App& calibrate);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_HEIGHTS_COMMAND_H
