#include "sim/cosim/world_options.h"

#include <CLI/CLI.hpp>
#include <string>

namespace selfproj {

void add_world_options(CLI::App& command, WorldOptions& options) {
  std::string names;
  for (const WorldSwitch& entry : world_switches()) {
    names += (names.empty() ? "" : ", ") + std::string(entry.name);
  }
  command
      .add_option(
          "--disturb", options.disturb,
          "Disturbances that an ideal world does not have, each as NAME or NAME=STRENGTH, with commas between them: " +
              names + ".")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("NAME,...")
      ->default_str("none");
  command.add_option("--world", options.file, "The parameters of disturbances: a file like world.yaml in sim/scene.")
      ->type_name("FILE.yaml")
      ->default_str(kBuiltInWorld);
}

}  // namespace selfproj
