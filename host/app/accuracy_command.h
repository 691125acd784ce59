// The command `selfproj accuracy`.
#ifndef SELFPROJ_HOST_APP_ACCURACY_COMMAND_H
#define SELFPROJ_HOST_APP_ACCURACY_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// Adds the subcommand `accuracy`: quantization error and range of a rig, beside the published figures.
void add_accuracy_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_ACCURACY_COMMAND_H
