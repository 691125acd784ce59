#include "sim/app/experiment_command.h"

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "host/structured_light/stripe_code.h"
#include "sim/experiment/experiment.h"
#include "sim/scene/renderer.h"
#include "sim/scene/virtual_scan.h"

namespace selfproj {

void add_experiment_command(CLI::App& app) {
  auto options = std::make_shared<ExperimentOptions>();
  CLI::App* command = app.add_subcommand(
      "experiment", "Run an experiment of the thesis in simulation: published figures beside measured ones");
  command
      ->add_option(
          "NAME", options->name,
          "A1 (mountain), A2 (stairs with carved marks); structured light: B4 (cuboids), B7 (mouse), B8 (hands)")
      ->required()
      ->check(CLI::IsMember({"A1", "A2", "B4", "B7", "B8"}));
  command->add_option("--rig", options->rig, "Built-in rig or YAML file (default: that of the experiment)");
  command->add_option("--out", options->out, "Folder for the files of the inspection and the report");
  command->add_option("--every", options->every, "Take every so many frames only")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_flag_callback(
      "--no-residual", [options] { options->residual = false; }, "Do not measure and remove the reference's residual");
  command->add_flag_callback(
      "--gray-scan", [options] { options->scan = ScanMethod::gray_codes; },
      "B4, B7, B8: scan the reference by Gray codes, not line by line");
  command
      ->add_option("--e", options->e,
                   "B4, B7, B8: cells below the reference that are searched [that of the experiment: 8, 0, 0]")
      ->check(CLI::Range(0, (1 << Stripes{}.bits) - 1))
      ->type_name("CELLS");
  std::vector<std::string> sources;
  for (const Disturbance& source : kDisturbances) {
    sources.emplace_back(source.name);
  }
  command->add_option("--off", options->off, "Switch error sources off, comma between")
      ->delimiter(',')
      ->check(CLI::IsMember(sources));
  command->add_flag(
      "--sources", options->sources,
      "Also the table of error sources: the self-projected measurement with each of them off in its turn");
  command->callback([options] { run_experiment(*options); });
}

}  // namespace selfproj
