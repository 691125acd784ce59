// selfproj-lab: the experiments of the thesis and studies beyond them, in simulation.
#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/cli/command_line.h"
#include "host/cli/completion.h"
#include "host/cli/program_main.h"
#include "host/structured_light/self_reference.h"
#include "lab/experiment.h"
#include "lab/thesis.h"
#include "sim/cosim/render_options.h"
#include "sim/scene/virtual_capture.h"

namespace selfproj::lab {
namespace {

void add_experiment_command(CLI::App& app) {
  auto options = std::make_shared<ExperimentOptions>();
  auto world = std::make_shared<sim::WorldOptions>();
  CLI::App* command = cli::add_command(
      app, {.name = "experiment",
            .purpose = "Repeats an experiment of the thesis in simulation, and compares it with the published figures.",
            .details = "The experiments are\n"
                       "- A1: light section of a mountain\n"
                       "- A2: light section of stairs with carved marks\n"
                       "- B1: structured light of a moving fist, and the filter that finds the foreground\n"
                       "- B2: structured light of waves on water\n"
                       "- B3: structured light of fingers that tap on keys\n"
                       "- B4: structured light on cuboids\n"
                       "- B7: structured light on a moving mouse\n"
                       "- B8: structured light on two moving hands\n"
                       "- robustness: A2 and B4 under each of the disturbances of --disturb, over its strength\n"
                       "- remedies: what helps B4 against the disturbances that break it\n"
                       "- parts: which defects, planted into parts that pass, are found, and how often one is found "
                       "where there is none\n\n"
                       "The exit status is 1 where a figure is not reached.",
            .examples = R"(
# A null test of A1 on every 50th frame, as a quick look.
selfproj-lab experiment A1 --null-test --every 50 --out mountain

# The same the thesis's way: calibrated from images, with a scanned part (takes minutes)
selfproj-lab experiment A1 --every 50 --out scanned

# All of A2, with a table of what each source of error costs (takes minutes)
selfproj-lab experiment A2 --sources --out stairs

# What gloss, hot pixels, flicker and all the others cost (takes minutes)
selfproj-lab experiment robustness --out robustness

# Parts with planted defects, and a tolerance that was learned from others (takes minutes)
selfproj-lab experiment parts --out detection
)"});
  const std::vector<std::string> thesis{"A1", "A2", "B1", "B2", "B3", "B4", "B7", "B8"};
  std::vector<std::string> names = thesis;
  names.insert(names.end(), {"robustness", "remedies", "parts"});
  std::vector<std::string> thesis_and_parts = thesis;
  thesis_and_parts.emplace_back("parts");
  sim::OptionFamilies families(*command);
  const auto number = [&](const char* name, auto& value, std::int64_t min, std::int64_t max, const char* text) {
    return command->add_option(name, value, text)->transform(cli::whole_number(min, max))->type_name("N");
  };
  command->add_option("NAME", options->name, "Name of the experiment.")->required()->check(cli::one_of(names));
  families.begin("A1 to B8", thesis);
  command->add_option("--rig", options->rig, "Built-in rig or YAML file.")
      ->type_name("RIG")
      ->default_str("that of the experiment");
  families.begin("A1 to B8, parts", thesis_and_parts);
  sim::add_error_source_option(*command, "--off", options->off,
                               "Sources of error to switch off, with commas between them.");
  sim::add_disturb_option(*command, *world);
  families.begin("All experiments", names);
  sim::add_world_file_option(*command, *world);
  families.begin("A1, A2", {"A1", "A2"});
  command->add_flag_callback(
      "--no-residual", [options] { options->residual = false; },
      "Do not measure and remove the residual of the reference.");
  command->add_flag("--sources", options->sources,
                    "Also print the table of error sources: the null test with each of them off in turn.");
  families.begin("A1, A2, robustness", {"A1", "A2", "robustness"});
  number("--every", options->every, 1, 1000, "Take only every N-th frame.")->default_str("1; 70 for robustness");
  families.begin("A1, A2, parts", {"A1", "A2", "parts"});
  command->add_flag("--null-test", options->null_test,
                    "Only measure with a rig that is known perfectly and a good part whose shape is known. Otherwise "
                    "the rig is calibrated from images and the good part is scanned, and the null test stands beside.");
  sim::accept_old_name(*command, "--real-rig-seed",
                       number("--perturbed-rig-seed", options->perturbed_rig_seed, 0, cli::kNoLimit,
                              "Seed of the rig that takes the images.")
                           ->capture_default_str());
  families.begin("B1", {"B1"});
  number("--paths", options->paths, 1, 1000, "Paths of the fist on which its filter was not chosen.")
      ->capture_default_str();
  number("--path-seed", options->path_seed, 1, 1'000'000, "Draw these paths by seeds from N on, and no others.")
      ->default_str("that of the thesis first, then seeds from 1 on");
  families.begin("B2", {"B2"});
  number("--pools", options->pools, 0, 1000, "Pools of other depths, beside that of the thesis.")
      ->capture_default_str();
  number("--pool-seed", options->pool_seed, 1, 1'000'000, "Draw all of these pools, by seeds from N on.")
      ->default_str("pools of 20 and 40 mm first, then seeds from 1 on");
  families.begin("B4, B7, B8", {"B4", "B7", "B8"});
  command->add_flag_callback(
      "--gray-scan", [options] { options->scan = sim::ScanMethod::gray_codes; },
      "Scan the reference by Gray codes, not line by line.");
  number("--e", options->e, 0, (1 << structured_light::Stripes{}.bits) - 1,
         "Codes that are searched below the reference.")
      ->type_name("E")
      ->default_str("8 for B4, 0 for B7 and B8");
  families.begin("robustness", {"robustness"});
  number("--cameras", options->cameras, 1, 1000, "Cameras with defect pixels of their own.")->capture_default_str();
  number("--strengths", options->strengths, 1, 5, "Strengths of each disturbance.")->capture_default_str();
  families.begin("robustness, remedies", {"robustness", "remedies"});
  number("--coarser", options->coarser, 1, 8, "Give the scanner N times fewer pixels along each side.")
      ->capture_default_str();
  families.begin("remedies", {"remedies"});
  number("--seeds", options->seeds, 1, 100, "Seeds on which each is measured, beside that on which it is set.")
      ->capture_default_str();
  families.begin("parts (ends early at Ctrl-C)", {"parts"});
  number("--parts", options->parts, 1, 100'000, "Parts with planted defects.")->capture_default_str();
  number("--good-parts", options->good_parts, 1, 100'000, "Parts without any.")->capture_default_str();
  command->add_flag("--verdict", options->verdict,
                    "Judge the moments, too, as a board does. The parts are shifted by up to 2 mm.");
  number("--line-parts", options->line_parts, 0, 1000,
         "Also write rig, reference and tolerance, and images of so many good and so many bad parts that lie alike.");
  number("--parts-seed", options->parts_seed, 1, 100'000,
         "Seed of these parts. The tolerance is learned from parts of the seed before.")
      ->capture_default_str();
  cli::begin_group(*command, "Output");
  command->add_option("--out", options->out, "Folder for images, tables and report.")->type_name("DIR");
  command->callback([options, world, families] {
    families.check(options->name, "experiment " + options->name);
    options->world = world->world();
    options->parameters = sim::load_world(world->file);
    run_experiment(*options);
  });
}

}  // namespace
}  // namespace selfproj::lab

int main(int argc, char** argv) {
  return selfproj::cli::program_main(
      {.name = "selfproj-lab",
       .purpose = "Repeats the experiments of the thesis in simulation, and measures beyond them.",
       .details = "The exit status is 0 for success, 1 for a figure that is not reached and 2 for bad usage or input.",
       .examples = R"(
# A null test of A1 on every 50th frame, as a quick look.
selfproj-lab experiment A1 --null-test --every 50 --out mountain
)"},
      [](CLI::App& app) {
        selfproj::lab::add_experiment_command(app);
        selfproj::lab::add_thesis_command(app);
        selfproj::cli::add_completion_command(app);
      },
      argc, argv);
}
