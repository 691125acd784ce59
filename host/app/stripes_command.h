// The commands of self-projected structured light.
#ifndef SELFPROJ_HOST_APP_STRIPES_COMMAND_H
#define SELFPROJ_HOST_APP_STRIPES_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// `selfproj pattern stripes`, below the command `pattern`: patterns to scan a reference with, and the reference folder
// made of what was recorded.
CLI::App* add_stripes_command(CLI::App& pattern);

// `selfproj match`: depth and difference of images seen under a reference's patterns.
void add_match_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_STRIPES_COMMAND_H
