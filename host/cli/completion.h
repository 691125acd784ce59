// Completion of a program's commands, options and their values in bash.
#ifndef SELFPROJ_HOST_CLI_COMPLETION_H
#define SELFPROJ_HOST_CLI_COMPLETION_H

#include <CLI/CLI.hpp>
#include <string>

namespace selfproj::cli {

// The script for bash, from the commands and options that the program has.
std::string bash_completion(const CLI::App& program);

// Adds `completion SHELL`, which prints it; all other commands must be there already.
void add_completion_command(CLI::App& program);

}  // namespace selfproj::cli

#endif  // SELFPROJ_HOST_CLI_COMPLETION_H
