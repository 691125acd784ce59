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
#include <vector>

#include "host/app/commands.h"
#include "host/app/scanner_run.h"
#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/files/output_folder.h"
#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "host/light_section/pattern.h"
#include "host/report/map_picture.h"
#include "host/structured_light/point_scan.h"
#include "host/structured_light/self_reference.h"
#include "host/structured_light/sequence_check.h"
#include "selfproj/files/user_error.h"
#include "selfproj/images/float_image.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/rig/calibration.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/gray_sequence.h"
#include "selfproj/structured_light/lens_triangulation.h"

namespace selfproj::app {
namespace {

constexpr double kLeastSeen = 0.05;  // of the projector's pixels; a small part before a black background shows more

struct StripesOptions {
  std::string rig = "scanner";
  std::string scan;
  bool sweep = false;
  bool gray_code = false;
  structured_light::Stripes stripes;
  bool reflected = false;
  images::PixelOptions pixels;
  bool unchecked = false;
  std::string out;
};

// Returns the number of patterns.
int make_sweep(const rig::Rig& rig, files::OutputFolder& folder) {
  const int count = structured_light::LinePointScan(rig).count();
  cli::Progress progress("pattern", static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    folder.append(fmt::format("pattern_{:05}.png", i),
                  light_section::encode_pattern_png(structured_light::scan_pattern(rig, i)));
    progress.update(static_cast<std::size_t>(i) + 1);
  }
  return count;
}

// `look` sees each image as well.
template <class Scan, class Look>
void add_folder(const rig::Rig& rig, const StripesOptions& options, const std::vector<std::string>& files, Scan& scan,
                const Look& look) {
  cli::Progress progress("image", files.size());
  for (std::size_t i = 0; i < files.size(); ++i) {
    const images::Image image = images::read_image(files[i], options.pixels.rule());
    check_camera_size(rig, files[i], image);
    scan.add(image.view());
    look(i, image);
    progress.update(i + 1);
  }
}

// What the points contradict, as those of a scan that `depth` would measure.
std::string contradiction_of(const rig::Rig& rig, const structured_light::ProjectorPoints& points) {
  const structured_light::GraySequence sequence(rig.projector.columns, rig.projector.lines);
  const structured_light::LensTriangulation triangulation(
      rig::calibration_of(rig), {.rows = rig.camera.rows,
                                 .columns = rig.camera.columns,
                                 .bits = sequence.row_bits(),
                                 .row_bits = sequence.column_bits(),
                                 .limits = {.max_z_per_line_mm = rig.measure.max_z_per_line_mm},
                                 .rows_are_x = true});
  const auto words_of = [](const images::FloatImage& places) {
    std::vector<std::uint16_t> words(places.values.size());
    std::transform(places.values.begin(), places.values.end(), words.begin(), [](float place) {
      const auto code = static_cast<int>(std::lround(std::max(0.0F, place)));
      return static_cast<std::uint16_t>(std::isnan(place) ? 0 : code | model::GrayDecoder::kMeasurable);
    });
    return words;
  };
  const std::vector<std::uint16_t> lines = words_of(points.line);
  const std::vector<std::uint16_t> columns = words_of(points.column);
  std::vector<float> z(triangulation.pixels());
  std::vector<structured_light::PointState> states(triangulation.pixels());
  triangulation.depth_of_both(lines.data(), columns.data(), z.data(), states.data(), nullptr);
  return structured_light::contradiction_of(triangulation, lines.data(), structured_light::count_states(states));
}

structured_light::ProjectorPoints scanned(const rig::Rig& rig, const StripesOptions& options) {
  const std::vector<std::string> files = images::files_of_folder(options.scan);
  if (options.gray_code) {
    structured_light::GrayPointScan scan(rig);
    const auto all = static_cast<std::size_t>(scan.count());
    if (files.size() != all && files.size() + 2 != all) {
      throw UserError(options.scan, fmt::format("has {} images; the Gray codes of this rig's projector have {}, or {} "
                                                "without white and black",
                                                files.size(), all, all - 2));
    }
    // Columns, then lines.
    const structured_light::GraySequence sequence(rig.projector.columns, rig.projector.lines);
    const auto columns = static_cast<std::size_t>(sequence.first_of_rows());
    const auto codes = static_cast<std::size_t>(sequence.white());
    structured_light::SequenceCheck of_columns(rig.camera.rows, rig.camera.columns, sequence.column_bits());
    structured_light::SequenceCheck of_lines(rig.camera.rows, rig.camera.columns, sequence.row_bits());
    std::array<images::Image, 2> last;
    add_folder(rig, options, files, scan, [&](std::size_t i, const images::Image& image) {
      if (i < codes) {
        (i < columns ? of_columns : of_lines).add(static_cast<int>(i < columns ? i : i - columns), image.view());
      } else {
        last.at(i - codes) = image;
      }
    });
    std::string contradiction;
    if (files.size() == all && !structured_light::SequenceCheck::is_white_and_black(last[0].view(), last[1].view())) {
      contradiction = fmt::format("{} and {} are no white and black picture: do they follow the codes, white first?",
                                  files[all - 2], files[all - 1]);
    }
    if (contradiction.empty()) {
      contradiction = structured_light::contradiction_of(of_columns, files);
    }
    if (contradiction.empty()) {
      contradiction =
          structured_light::contradiction_of(of_lines, {files.begin() + sequence.first_of_rows(), files.end()});
    }
    cli::refuse_contradiction(options.scan, contradiction, options.unchecked);
    return scan.points();
  }
  structured_light::LinePointScan scan(rig);
  if (files.size() != static_cast<std::size_t>(scan.count())) {
    throw UserError(options.scan,
                    fmt::format("has {} images; a scan of this rig's projector has {}, one a line and one "
                                "a column",
                                files.size(), scan.count()));
  }
  add_folder(rig, options, files, scan, [](std::size_t /*i*/, const images::Image& /*image*/) {});
  return scan.points();
}

void run_stripes(const StripesOptions& options) {
  if (options.sweep == !options.scan.empty()) {
    throw UserError("--scan, --sweep", "exactly one of them is needed");
  }
  if (options.gray_code && options.sweep) {
    throw UserError("--gray-code", "goes only with --scan; `selfproj pattern gray` writes its patterns");
  }
  const rig::Rig rig = scanner_rig(options.rig);
  files::OutputFolder folder(options.out);
  if (options.sweep) {
    const int count = make_sweep(rig, folder);
    folder.commit();
    fmt::print("{} patterns → {}\n", count, options.out);
    return;
  }
  const structured_light::ProjectorPoints points = scanned(rig, options);
  cli::refuse_contradiction(options.scan, contradiction_of(rig, points), options.unchecked);
  structured_light::Stripes stripes = options.stripes;
  stripes.code = options.reflected ? structured_light::StripeCode::reflected : structured_light::StripeCode::cyclic;
  structured_light::SelfReference reference;
  try {
    reference = structured_light::make_self_reference(rig, points, stripes);
  } catch (const std::invalid_argument&) {
    throw UserError(options.scan, "no camera pixel sees both a line and a column of the scan");
  }
  const double seen = static_cast<double>(std::count(reference.seen.begin(), reference.seen.end(), 1)) /
                      static_cast<double>(reference.seen.size());
  if (seen < kLeastSeen) {
    cli::refuse_contradiction(
        options.scan,
        fmt::format("the camera sees {:.1f} % of the projector's pixels on the reference, and the patterns would be "
                    "invented elsewhere: is there enough light, and are these the images of the scan?",
                    100 * seen),
        options.unchecked);
  }
  structured_light::write_self_reference(rig, reference, folder);
  folder.append("preview.png",
                report::labelled_map_png(
                    reference.points.line, {report::ColourMap::sequential, 0, rig.projector.lines - 1.0, "line"},
                    {.row_mm = 1, .column_mm = 1, .unit = "px"}, "X_R: projector line seen by each camera pixel"));
  folder.commit();
  std::size_t measurable = 0;
  for (std::size_t i = 0; i < points.line.values.size(); ++i) {
    measurable += reference.measurable(i) ? 1 : 0;
  }
  fmt::print(
      "{}: {} bits, {} code; reference in {} of {} camera pixels; {:.1f} % of the projector's seen, the rest "
      "filled in\n",
      options.out, stripes.bits, options.reflected ? "reflected" : "cyclic", measurable, points.line.values.size(),
      100 * seen);
}

}  // namespace

CLI::App* add_stripes_command(CLI::App& pattern) {
  CLI::App* command = cli::add_command(
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
  cli::begin_group(*command, "Scan (one of --scan and --sweep is required)");
  command
      ->add_option("--scan", options->scan,
                   "Folder of the camera images under the patterns of the scan, numbered in their order.")
      ->type_name("DIR");
  command->add_flag("--sweep", options->sweep, "Only write the patterns of a scan: every line, then every column.");
  command->add_flag("--gray-code", options->gray_code,
                    "The images of --scan were taken under the patterns of `selfproj pattern gray`.");
  cli::add_pixel_options(*command, options->pixels);
  cli::add_unchecked_option(*command, options->unchecked);
  cli::begin_group(*command, "Stripes");
  command->add_option("--rig", options->rig, "Built-in rig or YAML file of kind scanner.")
      ->type_name("RIG")
      ->capture_default_str();
  command->add_option("--bits", options->stripes.bits, "Bits of the code, m. 2m patterns are written.")
      ->transform(cli::whole_number(1, structured_light::Stripes::kMaxBits))
      ->type_name("M")
      ->capture_default_str();
  command->add_option("--rows-per-code", options->stripes.width, "Width of a code in camera rows, a.")
      ->transform(cli::whole_number(1, structured_light::Stripes::kMaxWidth))
      ->type_name("A")
      ->capture_default_str();
  command->add_flag(
      "--reflected", options->reflected,
      "Use the reflected code as printed in the thesis. Without it the code is cyclic, so that a window of "
      "2^m codes has each of them once.");
  cli::begin_group(*command, "Output");
  command->add_option("--out", options->out, "Folder for the results.")->type_name("DIR")->required();
  command->callback([options] { run_stripes(*options); });
  return command;
}

}  // namespace selfproj::app
