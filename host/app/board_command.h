#ifndef SELFPROJ_HOST_APP_BOARD_COMMAND_H
#define SELFPROJ_HOST_APP_BOARD_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// Adds the subcommand `board` with its own subcommands: registers and state of a board.
void add_board_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_BOARD_COMMAND_H
