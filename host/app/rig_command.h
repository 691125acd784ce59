#ifndef SELFPROJ_HOST_APP_RIG_COMMAND_H
#define SELFPROJ_HOST_APP_RIG_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// Adds the subcommand `rig`, which lists the built-in rigs, or prints or checks one.
void add_rig_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_RIG_COMMAND_H
