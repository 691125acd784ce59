#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/app/commands.h"
#include "host/app/receive.h"
#include "host/app/scanner_run.h"
#include "host/cli/command_line.h"
#include "host/files/output_folder.h"
#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "host/images/image_sequence.h"
#include "host/production/production.h"
#include "host/structured_light/depth_run.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/packet.h"

namespace selfproj::app {
namespace {

struct MatchCommand {
  MatchCommand() { match.rig = "scanner"; }

  MatchOptions match;
  images::PixelOptions pixels;
  std::string out;
  std::string list;
  bool unchecked = false;
  ReceiveOptions receive;
  production::ProductionOptions production;
  std::size_t save = 0;  // depth images of a device of which depth and difference are written
  std::vector<std::string> images;
};

// What the page shows of the stream.
std::vector<report::Fact> stream_facts(std::size_t images, double rate, const structured_light::DeviceCounts& counts) {
  std::vector<report::Fact> facts = {{"depth_images", "depth images", static_cast<std::int64_t>(images)},
                                     {"depth_images_per_second", "depth images a second", rate},
                                     {"incomplete", "incomplete images", static_cast<std::int64_t>(counts.incomplete)}};
  const std::vector<report::Fact> driver = report::counter_facts(counts.counters);
  facts.insert(facts.end(), driver.begin(), driver.end());
  return facts;
}

// Depth images from the packets of a board or a camera.
void match_device(const MatchCommand& options) {
  if (!options.images.empty() || !options.pixels.given().empty()) {
    throw UserError(options.images.empty() ? options.pixels.given() : "IMAGE", "does not go with --device");
  }
  const std::string& uri = options.receive.device;
  const MatchRun run(options.match);
  files::OutputFolder folder(options.out);
  DepthList list(options.list);
  MatchStream stream(run, uri);
  Receiver receiver(options.receive);  // before the page can be seen
  std::optional<production::Production> production;
  if (options.production.any()) {
    production.emplace(options.production, run.rig(), stream.scanner().reference_depth(), run.patterns(),
                       fmt::format("{}: {}", run.rig().name, uri));
  }
  receiver.open(run.decoder());

  report::MatchReport report = run.report();
  report.device = uri;
  std::uint64_t pair = 0;
  const auto counts = [&] { return structured_light::DeviceCounts{receiver.counters(), stream.stream().incomplete()}; };
  const auto receive = [&](const model::PacketView& packet) -> std::uint64_t {
    if (production) {
      production->image(packet);
    }
    if (!stream.add(packet)) {
      return report.depth_images;
    }
    pair = stream.stream().pair();
    const structured_light::SelfScanner& scanner = stream.scanner();
    if (report.depth_images < options.save) {
      append_maps(scanner, pair, folder);
    }
    list.add(pair, scanner);
    if (production) {
      production::MeasuredFrame& slot = production->claim();
      slot.header = stream.stream().header();
      slot.arrival_ns = receiver.device().arrival_ns();
      slot.depth.values = scanner.depth().values;
      slot.difference.values = scanner.difference().values;
      production->publish();
    }
    return ++report.depth_images;
  };
  const auto status = [&] {
    const std::string parts = production ? production->status_text() : std::string();
    return fmt::format("incomplete images {}{}{}", stream.stream().incomplete(), parts.empty() ? "" : ", ", parts);
  };
  const auto show = [&](double rate) {
    if (production) {
      production->report(receiver.counters(), stream_facts(report.depth_images, rate, counts()));
    }
  };
  receiver.run({receive, status, show});
  if (report.depth_images == 0) {
    throw UserError(uri, "delivered no complete code image, nor images enough for one");
  }
  if (production) {
    production->finish();
    report.line = production->facts();
    production->describe(report.parts);
  }
  std::vector<structured_light::PointState> states;
  stream.scanner().explain(states);
  report.all_shares.push_back({pair, structured_light::count_states(states)});
  report.counts = counts();
  const std::string contradiction = stream.contradiction();
  report.doubt = contradiction;
  if (contradiction.empty()) {
    const std::string reason = structured_light::reason_without_points(report.all_shares.back().value);
    report.doubt = reason.empty() ? structured_light::doubt_of(stream.scanner()) : reason;
  }
  const report::MatchPictures pictures = report::write_match(stream.table(), stream.scanner(), report, folder);
  folder.append("report.html", report::match_page(report, stream.table(), stream.scanner(), pictures));
  folder.commit();
  list.commit();
  fmt::print("{}{}", report::match_text(stream.table(), report, folder.name()),
             production ? production->end_text() : std::string());
  if (production) {
    production->check();
  }
  if (options.receive.check && !options.unchecked && !contradiction.empty()) {
    throw CheckFailed(fmt::format("--check: {}", contradiction));
  }
  cli::note_doubt(uri, report.doubt);
  receiver.check(report.counts->incomplete);
}

void run_match(const MatchCommand& options) {
  if (!options.receive.device.empty()) {
    match_device(options);
    return;
  }
  const MatchRun run(options.match);
  const std::vector<std::string> files = images::image_arguments(options.images);
  const std::size_t count = files.size();
  const auto patterns = static_cast<std::size_t>(run.patterns());
  if (count < patterns || count % 2 != 0) {
    throw UserError("IMAGE", fmt::format("{} images are {}; {} or more are needed, a positive and its negative in turn",
                                         count, count < patterns ? "too few" : "an odd number", patterns));
  }
  images::ImageSequence images(files, options.pixels.rule());
  files::OutputFolder folder(options.out);
  DepthList list(options.list);
  const MatchResult result = run.measure(images, folder, &list);
  folder.append("report.html", result.page);
  cli::refuse_contradiction("IMAGE", result.contradiction, options.unchecked);
  cli::note_doubt("IMAGE", result.doubt);
  folder.commit();
  list.commit();
  fmt::print("{}", result.text);
}

}  // namespace

void add_match_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app,
      {.name = "match",
       .purpose = "Measures depth, and its difference from a reference, under self-projected patterns.",
       .details = "The images are the positive and the negative of each bit in turn, as `selfproj pattern stripes` "
                  "numbers its patterns. From pair m on, every pair completes a depth image.\n\n"
                  "The output folder gets depth.tiff (z in mm), difference.tiff (in mm, positive towards the camera), "
                  "pictures, cloud.ply, shares.csv, summary.json, and depth_KKKK.tiff and difference_KKKK.tiff of each "
                  "pair K where there are several. Numbers in parentheses are those of the equations in the thesis.",
       .examples = R"(
# Scan the empty plane of a simulated scanner, and make its patterns.
selfproj pattern gray --rig scanner --out codes
selfproj-sim capture --rig scanner --scene plane --patterns codes --out captures
selfproj pattern stripes --scan captures --gray-code --out reference

# Capture a block under these patterns, and measure it.
mkdir -p stripes
cp reference/pattern_*.png stripes
selfproj-sim capture --rig scanner --scene block --patterns stripes --out block
selfproj match --reference reference --e 8 --out depth block

# The same on a board, until Ctrl-C (needs hardware)
selfproj match --reference reference --e 8 --device ring:line1 --out today
)"});
  const auto options = std::make_shared<MatchCommand>();
  cli::begin_group(*command, "Rig and reference");
  command->add_option("--rig", options->match.rig, "Built-in rig or YAML file of kind scanner.")
      ->type_name("RIG")
      ->capture_default_str();
  command->add_option("--reference", options->match.reference, "Folder that `selfproj pattern stripes` wrote.")
      ->type_name("DIR")
      ->required();
  cli::begin_group(*command, "Decoding");
  add_threshold_option(*command, options->match.threshold, "the rig's");
  cli::add_pixel_options(*command, options->pixels);
  cli::add_unchecked_option(*command, options->unchecked);
  add_search_options(*command, options->match);
  CLI::Option* const device =
      add_receive_options(*command, options->receive, "depth images", kImagesOfPatterns, DeviceIs::instead_of_images);
  add_production_options(*command, options->production, device);
  cli::begin_group(*command, "Input and output");
  command
      ->add_option("--save", options->save,
                   "Write depth_KKKK.tiff and difference_KKKK.tiff of the first N depth images of the device as well; "
                   "later ones only count.")
      ->transform(cli::whole_number(1))
      ->type_name("N")
      ->default_str("none")
      ->needs(device);
  command
      ->add_option(
          "--list", options->list,
          "Table of all depth images, which is for comparing two runs: number of the pair, pixels with a depth, "
          "and a checksum each of depth map and difference map.")
      ->type_name("FILE");
  command->add_option("--out", options->out, "Folder for the results.")->type_name("DIR")->required();
  cli::add_files(
      *command, "IMAGE", options->images,
      "8-bit images of the camera's size, or one folder of them, in natural order and nothing else in it. These "
      "or --device are needed.");
  command->callback([options] { run_match(*options); });
}

}  // namespace selfproj::app
