#ifndef SELFPROJ_HOST_APP_DEPTH_COMMAND_H
#define SELFPROJ_HOST_APP_DEPTH_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// Adds the subcommand `depth`: depth images, clouds and what moved, of recorded Gray-code images.
void add_depth_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_DEPTH_COMMAND_H
