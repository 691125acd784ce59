// selfproj lines
#ifndef SELFPROJ_HOST_APP_LINES_COMMAND_H
#define SELFPROJ_HOST_APP_LINES_COMMAND_H

#include <CLI/CLI.hpp>

namespace selfproj {

// Adds the command to the program.
void add_lines_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_LINES_COMMAND_H
