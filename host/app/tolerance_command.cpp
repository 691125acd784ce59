#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/app/commands.h"
#include "host/app/image_source.h"
#include "host/app/receive.h"
#include "host/app/scanner_run.h"
#include "host/app/section_run.h"
#include "host/camera/camera_device.h"
#include "host/cli/command_line.h"
#include "host/files/output_file.h"
#include "host/production/cutter.h"
#include "host/production/height_map.h"
#include "host/production/learn.h"
#include "host/production/part_reference.h"
#include "host/production/tolerance.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"

namespace selfproj::app {
namespace {

struct LearnCommandOptions {
  SectionOptions section;
  MatchOptions match;  // of a scanner
  ReceiveOptions receive;
  ImageSourceOptions images;
  std::string out;
  bool strict = false;
  production::LearnOptions learn;
  std::optional<double> min_defect_mm2;  // empty: LearnOptions' for a light section, of 9 cells for a scanner
  std::optional<double> edge_mm;         // empty: of a light section kEdgeCells cells, of a scanner 3

  // Where the parts come from, in messages.
  [[nodiscard]] const std::string& source() const {
    return receive.device.empty() ? images.images.front() : receive.device;
  }
};

// `doubts` are those about what came.
void write_tolerance(const LearnCommandOptions& options, const rig::Rig& rig, const files::OutputFile& out,
                     const production::Learner& learner, std::uint64_t specks, std::vector<std::string> doubts = {}) {
  const auto note_doubts = [&] {
    for (const std::string& doubt : doubts) {
      cli::note_doubt(options.source(), doubt);
    }
  };
  production::LearnRemarks remarks;
  production::Tolerance tolerance;
  try {
    tolerance = learner.learn(options.source(), &remarks);
  } catch (const UserError&) {
    note_doubts();  // they may be why
    throw;
  }
  const std::vector<std::string>& left_out = remarks.left_out;
  if (options.strict && !left_out.empty()) {
    throw CheckFailed(fmt::format("--strict: {}: {} not as the others; {}", options.source(),
                                  left_out.size() == 1 ? "a part is" : fmt::format("{} parts are", left_out.size()),
                                  left_out.front()));
  }
  for (const std::string& part : left_out) {
    cli::note_doubt(options.source(), "left out as not good: " + part);
  }
  doubts.insert(doubts.end(), remarks.doubts.begin(), remarks.doubts.end());
  if (options.receive.check && !doubts.empty()) {
    throw CheckFailed(fmt::format("--check: {}: {}", options.source(), fmt::join(doubts, "; ")));
  }
  out.write(fmt::format("# learned from {} good parts on rig {}\n", learner.parts() - left_out.size(), rig.name) +
            production::to_yaml(tolerance));
  fmt::print("{} good parts{}{}; {:.3f} mm long, {:.3f} mm wide, {} regions → {}\n", learner.parts() - left_out.size(),
             learner.not_kept() > 0 ? fmt::format(" (and {} that are not kept)", learner.not_kept()) : std::string(),
             specks > 0 ? fmt::format(", {} things too short to be a part", specks) : std::string(),
             tolerance.length_mm, tolerance.right_mm - tolerance.left_mm, tolerance.regions.size(), options.out);
  for (const production::ToleranceRegion& region : tolerance.regions) {
    fmt::print("  {}: {:+.3f} to {:+.3f} mm, {:.2f} % may be missing\n", region.name, region.low_mm, region.high_mm,
               100 * region.max_missing);
  }
  if (remarks.unseen_mm2 > 0) {
    fmt::print("  not inspected: {:.1f} of {:.1f} mm² that most of the parts do not show, with the strip around it\n",
               remarks.unseen_mm2, remarks.regions_mm2);
  }
  note_doubts();
}

// Near an edge a light section's line lies partly beside it, and its centroid is pulled.
constexpr double kEdgeCells = 6;

production::LearnOptions learn_options(const LearnCommandOptions& options, const production::LearnOptions& otherwise) {
  production::LearnOptions learn = options.learn;
  learn.min_defect_mm2 = options.min_defect_mm2.value_or(otherwise.min_defect_mm2);
  learn.edge_mm = options.edge_mm.value_or(otherwise.edge_mm);
  return learn;
}

void add_part(production::Learner& learner, std::optional<production::CutPart> part) {
  if (part) {
    learner.add(std::move(*part));
  }
}

// From depth images under the stripes of a reference.
void learn_depth(const LearnCommandOptions& options) {
  MatchOptions match = options.match;
  match.rig = options.section.rig;
  match.reference = options.section.reference;
  if (match.reference.empty()) {
    throw UserError("--reference", "is needed for a rig of kind scanner: the folder of `selfproj pattern stripes`");
  }
  const files::OutputFile out(options.out);
  const MatchRun run(match);
  MatchStream stream(run, options.receive.device);
  production::DepthGrid grid(run.rig());
  const double cell = run.rig().parts->grid_mm;
  production::Learner learner(run.rig(), grid.cells(stream.scanner().reference_depth()),
                              learn_options(options, {.min_defect_mm2 = 9 * cell * cell, .edge_mm = 3 * cell}));
  production::DepthCutter cutter(run.rig(), run.patterns());
  Receiver receiver(options.receive);
  receiver.open(run.decoder());
  std::uint64_t images = 0;
  const auto receive = [&](const model::PacketView& packet) {
    if (stream.add(packet)) {
      const std::int64_t arrival_ns = receiver.device().arrival_ns();
      add_part(learner, cutter.add(stream.stream().header(), stream.scanner().depth(), arrival_ns));
      ++images;
    }
    return images;
  };
  receiver.run({receive, [&] { return fmt::format("{} good parts", learner.parts()); }});
  add_part(learner, cutter.finish());
  write_tolerance(options, run.rig(), out, learner, cutter.specks());
  receiver.check(stream.stream().incomplete());
}

void learn_section(const LearnCommandOptions& options) {
  const rig::Rig rig = options.section.load_rig(options.images.says_way());
  const files::OutputFile out(options.out);
  const light_section::ReferenceProfile reference =
      options.section.load_reference(rig, options.receive.device, options.images.images);
  const light_section::DifferentialProfiler profiler(rig, reference);
  production::Learner learner(
      rig, production::section_of(rig, reference, profiler),
      learn_options(options, {.edge_mm = kEdgeCells * rig.parts.value_or(rig::RigParts{}).grid_mm}));
  production::ProfileCutter cutter(rig);
  SectionRun section(profiler, rig.measure);
  const model::Measure measure = measure_of_rig(rig);
  light_section::Profile profile;
  profile.resize(profiler.columns());
  std::vector<std::string> doubts;
  const auto finish = [&] {
    add_part(learner, cutter.finish());
    if (std::string doubt = doubt_about(section.counts(), rig); !doubt.empty()) {
      doubts.push_back(std::move(doubt));
    }
    write_tolerance(options, rig, out, learner, cutter.specks(), doubts);
  };
  if (options.receive.device.empty()) {
    ImageSource source(options.images, rig, measure);
    if (!source.doubt().empty()) {
      doubts.push_back(source.doubt());
    }
    source.run(options.receive.count, [&](const model::PacketHeader& header, const model::RunsView& runs) {
      section.profile(header, runs, source.first(), 0, profile.view());
      add_part(learner, cutter.add(header, profile.view(), 0));
    });
    finish();
    return;
  }
  Receiver receiver(options.receive);
  receiver.open(camera::camera_of_rig(rig, measure), BoardSetup{rig.camera, measure, rig.measure.sends_compact()});
  const auto receive = [&](const model::PacketView& packet) {
    if (section.profile(packet, receiver.device(), profile.view())) {
      add_part(learner, cutter.add(packet.header, profile.view(), receiver.device().arrival_ns()));
    }
    return section.counts().profiles;
  };
  receiver.run({receive, [&] { return fmt::format("{} good parts", learner.parts()); }});
  finish();
  receiver.check(section.counts().other_size);
}

void run_learn(const LearnCommandOptions& options) {
  if (options.receive.device.empty() == options.images.images.empty()) {
    throw UserError("--device, --images", "one of them is required");
  }
  if (rig::load_any_rig(options.section.rig).kind == rig::RigKind::scanner) {
    if (options.receive.device.empty()) {
      throw UserError("--images", "goes only with a rig of kind light-section");
    }
    learn_depth(options);
  } else {
    learn_section(options);
  }
}

void add_learn_command(CLI::App& tolerance) {
  CLI::App* command = cli::add_command(
      tolerance,
      {.name = "learn",
       .purpose = "Makes a tolerance file from good parts.",
       .details =
           "The device, or the images, bring at least 5 good parts; the rig's section `parts` says how they are cut. "
           "Each stretch of "
           "the reference's section between two walls becomes a region. Its band is what the good parts reach, and "
           "--spreads standard deviations, times 1 + 3 / parts, more. The file is YAML, to be looked at and "
           "changed.\n\n"
           "With a rig of kind scanner the parts are depth images under the stripes of --reference, and each surface "
           "of the reference becomes a region.\n\n"
           "The run ends when the device ends, after --count profiles or depth images, after --seconds, or at Ctrl-C.",
       .examples = R"(
# A tolerance from recorded good parts, and parts classified by it.
selfproj-sim production --out line
selfproj tolerance learn --rig line/rig.yaml --reference line/part \
  --device file:line/good.packets --out tolerance.yaml
selfproj inspect --rig line/rig.yaml --reference line/part --device file:line/run.packets \
  --tolerance tolerance.yaml --parts today

# The same with structured light.
selfproj-sim production --rig scanner --good 5 --parts 3 --out scans
selfproj tolerance learn --rig scans/rig.yaml --reference scans/stripes \
  --device file:scans/good.packets --out scans.yaml
selfproj match --rig scans/rig.yaml --reference scans/stripes --device file:scans/run.packets \
  --tolerance scans.yaml --parts scanned --out newest
)"});
  const auto options = std::make_shared<LearnCommandOptions>();
  CLI::Option* const device =
      add_receive_options(*command, options->receive, "profiles or depth images",
                          ", of whose images this program makes the packets itself, as the rig says.",
                          DeviceIs::or_images, BoardIs::set_up);
  add_image_source_options(*command, options->images, device);
  cli::begin_group(*command, "Measuring");
  add_section_options(*command, options->section);
  add_search_options(*command, options->match);
  cli::begin_group(*command, "Tolerance");
  command->add_option("--min-defect-mm2", options->min_defect_mm2, "Area of the smallest defect.")
      ->transform(cli::number_above_zero())
      ->type_name("MM2")
      ->default_str("0.5; of a scanner that of 9 cells");
  command->add_option("--edge-mm", options->edge_mm, "Strip along edges and walls that is not inspected.")
      ->transform(cli::real_number(0, 1000))
      ->type_name("MM")
      ->default_str("6 cells of the map; of a scanner 3");
  command
      ->add_option("--spreads", options->learn.spreads,
                   "Standard deviations, times 1 + 3 / parts, from the mean of the good parts to a limit.")
      ->transform(cli::real_number(1, 100))
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--max-shift-mm", options->learn.max_shift_mm, "A part may be shifted across so far.")
      ->transform(cli::real_number(0, 1000))
      ->type_name("MM")
      ->capture_default_str();
  command->add_option("--max-turn-deg", options->learn.max_turn_deg, "A part may be turned so far.")
      ->transform(cli::real_number(0, 45))
      ->type_name("DEG")
      ->capture_default_str();
  cli::add_old_name(*command, "--smallest-mm2", "--min-defect-mm2");
  cli::add_old_name(*command, "--shift-mm", "--max-shift-mm");
  cli::add_old_name(*command, "--turn-deg", "--max-turn-deg");
  command->add_flag("--strict", options->strict,
                    "Write nothing, and exit with status 1, if a part is not as the others. Without it, such a part is "
                    "left out with a warning.");
  cli::begin_group(*command, "Output");
  command->add_option("--out", options->out, "File for the tolerance.")->type_name("FILE")->required();
  command->callback([options] { run_learn(*options); });
}

}  // namespace

void add_tolerance_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app, {.name = "tolerance",
            .purpose = "Makes the tolerances by which `selfproj inspect` and `selfproj match` classify parts.",
            .details = "",
            .examples = R"(
# A tolerance from the good parts of a simulated line.
selfproj-sim production --out good-line
selfproj tolerance learn --rig good-line/rig.yaml --reference good-line/part \
  --device file:good-line/good.packets --out good.yaml
)"});
  command->require_subcommand(1);
  add_learn_command(*command);
}

}  // namespace selfproj::app
