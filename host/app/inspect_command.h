#ifndef SELFPROJ_HOST_APP_INSPECT_COMMAND_H
#define SELFPROJ_HOST_APP_INSPECT_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// Adds the subcommand `inspect`: packets of a device into profiles, on-line.
void add_inspect_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_INSPECT_COMMAND_H
