// selfproj with only the commands that scripts/demo.sh shows, so that the demo builds no others.

#include "host/app/commands.h"
#include "host/cli/program_main.h"

int main(int argc, char** argv) {
  return selfproj::cli::program_main(
      {.name = "selfproj",
       .purpose = "The commands of the demonstration: tolerances and on-line inspection.",
       .details = "This program belongs to scripts/demo.sh. scripts/build.sh builds selfproj with all commands.",
       .examples = R"(
# Classify the parts of a simulated line.
selfproj-sim production --out line
selfproj tolerance learn --rig line/rig.yaml --reference line/part \
  --device file:line/good.packets --out tolerance.yaml
selfproj inspect --rig line/rig.yaml --reference line/part --device file:line/run.packets \
  --tolerance tolerance.yaml --parts today
)"},
      [](CLI::App& app) {
        selfproj::app::add_inspect_command(app);
        selfproj::app::add_tolerance_command(app);
      },
      argc, argv);
}
