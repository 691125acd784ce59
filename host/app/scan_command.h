#ifndef SELFPROJ_HOST_APP_SCAN_COMMAND_H
#define SELFPROJ_HOST_APP_SCAN_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// Adds `selfproj scan`: projects, captures, decodes and triangulates in one run.
void add_scan_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_SCAN_COMMAND_H
