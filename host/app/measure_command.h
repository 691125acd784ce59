#ifndef SELFPROJ_HOST_APP_MEASURE_COMMAND_H
#define SELFPROJ_HOST_APP_MEASURE_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// Adds `selfproj measure` with `gamma`: measures properties of a projector by a camera.
void add_measure_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_MEASURE_COMMAND_H
