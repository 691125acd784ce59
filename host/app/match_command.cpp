#include "host/app/match_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "host/app/depth_options.h"
#include "host/app/line_run.h"
#include "host/app/match_run.h"
#include "host/camera/camera_device.h"
#include "host/cli/command_line.h"
#include "host/files/output_folder.h"
#include "host/files/user_error.h"
#include "host/images/frame_options.h"
#include "host/images/image_sequence.h"

namespace selfproj {
namespace {

struct MatchCommand {
  MatchCommand() { match.rig = "scanner"; }

  MatchOptions match;
  std::string channel;
  std::string out;
  std::string list;
  MatchDevice device;
  std::vector<std::string> images;
};

// The part of a run that takes a board or a camera.
void match_device(const MatchCommand& options) {
  if (!options.images.empty() || !options.channel.empty()) {
    throw UserError(options.images.empty() ? "--channel" : "IMAGE", "does not go with --device");
  }
  const MatchRun run(options.match);
  OutputFolder folder(options.out);
  DepthList list(options.list);
  const CameraBoardSettings decoder{.code_bits = run.patterns() / 2, .code_threshold = run.threshold()};
  const auto open = [&] {
    return open_any_device(options.device.uri, {.wait_for_board = options.device.wait_for_board}, {.board = decoder});
  };
  const MatchResult result = run.measure(options.device, open, folder, &list);
  folder.commit();
  list.commit();
  fmt::print("{}", result.text);
}

void run_match(const MatchCommand& options) {
  if (!options.device.uri.empty()) {
    match_device(options);
    return;
  }
  const std::string line = options.device.line.first();
  if (options.device.count > 0 || options.device.save > 0 || !line.empty()) {
    throw UserError(options.device.count > 0 ? "--count" : (options.device.save > 0 ? "--save" : line),
                    "goes only with --device");
  }
  const MatchRun run(options.match);
  const std::size_t count = options.images.size();
  const auto patterns = static_cast<std::size_t>(run.patterns());
  if (count < patterns || count % 2 != 0) {
    throw UserError("IMAGE", fmt::format("{} images are {}; {} or more are needed, a positive and its negative in turn",
                                         count, count < patterns ? "too few" : "an odd number", patterns));
  }
  ImageSequence images(options.images, channel_of(options.channel));
  OutputFolder folder(options.out);
  DepthList list(options.list);
  const MatchResult result = run.measure(images, folder, &list);
  folder.commit();
  list.commit();
  fmt::print("{}", result.text);
}

}  // namespace

void add_match_command(CLI::App& app) {
  CLI::App* command = add_command(
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
selfproj match --reference reference --e 8 --out depth block/image_*.png

# The same on a board, until Ctrl-C (needs hardware)
selfproj match --reference reference --e 8 --device ring:line1 --out today
)"});
  const auto options = std::make_shared<MatchCommand>();
  begin_group(*command, "Rig and reference");
  command->add_option("--rig", options->match.rig, "Built-in rig or YAML file of kind scanner.")
      ->type_name("RIG")
      ->capture_default_str();
  command->add_option("--reference", options->match.reference, "Folder that `selfproj pattern stripes` wrote.")
      ->type_name("DIR")
      ->required();
  begin_group(*command, "Decoding");
  add_threshold_option(*command, options->match.threshold, "the rig's");
  add_channel_option(*command, options->channel);
  add_search_options(*command, options->match);
  add_line_options(*command, options->device.line);
  begin_group(*command, "Input and output");
  command
      ->add_option("--device", options->device.uri,
                   "Instead of images, a board: ring:NAME, udp:HOST[:PORT], litepcie:PATH or file:PATH. It sends "
                   "codes, or images, "
                   "which are decoded here. Or a camera that the projector triggers, camera:NAME. Image k, by the "
                   "board's or the camera's own number, shows pattern k modulo 2m. The run ends with the device, "
                   "--count or Ctrl-C.")
      ->type_name("URI");
  command->add_flag("--wait-for-board", options->device.wait_for_board,
                    "With --device: wait until a ring and a board exist. Ctrl-C ends the run.");
  command->add_option("--count", options->device.count, "With --device: number of depth images to make.")
      ->transform(whole_number(1))
      ->type_name("N")
      ->default_str("all");
  command
      ->add_option("--save", options->device.save,
                   "With --device: write depth_KKKK.tiff and difference_KKKK.tiff of the first N depth images as well; "
                   "later ones only count.")
      ->transform(whole_number(1))
      ->type_name("N")
      ->default_str("none");
  command
      ->add_option(
          "--list", options->list,
          "Table of all depth images, which is for comparing two runs: number of the pair, pixels with a depth, "
          "and a checksum each of depth map and difference map.")
      ->type_name("FILE");
  command->add_option("--out", options->out, "Folder for the results.")->type_name("DIR")->required();
  add_files(*command, "IMAGE", options->images, "8-bit images of the camera's size. These or --device are needed.");
  command->callback([options] { run_match(*options); });
}

}  // namespace selfproj
