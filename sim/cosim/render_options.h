// The options that all commands share that render, and families of options, each of which goes with some cases only.
#ifndef SELFPROJ_SIM_COSIM_RENDER_OPTIONS_H
#define SELFPROJ_SIM_COSIM_RENDER_OPTIONS_H

#include <CLI/CLI.hpp>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "selfproj/rig/rig.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/world.h"

namespace selfproj::sim {

struct WorldOptions {
  std::vector<std::string> disturb;
  std::string file = kBuiltInWorld;

  // Throws as load_world and world_of do.
  [[nodiscard]] World world() const { return world_of(load_world(file), disturb); }
};

// Adds --disturb and --world, or one of them.
void add_world_options(CLI::App& command, WorldOptions& options);
void add_disturb_option(CLI::App& command, WorldOptions& options);
void add_world_file_option(CLI::App& command, WorldOptions& options);

// Adds an option that lists sources of error to switch off. Images of 8 bits are always quantized.
void add_error_source_option(CLI::App& command, const std::string& name, std::vector<std::string>& off,
                             const std::string& text, bool quantized = false);

// Adds --seed, of the noise.
void add_noise_seed_option(CLI::App& command, std::optional<std::int64_t>& seed);

// Adds --perturbed-rig-seed; and the rig that then takes the images of one believed to be `rig`.
void add_perturbed_rig_option(CLI::App& command, std::optional<std::uint64_t>& seed);
PerturbedRig rig_of_seed(const rig::Rig& rig, std::optional<std::uint64_t> seed);

// Accepts an option by its name of before, with a note on stderr.
void accept_old_name(CLI::App& command, const std::string& old_name, CLI::Option* option);

// Groups of a command's options in its help, each of which does something in some cases only: for a kind of scene, or
// for an experiment.
class OptionFamilies {
 public:
  explicit OptionFamilies(CLI::App& command) : command_(&command) {}

  // Options added from now on appear in this group, and go with these cases only.
  void begin(const std::string& group, const std::vector<std::string>& cases);

  // Throws UserError about the first option that is given and does not go with this case. `what` are the words for it.
  void check(const std::string& given_case, const std::string& what) const;

 private:
  CLI::App* command_;
  std::map<std::string, std::vector<std::string>> cases_;  // of each group
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_COSIM_RENDER_OPTIONS_H
