#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include "host/app/commands.h"
#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/files/output_folder.h"
#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "host/light_section/line_finder.h"
#include "host/light_section/pattern.h"
#include "host/light_section/scan.h"
#include "host/structured_light/self_reference.h"
#include "selfproj/files/user_error.h"
#include "selfproj/images/float_image.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/light_section/reference_file.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/gray_sequence.h"

namespace selfproj::app {
namespace {

namespace fs = std::filesystem;

struct PatternOptions {
  std::string rig = "light-section";
  std::string out;
  // Exactly one of these is given.
  std::string reference;
  std::string scan;
  std::optional<double> line;
  bool sweep = false;
  // Further options.
  std::string residual;
  std::string assume;
  std::optional<int> frame;
  std::optional<double> across_mm;
  int every = 1;
  images::PixelOptions pixels;
  cli::SelectOptions select;
  bool unchecked = false;
};

// Passes on the images one after another, each of the camera's size and bits.
void for_each_image(const rig::Rig& rig, const std::vector<std::string>& files, images::PixelRule rule,
                    const std::function<void(std::size_t index, const light_section::SensorView& image)>& take) {
  cli::Progress progress("image", files.size());
  rule.bits = rig.measure.bits();
  for (std::size_t i = 0; i < files.size(); ++i) {
    const images::SensorImage image = images::read_sensor_image(files[i], rule);
    const auto [rows, columns] = std::visit([](const auto& one) { return std::pair(one.rows, one.columns); }, image);
    const rig::RigRegion sent = rig.camera.sent();
    if ((rows != rig.camera.rows || columns != rig.camera.columns) && (rows != sent.rows || columns != sent.columns)) {
      throw UserError(files[i], fmt::format("has {} x {} pixels; the rig's camera has {} rows x {} columns", rows,
                                            columns, rig.camera.rows, rig.camera.columns));
    }
    take(i, light_section::view_of(image));
    progress.update(i + 1);
  }
}

light_section::ReferenceProfile scanned(const rig::Rig& rig, const PatternOptions& options) {
  const std::vector<std::string> files = images::files_of_folder(options.scan);
  const std::vector<int> lines = light_section::sweep_lines(rig, options.every);
  if (files.size() != lines.size()) {
    throw UserError(options.scan,
                    fmt::format("has {} images; a sweep of this rig with --every {} has {}, of the lines {} to {}",
                                files.size(), options.every, lines.size(), lines.front(), lines.back()));
  }
  light_section::LineScan scan(rig, options.every);
  light_section::SweepCheck check(rig);
  for_each_image(rig, files, options.pixels.rule(), [&](std::size_t i, const light_section::SensorView& image) {
    scan.add(lines[i], image);
    check.add(lines[i], image, files[i]);
  });
  cli::refuse_contradiction(options.scan, check.contradiction(), options.unchecked);
  return scan.reference();
}

light_section::ReferenceProfile with_residual_out(const rig::Rig& rig, const PatternOptions& options,
                                                  const light_section::ReferenceProfile& reference) {
  light_section::CentroidMean mean(rig);
  for_each_image(rig, images::files_of_folder(options.residual), options.pixels.rule(),
                 [&](std::size_t, const light_section::SensorView& image) { mean.add(image); });
  cli::refuse_contradiction(options.residual, mean.contradiction(), options.unchecked);
  return light_section::without_residual(rig, reference, mean.centroids());
}

void add_pattern(files::OutputFolder& folder, const images::FloatImage& pattern) {
  folder.append("pattern.tiff", images::encode_float_tiff(folder.name() + "/pattern.tiff", pattern));
  folder.append("pattern.png", light_section::encode_pattern_png(pattern));
}

// The curve of a part that lies so far across, in the direction of increasing columns. Beside it the curve goes on as
// high as it ends.
light_section::ReferenceCurve shifted(light_section::ReferenceCurve curve, double mm) {
  for (double& y : curve.y_mm) {
    y += mm;
  }
  const auto at = mm < 0 ? curve.y_mm.size() : 0;
  const double y = mm < 0 ? curve.y_mm.back() : curve.y_mm.front();
  const double z = mm < 0 ? curve.z_mm.back() : curve.z_mm.front();
  curve.y_mm.insert(curve.y_mm.begin() + static_cast<std::ptrdiff_t>(at), y - mm);
  curve.z_mm.insert(curve.z_mm.begin() + static_cast<std::ptrdiff_t>(at), z);
  return curve;
}

// The shape of the part, and the pattern for it; a laser has none.
light_section::ReferenceProfile reference_of(const rig::Rig& rig, const PatternOptions& options,
                                             images::FloatImage& pattern) {
  std::error_code error;
  const bool finished = fs::is_directory(options.reference, error);  // a reference folder
  if (finished && options.residual.empty() && !options.across_mm) {
    throw UserError("--reference", options.reference +
                                       " is a finished reference; give --residual to take out its "
                                       "residual, or --across for a part that lies elsewhere");
  }
  if (finished && !options.across_mm) {
    if (!rig.light_plane) {
      pattern = light_section::load_pattern(rig, options.reference);
    }
    return light_section::load_reference(rig, options.reference);
  }
  if (options.reference.empty() && options.scan.empty()) {
    return light_section::reference_of_plane(rig);  // of a laser, which sees the part at its residual
  }
  light_section::ReferenceCurve curve;
  light_section::ReferenceProfile reference;
  if (finished || !options.scan.empty()) {
    reference = finished ? light_section::load_reference(rig, options.reference) : scanned(rig, options);
    curve = light_section::curve_of_reference(rig, reference);
  } else {
    curve = light_section::load_curve(rig, options.reference, options.frame);
  }
  if (options.across_mm) {
    const light_section::MiddleRow middle(rig);
    const double left = rig.plane_z_mm * middle.tan_beta(0) - *options.across_mm;
    const double right = rig.plane_z_mm * middle.tan_beta(rig.camera.columns - 1) - *options.across_mm;
    if (std::ranges::none_of(curve.y_mm, [&](double y) { return y > left && y < right; })) {
      throw UserError("--across", fmt::format("is {} mm: there the camera does not see the part", *options.across_mm));
    }
    curve = shifted(std::move(curve), *options.across_mm);
  }
  if (options.across_mm || options.scan.empty()) {
    reference = light_section::reference_of_curve(rig, curve);
  }
  if (!rig.light_plane) {
    pattern = light_section::draw_pattern(rig, light_section::pattern_of_curve(rig, curve));
  }
  return reference;
}

void make_reference(const rig::Rig& rig, const PatternOptions& options) {
  files::OutputFolder folder(options.out);
  images::FloatImage pattern;
  light_section::ReferenceProfile reference = reference_of(rig, options, pattern);
  const std::string& source = !options.scan.empty()        ? options.scan
                              : !options.reference.empty() ? options.reference
                                                           : options.rig;
  if (reference.valid_columns() == 0) {
    throw UserError(source, !options.scan.empty() ? "no camera column sees the line cross its middle row"
                            : rig.light_plane     ? "no camera column sees the laser on the part"
                                                  : "no camera column sees the part in the projector's light");
  }
  const int before = reference.valid_columns();
  if (!options.residual.empty()) {
    reference = with_residual_out(rig, options, reference);
    if (reference.valid_columns() == 0) {
      throw UserError(options.residual, "no column of the reference sees the line");
    }
  }
  folder.append("reference.csv", light_section::reference_csv(rig, reference));
  if (!rig.light_plane) {
    add_pattern(folder, pattern);
  }
  folder.append("preview.png", light_section::draw_preview(rig, pattern, reference));
  folder.commit();
  fmt::print("{}: reference in {} of {} columns\n", options.out, reference.valid_columns(), reference.columns());
  if (!options.residual.empty() && 4 * reference.valid_columns() < 3 * before) {
    cli::note_doubt(
        options.residual,
        fmt::format("in {} of {} columns of the reference no line was found, and nothing is compared there: "
                    "no light above the threshold, too much of it, or a line outside of the rows that count",
                    before - reference.valid_columns(), before));
  }
}

void make_line(const rig::Rig& rig, const PatternOptions& options) {
  if (!std::isfinite(*options.line) || *options.line < 0 || *options.line > rig.projector.lines - 1) {
    throw UserError("--line",
                    fmt::format("is {}; the projector has lines 0 to {}", *options.line, rig.projector.lines - 1));
  }
  files::OutputFolder folder(options.out);
  const images::FloatImage pattern = light_section::draw_straight_line(rig, *options.line);
  add_pattern(folder, pattern);
  folder.append("preview.png", light_section::draw_preview(rig, pattern, {}));
  folder.commit();
}

void make_sweep(const rig::Rig& rig, const PatternOptions& options) {
  files::OutputFolder folder(options.out);
  const std::vector<int> lines = light_section::sweep_lines(rig, options.every);
  cli::Progress progress("pattern", lines.size());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    folder.append(fmt::format("line_{:05}.png", lines[i]),
                  light_section::encode_pattern_png(light_section::draw_straight_line(rig, lines[i])));
    progress.update(i + 1);
  }
  folder.commit();
}

void run_pattern(const PatternOptions& options) {
  rig::Rig rig = rig::load_any_rig(options.rig);
  if (rig.light_plane && (options.line || options.sweep || !options.scan.empty())) {
    throw UserError("--line, --sweep, --scan", "are for a projector, and the rig has a laser");
  }
  if (rig.light_plane && options.across_mm) {
    throw UserError("--across", "is for a projector: the light of a laser is the same wherever a part lies");
  }
  if (!rig.light_plane && options.reference.empty() && options.scan.empty() && !options.line && !options.sweep) {
    throw UserError("--residual", "alone is for a laser; give --reference or --scan");
  }
  if (rig.light_plane) {
    if (!options.assume.empty()) {
      rig::assume(rig, options.assume, "--assume");
    }
    rig::expect_measured(rig, options.rig, rig::Millimetres::of_section);
  }
  model::Measure measure = rig.measure.of_board();
  options.select.apply(measure);
  rig.measure.apply(measure);
  if (!rig.light_plane && light_section::sweep_lines(rig, options.every).empty()) {
    throw UserError(options.rig, fmt::format("measure.line_width_px is {}, too wide for the {} lines of the projector",
                                             rig.measure.line_width_px, rig.projector.lines));
  }
  if (options.line) {
    make_line(rig, options);
  } else if (options.sweep) {
    make_sweep(rig, options);
  } else {
    make_reference(rig, options);
  }
}

struct GrayOptions {
  std::string projector;
  std::string rig;
  int bits = 0;
  std::string out;
};

// The code of the projector's lines alone.
void make_gray_of_lines(const GrayOptions& options) {
  const rig::Rig rig = rig::load_rig(options.rig);
  files::OutputFolder folder(options.out);
  for (int i = 0; i < 2 * options.bits; ++i) {
    const images::FloatImage light = structured_light::gray_pattern(rig, options.bits, rig.projector.lines, i);
    images::Image image{light.rows, light.columns, std::vector<std::uint8_t>(light.values.size())};
    std::ranges::transform(light.values, image.pixels.begin(), [](float value) { return value > 0 ? 255 : 0; });
    folder.append(fmt::format("pattern_{:02}.png", i), images::encode_png(image));
  }
  folder.commit();
  fmt::print(
      "{}: {} patterns of {}: {} bits for the {} lines; `selfproj depth --rig {} --bits {}` takes their images\n",
      options.out, 2 * options.bits, images::size_text(rig.projector.lines, rig.projector.columns), options.bits,
      rig.projector.lines, options.rig, options.bits);
}

void make_gray(const GrayOptions& options) {
  if (options.bits > 0) {
    make_gray_of_lines(options);
    return;
  }
  if (options.projector.empty() == options.rig.empty()) {
    throw UserError("--projector, --rig", "exactly one of them is needed");
  }
  images::FrameSize size;
  if (options.rig.empty()) {
    size = images::size_of_text("--projector", options.projector, structured_light::GraySequence::kMaxSide);
  } else {
    const rig::RigProjector projector = rig::load_rig(options.rig).projector;
    size = {projector.lines, projector.columns};
  }
  const structured_light::GraySequence sequence(size.columns, size.rows);
  files::OutputFolder folder(options.out);
  cli::Progress progress("pattern", static_cast<std::size_t>(sequence.count()));
  const int digits = sequence.count() > 100 ? 3 : 2;
  for (int i = 0; i < sequence.count(); ++i) {
    folder.append(fmt::format("pattern_{:0{}}.png", i, digits),
                  images::encode_png({sequence.rows(), sequence.columns(), sequence.image(i)}));
    progress.update(static_cast<std::size_t>(i) + 1);
  }
  folder.commit();
  fmt::print("{}: {} patterns of {}: {} bits for columns, {} for rows, white, black\n", options.out, sequence.count(),
             options.projector.empty() ? images::size_text(size.rows, size.columns) : options.projector,
             sequence.column_bits(), sequence.row_bits());
}

CLI::App* add_gray(CLI::App& pattern) {
  CLI::App* command = cli::add_command(
      pattern,
      {.name = "gray",
       .purpose = "Writes the Gray-code patterns of both projector axes, or of its lines alone.",
       .details = "The sequence is: each bit of the column code, most significant first, as a positive and its "
                  "negative; the same for the row code; white; black. Capture one image of each, in this order. "
                  "`selfproj calibrate`, `selfproj pattern stripes --gray-code` and `selfproj depth --row-bits` take "
                  "such captures. With --bits only the code of a rig's lines is written, for `selfproj depth --rig`.",
       .examples = R"(
# The patterns of a projector of 1024 x 768 pixels: 42 images.
selfproj pattern gray --projector 1024x768 --out patterns
# 16 patterns: 256 codes over the lines of a rig.
selfproj pattern gray --rig scanner --bits 8 --out lines
)"});
  const auto options = std::make_shared<GrayOptions>();
  command
      ->add_option("--projector", options->projector,
                   "Columns and rows of the projector in pixels. This or --rig is needed.")
      ->type_name("WxH");
  auto* rig =
      command
          ->add_option("--rig", options->rig, "Built-in rig or YAML file with the projector. Its lines are the rows.")
          ->type_name("RIG");
  command
      ->add_option("--bits", options->bits,
                   "Only the code of the rig's lines, of this many bits: 2^M codes share the lines, or each line has a "
                   "code of its own where there are fewer.")
      ->type_name("M")
      ->transform(cli::whole_number(1, model::GrayDecoder::kMaxBits))
      ->needs(rig)
      ->excludes("--projector");
  command->add_option("--out", options->out, "Folder for pattern_00.png and so on.")->type_name("DIR")->required();
  command->callback([options] { make_gray(*options); });
  return command;
}

void add_source_options(CLI::App& command, PatternOptions& options) {
  cli::begin_group(command, "Source of the pattern (one of them is required)");
  auto* reference =
      command
          .add_option("--reference", options.reference,
                      "Shape of the part: a CSV table y_mm,z_mm of its section, or a TIFF of heights in mm "
                      "with one column for each camera column. With --residual or --across: a folder that "
                      "this command wrote.")
          ->type_name("FILE|DIR");
  auto* scan = command
                   .add_option("--scan", options.scan,
                               "Folder of the camera images under the lines of --sweep, numbered in their order.")
                   ->type_name("DIR");
  auto* unchecked = cli::add_unchecked_option(command, options.unchecked);
  auto* line =
      command
          .add_option("--line", options.line, "Without a part: a straight line at this projector line, counted from 0.")
          ->transform(cli::real_number(0, 1e6))
          ->type_name("LINE");
  auto* sweep = command.add_flag("--sweep", options.sweep, "Writes the straight lines with which a part is scanned.");
  reference->excludes(scan)->excludes(line)->excludes(sweep);
  scan->excludes(line)->excludes(sweep);
  unchecked->excludes(line)->excludes(sweep);
  line->excludes(sweep);
  cli::begin_group(command, "Refinement");
  auto* across =
      command
          .add_option("--across", options.across_mm,
                      "Make pattern and reference for the same part where it lies so far across, in the direction of "
                      "increasing columns.")
          ->transform(cli::real_number(-1000, 1000))
          ->type_name("MM")
          ->excludes(line)
          ->excludes(sweep);
  command
      .add_option(
          "--residual", options.residual,
          "Folder of camera images of the part under its own pattern. The pattern is corrected by the mean distance "
          "of the line from the middle row, column by column. With a laser: images of good parts under its line, whose "
          "mean is the reference; nothing else is needed then.")
      ->type_name("DIR")
      ->excludes(line)
      ->excludes(sweep)
      ->excludes(across);
  command.add_option("--frame", options.frame, "Frame of the TIFF of heights to use, from 1.")
      ->transform(cli::whole_number(1, 1'000'000))
      ->type_name("N")
      ->default_str("the median of all frames")
      ->needs(reference);
  command.add_option("--every", options.every, "Distance between two lines of a sweep, in projector lines.")
      ->transform(cli::whole_number(1, 64))
      ->type_name("N")
      ->capture_default_str()
      ->excludes(reference)
      ->excludes(line);
  cli::add_pixel_options(command, options.pixels);
  cli::begin_group(command, "Measuring, in images of --scan and --residual");
  cli::add_select_options(command, options.select, cli::kRigsSelect);
}

}  // namespace

void add_pattern_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app,
      {.name = "pattern",
       .purpose = "Computes the pattern that the camera sees as a straight line on a good part.",
       .details = "The shape of the part is known (--reference) or scanned. To scan it, --sweep writes straight lines "
                  "to project, and --scan takes the camera images of them. The output folder gets pattern.png and "
                  "pattern.tiff for the projector, preview.png, and reference.csv. `selfproj inspect --reference` "
                  "takes this folder. With a laser there is no pattern: the folder gets reference.csv and "
                  "preview.png.\n\n"
                  "The commands gray and stripes make patterns for structured light; chessboard draws a target for "
                  "calibration.",
       .examples = R"(
# The pattern for a part whose section is known: a roof 20 mm high on the plane at z = 1167 mm.
printf 'y_mm,z_mm\n-50,1167\n0,1147\n50,1167\n' > roof.csv
selfproj pattern --reference roof.csv --out roof

# The lines with which to scan a part.
selfproj pattern --sweep --every 4 --out lines

# The pattern from the camera images of these lines on the part (needs your files)
selfproj pattern --scan captures --every 4 --out part
)"});
  auto options = std::make_shared<PatternOptions>();
  cli::begin_group(*command, "Rig and output");
  command->add_option("--rig", options->rig, "Built-in rig or YAML file of kind light-section.")
      ->type_name("RIG")
      ->capture_default_str();
  command
      ->add_option("--assume", options->assume,
                   "With a laser: values of the rig that are taken though no calibration measured them, with commas "
                   "between them: camera, light, belt.")
      ->type_name("NAME,...");
  command->add_option("--out", options->out, "Folder for the results. Required.")->type_name("DIR");
  add_source_options(*command, *options);
  const CLI::App* chessboard = add_chessboard_command(*command);
  const CLI::App* gray = add_gray(*command);
  const CLI::App* stripes = add_stripes_command(*command);
  // Options that are required without a subcommand. CLI11 would require them with a subcommand too.
  command->callback([=] {
    if (chessboard->parsed() || gray->parsed() || stripes->parsed()) {
      return;
    }
    if (options->out.empty()) {
      throw UserError("--out", "is required");
    }
    if (options->reference.empty() && options->scan.empty() && options->residual.empty() && !options->line &&
        !options->sweep) {
      throw UserError("--reference, --scan, --line, --sweep",
                      "one of them is required, or a command: chessboard, gray, stripes");
    }
    run_pattern(*options);
  });
}

}  // namespace selfproj::app
