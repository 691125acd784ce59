#ifndef SELFPROJ_HOST_CLI_PROGRAM_MAIN_H
#define SELFPROJ_HOST_CLI_PROGRAM_MAIN_H

#include <CLI/CLI.hpp>
#include <functional>

#include "host/cli/command_line.h"

namespace selfproj::cli {

// Runs a program: reads its command line, runs the command, and prints an error as one line "NAME: ...". Returns the
// exit status: 0 for success, 1 for a failed check or a failure of the program itself, 2 for bad usage or input.
int program_main(const CommandText& text, const std::function<void(CLI::App&)>& add_commands, int argc, char** argv);

}  // namespace selfproj::cli

#endif  // SELFPROJ_HOST_CLI_PROGRAM_MAIN_H
