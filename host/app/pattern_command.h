#ifndef SELFPROJ_HOST_APP_PATTERN_COMMAND_H
#define SELFPROJ_HOST_APP_PATTERN_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// Adds the subcommand `pattern`, which makes reference folders, straight lines, and the patterns of a sweep.
void add_pattern_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_PATTERN_COMMAND_H
