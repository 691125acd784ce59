#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
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
#include "host/cli/progress.h"
#include "host/files/numbers.h"
#include "host/files/output_folder.h"
#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "host/images/image_sequence.h"
#include "host/report/depth_output.h"
#include "host/structured_light/cloud_axes.h"
#include "host/structured_light/depth_run.h"
#include "host/structured_light/plane_fit.h"
#include "selfproj/files/user_error.h"
#include "selfproj/images/float_image.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/model/packet.h"
#include "selfproj/structured_light/point_cloud.h"

namespace selfproj::app {
namespace {

struct DepthOptions {
  DepthOptions() { setup.scanner.median = false; }

  structured_light::DepthSetup setup;
  images::PixelOptions pixels;
  std::string compare;
  structured_light::CloudAxes compare_axes;  // of that cloud
  bool plane = false;
  bool unchecked = false;
  std::string plane_region;
  std::string out;
  ReceiveOptions receive;
  std::size_t save = 0;
  std::vector<std::string> images;
};

void check_options(const DepthOptions& options) {
  const structured_light::DepthGeometry& geometry = options.setup.geometry;
  const structured_light::ScannerSettings& scanner = options.setup.scanner;
  if (geometry.rig.empty() == geometry.calibration.empty()) {
    throw UserError("--rig, --calibration", "exactly one of them is needed");
  }
  if (geometry.row_lines > 0 && geometry.row_bits == 0) {
    throw UserError("--row-lines", "goes only with --row-bits");
  }
  if (geometry.row_bits > 0 && (scanner.median || !options.setup.background.empty())) {
    throw UserError("--row-bits", "measures once with both axes; --median and --background go only with one axis");
  }
  if (!(geometry.limits.min_z_mm < geometry.limits.max_z_mm)) {
    throw UserError("--min-z", fmt::format("is {}, --max-z {}; it must be less", geometry.limits.min_z_mm,
                                           geometry.limits.max_z_mm));
  }
  if (!options.compare_axes.as_they_are() && options.compare.empty()) {
    throw UserError(options.compare_axes.opengl ? "--compare-opengl" : "--compare-exchange-xy", "is for --compare");
  }
  if (scanner.strict && scanner.median) {
    throw UserError("--strict", "cannot be combined with --median, which fills what --strict leaves out");
  }
  if (!options.plane && !options.plane_region.empty()) {
    throw UserError("--plane-region", "is for --plane");
  }
  const bool device = !options.receive.device.empty();
  if (options.images.empty() != device) {
    throw UserError("IMAGE, --device", "exactly one of them is needed");
  }
  if (device && (geometry.row_bits > 0 || scanner.strict || scanner.median || !options.pixels.given().empty())) {
    throw UserError("--device",
                    "delivers codes that the board has decoded; --row-bits, --strict, --median, --channel, --shift go "
                    "only with images");
  }
}

// The files of the images. A folder may hold the white and the black image of a whole sequence after the codes; they
// are put into `extra`.
std::vector<std::string> files_of(const DepthOptions& options, std::vector<std::string>* extra = nullptr) {
  std::vector<std::string> files = images::image_arguments(options.images);
  const structured_light::DepthGeometry& geometry = options.setup.geometry;
  const auto need = 2 * static_cast<std::size_t>(geometry.bits + geometry.row_bits);
  if (files.size() == need + 2 && files.size() != options.images.size()) {
    if (extra != nullptr) {
      extra->assign(files.end() - 2, files.end());
    }
    files.resize(need);
  }
  const std::size_t count = files.size();
  if (count % 2 != 0) {
    throw UserError("IMAGE",
                    fmt::format("{} images are an odd number; each positive is followed by its negative", count));
  }
  if (count < need) {
    throw UserError("IMAGE", fmt::format("{} images are too few; {} are needed for {} bits", count, need,
                                         geometry.bits + geometry.row_bits));
  }
  if (geometry.row_bits > 0 && count != need) {
    throw UserError("IMAGE",
                    fmt::format("{} images are too many; with --row-bits, exactly {} are needed, or in a folder, with "
                                "white and black, {}",
                                count, need, need + 2));
  }
  return files;
}

// Four whole numbers with commas between them.
structured_light::PlaneRegion region_of_text(const std::string& text, const images::FloatImage& depth) {
  std::vector<int> numbers;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::optional<int> number = files::number_of_text<int>(text.substr(begin, end - begin));
    if (!number || *number < 0) {
      break;
    }
    numbers.push_back(*number);
    begin = end + 1;
  }
  const bool whole = numbers.size() == 4 && std::count(text.begin(), text.end(), ',') == 3;
  if (!whole || numbers[2] == 0 || numbers[3] == 0) {
    throw UserError("--plane-region", fmt::format("'{}' is not ROW,COLUMN,ROWS,COLUMNS, four whole numbers", text));
  }
  if (numbers[2] > depth.rows - numbers[0] || numbers[3] > depth.columns - numbers[1]) {
    throw UserError("--plane-region", fmt::format("{} reaches beyond the depth image of {}", text,
                                                  images::size_text(depth.rows, depth.columns)));
  }
  return {numbers[0], numbers[1], numbers[2], numbers[3]};
}

void append_depth(files::OutputFolder& folder, const char* what, std::size_t pair, const images::FloatImage& map) {
  const std::string name = fmt::format("{}_{:04}.tiff", what, pair);
  folder.append(name, images::encode_float_tiff(name, map));
}

// Computes the depth images of the recorded images. If there are several, each is written into the folder.
structured_light::DepthRun depth_of_files(const DepthOptions& options, files::OutputFolder& folder) {
  std::vector<std::string> extra;
  images::ImageSequence images(files_of(options, &extra), options.pixels.rule());
  if (!extra.empty()) {
    images::ImageSequence last(extra, options.pixels.rule());
    const images::Image white = last.read(0);
    cli::refuse_contradiction(
        fmt::format("{}, {}", extra[0], extra[1]),
        structured_light::SequenceCheck::is_white_and_black(white.view(), last.read(1).view())
            ? ""
            : "the last two of the folder's images are not white and black, which follow the codes",
        options.unchecked);
  }
  const structured_light::DepthGeometry& geometry = options.setup.geometry;
  cli::Progress progress("image", images.count());
  const auto done = [&](std::size_t count, const std::string& note) { progress.update(count, note); };
  if (geometry.row_bits > 0) {
    return structured_light::depth_of_both_axes(options.setup, images, done);
  }
  const bool several = images.count() > static_cast<std::size_t>(2 * geometry.bits);
  const auto take = [&](std::size_t pair, const images::FloatImage& depth) {
    if (several) {
      append_depth(folder, "depth", pair, depth);
    }
  };
  return structured_light::depth_of_images(options.setup, images, take, done);
}

// Code images of a board, or images of a board or camera that are decoded here. The first depth images are written into
// the folder, as many as --save says.
structured_light::DepthRun depth_of_device(const DepthOptions& options, Receiver& receiver,
                                           files::OutputFolder& folder) {
  const structured_light::DepthSetup& setup = options.setup;
  structured_light::DepthStream stream(setup, options.receive.device);
  receiver.open({.board = {.code_bits = setup.geometry.bits, .code_threshold = setup.scanner.threshold}});
  const auto receive = [&](const model::PacketView& packet) -> std::uint64_t {
    if (stream.add(packet) && stream.depth_images() <= options.save) {
      append_depth(folder, "depth", stream.pair(), stream.depth());
    }
    return stream.depth_images();
  };
  const auto status = [&] {
    const structured_light::Foreground* const moved = stream.moved();
    return fmt::format("incomplete images {}{}", stream.incomplete(),
                       moved == nullptr ? ""
                                        : fmt::format("; {} pixels moved, at {:.1f}, {:.1f}, {:.1f} mm", moved->pixels,
                                                      moved->x, moved->y, moved->z));
  };
  receiver.run({receive, status});
  return stream.result(receiver.counters());
}

// How far the points lie from those of the file, and a doubt where other axes fit much better.
structured_light::CloudComparison compare_with_file(const DepthOptions& options, const structured_light::DepthRun& run,
                                                    std::vector<std::string>& doubts) {
  constexpr double kWithin = 1;  // mm
  std::vector<structured_light::Point3f> theirs = structured_light::read_ply(options.compare);
  const std::vector<structured_light::Point3f> ours = report::points_of(*run.triangulation, run.depth);
  if (options.compare_axes.as_they_are() && !ours.empty() && !theirs.empty()) {
    const std::string doubt = doubt_about_axes(structured_light::NearestPoint(ours), theirs, "ours", "--compare-");
    cli::note_doubt(options.compare, doubt);
    if (!doubt.empty()) {
      doubts.push_back(options.compare + ": " + doubt);
    }
  }
  for (structured_light::Point3f& point : theirs) {
    point = options.compare_axes.of(point);
  }
  return structured_light::compare_clouds(ours, theirs, kWithin);
}

void run_depth(const DepthOptions& options) {
  check_options(options);
  files::OutputFolder folder(options.out);
  std::optional<Receiver> receiver;
  if (!options.receive.device.empty()) {
    receiver.emplace(options.receive);
  }
  const structured_light::DepthRun run =
      receiver ? depth_of_device(options, *receiver, folder) : depth_of_files(options, folder);
  const std::size_t came = receiver ? 0 : files_of(options).size();
  if (receiver) {
    if (options.receive.check && !options.unchecked && !run.contradiction.empty()) {
      throw CheckFailed(fmt::format("--check: {}", run.contradiction));
    }
    cli::note_doubt(options.receive.device, run.contradiction);
  } else {
    const std::size_t need =
        2 * static_cast<std::size_t>(options.setup.geometry.bits + options.setup.geometry.row_bits);
    cli::refuse_contradiction(came == need
                                  ? "IMAGE"
                                  : fmt::format("IMAGE ({} came; a code of {} bits has {}, and more show it again)",
                                                came, options.setup.geometry.bits, need),
                              run.contradiction, options.unchecked);
  }
  if (run.contradiction.empty()) {
    cli::note_doubt(receiver ? options.receive.device : "IMAGE", run.doubt);
  }
  report::DepthReport report{.setup = options.setup,
                             .device = options.receive.device,
                             .images = came,
                             .cloud = options.compare,
                             .axes = options.compare_axes,
                             .comparison = {},
                             .plane = {},
                             .doubts = {}};
  if (const std::string& doubt = run.contradiction.empty() ? run.doubt : run.contradiction; !doubt.empty()) {
    report.doubts.push_back(doubt);
  }
  if (!options.compare.empty()) {
    report.comparison = compare_with_file(options, run, report.doubts);
  }
  if (options.plane) {
    const images::FloatImage& depth = run.depth;
    report.plane =
        options.plane_region.empty()
            ? structured_light::fit_plane(*run.triangulation, depth)
            : structured_light::fit_plane(*run.triangulation, depth, region_of_text(options.plane_region, depth));
  }
  const report::ReportPicture picture = report::write_depth(run, report, folder);
  folder.append("report.html", report::depth_page(run, report, picture));
  folder.commit();
  fmt::print("{}", report::depth_text(run, report, folder.name()));
  if (receiver) {
    receiver->check(run.device->incomplete);
  }
}

}  // namespace

