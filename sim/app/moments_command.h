#ifndef SELFPROJ_SIM_APP_MOMENTS_COMMAND_H
#define SELFPROJ_SIM_APP_MOMENTS_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// Adds the subcommand `moments`, which computes the column moments of image files with an engine.
void add_moments_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_APP_MOMENTS_COMMAND_H
