#ifndef SELFPROJ_HOST_APP_IMAGES_COMMAND_H
#define SELFPROJ_HOST_APP_IMAGES_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// Adds the subcommand `images`, which writes the images in a device's packets.
void add_images_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_IMAGES_COMMAND_H
