#ifndef SELFPROJ_HOST_APP_BOARD_REPLAY_H
#define SELFPROJ_HOST_APP_BOARD_REPLAY_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// Adds the subcommands `source` and `replay` of `board`: where a board's frames come from.
void add_board_replay_commands(CLI::App& board);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_BOARD_REPLAY_H
