#ifndef SELFPROJ_HOST_APP_DEVICES_COMMAND_H
#define SELFPROJ_HOST_APP_DEVICES_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// Adds the subcommand `devices`, which lists the rings of this machine and their state, or removes one.
void add_devices_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_DEVICES_COMMAND_H
