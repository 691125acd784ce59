// selfproj-sim: the world around the board, in simulation.

#include "host/cli/command_line.h"
#include "host/cli/completion.h"
#include "host/cli/program_main.h"
#include "sim/app/commands.h"

int main(int argc, char** argv) {
  return selfproj::cli::program_main(
      {.name = "selfproj-sim",
       .purpose = "Simulates what surrounds the board, and runs the board's circuits cycle by cycle.",
       .details =
           "The exit status is 0 for success, 1 for a failed check and 2 for bad usage or input. An error is one line "
           "on "
           "standard error that names the file or option and the reason.\n\n"
           "Output files and folders are written whole or not at all. Missing parent folders are made.\n\n"
           "Numbered files are taken by number, img2 before img10: all files of a folder or a quoted pattern, and "
           "lists in alphabetical order, as a shell expands img*.png. Lists in any other order are taken as "
           "given.",
       .examples = R"(
# Send 20 simulated frames through the board's RTL and the driver; compare every packet.
selfproj-sim cosim --count 20 --out part
)"},
      [](CLI::App& app) {
        selfproj::sim::add_cosim_command(app);
        selfproj::sim::add_moments_command(app);
        selfproj::sim::add_decode_command(app);
        selfproj::sim::add_board_command(app);
        selfproj::sim::add_production_command(app);
        selfproj::cli::set_heading(app, "Circuits and boards", {"cosim", "moments", "decode", "board", "production"});
        selfproj::sim::add_scene_command(app);
        selfproj::sim::add_camera_command(app);
        selfproj::sim::add_capture_command(app);
        selfproj::cli::set_heading(app, "Scenes and their images", {"scene", "camera", "capture"});
        selfproj::cli::add_completion_command(app);
      },
      argc, argv);
}
