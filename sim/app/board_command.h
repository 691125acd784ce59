#ifndef SELFPROJ_SIM_APP_BOARD_COMMAND_H
#define SELFPROJ_SIM_APP_BOARD_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// Adds the subcommand `board`, which plays recorded or made packets in real time into a ring, or into a file.
void add_board_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_APP_BOARD_COMMAND_H
