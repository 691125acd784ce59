// selfproj with only the commands that scripts/demo.sh shows, so that the demo builds no others.

#include "host/app/inspect_command.h"
#include "host/app/pattern_command.h"
#include "host/io/program_main.h"

int main(int argc, char** argv) {
  return selfproj::program_main(
      {.name = "selfproj",
       .purpose = "The commands of the demonstration: patterns and on-line inspection.",
       .details = "This program belongs to scripts/demo.sh. scripts/build.sh builds selfproj with all commands.",
       .examples = R"(
# Compute the pattern that shows a plane as a straight line.
selfproj pattern --out plane
)"},
      [](CLI::App& app) {
        selfproj::add_pattern_command(app);
        selfproj::add_inspect_command(app);
      },
      argc, argv);
}
