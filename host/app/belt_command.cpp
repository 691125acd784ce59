#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "host/app/commands.h"
#include "host/calibration/belt.h"
#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/files/json_text.h"
#include "host/files/output_folder.h"
#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "host/production/height_map.h"
#include "selfproj/files/user_error.h"
#include "selfproj/rig/rig.h"

namespace selfproj::app {
namespace {

using Json = nlohmann::ordered_json;

struct BeltOptions {
  std::string rig;
  std::string chessboard;
  calibration::BeltSettings settings;
  images::PixelOptions pixels;
  std::vector<std::string> images;
  std::vector<std::string> laser;
  std::vector<double> heights;
  int threshold = calibration::CameraSettings{}.threshold;
  std::optional<double> above_mm, length_mm;  // of parts
  std::string out;
};

// Throws unless there is one value for each image, and they ascend.
void check_list(const char* option, const std::vector<double>& values, std::size_t count, const char* of) {
  if (values.size() != count) {
    throw UserError(option, fmt::format("has {} values for {} {}", values.size(), count, of));
  }
  const auto late = std::adjacent_find(values.begin(), values.end(), std::greater_equal<>());
  if (late != values.end()) {
    throw UserError(option,
                    fmt::format("{:g} follows {:g}; numbers are expected in ascending order", *(late + 1), *late));
  }
}

void check_images(const std::vector<std::string>& files, const char* option) {
  if (std::set<std::string>(files.begin(), files.end()).size() != files.size()) {
    throw UserError(option, "an image is given twice");
  }
  for (const std::string& file : files) {
    images::check_image_file(file);
  }
}

// Checks the options and fills the settings from them. Returns the rig.
rig::Rig apply(BeltOptions& options) {
  calibration::BeltSettings& settings = options.settings;
  constexpr int kMaxCorners = 200;
  const images::FrameSize corners = images::size_of_text("--chessboard", options.chessboard, kMaxCorners);
  if (corners.columns < 3 || corners.rows < 3) {
    throw UserError("--chessboard",
                    fmt::format("is {}; at least 3 inner corners are needed along both sides", options.chessboard));
  }
  settings.chessboard.columns = corners.columns;
  settings.chessboard.rows = corners.rows;
  options.images = images::image_arguments(options.images);
  options.laser = images::image_arguments(options.laser);
  check_images(options.images, "IMAGE");
  check_images(options.laser, "--laser");
  if (options.images.size() < 2) {
    throw UserError("IMAGE", "one image is given; the chessboard is needed at two or more places of the belt");
  }
  for (const auto& [option, values] :
       {std::pair{"--moves", &settings.moves_mm}, {"--counts", &settings.counts}, {"--seconds", &settings.seconds}}) {
    if (!values->empty()) {
      check_list(option, *values, options.images.size(), "images of the chessboard");
    }
  }
  rig::Rig rig = rig::load_any_rig(options.rig);
  if (rig.kind != rig::RigKind::light_section) {
    throw UserError(options.rig, "is not a rig of kind light-section");
  }
  if (rig.heights) {
    throw UserError(options.rig, "has corrected heights, which hold for its belt_pose; calibrate its belt before them");
  }
  if (!options.laser.empty() && !rig.light_plane) {
    throw UserError("--laser", "is for a rig with a laser; a projector's heights are for `selfproj calibrate heights`");
  }
  if (options.heights.empty() && options.laser.size() == 1) {
    options.heights = {0};
  }
  if (!options.laser.empty() || !options.heights.empty()) {
    check_list("--heights", options.heights, options.laser.size(), "images of the laser");
    if (options.heights.front() != 0) {
      throw UserError("--heights",
                      fmt::format("begins with {:g}; the first image is that of the belt, 0", options.heights.front()));
    }
  }
  return rig;
}

images::Image read_image(const BeltOptions& options, const rig::Rig& rig, const std::string& file) {
  images::Image image = images::read_image(file, options.pixels.rule());
  if (image.rows != rig.camera.rows || image.columns != rig.camera.columns) {
    throw UserError(file, fmt::format("is {}; the rig's camera has {}", images::size_text(image.rows, image.columns),
                                      images::size_text(rig.camera.rows, rig.camera.columns)));
  }
  return image;
}

std::string report_json(const BeltOptions& options, const calibration::BeltCalibration& belt) {
  const rig::Rig& rig = belt.rig;
  Json json;
  json["rig"] = options.rig;
  json["plane_z_mm"] = rig.plane_z_mm;
  json["direction"] = rig.belt_pose->direction;
  json["normal"] = rig.belt_pose->normal;
  json["distance_sd_mm"] = belt.distance_sd_mm;
  json["normal_sd_deg"] = belt.normal_sd_deg;
  json["direction_sd_deg"] = belt.direction_sd_deg;
  json["rms_px"] = belt.rms_px;
  for (const calibration::BeltPlace& place : belt.places) {
    json["places"].push_back({{"name", place.name}, {"along_mm", place.along_mm}, {"rms_px", place.rms_px}});
  }
  if (belt.way > 0) {
    json["mm_per_mm_of_moves"] = belt.way;
  }
  if (!options.settings.counts.empty()) {
    json["encoder_mm_per_count"] = rig.conveyor.encoder_mm_per_count;
  }
  if (!options.settings.seconds.empty()) {
    json["speed_mm_per_s"] = rig.conveyor.speed_mm_per_s;
  }
  json["max_uneven_mm"] = belt.spread_mm;
  if (!belt.heights.empty()) {
    json["laser"] = {{"zero_before_mm", belt.zero_mm},
                     {"belt_turned_deg", belt.zero_turn_deg},
                     {"light_turned_deg", belt.light_turn_deg},
                     {"light_scale", belt.light_scale}};
    for (const auto& height : belt.heights) {
      json["laser"]["heights"].push_back({{"name", height.name},
                                          {"height_mm", height.height_mm},
                                          {"mean_mm", height.mean_mm},
                                          {"rms_mm", height.rms_mm},
                                          {"points", height.points}});
    }
  }
  return files::json_text(json, 2) + "\n";
}

// Where the chessboard went from the first image to the last one.
const char* way_in_image(const calibration::BoardImage& first, const calibration::BoardImage& last) {
  cv::Point2d way;
  for (std::size_t i = 0; i < first.corners.size(); ++i) {
    way += last.corners[i] - first.corners[i];  // a board that was found turned has the same middle
  }
  return std::abs(way.y) > std::abs(way.x) ? (way.y > 0 ? "down" : "up")
         : way.x > 0                       ? "to the right in"
                                           : "to the left in";
}

std::string report_text(const BeltOptions& options, const calibration::BeltCalibration& belt, const char* way) {
  const rig::Rig& rig = belt.rig;
  std::string text;
  for (const calibration::BeltPlace& place : belt.places) {
    text += fmt::format("{}: {:.3f} mm along the belt, RMS {:.3f} px\n", place.name, place.along_mm, place.rms_px);
  }
  const auto& [direction, normal] = *rig.belt_pose;
  text += fmt::format("belt       {:.3f} ± {:.3f} mm away, normal ({:.5f}, {:.5f}, {:.5f}) ± {:.3f}°\n", rig.plane_z_mm,
                      belt.distance_sd_mm, normal[0], normal[1], normal[2], belt.normal_sd_deg);
  text += fmt::format("way        ({:.5f}, {:.5f}, {:.5f}) ± {:.3f}°, {} the image{}\n", direction[0], direction[1],
                      direction[2], belt.direction_sd_deg, way,
                      belt.way > 0 ? fmt::format(", {:.4f} mm for each mm of --moves", belt.way) : "");
  if (!options.settings.counts.empty()) {
    text += fmt::format("encoder    {:.6g} mm for each count\n", rig.conveyor.encoder_mm_per_count);
  }
  if (!options.settings.seconds.empty()) {
    text += fmt::format("speed      {:.6g} mm/s\n", rig.conveyor.speed_mm_per_s);
  }
  if (!belt.heights.empty()) {
    text += fmt::format(
        "laser      saw the belt {:.3f} mm high, which is now 0{}; belt turned by {:.3f}° about its way, laser by "
        "{:.3f}°\n",
        belt.zero_mm,
        belt.heights.size() > 1 ? fmt::format(", and {:.4f} mm for each mm of the heights", belt.light_scale)
                                : ", and nothing of a known height, so the scale of heights is the chessboards'",
        belt.zero_turn_deg, belt.light_turn_deg);
    for (const auto& height : belt.heights) {
      text += fmt::format("{}: {:g} mm is measured as {:.3f} mm, {:.3f} mm RMS, {} points\n", height.name,
                          height.height_mm, height.mean_mm, height.rms_mm, height.points);
    }
  }
  return text;
}

// What a rig needs for parts, as far as it does not say it.
rig::RigParts parts_of(const BeltOptions& options, const rig::Rig& rig) {
  const bool by_encoder = !options.settings.counts.empty() || options.settings.seconds.empty();
  rig::RigParts parts = rig.parts ? *rig.parts : production::usual_parts(rig, by_encoder);
  parts.above_mm = options.above_mm.value_or(parts.above_mm);
  parts.length_mm = options.length_mm.value_or(parts.length_mm);
  return parts;
}

void run_belt(BeltOptions options) {
  const rig::Rig rig = apply(options);
  files::OutputFolder folder(options.out);
  std::vector<calibration::BoardImage> boards;
  {
    cli::Progress progress("image", options.images.size());
    for (const std::string& file : options.images) {
      boards.push_back(calibration::observe_board(file, read_image(options, rig, file), options.settings.chessboard));
      progress.update(boards.size());
    }
  }
  std::vector<calibration::LineAtHeight> lines;
  for (std::size_t i = 0; i < options.laser.size(); ++i) {
    lines.push_back({options.laser[i], options.heights[i],
                     calibration::line_centres(read_image(options, rig, options.laser[i]), options.threshold)});
  }
  calibration::BeltCalibration belt = calibration::calibrate_belt(rig, boards, lines, options.settings);
  belt.rig.parts = parts_of(options, belt.rig);
  const auto back = std::ranges::adjacent_find(
      belt.places, [](const auto& before, const auto& after) { return after.along_mm <= before.along_mm; });
  if (back != belt.places.end()) {
    throw UserError("IMAGE", fmt::format("from {} to {} the chessboard moves back; give the images in the order in "
                                         "which the belt carries it",
                                         back->name, (back + 1)->name));
  }
  const std::string yaml = rig::to_yaml(belt.rig);
  static_cast<void>(rig::parse_rig(yaml, "--counts, --seconds, --moves"));  // their scale may be none that a rig takes
  folder.append("rig.yaml", yaml);
  folder.append("report.json", report_json(options, belt));
  folder.commit();
  fmt::print("{}→ {}\n", report_text(options, belt, way_in_image(boards.front(), boards.back())), folder.name());
  constexpr double kFinest = 1e-4;  // mm, of usual encoders
  constexpr double kCoarsest = 1;
  const double count_mm = std::abs(belt.rig.conveyor.encoder_mm_per_count);
  if (!options.settings.counts.empty() && (count_mm < kFinest || count_mm > kCoarsest)) {
    cli::note_doubt("--counts", fmt::format("make {:.3g} mm for each count, which few encoders have", count_mm));
  }
  if (options.settings.counts.empty() && options.settings.seconds.empty()) {
    cli::note_doubt("--counts, --seconds",
                    "none is given, so the rig does not say how far the belt moves: it measures images with "
                    "--mm-per-image, and no device");
  }
  constexpr double kAlike = 0.005;
  if (std::abs(belt.light_scale - 1) > kAlike) {
    cli::note_doubt("--heights",
                    fmt::format("by lens and chessboard the laser saw {:.4f} mm for each mm of them: they, or the "
                                "--square of one of the calibrations, may be wrong by that much",
                                belt.light_scale));
  }
}

void add_list(CLI::App& command, const char* name, std::vector<double>& values, const char* type, const char* text) {
  command.add_option(name, values, text)
      ->delimiter(',')
      ->allow_extra_args(false)
      ->transform(cli::real_number(-1e12, 1e12))
      ->type_name(type);
}

void add_belt_options(CLI::App& command, BeltOptions& options) {
  calibration::BeltSettings& settings = options.settings;
  cli::begin_group(command, "Rig and chessboard");
  command
      .add_option("--rig", options.rig,
                  "Rig of kind light-section whose camera's lens is known, such as that of `selfproj calibrate "
                  "camera --laser`.")
      ->type_name("RIG")
      ->required();
  command.add_option("--chessboard", options.chessboard, "Inner corners along the two sides of the chessboard.")
      ->type_name("NxM")
      ->required();
  command.add_option("--square", settings.chessboard.square_mm, "Side of a square in mm.")
      ->transform(cli::number_above_zero())
      ->type_name("MM")
      ->required();
  command
      .add_option("--thickness", settings.thickness_mm,
                  "Thickness of the chessboard in mm: how high it is above the belt.")
      ->transform(cli::real_number(0, 1000))
      ->type_name("MM")
      ->capture_default_str();
  cli::add_pixel_options(command, options.pixels);
  cli::begin_group(command, "Belt, at each image of the chessboard, with commas between the values");
  add_list(command, "--counts", settings.counts, "N,...", "Counts of the encoder. They give mm a count.");
  add_list(command, "--seconds", settings.seconds, "S,...",
           "Times in seconds, of a belt that runs evenly. They give its speed.");
  add_list(command, "--moves", settings.moves_mm, "MM,...",
           "Places in mm. They are compared with the way of the chessboard.");
  cli::begin_group(command, "Laser");
  command
      .add_option("--laser", options.laser,
                  "Images of the laser's line: the first on the empty belt, which becomes height 0; further ones on "
                  "something flat of known height, such as a gauge block.")
      ->type_name("IMAGE");
  add_list(command, "--heights", options.heights, "MM,...",
           "Heights of what the images of --laser show, ascending from 0. They tie the scale of heights.");
  command.add_option("--laser-threshold", options.threshold, "The line is brighter than this grey value.")
      ->transform(cli::whole_number(0, 254))
      ->type_name("T")
      ->capture_default_str();
  cli::begin_group(command, "Parts: the section `parts` of the rig, if it has none yet");
  command.add_option("--part-above", options.above_mm, "What is higher above the belt belongs to a part, in mm.")
      ->transform(cli::number_above_zero(1e6))
      ->type_name("MM")
      ->default_str("four cells of a map, each as wide as a column of the camera");
  command.add_option("--part-length", options.length_mm, "A part that is longer along the belt is cut here, in mm.")
      ->transform(cli::number_above_zero(1e6))
      ->type_name("MM")
      ->default_str("twice the width of the camera's view");
  cli::begin_group(command, "Tolerances");
  command
      .add_option("--scale-tolerance", settings.scale_tolerance,
                  "How far --moves may be from the chessboard's way, and the scale of heights from --heights, as a "
                  "share.")
      ->transform(cli::number_above_zero(1))
      ->type_name("SHARE")
      ->capture_default_str();
  command
      .add_option("--height-tolerance", settings.height_tolerance,
                  "How far the laser may see the belt from where the chessboard has it, in mm.")
      ->transform(cli::number_above_zero(1000))
      ->type_name("MM")
      ->capture_default_str();
  cli::begin_group(command, "Output");
  command.add_option("--out", options.out, "Folder for rig.yaml and report.json.")->type_name("DIR")->required();
  cli::add_files(command, "IMAGE", options.images,
                 "Images of the chessboard flat on the belt, at two or more places, in the order in which the belt "
                 "passes them, or a folder of them.")
      ->required();
}

}  // namespace

CLI::App* add_belt_command(CLI::App& calibrate) {
  CLI::App* command = cli::add_command(
      calibrate,
      {.name = "belt",
       .purpose = "Finds how the belt lies and moves before a calibrated camera, and ties a laser's heights to it.",
       .details =
           "Lay the chessboard flat on the belt and let the belt carry it, without touching it, from one side of the "
           "camera's view to the other. Record it at five or more places. The images give the belt's plane and the way "
           "it moves; with --counts also the encoder's scale, with --seconds the speed.\n\n"
           "For a laser, record its line on the empty belt too, which becomes height 0, and on a gauge block, which "
           "ties the scale of heights. A projector's heights are tied by `selfproj calibrate heights`.\n\n"
           "The output folder gets report.json and rig.yaml. Its section `sources` says what was measured, its section "
           "`parts` how `selfproj inspect` and `selfproj tolerance learn` cut parts: by the encoder if --counts are "
           "given, or else by the clock.",
       .examples = R"(
# The belt of a laser line, by its encoder (needs your files)
selfproj calibrate belt --rig line1/rig.yaml --chessboard 9x7 --square 20 \
  --counts 0,2000,4000,6000,8000 --laser empty.png block20.png --heights 0,20 \
  --out line2 belt/*.png
)"});
  const auto options = std::make_shared<BeltOptions>();
  add_belt_options(*command, *options);
  // What `calibrate` itself requires is not required here.
  command->preparse_callback([&calibrate](std::size_t /*arguments*/) {
    for (CLI::Option* option : calibrate.get_options()) {
      option->required(false);
    }
  });
  command->callback([options] { run_belt(*options); });
  return command;
}

}  // namespace selfproj::app
