#ifndef SELFPROJ_SIM_APP_DECODE_COMMAND_H
#define SELFPROJ_SIM_APP_DECODE_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// Adds the subcommand `decode`, which decodes image files of a Gray-code sequence with an engine.
void add_decode_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_APP_DECODE_COMMAND_H
