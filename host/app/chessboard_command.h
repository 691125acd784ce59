#ifndef SELFPROJ_HOST_APP_CHESSBOARD_COMMAND_H
#define SELFPROJ_HOST_APP_CHESSBOARD_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// Adds `selfproj pattern chessboard` below the command `pattern`: a chessboard to print.
CLI::App* add_chessboard_command(CLI::App& pattern);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_CHESSBOARD_COMMAND_H
