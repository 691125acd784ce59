#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "host/app/commands.h"
#include "host/cli/command_line.h"
#include "selfproj/rig/rig.h"

namespace selfproj::app {

void add_rig_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app,
      {.name = "rig",
       .purpose = "Checks a rig and prints it as YAML, or lists the built-in rigs.",
       .details = "A rig describes camera, projector, conveyor and measuring. The name of each key ends in its unit.",
       .examples = R"(
# List the built-in rigs.
selfproj rig

# Copy a built-in rig to edit it, then check the copy.
selfproj rig light-section > my-rig.yaml
selfproj rig my-rig.yaml
)"});
  auto name = std::make_shared<std::string>();
  command->add_option("RIG", *name, "Built-in rig or YAML file. Without it, the built-in rigs are listed.");
  command->callback([name] {
    if (name->empty()) {
      fmt::print("{}\n", fmt::join(rig::built_in_rigs(), "\n"));
    } else {
      fmt::print("{}", rig::to_yaml(rig::load_any_rig(*name)));
    }
  });
}

}  // namespace selfproj::app
