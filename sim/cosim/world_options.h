// The options of all commands that render, for what the world adds to the images.
#ifndef SELFPROJ_SIM_COSIM_WORLD_OPTIONS_H
#define SELFPROJ_SIM_COSIM_WORLD_OPTIONS_H

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "sim/scene/world.h"

namespace selfproj {

struct WorldOptions {
  std::vector<std::string> disturb;
  std::string file = kBuiltInWorld;

  // Throws as load_world and world_of do.
  [[nodiscard]] World world() const { return world_of(load_world(file), disturb); }
};

// Adds --disturb and --world.
void add_world_options(CLI::App& command, WorldOptions& options);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_COSIM_WORLD_OPTIONS_H
