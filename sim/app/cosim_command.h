#ifndef SELFPROJ_SIM_APP_COSIM_COMMAND_H
#define SELFPROJ_SIM_APP_COSIM_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// Adds the subcommand `cosim`: a scene or recorded images through camera, board and driver, compared with the model, to
// profiles, pictures and report.
void add_cosim_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_APP_COSIM_COMMAND_H