void add_depth_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app,
      {.name = "depth",
       .purpose = "Computes depth images from Gray-code images, or from a board that decodes them.",
       .details =
           "The images are the positive and the negative of each bit in turn, most significant bit first: pos0 "
           "neg0 pos1 neg1 ... From pair M on, every pair completes a depth image. With --row-bits the pairs of "
           "the projector's columns come first, then those of its rows, and all of them give one depth "
           "image.\n\n"
           "The output folder gets depth.tiff (z in mm, NaN where there is none) and pictures of the newest "
           "depth image, cloud.ply, shares.csv (why pixels have no depth), summary.json, report.html, "
           "depth_KKKK.tiff of each pair K where there are several, and with --background moved.csv and moved.tiff.",
       .examples = R"(
# Render a scene under 8-bit Gray codes, and compute its depth image.
selfproj-sim scene render desk --count 16 --out codes
selfproj depth --rig scanner --bits 8 --median --out depth codes/frame_*.png

# Follow what moves before a known background, on a board (needs hardware)
selfproj depth --rig scanner --bits 8 --device ring:line1 \
  --background depth/depth.tiff --out moved
)"});
  const auto options = std::make_shared<DepthOptions>();
  structured_light::DepthGeometry& geometry = options->setup.geometry;
  structured_light::ScannerSettings& scanner = options->setup.scanner;
  cli::begin_group(*command, "Geometry");
  add_geometry_options(*command, geometry);
  command
      ->add_option("--lines", geometry.lines,
                   "Projector columns that the 2^M codes cover; with --rig and one axis, projector lines. Of the first "
                   "8 pairs of a code of 10 bits that has a line for each code, 1024.")
      ->transform(cli::number_above_zero())
      ->type_name("L")
      ->default_str("2^M, one for each code; with --rig and one axis all, where they are more");
  command->add_option("--row-lines", geometry.row_lines, "With --row-bits: projector rows that the 2^N codes cover.")
      ->transform(cli::number_above_zero())
      ->type_name("N")
      ->default_str("2^N, one row for each code");
  cli::begin_group(*command, "Decoding");
  command
      ->add_option(
          "--bits", geometry.bits,
          "Bits of the code, which are pairs of images. With --rig they divide all of the projector's lines, as those "
          "of `selfproj pattern gray --rig RIG --bits M` do; the first pairs of a longer code may need --lines.")
      ->transform(cli::whole_number(1, model::GrayDecoder::kMaxBits))
      ->type_name("M")
      ->required();
  command->add_option("--row-bits", geometry.row_bits, "Bits of a second code, along the projector's rows.")
      ->transform(cli::whole_number(1, model::GrayDecoder::kMaxBits))
      ->type_name("N");
  add_threshold_option(*command, scanner.threshold, std::to_string(scanner.threshold));
  command->add_flag("--median", scanner.median, "Apply a 3 x 3 median to the code image; with one axis only.");
  add_strict_option(*command, scanner);
  cli::add_pixel_options(*command, options->pixels);
  cli::add_unchecked_option(*command, options->unchecked);
  add_limit_options(*command, geometry);
  cli::begin_group(*command, "What moved");
  command
      ->add_option("--background", options->setup.background,
                   "Depth image of the still background. Pixels that differ from it have moved.")
      ->type_name("FILE.tiff");
  command
      ->add_option("--min-difference", scanner.min_difference_mm,
                   "A pixel has moved only if it differs from the background by more than this many mm.")
      ->transform(cli::real_number(0, 1e6))
      ->type_name("MM")
      ->capture_default_str();
  command
      ->add_option("--max-change", scanner.steady.max_change_mm,
                   "A pixel has moved only if its depth changed by at most this many mm since the last depth image.")
      ->transform(cli::real_number(0, 1e6))
      ->type_name("MM")
      ->default_str("any");
  command
      ->add_option("--min-neighbours", scanner.steady.min_neighbours,
                   "A pixel has moved only if at least this many of the 8 pixels around it have moved too and are as "
                   "close in z as --max-change says.")
      ->transform(cli::whole_number(0, 8))
      ->type_name("N")
      ->capture_default_str();
  cli::begin_group(*command, "Evaluation");
  command->add_option("--compare", options->compare, "Print how far the points lie from those of this cloud.")
      ->type_name("FILE.ply");
  command->add_flag("--compare-exchange-xy", options->compare_axes.exchange_xy, "Exchange x and y of that cloud.");
  command->add_flag("--compare-opengl", options->compare_axes.opengl, "y and z of that cloud have the opposite sign.");
  command->add_flag("--plane", options->plane,
                    "Fit the plane on which most points of the newest depth image lie, and print how flat it is.");
  command
      ->add_option("--plane-region", options->plane_region,
                   "Part of the image that --plane takes: its first row and column from 0, and how many of them.")
      ->type_name("R,C,ROWS,COLUMNS")
      ->default_str("the whole image");
  CLI::Option* const device =
      add_receive_options(*command, options->receive, "depth images", kImagesOfPatterns, DeviceIs::instead_of_images);
  cli::begin_group(*command, "Input and output");
  command
      ->add_option("--save", options->save,
                   "Write depth_KKKK.tiff of the first N depth images of the device as well; later ones only count.")
      ->transform(cli::whole_number(1))
      ->type_name("N")
      ->default_str("none")
      ->needs(device);
  command->add_option("--out", options->out, "Folder for the results.")->type_name("DIR")->required();
  cli::add_files(
      *command, "IMAGE", options->images,
      "8-bit images of one size, or one folder of them, in natural order and nothing else in it. The folder may "
      "hold white and black after the codes. These or --device are needed.");
  command->callback([options] { run_depth(*options); });
}

}  // namespace selfproj::app
