#ifndef SELFPROJ_HOST_APP_STRIPES_COMMAND_H
#define SELFPROJ_HOST_APP_STRIPES_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// Adds `selfproj pattern stripes` below the command `pattern`. It makes the patterns for scanning a reference, and the
// reference folder from the recordings.
CLI::App* add_stripes_command(CLI::App& pattern);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_STRIPES_COMMAND_H
