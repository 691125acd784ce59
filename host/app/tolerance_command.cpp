#include "host/app/tolerance_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "host/app/inspection_loop.h"
#include "host/app/match_run.h"
#include "host/app/packet_run.h"
#include "host/app/section_options.h"
#include "host/camera/camera_device.h"
#include "host/cli/command_line.h"
#include "host/driver/counters.h"
#include "host/files/output_file.h"
#include "host/files/stop_signal.h"
#include "host/files/user_error.h"
#include "host/light_section/differential_profile.h"
#include "host/production/depth_cutter.h"
#include "host/production/learn.h"
#include "host/production/part_cutter.h"
#include "host/production/part_line.h"
#include "host/production/section_reference.h"
#include "host/production/tolerance.h"
#include "host/rig/rig.h"

namespace selfproj {
namespace {

struct LearnCommandOptions {
  SectionOptions section;
  MatchOptions match;  // of a scanner
  std::string device;
  std::string out;
  std::uint64_t count = 0;
  double seconds = 0;
  LearnOptions learn;
  std::optional<double> smallest_mm2;  // empty: LearnOptions' for a light section, of 9 cells for a scanner
  std::optional<double> edge_mm;       // likewise, 3 cells
};

// What good parts have told, by which way ever they came.
struct GoodParts {
  const Learner& learner;
  std::uint64_t specks = 0;
};

void write_tolerance(const LearnCommandOptions& options, const Rig& rig, const OutputFile& out, const GoodParts& good) {
  const Learner& learner = good.learner;
  const Tolerance tolerance = learner.learn(options.device);
  out.write(fmt::format("# learned from {} good parts on rig {}\n", learner.parts(), rig.name) + to_yaml(tolerance));
  fmt::print("{} good parts{}, {} specks; {:.3f} mm long, {:.3f} mm wide, {} regions → {}\n", learner.parts(),
             learner.not_kept() > 0 ? fmt::format(" (and {} that are not kept)", learner.not_kept()) : std::string(),
             good.specks, tolerance.length_mm, tolerance.right_mm - tolerance.left_mm, tolerance.regions.size(),
             options.out);
  for (const ToleranceRegion& region : tolerance.regions) {
    fmt::print("  {}: {:+.3f} to {:+.3f} mm, {:.2f} % may be missing\n", region.name, region.low_mm, region.high_mm,
               100 * region.most_missing);
  }
}

LearnOptions learn_options(const LearnCommandOptions& options, const LearnOptions& otherwise) {
  LearnOptions learn = options.learn;
  learn.smallest_mm2 = options.smallest_mm2.value_or(otherwise.smallest_mm2);
  learn.edge_mm = options.edge_mm.value_or(otherwise.edge_mm);
  return learn;
}

// From depth images under the stripes of a reference.
void learn_depth(const LearnCommandOptions& options) {
  MatchOptions match = options.match;
  match.rig = options.section.rig;
  match.reference = options.section.reference;
  if (match.reference.empty()) {
    throw UserError("--reference", "is needed for a rig of kind scanner: the folder of `selfproj pattern stripes`");
  }
  const OutputFile out(options.out);
  const MatchRun run(match);
  MatchStream images(run);
  DepthGrid grid(run.rig());
  const double cell = run.rig().parts->grid_mm;
  Learner learner(run.rig(), grid.cells(images.scanner().reference_depth()),
                  learn_options(options, {.smallest_mm2 = 9 * cell * cell, .edge_mm = 3 * cell}));
  DepthCutter cutter(run.rig(), run.patterns(), [&](CutPart&& part) { learner.add(std::move(part)); });
  std::uint64_t count = 0;
  PacketRunOptions end;
  end.count = options.count;
  end.seconds = options.seconds;
  const std::unique_ptr<Device> device = open_any_device(
      options.device, {}, {.board = {.code_bits = run.patterns() / 2, .code_threshold = run.threshold()}});
  run_packets(
      *device, end,
      [&](const PacketView& packet) {
        if (images.take(packet, options.device)) {
          cutter.add(images.stream().header(), images.scanner().depth(), device->arrival_ns());
          ++count;
        }
        return count;
      },
      [&] { return fmt::format("{} depth images, {} good parts", count, learner.parts()); });
  cutter.finish();
  write_tolerance(options, run.rig(), out, {learner, cutter.specks()});
}

void learn_section(const LearnCommandOptions& options) {
  const Rig rig = options.section.load_rig();
  const OutputFile out(options.out);
  const ReferenceProfile reference = options.section.load_reference(rig);
  const DifferentialProfiler profiler(rig, reference);
  Learner learner(rig, section_of(rig, reference, profiler), learn_options(options, {}));
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
  write_tolerance(options, rig, out, {learner, cutter.specks()});
}

void run_learn(const LearnCommandOptions& options) {
  if (load_any_rig(options.section.rig).kind == RigKind::scanner) {
    learn_depth(options);
  } else {
    learn_section(options);
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
           "With a rig of kind scanner the parts are depth images under the stripes of --reference, and each surface "
           "of the reference becomes a region.\n\n"
           "The run ends when the device ends, after --count profiles or depth images, after --seconds, or at Ctrl-C.",
       .examples = R"(
# A tolerance from recorded good parts, and parts judged by it (needs your files)
selfproj tolerance learn --rig mine.yaml --reference good-part --device file:good.packets \
  --out tolerance.yaml
selfproj inspect --rig mine.yaml --reference good-part --device ring:line1 \
  --tolerance tolerance.yaml --parts today

# The same with structured light (needs your files)
selfproj tolerance learn --rig my-scanner.yaml --reference stripes --device file:good.packets \
  --out tolerance.yaml
selfproj match --rig my-scanner.yaml --reference stripes --device ring:line1 \
  --tolerance tolerance.yaml --parts today --out newest
)"});
  const auto options = std::make_shared<LearnCommandOptions>();
  begin_group(*command, "Input");
  command
      ->add_option("--device", options->device,
                   "Where packets of good parts come from: ring:NAME, udp:HOST[:PORT], litepcie:PATH, file:PATH "
                   "or camera:NAME.")
      ->type_name("URI")
      ->required();
  add_section_options(*command, options->section);
  add_search_options(*command, options->match);
  begin_group(*command, "Tolerance");
  command->add_option("--smallest-mm2", options->smallest_mm2, "Area of the smallest defect.")
      ->transform(number_above_zero())
      ->type_name("MM2")
      ->default_str("0.5; of a scanner that of 9 cells");
  command->add_option("--edge-mm", options->edge_mm, "Strip along edges and walls that is not judged.")
      ->transform(real_number(0, 1000))
      ->type_name("MM")
      ->default_str("1.5; of a scanner 3 cells");
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
  add_end_of_run(*command, options->count, options->seconds, "profiles or depth images");
  begin_group(*command, "Output");
  command->add_option("--out", options->out, "File for the tolerance.")->type_name("FILE")->required();
  command->callback([options] { run_learn(*options); });
}

}  // namespace

void add_tolerance_command(CLI::App& app) {
  CLI::App* command =
      add_command(app, {.name = "tolerance",
                        .purpose = "Makes the tolerances by which `selfproj inspect` and `selfproj match` judge parts.",
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
