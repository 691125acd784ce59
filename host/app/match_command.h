#ifndef SELFPROJ_HOST_APP_MATCH_COMMAND_H
#define SELFPROJ_HOST_APP_MATCH_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// Adds `selfproj match`: computes depth and difference from images under a reference's patterns.
void add_match_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_MATCH_COMMAND_H
