// selfproj-sim with only the commands that scripts/demo.sh shows, so that the demo builds no others.

#include "host/cli/program_main.h"
#include "sim/app/commands.h"

int main(int argc, char** argv) {
  return selfproj::cli::program_main(
      {.name = "selfproj-sim",
       .purpose = "The commands of the demonstration: co-simulation and a simulated board.",
       .details = "This program belongs to scripts/demo.sh. scripts/build.sh builds selfproj-sim with all commands.",
       .examples = R"(
# Send 20 simulated frames through the board's RTL and the driver; compare every packet.
selfproj-sim cosim --count 20 --out part
)"},
      [](CLI::App& app) {
        selfproj::sim::add_cosim_command(app);
        selfproj::sim::add_board_command(app);
        selfproj::sim::add_production_command(app);
      },
      argc, argv);
}
