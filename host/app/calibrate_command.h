#ifndef SELFPROJ_HOST_APP_CALIBRATE_COMMAND_H
#define SELFPROJ_HOST_APP_CALIBRATE_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// Adds the subcommand `calibrate`: turns captures of a chessboard into a calibrated rig.
void add_calibrate_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_CALIBRATE_COMMAND_H
