#ifndef SELFPROJ_HOST_APP_TOLERANCE_COMMAND_H
#define SELFPROJ_HOST_APP_TOLERANCE_COMMAND_H

namespace CLI {
class App;
}

namespace selfproj {

// `selfproj tolerance`: tolerance files.
void add_tolerance_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_TOLERANCE_COMMAND_H
