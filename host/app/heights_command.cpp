#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "host/app/commands.h"
#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/files/json_text.h"
#include "host/files/output_folder.h"
#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "host/light_section/height_fit.h"
#include "host/light_section/line_finder.h"
#include "host/light_section/scan.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/rig/rig.h"

namespace selfproj::app {
namespace {

struct HeightsOptions {
  std::string rig = "light-section";
  std::string heights;
  std::string steps;
  light_section::HeightSettings settings;
  int every = 4;
  images::PixelOptions pixels;
  cli::SelectOptions select;
  bool unchecked = false;
  bool check = false;
  std::string assume;               // values that --check takes though they were never measured
  std::optional<double> within_mm;  // nothing: by the tolerances and the noise of the images
  std::string out;
  std::vector<std::string> folders;
};

light_section::HeightPosition read_position(const HeightsOptions& options, const rig::Rig& rig,
                                            const std::string& folder, const std::vector<int>& lines) {
  light_section::HeightPosition position{folder, 0, {}};
  const std::vector<std::string> files = images::files_of_folder(folder);
  if (!rig.light_plane && files.size() != lines.size()) {
    throw UserError(folder, fmt::format("has {} images; a sweep of this rig with --every {} has {}, of the lines {} to "
                                        "{}",
                                        files.size(), options.every, lines.size(), lines.front(), lines.back()));
  }
  light_section::LineFinder finder(rig);
  light_section::SweepCheck check(rig);
  images::PixelRule rule = options.pixels.rule();
  rule.bits = rig.measure.bits();
  for (std::size_t i = 0; i < files.size(); ++i) {
    const images::SensorImage image = images::read_sensor_image(files[i], rule);
    const light_section::SensorView view = light_section::view_of(image);
    const auto [rows, columns] = std::visit([](const auto& one) { return std::pair(one.rows, one.columns); }, view);
    if (rows != rig.camera.rows || columns != rig.camera.columns) {
      throw UserError(files[i], fmt::format("is {}; the rig's camera has {}", images::size_text(rows, columns),
                                            images::size_text(rig.camera.rows, rig.camera.columns)));
    }
    // A laser has but one line; its images only have to differ.
    light_section::add_sightings(finder, rig.light_plane ? static_cast<double>(i) : lines[i], view, position.seen);
    if (!rig.light_plane) {
      check.add(lines[i], view, files[i]);
    }
  }
  cli::refuse_contradiction(folder, check.contradiction(), options.unchecked);
  return position;
}

std::vector<light_section::HeightPosition> read_positions(const HeightsOptions& options, const rig::Rig& rig,
                                                          const std::vector<double>& heights) {
  const std::vector<int> lines = rig.light_plane ? std::vector<int>() : light_section::sweep_lines(rig, options.every);
  if (!rig.light_plane && lines.empty()) {
    throw UserError(options.rig, fmt::format("measure.line_width_px is {}, too wide for the {} lines of the projector",
                                             rig.measure.line_width_px, rig.projector.lines));
  }
  std::vector<light_section::HeightPosition> positions;
  cli::Progress progress("position", options.folders.size());
  for (std::size_t i = 0; i < options.folders.size(); ++i) {
    positions.push_back(read_position(options, rig, options.folders[i], lines));
    positions.back().height_mm = heights.empty() ? 0 : heights[i];
    progress.update(i + 1);
  }
  return positions;
}

// A table of the levels; `before` with the errors of the geometry alone.
std::string levels_text(const std::vector<light_section::HeightLevel>& levels, bool before) {
  std::string text = before ? "  height      samples   mean, before       RMS, before       mean        RMS   mm\n"
                            : "  height      samples       mean        RMS     uneven   mm\n";
  for (const light_section::HeightLevel& level : levels) {
    text += before ? fmt::format("  {:8.3f}  {:9}  {:12.4f}  {:16.4f}  {:9.4f}  {:9.4f}   {}\n", level.height_mm,
                                 level.samples, level.before_mean_mm, level.before_rms_mm, level.mean_mm, level.rms_mm,
                                 level.name)
                   : fmt::format("  {:8.3f}  {:9}  {:9.4f}  {:9.4f}  {:9.4f}   {}\n", level.height_mm, level.samples,
                                 level.mean_mm, level.rms_mm, level.uneven_mm, level.name);
  }
  return text;
}

std::string report_json(const HeightsOptions& options, const light_section::HeightFit& fit) {
  nlohmann::ordered_json json;
  json["rig"] = options.rig;
  json["tolerance_mm"] = options.settings.tolerance_mm;
  json["flatness_mm"] = options.settings.flatness_mm;
  json["order"] = fit.rig.heights->order;
  json["order_heights"] = fit.rig.heights->order_heights;
  json["rms_mm"] = fit.rms_mm;
  json["max_correction_mm"] = fit.correction_mm;
  json["open_by_tolerance_mm"] = fit.open_by_tolerance_mm;
  json["open_by_flatness_mm"] = fit.open_by_flatness_mm;
  json["open_by_noise_mm"] = fit.open_by_noise_mm;
  for (const light_section::HeightLevel& level : fit.levels) {
    json["levels"].push_back({{"name", level.name},
                              {"height_mm", level.height_mm},
                              {"samples", level.samples},
                              {"mean_before_mm", level.before_mean_mm},
                              {"rms_before_mm", level.before_rms_mm},
                              {"mean_mm", level.mean_mm},
                              {"rms_mm", level.rms_mm},
                              {"uneven_mm", level.uneven_mm}});
  }
  return files::json_text(json, 2) + "\n";
}

void run_check(const HeightsOptions& options, const rig::Rig& rig,
               const std::vector<light_section::HeightPosition>& positions) {
  const std::vector<light_section::HeightLevel> levels = light_section::check_heights(rig, positions, options.settings);
  fmt::print("{}", levels_text(levels, false));
  // The part that is off most, as a share of what is allowed there.
  double worst = -1;
  std::string outcome;
  for (const light_section::HeightLevel& level : levels) {
    if (level.parts.empty()) {
      throw CheckFailed(fmt::format("--check: {}: the line was found in {} places only", level.name, level.samples));
    }
    for (const light_section::HeightPart& part : level.parts) {
      const double allowed = options.within_mm.value_or(allowed_mm(part, options.settings));
      if (const double share = std::abs(part.mean_mm) / allowed; !(share <= worst)) {
        worst = share;
        outcome = fmt::format("{}: in columns {}..{} heights are {:.3f} mm off; {:.3f} mm are allowed{}", level.name,
                              part.first_column + 1, part.last_column + 1, part.mean_mm, allowed,
                              options.within_mm ? " (--within)" : "");
      }
    }
  }
  if (!(worst <= 1)) {
    throw CheckFailed("--check: " + outcome);
  }
  fmt::print("{}\n", outcome);
}

void run_heights(HeightsOptions options) {
  if (options.heights.empty() == options.steps.empty()) {
    throw UserError("--heights, --steps", "exactly one of them is needed");
  }
  if (options.check == !options.out.empty()) {
    throw UserError("--out, --check", "exactly one of them is needed");
  }
  rig::Rig rig = rig::load_any_rig(options.rig);
  model::Measure measure = rig.measure.of_board();
  options.select.apply(measure);
  rig.measure.apply(measure);
  if (!options.assume.empty()) {
    rig::assume(rig, options.assume, "--assume");
  }
  if (rig.kind != rig::RigKind::light_section) {
    throw UserError(options.rig, "is not a rig of kind light-section");
  }
  std::vector<double> heights;
  if (options.steps.empty()) {
    heights = cli::ascending_lengths("--heights", options.heights);
    if (heights.size() != options.folders.size()) {
      throw UserError("--heights",
                      fmt::format("has {} heights for {} folders", heights.size(), options.folders.size()));
    }
  } else {
    options.settings.steps_mm = cli::ascending_lengths("--steps", options.steps);
  }
  if (std::set<std::string>(options.folders.begin(), options.folders.end()).size() != options.folders.size()) {
    throw UserError("DIR", "a folder is given twice");
  }
  if (options.check) {
    rig::expect_measured(rig, options.rig, rig::Millimetres::of_section);
    run_check(options, rig, read_positions(options, rig, heights));
    return;
  }
  files::OutputFolder folder(options.out);
  const light_section::HeightFit fit =
      light_section::fit_heights(rig, read_positions(options, rig, heights), options.settings);
  folder.append("rig.yaml", rig::to_yaml(fit.rig));
  folder.append("report.json", report_json(options, fit));
  folder.commit();
  fmt::print("{}", levels_text(fit.levels, true));
  fmt::print("corrections up to {:.3f} mm, of order {} ({} in the height); {:.4f} mm RMS of single centroids\n",
             fit.correction_mm, fit.rig.heights->order, fit.rig.heights->order_heights, fit.rms_mm);
  fmt::print(
      "left open: {:.4f} mm by the tolerance of the heights ({} mm each, all in the worst way), {} mm by the "
      "flatness,\n{:.4f} mm (one standard deviation) by noise\n",
      fit.open_by_tolerance_mm, options.settings.tolerance_mm, options.settings.flatness_mm, fit.open_by_noise_mm);
  fmt::print("→ {}\n", folder.name());
}

void add_heights_options(CLI::App& command, HeightsOptions& options) {
  cli::begin_group(command, "Target (one of --heights and --steps is required)");
  command
      .add_option("--heights", options.heights,
                  "True heights of the flat plate in mm, ascending, one for each folder. Three or more; five are good.")
      ->type_name("H,H,...");
  command
      .add_option("--steps", options.steps,
                  "True heights of the treads of a block in mm, ascending. Each folder shows some of them; the block "
                  "is moved in between.")
      ->type_name("H,H,...");
  command.add_option("--tolerance", options.settings.tolerance_mm, "How far a true height may be off, in mm.")
      ->transform(cli::real_number(0, 10))
      ->type_name("MM")
      ->capture_default_str();
  command
      .add_option("--flatness", options.settings.flatness_mm,
                  "How far the plate, or a tread, may be off a plane, in mm.")
      ->transform(cli::real_number(0, 10))
      ->type_name("MM")
      ->capture_default_str();
  command
      .add_option("--scale-tolerance", options.settings.scale_tolerance,
                  "How far the rig's own scale of heights may be off, as a share. A greater difference means that all "
                  "heights are wrong by one factor.")
      ->transform(cli::number_above_zero(10))
      ->type_name("SHARE")
      ->default_str(fmt::format("{:g}, for a calibrated rig {:g}", light_section::HeightSettings::kDrawnScale,
                                light_section::HeightSettings::kCalibratedScale));
  cli::begin_group(command, "Input");
  command
      .add_option("--rig", options.rig,
                  "Built-in rig or YAML file of kind light-section; one with a laser must know its belt.")
      ->type_name("RIG")
      ->capture_default_str();
  command
      .add_option("--assume", options.assume,
                  "Values of the rig that --check takes though no calibration measured them (its section `sources`), "
                  "with commas between them: camera, light, belt.")
      ->type_name("NAME,...");
  command.add_option("--every", options.every, "Distance of two lines of the sweep, in projector lines.")
      ->transform(cli::whole_number(1, 64))
      ->type_name("N")
      ->capture_default_str();
  cli::add_pixel_options(command, options.pixels);
  cli::add_unchecked_option(command, options.unchecked);
  cli::begin_group(command, "Measuring");
  cli::add_select_options(command, options.select, cli::kRigsSelect);
  cli::begin_group(command, "Output");
  command.add_option("--out", options.out, "Folder for rig.yaml and report.json.")->type_name("DIR");
  command.add_flag("--check", options.check,
                   "Write nothing: measure the positions with the rig as it is, and exit with status 1 if a height is "
                   "off.");
  command
      .add_option("--within", options.within_mm,
                  "What --check allows, in mm, for the mean of a sixteenth of the columns.")
      ->transform(cli::number_above_zero(1000))
      ->type_name("MM")
      ->default_str("twice the tolerances, and four standard deviations of the noise in these images");
  cli::add_files(
      command, "DIR", options.folders,
      "Folders with the camera images of a sweep, numbered in the order of the lines; with a laser, with one "
      "or more images of its line.")
      ->required();
}

}  // namespace

CLI::App* add_heights_command(CLI::App& calibrate) {
  CLI::App* command = cli::add_command(
      calibrate,
      {.name = "heights",
       .purpose = "Ties the heights of a light section to known ones.",
       .details = "Project the lines of `selfproj pattern --sweep` on a flat plate at several known heights over the "
                  "belt, or on a block with steps of known heights, and record one image of each line. For each column "
                  "of the camera the heights of the rig are then corrected to the true ones.\n\n"
                  "The output folder gets rig.yaml, which `selfproj pattern` and `selfproj inspect` take, and "
                  "report.json. The text says what the tolerances of the plate leave open.\n\n"
                  "--check measures a plate whose height is known with a finished rig. Do this before each use.",
       .examples = R"(
# The lines to project.
selfproj pattern --sweep --every 4 --out lines

# Five positions of a plate: correct the rig (needs your files)
selfproj calibrate heights --heights 0,10,20,30,40 --out line1 at0 at10 at20 at30 at40

# Check it with a plate at another height (needs your files)
selfproj calibrate heights --rig line1/rig.yaml --heights 15 --check at15
)"});
  const auto options = std::make_shared<HeightsOptions>();
  add_heights_options(*command, *options);
  // What `calibrate` itself requires is not required here.
  command->preparse_callback([&calibrate](std::size_t /*arguments*/) {
    for (CLI::Option* option : calibrate.get_options()) {
      option->required(false);
    }
  });
  command->callback([options] { run_heights(*options); });
  return command;
}

}  // namespace selfproj::app
