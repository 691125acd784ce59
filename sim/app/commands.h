// The commands of selfproj-sim. Each adds a command with its options and help to the program.
#ifndef SELFPROJ_SIM_APP_COMMANDS_H
#define SELFPROJ_SIM_APP_COMMANDS_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj::sim {

void add_board_command(CLI::App& app);    // a board that sends packets to a ring, over the network or into a file
void add_camera_command(CLI::App& app);   // a camera in the network that sends recorded images
void add_capture_command(CLI::App& app);  // camera images under projected patterns
void add_cosim_command(CLI::App& app);    // rendered frames through the board and the driver, compared with the model
void add_decode_command(CLI::App& app);   // Gray codes of image files, by an engine
void add_moments_command(CLI::App& app);  // column moments of image files, by an engine
void add_production_command(CLI::App& app);  // the files of a simulated production line
void add_scene_command(CLI::App& app);       // scenes listed and rendered

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_APP_COMMANDS_H
