// selfproj-sim: the world around the board, in simulation.

#include "host/io/program_main.h"
#include "sim/app/board_command.h"
#include "sim/app/capture_command.h"
#include "sim/app/cosim_command.h"
#include "sim/app/decode_command.h"
#include "sim/app/experiment_command.h"
#include "sim/app/moments_command.h"
#include "sim/app/scene_command.h"

int main(int argc, char** argv) {
  return selfproj::program_main(
      "selfproj-sim", "Simulated board of the light-section inspection",
      [](CLI::App& app) {
        selfproj::add_cosim_command(app);
        selfproj::add_moments_command(app);
        selfproj::add_decode_command(app);
        selfproj::add_experiment_command(app);
        selfproj::add_board_command(app);
        selfproj::add_scene_command(app);
        selfproj::add_capture_command(app);
      },
      argc, argv);
}
