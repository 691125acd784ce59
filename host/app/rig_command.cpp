#include "host/app/rig_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "host/rig/rig.h"

namespace selfproj {

void add_rig_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("rig", "Check a rig and print it as YAML, or list the built-in ones");
  auto name = std::make_shared<std::string>();
  command->add_option("RIG", *name, "a built-in rig or a YAML file; without it the built-in ones are listed");
  command->callback([name] {
    if (name->empty()) {
      fmt::print("{}\n", fmt::join(built_in_rigs(), "\n"));
    } else {
      fmt::print("{}", to_yaml(load_rig(*name)));
    }
  });
}

}  // namespace selfproj
