#ifndef SELFPROJ_HOST_APP_RECORD_COMMAND_H
#define SELFPROJ_HOST_APP_RECORD_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// Adds the subcommand `record`, which records the packets of a device.
void add_record_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_RECORD_COMMAND_H
