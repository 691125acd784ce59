#ifndef SELFPROJ_HOST_APP_DEPTH_COMMAND_H
#define SELFPROJ_HOST_APP_DEPTH_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// Adds the subcommand `depth`: computes depth images, clouds and moved pixels from recorded Gray-code images.
void add_depth_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_DEPTH_COMMAND_H
