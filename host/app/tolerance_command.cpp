#include "host/app/tolerance_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "host/app/inspection_loop.h"
#include "host/app/packet_run.h"
#include "host/app/section_options.h"
#include "host/camera/camera_device.h"
#include "host/driver/counters.h"
#include "host/io/command_line.h"
#include "host/io/output_file.h"
#include "host/io/stop_signal.h"
#include "host/light_section/differential_profile.h"
#include "host/line/part_line.h"
#include "host/parts/learn.h"
#include "host/parts/part_cutter.h"
#include "host/parts/section_reference.h"
#include "host/parts/tolerance.h"

namespace selfproj {
namespace {

struct LearnCommandOptions {
  SectionOptions section;
  std::string device;
  std::string out;
  std::uint64_t count = 0;
  double seconds = 0;
  LearnOptions learn;
};

void run_learn(const LearnCommandOptions& options) {
  const Rig rig = options.section.load_rig();
  const OutputFile out(options.out);
  const ReferenceProfile reference = options.section.load_reference(rig);
  const DifferentialProfiler profiler(rig, reference);
  Learner learner(rig, section_of(rig, reference, profiler), options.learn);
  PartCutter cutter(rig, [&](CutPart&& part) { learner.add(std::move(part)); });
  PartLine line(rig, nullptr, {.profile = [&](const PacketHeader& header, const ProfileView& profile) {
                  cutter.add(header, profile, 0);
                }});
  InspectionLoop loop({.count = options.count, .seconds = options.seconds, .line = &line}, rig, profiler);
  const std::unique_ptr<Device> device = open_any_device(options.device, {}, camera_of_rig(rig, measure_of_rig(rig)));
  {
    const StopSignal stop;
    loop.run(*device);
  }
  line.finish();
  cutter.finish();
  const Tolerance tolerance = learner.learn(options.device);
  out.write(fmt::format("# learned from {} good parts on rig {}\n", learner.parts(), rig.name) + to_yaml(tolerance));
  fmt::print("{} good parts{}, {} specks; {:.3f} mm long, {:.3f} mm wide, {} regions → {}\n", learner.parts(),
             learner.not_kept() > 0 ? fmt::format(" (and {} that are not kept)", learner.not_kept()) : std::string(),
             cutter.specks(), tolerance.length_mm, tolerance.right_mm - tolerance.left_mm, tolerance.regions.size(),
             options.out);
  for (const ToleranceRegion& region : tolerance.regions) {
    fmt::print("  {}: {:+.3f} to {:+.3f} mm, {:.2f} % may be missing\n", region.name, region.low_mm, region.high_mm,
               100 * region.most_missing);
  }
}

void add_learn_command(CLI::App& tolerance) {
  CLI::App* command = add_command(
      tolerance,
      {.name = "learn",
       .purpose = "Makes a tolerance file from good parts.",
       .details =
           "The device brings at least 5 good parts; the rig's section `parts` says how they are cut. Each stretch of "
           "the reference's section between two walls becomes a region. Its band is what the good parts reach, and "
           "--spreads standard deviations more. The file is YAML, to be looked at and changed.\n\n"
           "The run ends when the device ends, after --count profiles, after --seconds, or at Ctrl-C.",
       .examples = R"(
# A tolerance from recorded good parts, and parts judged by it (needs your files)
selfproj tolerance learn --rig mine.yaml --reference good-part --device file:good.packets \
  --out tolerance.yaml
selfproj inspect --rig mine.yaml --reference good-part --device ring:line1 \
  --tolerance tolerance.yaml --parts today
)"});
  const auto options = std::make_shared<LearnCommandOptions>();
  begin_group(*command, "Input");
  command
      ->add_option("--device", options->device,
                   "Where packets of good parts come from: ring:NAME, udp:HOST[:PORT], file:PATH or camera:NAME.")
      ->type_name("URI")
      ->required();
  add_section_options(*command, options->section);
  begin_group(*command, "Tolerance");
  command->add_option("--smallest-mm2", options->learn.smallest_mm2, "Area of the smallest defect.")
      ->transform(number_above_zero())
      ->type_name("MM2")
      ->capture_default_str();
  command->add_option("--edge-mm", options->learn.edge_mm, "Strip along edges and walls that is not judged.")
      ->transform(real_number(0, 1000))
      ->type_name("MM")
      ->capture_default_str();
  command
      ->add_option("--spreads", options->learn.spreads,
                   "Standard deviations from the mean of the good parts to a limit.")
      ->transform(real_number(1, 100))
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--shift-mm", options->learn.most_shift_mm, "A part may be shifted across so far.")
      ->transform(real_number(0, 1000))
      ->type_name("MM")
      ->capture_default_str();
  command->add_option("--turn-deg", options->learn.most_turn_deg, "A part may be turned so far.")
      ->transform(real_number(0, 45))
      ->type_name("DEG")
      ->capture_default_str();
  add_end_of_run(*command, options->count, options->seconds, "profiles");
  begin_group(*command, "Output");
  command->add_option("--out", options->out, "File for the tolerance.")->type_name("FILE")->required();
  command->callback([options] { run_learn(*options); });
}

}  // namespace

void add_tolerance_command(CLI::App& app) {
  CLI::App* command = add_command(app, {.name = "tolerance",
                                        .purpose = "Makes the tolerances by which `selfproj inspect` judges parts.",
                                        .details = "",
                                        .examples = R"(
# A tolerance from recorded good parts (needs your files)
selfproj tolerance learn --rig mine.yaml --reference good-part --device file:good.packets \
  --out tolerance.yaml
)"});
  command->require_subcommand(1);
  add_learn_command(*command);
}

}  // namespace selfproj
