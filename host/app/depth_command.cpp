#include "host/app/depth_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstddef>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "host/io/float_image.h"
#include "host/io/frame_options.h"
#include "host/io/image_sequence.h"
#include "host/io/output_folder.h"
#include "host/io/user_error.h"
#include "host/report/depth_output.h"
#include "host/report/depth_summary.h"
#include "host/structured_light/depth_run.h"
#include "host/structured_light/plane_fit.h"
#include "host/structured_light/point_cloud.h"
#include "model/gray_decoder.h"

namespace selfproj {
namespace {

struct DepthOptions {
  DepthOptions() { setup.scanner.median = false; }

  DepthSetup setup;
  std::string channel;
  std::string compare;
  bool compare_opengl = false;
  bool plane = false;
  std::string out;
  std::string device;
  std::size_t count = 0;
  std::vector<std::string> images;
};

void check_options(const DepthOptions& options) {
  const DepthGeometry& geometry = options.setup.geometry;
  const ScannerSettings& scanner = options.setup.scanner;
  if (geometry.rig.empty() == geometry.calibration.empty()) {
    throw UserError("--rig, --calibration", "one of them is needed, and not both");
  }
  if (!geometry.rig.empty() && (geometry.row_bits > 0 || geometry.lines > 0 || geometry.row_lines > 0)) {
    throw UserError("--row-bits, --lines, --row-lines", "go with --calibration; a rig has its own lines");
  }
  if (geometry.row_bits > 0 && (scanner.median || !options.setup.background.empty())) {
    throw UserError("--row-bits", "is for a single measurement; --median and --background go with one axis");
  }
  if (scanner.strict && scanner.median) {
    throw UserError("--strict, --median", "exclude each other: the median fills what --strict leaves out");
  }
  if (options.images.empty() == options.device.empty()) {
    throw UserError("IMAGE, --device", "one of them is needed, and not both");
  }
  if (!options.device.empty()) {
    if (geometry.row_bits > 0 || scanner.strict || scanner.median || !options.channel.empty()) {
      throw UserError("--device",
                      "brings codes decoded on the board; --row-bits, --strict, --median, --channel are for images");
    }
    return;
  }
  if (options.count > 0) {
    throw UserError("--count", "goes with --device");
  }
  const std::size_t count = options.images.size();
  const auto need = 2 * static_cast<std::size_t>(geometry.bits + geometry.row_bits);
  if (count % 2 != 0) {
    throw UserError("IMAGE",
                    fmt::format("{} images are an odd number; each positive is followed by its negative", count));
  }
  if (count < need) {
    throw UserError("IMAGE", fmt::format("{} images are too few; {} are needed for {} bits", count, need,
                                         geometry.bits + geometry.row_bits));
  }
  if (geometry.row_bits > 0 && count != need) {
    throw UserError("IMAGE", fmt::format("{} images are too many; with --row-bits {} are taken", count, need));
  }
}

// Depth images of the recorded images; where there are several, each is written into the folder.
DepthRun depth_of_files(const DepthOptions& options, OutputFolder& folder) {
  ImageSequence images(options.images, channel_of(options.channel));
  const DepthGeometry& geometry = options.setup.geometry;
  if (geometry.row_bits > 0) {
    return depth_of_both_axes(options.setup, images);
  }
  const bool several = images.count() > static_cast<std::size_t>(2 * geometry.bits);
  return depth_of_images(options.setup, images, [&](std::size_t pair, const FloatImage& depth) {
    if (several) {
      const std::string name = fmt::format("depth_{:04}.tiff", pair);
      folder.append(name, encode_float_tiff(name, depth));
    }
  });
}

// How far the points lie from those of the file.
CloudComparison compare_with_file(const DepthOptions& options, const DepthRun& run) {
  constexpr double kWithin = 1;  // mm
  std::vector<Point3f> theirs = read_ply(options.compare);
  if (options.compare_opengl) {
    for (Point3f& point : theirs) {
      point = {point.x, -point.y, -point.z};
    }
  }
  return compare_clouds(points_of(*run.triangulation, run.depth), theirs, kWithin);
}

void run_depth(const DepthOptions& options) {
  check_options(options);
  OutputFolder folder(options.out);
  const DepthRun run = options.device.empty() ? depth_of_files(options, folder)
                                              : depth_of_device(options.setup, options.device, options.count);
  DepthReport report{.setup = options.setup,
                     .device = options.device,
                     .images = options.images.size(),
                     .cloud = options.compare,
                     .comparison = {},
                     .plane = {}};
  if (!options.compare.empty()) {
    report.comparison = compare_with_file(options, run);
  }
  if (options.plane) {
    report.plane = fit_plane(*run.triangulation, run.depth);
  }
  write_depth(run, report, folder);
  folder.commit();
  fmt::print("{}", depth_text(run, report, folder.name()));
}

}  // namespace

void add_depth_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "depth", "Depth images of recorded Gray-code images, pos0 neg0 pos1 neg1 ..., or of a board that decodes");
  const auto options = std::make_shared<DepthOptions>();
  DepthGeometry& geometry = options->setup.geometry;
  ScannerSettings& scanner = options->setup.scanner;
  const CLI::Range positive(std::numeric_limits<double>::min(), 1e6, "a number greater than 0");
  command->add_option("--rig", geometry.rig, "Geometry: a built-in rig or a YAML file")->type_name("RIG");
  command
      ->add_option("--calibration", geometry.calibration,
                   "Geometry: OpenCV YAML with cam_K, cam_kc, pro_K, pro_kc, R, T")
      ->type_name("FILE.yaml");
  command->add_option("--bits", geometry.bits, "Pairs of patterns in a cycle; with --row-bits, of the column code")
      ->check(CLI::Range(1, GrayDecoder::kMaxBits))
      ->type_name("M")
      ->required();
  command
      ->add_option("--row-bits", geometry.row_bits,
                   "Both axes: so many pairs of the projector rows' code follow those of its columns")
      ->check(CLI::Range(1, GrayDecoder::kMaxBits))
      ->type_name("N");
  command->add_option("--threshold", scanner.threshold, "Differences of a pair up to this are ambiguous")
      ->check(CLI::Range(0, 255))
      ->type_name("T")
      ->capture_default_str();
  command->add_flag("--median", scanner.median, "3 x 3 median of the code image");
  command->add_flag("--strict", scanner.strict, "No depth where even one pair is ambiguous (default: two)");
  command->add_option("--channel", options->channel, "What to take of colour images")
      ->check(CLI::IsMember(channel_names()));
  command
      ->add_option("--lines", geometry.lines,
                   "Calibration: projector columns that the 2^M codes cover (default: 2^M, a code a column)")
      ->check(positive)
      ->type_name("H");
  command->add_option("--row-lines", geometry.row_lines, "Likewise rows and 2^N")->check(positive)->type_name("H");
  command->add_option("--min-z", geometry.limits.min_z_mm, "Smallest depth in mm")
      ->type_name("MM")
      ->capture_default_str();
  command->add_option("--max-z", geometry.limits.max_z_mm, "Greatest depth in mm (default: none)")->type_name("MM");
  command
      ->add_option("--max-z-per-line", geometry.limits.max_z_per_line_mm,
                   "No depth where a projector line is worth more (default: the rig's; none for a calibration)")
      ->check(positive)
      ->type_name("MM");
  command
      ->add_option("--max-residual", geometry.max_residual_px,
                   "Both axes: no depth where ray and codes are further apart in the projector image")
      ->check(positive)
      ->type_name("PX")
      ->capture_default_str();
  command
      ->add_option("--background", options->setup.background,
                   "Depth image of what does not move: moved.csv, moved.tiff")
      ->type_name("FILE.tiff");
  command->add_option("--min-difference", scanner.min_difference_mm, "From the background, for what counts as moved")
      ->check(CLI::NonNegativeNumber)
      ->type_name("MM")
      ->capture_default_str();
  command
      ->add_option("--max-change", scanner.steady.most_change_mm,
                   "Of depth from one depth image to the next, for what counts as moved [any]")
      ->check(CLI::NonNegativeNumber)
      ->type_name("MM");
  command
      ->add_option("--min-neighbours", scanner.steady.least_neighbours,
                   "Of the 8 pixels around, moved and no further off in z than --max-change, for what counts as moved")
      ->check(CLI::Range(0, 8))
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--compare", options->compare, "Say how far the points lie from those of this cloud")
      ->type_name("FILE.ply");
  command->add_flag("--compare-opengl", options->compare_opengl, "The cloud's y and z have the other sign");
  command->add_flag("--plane", options->plane, "Fit a plane to the newest depth image and say how flat it is");
  command
      ->add_option("--device", options->device,
                   "In place of images, a board that decodes: ring:NAME, file:PATH; until it ends, --count or Ctrl-C")
      ->type_name("URI");
  command->add_option("--count", options->count, "Device: so many code images")->check(CLI::PositiveNumber);
  command->add_option("--out", options->out, "Folder for the results")->type_name("DIR")->required();
  command->add_option("IMAGE", options->images, "8-bit images of one size")->type_name("FILE");
  command->callback([options] { run_depth(*options); });
}

}  // namespace selfproj
