#ifndef SELFPROJ_HOST_APP_PROJECT_COMMAND_H
#define SELFPROJ_HOST_APP_PROJECT_COMMAND_H

#include <CLI/CLI.hpp>
#include <string>

#include "host/capture/projector.h"

namespace selfproj {

// selfproj project: patterns on a display.
void add_project_command(CLI::App& app);

// Adds --display and --gamma.
struct DisplayOptions {
  int display = 0;
  std::string gamma;  // empty: every grey value as it is
};
void add_display_options(CLI::App& command, DisplayOptions& options);

// The table of --gamma.
GreyTable greys_of(const DisplayOptions& options);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_PROJECT_COMMAND_H
