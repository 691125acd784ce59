#include "host/app/match_run.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "host/app/packet_run.h"
#include "host/io/command_line.h"
#include "host/io/float_image.h"
#include "host/io/frame_options.h"
#include "host/io/progress.h"
#include "host/io/user_error.h"
#include "host/report/depth_summary.h"
#include "host/structured_light/depth_run.h"
#include "host/structured_light/depth_shares.h"
#include "host/structured_light/scan_stream.h"
#include "host/structured_light/self_reference_file.h"
#include "host/structured_light/self_scanner.h"

namespace selfproj {
namespace {

// Writes depth and difference of the scanner's newest image into the folder.
void append_maps(const SelfScanner& scanner, std::size_t pair, OutputFolder& folder) {
  for (const auto& [name, map] : {std::pair{"depth", &scanner.depth()}, {"difference", &scanner.difference()}}) {
    const std::string file = fmt::format("{}_{:04}.tiff", name, pair);
    folder.append(file, encode_float_tiff(file, *map));
  }
}

// Passes all images to the scanner, and returns the shares of each depth image. If there are several, depth and
// difference of each are written into the folder.
std::vector<OfImage<DepthShares>> match_images(const Rig& rig, std::size_t patterns, ImageSequence& images,
                                               SelfScanner& scanner, OutputFolder& folder) {
  std::array<Image, 2> pair;  // the scanner reads the positive when its negative comes
  std::vector<PointState> states;
  std::vector<OfImage<DepthShares>> all_shares;
  Progress progress("image", images.count());
  for (std::size_t i = 0; i < images.count(); ++i) {
    Image& image = pair.at(i % 2);
    image = images.read(i);
    check_camera_size(rig, images.files()[i], image);
    if (scanner.take(image.view(), static_cast<int>(i % patterns))) {
      scanner.explain(states);
      all_shares.push_back({i / 2, count_states(states)});
      if (images.count() > patterns) {
        append_maps(scanner, i / 2, folder);
      }
    }
    progress.update(i + 1);
  }
  return all_shares;
}

}  // namespace

void add_search_options(CLI::App& command, MatchOptions& options) {
  begin_group(command, "Search");
  command
      .add_option(
          "--e", options.settings.e,
          "Codes that are searched below the reference, less than 2^m. The other 2^m - e are searched above it.")
      ->transform(whole_number(0, (1 << Stripes::kMaxBits) - 1))
      ->type_name("E")
      ->capture_default_str();
  command.add_flag("--printed-direction", options.settings.printed_direction,
                   "Search along Xp at constant Yp, as printed in (4.19), instead of along the epipolar line.");
  command.add_flag("--printed-window", options.settings.printed_window,
                   "Search a window of projector lines, as printed in (4.20), instead of one of codes.");
  command
      .add_option("--line-width", options.settings.line_width, "Projector lines of a code in the printed window, a'.")
      ->transform(number_above_zero())
      ->type_name("LINES")
      ->capture_default_str();
}

Rig scanner_rig(const std::string& name) {
  Rig rig = load_rig(name);
  if (rig.kind != RigKind::scanner) {
    throw UserError("--rig", fmt::format("{} is not a rig of kind scanner", name));
  }
  return rig;
}

void check_camera_size(const Rig& rig, const std::string& name, const Image& image) {
  if (image.rows != rig.camera.rows || image.columns != rig.camera.columns) {
    throw UserError(name, fmt::format("is {}; the rig's camera has {}", size_text(image.rows, image.columns),
                                      size_text(rig.camera.rows, rig.camera.columns)));
  }
}

MatchRun::MatchRun(const MatchOptions& options)
    : options_(options), rig_(scanner_rig(options.rig)), reference_(read_self_reference(rig_, options.reference)) {
  const int bits = reference_.stripes.bits;
  const int codes = 1 << bits;
  if (options.settings.e < 0 || options.settings.e >= codes) {
    throw UserError("--e",
                    fmt::format("is {}; a reference of {} bits allows 0 to {}", options.settings.e, bits, codes - 1));
  }
  if (!(options.settings.line_width > 0) || options.settings.line_width > rig_.projector.lines) {
    throw UserError("--line-width", fmt::format("is {}; it must be above 0, and at most the {} lines of the projector",
                                                options.settings.line_width, rig_.projector.lines));
  }
}

MatchResult MatchRun::measure(ImageSequence& images, OutputFolder& folder) const {
  const MatchTable table(rig_, reference_, options_.settings);
  SelfScanner scanner(rig_, reference_, table, threshold());
  MatchReport report{options_.rig,
                     options_.reference,
                     reference_.stripes.bits,
                     options_.settings,
                     threshold(),
                     images.count(),
                     match_images(rig_, static_cast<std::size_t>(patterns()), images, scanner, folder)};
  report.depth_images = report.all_shares.size();
  MatchPictures pictures = write_match(rig_, table, scanner, report, folder);
  return {.text = match_text(table, report, folder.name()), .pictures = std::move(pictures)};
}

MatchResult MatchRun::measure(const MatchDevice& of, Device& device, OutputFolder& folder) const {
  const MatchTable table(rig_, reference_, options_.settings);
  SelfScanner scanner(rig_, reference_, table, threshold());
  MatchReport report{options_.rig, options_.reference, reference_.stripes.bits, options_.settings, threshold(), 0, {}};
  report.device = of.uri;
  ScanStream stream;
  std::uint64_t pair = 0;
  const auto take = [&](const PacketView& packet) {
    const ScanStream::Got got = stream.add(packet);
    if (got == ScanStream::Got::nothing) {
      return report.depth_images;
    }
    check_size("the rig's camera", rig_.camera.rows, rig_.camera.columns,
               {"an image of " + of.uri, stream.header().rows, stream.header().columns});
    if (got == ScanStream::Got::codes) {
      scanner.take_codes(stream.codes().data());
    } else if (!scanner.take(stream.image(), stream.pattern(patterns()))) {
      return report.depth_images;
    }
    pair = stream.pair();
    if (report.depth_images < of.save) {
      append_maps(scanner, pair, folder);
    }
    return ++report.depth_images;
  };
  PacketRunOptions end;
  end.count = of.count;
  run_packets(device, end, take, [&] {
    return fmt::format("{} depth images, {}", report.depth_images, losses_of({device.counters(), stream.incomplete()}));
  });
  if (report.depth_images == 0) {
    throw UserError(of.uri, "delivered no complete code image, nor images enough for one");
  }
  std::vector<PointState> states;
  scanner.explain(states);
  report.all_shares.push_back({pair, count_states(states)});
  report.counts = {device.counters(), stream.incomplete()};
  MatchPictures pictures = write_match(rig_, table, scanner, report, folder);
  return {.text = match_text(table, report, folder.name()), .pictures = std::move(pictures)};
}

}  // namespace selfproj
