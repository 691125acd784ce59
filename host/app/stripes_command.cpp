#include "host/app/stripes_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/io/command_line.h"
#include "host/io/float_image.h"
#include "host/io/frame_options.h"
#include "host/io/image_files.h"
#include "host/io/output_folder.h"
#include "host/io/progress.h"
#include "host/io/user_error.h"
#include "host/light_section/pattern.h"
#include "host/report/map_picture.h"
#include "host/report/match_output.h"
#include "host/rig/rig.h"
#include "host/structured_light/depth_run.h"
#include "host/structured_light/depth_shares.h"
#include "host/structured_light/match_table.h"
#include "host/structured_light/point_scan.h"
#include "host/structured_light/self_reference.h"
#include "host/structured_light/self_reference_file.h"
#include "host/structured_light/self_scanner.h"

namespace selfproj {
namespace {

Rig scanner_rig(const std::string& name) {
  Rig rig = load_rig(name);
  if (rig.kind != RigKind::scanner) {
    throw UserError("--rig", fmt::format("{} is not a rig of kind scanner", name));
  }
  return rig;
}

Image camera_image(const Rig& rig, const std::string& file, const std::string& channel) {
  Image image = read_image(file, channel_of(channel));
  if (image.rows != rig.camera.rows || image.columns != rig.camera.columns) {
    throw UserError(file, fmt::format("is {}; the rig's camera has {}", size_text(image.rows, image.columns),
                                      size_text(rig.camera.rows, rig.camera.columns)));
  }
  return image;
}

// --- selfproj pattern stripes ---

struct StripesOptions {
  std::string rig = "scanner";
  std::string scan;
  bool sweep = false;
  bool gray_code = false;
  Stripes stripes;
  bool reflected = false;
  std::string channel;
  std::string out;
};

void make_sweep(const Rig& rig, OutputFolder& folder) {
  const int count = LinePointScan(rig).count();
  Progress progress("pattern", static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    folder.append(fmt::format("pattern_{:05}.png", i), encode_pattern_png(scan_pattern(rig, i)));
    progress.update(static_cast<std::size_t>(i) + 1);
  }
}

template <class Scan>
void take_folder(const Rig& rig, const StripesOptions& options, const std::vector<std::string>& files, Scan& scan) {
  Progress progress("image", files.size());
  for (std::size_t i = 0; i < files.size(); ++i) {
    scan.add(camera_image(rig, files[i], options.channel).view());
    progress.update(i + 1);
  }
}

ProjectorPoints scanned(const Rig& rig, const StripesOptions& options) {
  const std::vector<std::string> files = files_of_folder(options.scan);
  if (options.gray_code) {
    GrayPointScan scan(rig);
    const auto all = static_cast<std::size_t>(scan.count());
    if (files.size() != all && files.size() + 2 != all) {
      throw UserError(options.scan, fmt::format("has {} images; the Gray codes of this rig's projector have {}, or {} "
                                                "without white and black",
                                                files.size(), all, all - 2));
    }
    take_folder(rig, options, files, scan);
    return scan.points();
  }
  LinePointScan scan(rig);
  if (files.size() != static_cast<std::size_t>(scan.count())) {
    throw UserError(options.scan,
                    fmt::format("has {} images; a scan of this rig's projector has {}, one a line and one "
                                "a column",
                                files.size(), scan.count()));
  }
  take_folder(rig, options, files, scan);
  return scan.points();
}

void run_stripes(const StripesOptions& options) {
  if (options.sweep == !options.scan.empty()) {
    throw UserError("--scan, --sweep", "give one of them, not both");
  }
  if (options.gray_code && options.sweep) {
    throw UserError("--gray-code", "goes only with --scan; `selfproj pattern gray` writes its patterns");
  }
  const Rig rig = scanner_rig(options.rig);
  OutputFolder folder(options.out);
  if (options.sweep) {
    make_sweep(rig, folder);
    folder.commit();
    return;
  }
  const ProjectorPoints points = scanned(rig, options);
  Stripes stripes = options.stripes;
  stripes.code = options.reflected ? StripeCode::reflected : StripeCode::cyclic;
  SelfReference reference;
  try {
    reference = make_self_reference(rig, points, stripes);
  } catch (const std::invalid_argument&) {
    throw UserError(options.scan, "no camera pixel sees both a line and a column of the scan");
  }
  write_self_reference(rig, reference, folder);
  folder.append("preview.png",
                labelled_map_png(reference.points.line, {ColourMap::sequential, 0, rig.projector.lines - 1.0}, {1, 1},
                                 "X_R: projector line seen by each camera pixel"));
  folder.commit();
  std::size_t measurable = 0;
  for (std::size_t i = 0; i < points.line.values.size(); ++i) {
    measurable += reference.measurable(i) ? 1 : 0;
  }
  const auto seen = static_cast<double>(std::count(reference.seen.begin(), reference.seen.end(), 1));
  fmt::print(
      "{}: {} bits, {} code; reference in {} of {} camera pixels; {:.1f} % of the projector's seen, the rest "
      "filled in\n",
      options.out, stripes.bits, options.reflected ? "reflected" : "cyclic", measurable, points.line.values.size(),
      100 * seen / static_cast<double>(reference.seen.size()));
}

// --- selfproj match ---

struct MatchOptions {
  std::string rig = "scanner";
  std::string reference;
  MatchSettings settings;
  int threshold = -1;
  std::string channel;
  std::string out;
  std::vector<std::string> images;
};

void check_options(const MatchOptions& options, const Rig& rig, int bits) {
  const int codes = 1 << bits;
  if (options.settings.e < 0 || options.settings.e >= codes) {
    throw UserError("--e",
                    fmt::format("is {}; a reference of {} bits allows 0 to {}", options.settings.e, bits, codes - 1));
  }
  if (!(options.settings.line_width > 0) || options.settings.line_width > rig.projector.lines) {
    throw UserError("--line-width", fmt::format("is {}; it must be above 0, and at most the {} lines of the projector",
                                                options.settings.line_width, rig.projector.lines));
  }
  const auto patterns = static_cast<std::size_t>(2 * bits);
  if (options.images.size() < patterns || options.images.size() % 2 != 0) {
    throw UserError("IMAGE", fmt::format("{} images are {}; {} or more are needed, a positive and its negative in turn",
                                         options.images.size(),
                                         options.images.size() < patterns ? "too few" : "an odd number", patterns));
  }
  for (const std::string& file : options.images) {
    check_image_file(file);
  }
}

// Passes all images to the scanner, and returns the shares of each depth image. If there are several, depth and
// difference of each are written into the folder.
std::vector<OfImage<DepthShares>> match_images(const MatchOptions& options, const Rig& rig, int bits,
                                               SelfScanner& scanner, OutputFolder& folder) {
  const auto patterns = static_cast<std::size_t>(2 * bits);
  std::array<Image, 2> pair;  // the scanner reads the positive when its negative comes
  std::vector<PointState> states;
  std::vector<OfImage<DepthShares>> all_shares;
  Progress progress("image", options.images.size());
  for (std::size_t i = 0; i < options.images.size(); ++i) {
    Image& image = pair.at(i % 2);
    image = camera_image(rig, options.images[i], options.channel);
    if (scanner.take(image.view(), static_cast<int>(i % patterns))) {
      scanner.explain(states);
      all_shares.push_back({i / 2, count_states(states)});
      if (options.images.size() > patterns) {
        for (const auto& [name, map] : {std::pair{"depth", &scanner.depth()}, {"difference", &scanner.difference()}}) {
          const std::string file = fmt::format("{}_{:04}.tiff", name, i / 2);
          folder.append(file, encode_float_tiff(file, *map));
        }
      }
    }
    progress.update(i + 1);
  }
  return all_shares;
}

void run_match(const MatchOptions& options) {
  const Rig rig = scanner_rig(options.rig);
  const SelfReference reference = read_self_reference(rig, options.reference);
  const int bits = reference.stripes.bits;
  check_options(options, rig, bits);
  OutputFolder folder(options.out);
  const MatchTable table(rig, reference, options.settings);
  const int threshold = options.threshold >= 0 ? options.threshold : rig.measure.code_threshold;
  SelfScanner scanner(rig, reference, table, threshold);
  const MatchReport report{options.rig,
                           options.reference,
                           bits,
                           options.settings,
                           threshold,
                           options.images.size(),
                           match_images(options, rig, bits, scanner, folder)};
  write_match(rig, table, scanner, report, folder);
  folder.commit();
  fmt::print("{}", match_text(table, report, options.out));
}

}  // namespace

CLI::App* add_stripes_command(CLI::App& pattern) {
  CLI::App* command = add_command(
      pattern,
      {.name = "stripes",
       .purpose = "Makes the self-projected patterns of structured light from the scan of a reference.",
       .details =
           "The reference is scanned once, line by line (--sweep writes the patterns) or by the Gray codes of "
           "`selfproj pattern gray`. From the camera images of the scan (--scan) follow the patterns that the camera "
           "sees as straight stripes on the reference. The output folder is the --reference of `selfproj match`.",
       .examples = R"(
# Scan the empty plane of a simulated scanner by Gray codes, and make its 4-bit patterns.
selfproj pattern gray --rig scanner --out codes
selfproj-sim capture --rig scanner --scene plane --patterns codes --out captures
selfproj pattern stripes --scan captures --gray-code --bits 4 --out reference

# The patterns of a scan line by line: 1792 images (takes minutes)
selfproj pattern stripes --sweep --out lines
)"});
  const auto options = std::make_shared<StripesOptions>();
  begin_group(*command, "Scan (one of --scan and --sweep is required)");
  command
      ->add_option("--scan", options->scan,
                   "Folder of the camera images under the patterns of the scan, numbered in their order.")
      ->type_name("DIR");
  command->add_flag("--sweep", options->sweep, "Only write the patterns of a scan: every line, then every column.");
  command->add_flag("--gray-code", options->gray_code,
                    "The images of --scan were taken under the patterns of `selfproj pattern gray`.");
  add_channel_option(*command, options->channel);
  begin_group(*command, "Stripes");
  command->add_option("--rig", options->rig, "Built-in rig or YAML file of kind scanner.")
      ->type_name("RIG")
      ->capture_default_str();
  command->add_option("--bits", options->stripes.bits, "Bits of the code, m. 2m patterns are written.")
      ->transform(whole_number(1, Stripes::kMaxBits))
      ->type_name("M")
      ->capture_default_str();
  command->add_option("--rows-per-code", options->stripes.width, "Width of a code in camera rows, a.")
      ->transform(whole_number(1, Stripes::kMaxWidth))
      ->type_name("A")
      ->capture_default_str();
  command->add_flag(
      "--reflected", options->reflected,
      "Use the reflected code as printed in the thesis. Without it the code is cyclic, so that a window of "
      "2^m codes has each of them once.");
  begin_group(*command, "Output");
  command->add_option("--out", options->out, "Folder for the results.")->type_name("DIR")->required();
  command->callback([options] { run_stripes(*options); });
  return command;
}

void add_match_command(CLI::App& app) {
  CLI::App* command = add_command(
      app,
      {.name = "match",
       .purpose = "Measures depth, and its difference from a reference, from images under self-projected patterns.",
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
)"});
  const auto options = std::make_shared<MatchOptions>();
  begin_group(*command, "Rig and reference");
  command->add_option("--rig", options->rig, "Built-in rig or YAML file of kind scanner.")
      ->type_name("RIG")
      ->capture_default_str();
  command->add_option("--reference", options->reference, "Folder that `selfproj pattern stripes` wrote.")
      ->type_name("DIR")
      ->required();
  begin_group(*command, "Decoding");
  command
      ->add_option("--threshold", options->threshold,
                   "A pair of images that differs by at most this many grey levels is ambiguous.")
      ->transform(whole_number(0, 255))
      ->type_name("T")
      ->default_str("the rig's");
  add_channel_option(*command, options->channel);
  begin_group(*command, "Search");
  command
      ->add_option(
          "--e", options->settings.e,
          "Codes that are searched below the reference, less than 2^m. The other 2^m - e are searched above it.")
      ->transform(whole_number(0, (1 << Stripes::kMaxBits) - 1))
      ->type_name("E")
      ->capture_default_str();
  command->add_flag("--printed-direction", options->settings.printed_direction,
                    "Search along Xp at constant Yp, as printed in (4.19), instead of along the epipolar line.");
  command->add_flag("--printed-window", options->settings.printed_window,
                    "Search a window of projector lines, as printed in (4.20), instead of one of codes.");
  command
      ->add_option("--line-width", options->settings.line_width, "Projector lines of a code in the printed window, a'.")
      ->transform(number_above_zero())
      ->type_name("LINES")
      ->capture_default_str();
  begin_group(*command, "Output");
  command->add_option("--out", options->out, "Folder for the results.")->type_name("DIR")->required();
  add_files(*command, "IMAGE", options->images, "8-bit images of the camera's size.")->required();
  command->callback([options] { run_match(*options); });
}

}  // namespace selfproj
