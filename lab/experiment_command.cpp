#include "lab/experiment_command.h"

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "host/cli/command_line.h"
#include "host/structured_light/self_reference.h"
#include "lab/experiment.h"
#include "sim/cosim/world_options.h"
#include "sim/scene/renderer.h"
#include "sim/scene/virtual_scan.h"

namespace selfproj {

void add_experiment_command(CLI::App& app) {
  auto options = std::make_shared<ExperimentOptions>();
  auto world = std::make_shared<WorldOptions>();
  CLI::App* command = add_command(
      app, {.name = "experiment",
            .purpose = "Repeats an experiment of the thesis in simulation, and compares it with the published figures.",
            .details = "The experiments are\n"
                       "- A1: light section of a mountain\n"
                       "- A2: light section of stairs with carved marks\n"
                       "- B1: structured light of a moving fist, and the filter that finds what moved\n"
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

# Parts with planted defects, judged by a tolerance that was learned from others (takes minutes)
selfproj-lab experiment parts --out detection
)"});
  command->add_option("NAME", options->name, "Name of the experiment.")
      ->required()
      ->check(one_of({"A1", "A2", "B1", "B2", "B3", "B4", "B7", "B8", "robustness", "remedies", "parts"}));
  begin_group(*command, "Settings");
  command->add_option("--rig", options->rig, "Built-in rig or YAML file.")
      ->type_name("RIG")
      ->default_str("that of the experiment");
  std::vector<std::string> sources;
  for (const Disturbance& source : kDisturbances) {
    sources.emplace_back(source.name);
  }
  command->add_option("--off", options->off, "Sources of error to switch off, with commas between them.")
      ->delimiter(',')
      ->check(one_of(sources))
      ->type_name("NAME,...");
  add_world_options(*command, *world);
  begin_group(*command, "Light section (A1, A2)");
  command->add_option("--every", options->every, "Take only every N-th frame.")
      ->transform(whole_number(1, 1000))
      ->type_name("N")
      ->default_str("1; 70 for robustness");
  command->add_flag("--null-test", options->null_test,
                    "Only measure with a rig that is known perfectly and a good part whose shape is known. Otherwise "
                    "the rig is calibrated from images and the good part is scanned, and the null test stands beside.");
  command->add_option("--real-rig-seed", options->real_rig_seed, "Seed of the rig that takes the images.")
      ->transform(whole_number(0))
      ->type_name("N")
      ->capture_default_str();
  command->add_flag_callback(
      "--no-residual", [options] { options->residual = false; },
      "Do not measure and remove the residual of the reference.");
  command->add_flag("--sources", options->sources,
                    "Also print the table of error sources: the null test with each of them off in turn.");
  begin_group(*command, "Structured light (B1, B2, B4, B7, B8)");
  command->add_option("--paths", options->paths, "B1: paths of the fist on which its filter was not chosen.")
      ->transform(whole_number(1, 1000))
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--pools", options->pools, "B2: pools of other depths, beside that of the thesis.")
      ->transform(whole_number(0, 1000))
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--pool-seed", options->pool_seed, "B2: draw all of these pools, by seeds from N on.")
      ->transform(whole_number(1, 1'000'000))
      ->type_name("N")
      ->default_str("pools of 20 and 40 mm first, then seeds from 1 on");
  command->add_flag_callback(
      "--gray-scan", [options] { options->scan = ScanMethod::gray_codes; },
      "Scan the reference by Gray codes, not line by line.");
  command->add_option("--e", options->e, "Codes that are searched below the reference.")
      ->transform(whole_number(0, (1 << Stripes{}.bits) - 1))
      ->type_name("E")
      ->default_str("8 for B4, 0 for B7 and B8");
  begin_group(*command, "Disturbances (robustness, which also takes --every and --world; remedies)");
  const auto number = [&](const char* name, int& value, int most, const char* text) {
    command->add_option(name, value, text)->transform(whole_number(1, most))->type_name("N")->capture_default_str();
  };
  number("--cameras", options->cameras, 1000, "Cameras with defect pixels of their own.");
  number("--strengths", options->strengths, 5, "Strengths of each disturbance.");
  number("--coarser", options->coarser, 8, "Give the scanner N times fewer pixels along each side.");
  number("--seeds", options->seeds, 100, "Remedies: seeds on which each is measured, beside that on which it is set.");
  begin_group(*command, "Parts (which also takes --null-test and --real-rig-seed, and ends early at Ctrl-C)");
  const auto count = [&](const char* name, std::uint64_t& value, std::int64_t least, const char* text) {
    command->add_option(name, value, text)
        ->transform(whole_number(least, 100'000))
        ->type_name("N")
        ->capture_default_str();
  };
  count("--parts", options->parts, 1, "Parts with planted defects.");
  count("--good-parts", options->good_parts, 1, "Parts without any.");
  count("--parts-seed", options->parts_seed, 1,
        "Seed of these parts. The tolerance is learned from parts of the seed before.");
  begin_group(*command, "Output");
  command->add_option("--out", options->out, "Folder for images, tables and report.")->type_name("DIR");
  command->callback([options, world] {
    options->world = world->world();
    options->parameters = load_world(world->file);
    run_experiment(*options);
  });
}

}  // namespace selfproj
