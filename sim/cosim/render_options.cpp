#include "sim/cosim/render_options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "host/cli/command_line.h"
#include "selfproj/files/user_error.h"

namespace selfproj::sim {

void add_disturb_option(CLI::App& command, WorldOptions& options) {
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
}

void add_world_file_option(CLI::App& command, WorldOptions& options) {
  command.add_option("--world", options.file, "The parameters of disturbances: a file like world.yaml in sim/scene.")
      ->type_name("FILE.yaml")
      ->default_str(kBuiltInWorld);
}

void add_world_options(CLI::App& command, WorldOptions& options) {
  add_disturb_option(command, options);
  add_world_file_option(command, options);
}

void add_error_source_option(CLI::App& command, const std::string& name, std::vector<std::string>& off,
                             const std::string& text, bool quantized) {
  std::vector<std::string> names;
  for (const ErrorSource& source : kErrorSources) {
    if (!quantized || source.flag != &RenderOptions::quantization) {
      names.emplace_back(source.name);
    }
  }
  command.add_option(name, off, text)->delimiter(',')->check(cli::one_of(names))->type_name("NAME,...");
}

void add_noise_seed_option(CLI::App& command, std::optional<std::int64_t>& seed) {
  command.add_option("--seed", seed, "Seed of the noise.")
      ->transform(cli::whole_number(0))
      ->type_name("N")
      ->default_str("the rig's");
}

void add_perturbed_rig_option(CLI::App& command, std::optional<std::uint64_t>& seed) {
  accept_old_name(command, "--real-rig-seed",
                  command
                      .add_option("--perturbed-rig-seed", seed,
                                  "Seed of a perturbed rig that takes the images instead: it deviates from --rig in "
                                  "lenses and mounting.")
                      ->transform(cli::whole_number(0))
                      ->type_name("N")
                      ->default_str("--rig takes them"));
}

PerturbedRig rig_of_seed(const rig::Rig& rig, std::optional<std::uint64_t> seed) {
  return seed ? hidden_rig(rig, *seed) : PerturbedRig(rig);
}

void accept_old_name(CLI::App& command, const std::string& old_name, CLI::Option* option) {
  command
      .add_option_function<std::string>(old_name,
                                        [old_name, option](const std::string& value) {
                                          fmt::print(stderr, "note: {} is now {}\n", old_name, option->get_name());
                                          option->add_result(value);
                                          option->run_callback();
                                        })
      ->group("");
}

void OptionFamilies::begin(const std::string& group, const std::vector<std::string>& cases) {
  cli::begin_group(*command_, group);
  cases_[group] = cases;
}

void OptionFamilies::check(const std::string& given_case, const std::string& what) const {
  for (const CLI::Option* option : command_->get_options()) {
    const auto family = cases_.find(option->get_group());
    if (option->count() > 0 && family != cases_.end() &&
        std::find(family->second.begin(), family->second.end(), given_case) == family->second.end()) {
      throw UserError(option->get_name(), fmt::format("does not go with {}", what));
    }
  }
}

}  // namespace selfproj::sim
