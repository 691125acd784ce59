// selfproj with only the commands that scripts/demo.sh shows, so that the demo builds no others.

#include "host/app/commands.h"
#include "host/cli/program_main.h"

int main(int argc, char** argv) {
  return selfproj::cli::program_main(
      {.name = "selfproj",
       .purpose = "The commands of the demonstration: patterns and on-line inspection.",
       .details = "This program belongs to scripts/demo.sh. scripts/build.sh builds selfproj with all commands.",
       .examples = R"(
# Compute the pattern that the camera sees as a straight line on a roof 20 mm high.
printf 'y_mm,z_mm\n-50,1167\n0,1147\n50,1167\n' > roof.csv
selfproj pattern --reference roof.csv --out roof
)"},
      [](CLI::App& app) {
        selfproj::app::add_pattern_command(app);
        selfproj::app::add_inspect_command(app);
      },
      argc, argv);
}
