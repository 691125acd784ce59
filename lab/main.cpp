// selfproj-lab: the experiments of the thesis and studies beyond them, in simulation.

#include "host/cli/program_main.h"
#include "lab/experiment_command.h"

int main(int argc, char** argv) {
  return selfproj::program_main(
      {.name = "selfproj-lab",
       .purpose = "Repeats the experiments of the thesis in simulation, and measures beyond them.",
       .details = "The exit status is 0 for success, 1 for a figure that is not reached and 2 for bad usage or input.",
       .examples = R"(
# A null test of A1 on every 50th frame, as a quick look.
selfproj-lab experiment A1 --null-test --every 50 --out mountain
)"},
      [](CLI::App& app) { selfproj::add_experiment_command(app); }, argc, argv);
}
