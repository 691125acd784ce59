#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "host/app/commands.h"
#include "host/calibration/chessboard.h"
#include "host/calibration/laser_plane.h"
#include "host/calibration/line_removal.h"
#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/files/json_text.h"
#include "host/files/output_folder.h"
#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "selfproj/files/user_error.h"
#include "selfproj/rig/rig.h"

namespace selfproj::app {
namespace {

using Json = nlohmann::ordered_json;

struct CameraOptions {
  std::string chessboard;
  std::string rig = "light-section";
  std::string distortion = "auto";
  std::string board = "bent";
  images::PixelOptions pixels;
  std::string laser_channel;  // empty: that of the boards
  std::string out;
  calibration::CameraSettings settings;
  std::vector<std::string> images;
  std::vector<std::string> laser;
};

constexpr std::array<const char*, calibration::kLensParameters> kNames{"fx", "fy", "cx", "cy", "k1",
                                                                       "k2", "p1", "p2", "k3"};

// Checks the options and fills the settings from them.
void apply(CameraOptions& options) {
  constexpr int kMaxCorners = 200;
  const images::FrameSize corners = images::size_of_text("--chessboard", options.chessboard, kMaxCorners);
  if (corners.columns < 3 || corners.rows < 3) {
    throw UserError("--chessboard",
                    fmt::format("is {}; at least 3 inner corners are needed along both sides", options.chessboard));
  }
  options.settings.chessboard.columns = corners.columns;
  options.settings.chessboard.rows = corners.rows;
  options.settings.distortion =
      options.distortion == "auto" ? calibration::FreeDistortion::kByData : std::stoi(options.distortion);
  options.settings.bent = options.board == "bent";
  options.images = images::image_arguments(options.images);
  options.laser = images::image_arguments(options.laser);
  const std::set<std::string> once(options.images.begin(), options.images.end());
  if (once.size() != options.images.size()) {
    throw UserError("IMAGE", "an image is given twice");
  }
  if (!options.laser.empty() && options.laser.size() != options.images.size()) {
    throw UserError("--laser", fmt::format("has {} images for {} of the chessboard; one of each pose is needed, in the "
                                           "same order",
                                           options.laser.size(), options.images.size()));
  }
  for (const std::string& file : options.images) {
    images::check_image_file(file);
  }
  for (const std::string& file : options.laser) {
    images::check_image_file(file);
  }
}

// The light of the colour that stands out most from a board of black and white.
struct Light {
  images::Channel of;
  images::Image image;
};
Light strongest_light(const std::string& file, std::optional<int> shift) {
  using images::Channel;
  std::optional<Light> best;
  double most = -1;
  for (const Channel channel : {Channel::red_difference, Channel::green_difference, Channel::blue_difference}) {
    images::Image image = images::read_image(file, images::PixelRule(channel, shift));
    constexpr int kLit = 40;  // grey values
    const auto lit = static_cast<double>(
        std::count_if(image.pixels.begin(), image.pixels.end(), [](std::uint8_t value) { return value > kLit; }));
    if (lit > most) {
      most = lit;
      best = Light{channel, std::move(image)};
    }
  }
  return std::move(*best);
}

// The image in the two colours that the laser does not have.
images::Image without_colour(const std::string& file, images::Channel of, std::optional<int> shift) {
  using images::Channel;
  const Channel first = of == Channel::red_difference ? Channel::green : Channel::red;
  const Channel second = of == Channel::blue_difference ? Channel::green : Channel::blue;
  images::Image image = images::read_image(file, images::PixelRule(first, shift));
  const images::Image other = images::read_image(file, images::PixelRule(second, shift));
  std::transform(image.pixels.begin(), image.pixels.end(), other.pixels.begin(), image.pixels.begin(),
                 [](std::uint8_t a, std::uint8_t b) { return static_cast<std::uint8_t>((a + b + 1) / 2); });
  return image;
}

// The board. Where a laser is calibrated, its line may be on in the board's image, too.
calibration::BoardImage observe(const CameraOptions& options, const std::string& file) {
  const images::PixelRule rule = options.pixels.rule();
  const images::Image image = images::read_image(file, rule);
  const calibration::Chessboard& chessboard = options.settings.chessboard;
  if (options.laser.empty()) {
    return calibration::observe_board(file, image, chessboard);
  }
  if (!images::is_colour_image(file)) {
    const images::Image none;
    return calibration::observe_board(file, image, chessboard, &none);
  }
  const Light light = strongest_light(file, rule.shift);
  const bool crossed = rule.channel == images::Channel::grey && calibration::line_of_light(light.image);
  return calibration::observe_board(file, crossed ? without_colour(file, light.of, rule.shift) : image, chessboard,
                                    &light.image);
}

// Reads the images of the laser. They must have the size of the chessboard's images.
std::vector<images::Image> read_lines(const CameraOptions& options, const calibration::CameraReport& camera) {
  std::vector<images::Image> lines;
  images::PixelRule rule = options.pixels.rule();
  if (!options.laser_channel.empty()) {
    rule.channel = images::channel_of(options.laser_channel);
  }
  for (const std::string& file : options.laser) {
    lines.push_back(images::read_image(file, rule));
    const calibration::BoardImage& first = camera.images.front();
    if (lines.back().rows != first.rows || lines.back().columns != first.columns) {
      throw UserError(file,
                      fmt::format("is {}, but {} is {}", images::size_text(lines.back().rows, lines.back().columns),
                                  first.name, images::size_text(first.rows, first.columns)));
    }
  }
  return lines;
}

std::string camera_yaml(const calibration::CameraReport& camera) {
  const calibration::LensParameters& p = camera.model.result.bundle.camera;
  const calibration::BoardImage& first = camera.images.front();
  return fmt::format(
      "%YAML:1.0\n---\ncam_size: [ {}, {} ]\ncam_K: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
      "   data: [ {}, 0., {}, 0., {}, {}, 0., 0., 1. ]\ncam_kc: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n"
      "   data: [ {}, {}, {}, {}, {} ]\n",
      first.columns, first.rows, p[0], p[2], p[1], p[3], p[4], p[5], p[6], p[7], p[8]);
}

std::string report_json(const calibration::CameraReport& camera, const std::optional<calibration::LaserPlane>& laser) {
  const calibration::BundleResult& found = camera.model.result;
  Json json;
  for (std::size_t i = 0; i < calibration::kLensParameters; ++i) {
    const bool estimated = i < 4 + static_cast<std::size_t>(camera.model.free.camera);
    json["camera"][kNames.at(i)] = {{"value", found.bundle.camera.at(i)},
                                    {"sd", estimated ? Json(found.deviation.camera.at(i)) : Json("fixed")}};
  }
  json["rms_px"] = found.camera_rms;
  json["starts"] = {
      {"agreeing", camera.model.agreeing}, {"worse", camera.model.worse}, {"failed", camera.model.failed}};
  for (const calibration::BoardImage& image : camera.images) {
    Json entry{{"name", image.name}, {"corners", image.corners.size()}, {"used", image.used_corners()}};
    if (image.reason.empty()) {
      entry["rms_px"] = image.rms_px;
      if (image.by_squares) {
        entry["found_by"] = calibration::kBySquares;
      }
    } else {
      entry["left_out"] = image.reason;
    }
    json["images"].push_back(entry);
  }
  if (laser) {
    json["laser"] = {
        {"normal", laser->plane.normal},     {"distance_mm", laser->plane.distance_mm}, {"images", laser->images},
        {"points", laser->points},           {"points_left_out", laser->left_out},      {"rms_mm", laser->rms_mm},
        {"turn_sd_deg", laser->turn_sd_deg}, {"shift_sd_mm", laser->shift_sd_mm}};
  }
  return files::json_text(json, 2) + "\n";
}

std::string report_text(const calibration::CameraReport& camera, const std::optional<calibration::LaserPlane>& laser) {
  const calibration::BundleResult& found = camera.model.result;
  std::string text;
  for (const calibration::BoardImage& image : camera.images) {
    text += image.reason.empty()
                ? fmt::format("{}: {} of {} corners, RMS {:.3f} px{}\n", image.name, image.used_corners(),
                              image.corners.size(), image.rms_px,
                              image.by_squares ? fmt::format(", found by {}", calibration::kBySquares) : "")
                : fmt::format("{}: left out: {}\n", image.name, image.reason);
  }
  text += "camera    ";
  for (std::size_t i = 0; i < 4 + static_cast<std::size_t>(camera.model.free.camera); ++i) {
    text +=
        i < 4
            ? fmt::format(" {} {:.2f} ± {:.2f}", kNames.at(i), found.bundle.camera.at(i), found.deviation.camera.at(i))
            : fmt::format(" {} {:.4f} ± {:.4f}", kNames.at(i), found.bundle.camera.at(i), found.deviation.camera.at(i));
  }
  text += fmt::format("\nRMS        {:.3f} px\n", found.camera_rms);
  if (laser) {
    const std::array<double, 3>& n = laser->plane.normal;
    text += fmt::format(
        "laser      normal ({:.5f}, {:.5f}, {:.5f}) ± {:.3f}°, {:.3f} mm away, ± {:.3f} mm where it was seen; {} "
        "points "
        "in {} images, {} left out, {:.3f} mm RMS\n",
        n[0], n[1], n[2], laser->turn_sd_deg, laser->plane.distance_mm, laser->shift_sd_mm, laser->points,
        laser->images, laser->left_out, laser->rms_mm);
    for (const std::string& name : laser->without_line) {
      text += fmt::format("{}: its image of the line has fewer than {} points on the chessboard\n", name,
                          calibration::kMinLinePoints);
    }
  }
  return text;
}

void run_camera(CameraOptions options) {
  apply(options);
  files::OutputFolder folder(options.out);
  static_cast<void>(rig::load_any_rig(options.rig));
  std::vector<calibration::BoardImage> boards;
  {
    cli::Progress progress("image", options.images.size());
    for (const std::string& file : options.images) {
      boards.push_back(observe(options, file));
      progress.update(boards.size());
    }
  }
  const calibration::CameraReport camera = calibration::calibrate_camera(std::move(boards), options.settings);
  if (!camera.model.refusal.empty()) {
    throw CheckFailed(fmt::format("calibrate camera: no camera: {}", camera.model.refusal));
  }
  std::optional<calibration::LaserPlane> laser;
  if (!options.laser.empty()) {
    laser = calibration::laser_plane(camera, read_lines(options, camera));
    folder.append("rig.yaml", rig::to_yaml(calibration::rig_of_laser(rig::load_any_rig(options.rig), camera, *laser)));
  }
  folder.append("camera.yaml", camera_yaml(camera));
  folder.append("report.json", report_json(camera, laser));
  folder.commit();
  fmt::print("{}→ {}\n", report_text(camera, laser), folder.name());
}

void add_camera_options(CLI::App& command, CameraOptions& options) {
  cli::begin_group(command, "Chessboard");
  command.add_option("--chessboard", options.chessboard, "Inner corners along the two sides of the chessboard.")
      ->type_name("NxM")
      ->required();
  command
      .add_option("--square", options.settings.chessboard.square_mm,
                  "Side of a square in mm. Measure it: if it is wrong, all lengths are wrong by the same factor, and "
                  "nothing shows it.")
      ->transform(cli::number_above_zero())
      ->type_name("MM")
      ->required();
  command
      .add_option("--board", options.board,
                  "bent: the chessboard's shape is estimated, as paper is never flat. flat: it is exactly flat.")
      ->check(cli::one_of({"bent", "flat"}))
      ->type_name("SHAPE")
      ->capture_default_str();
  command
      .add_option(
          "--distortion", options.distortion,
          "How many of k1, k2, p1, p2, k3 are estimated. The others are 0. auto: as many as the images support, "
          "without k3.")
      ->check(cli::one_of({"auto", "0", "1", "2", "4", "5"}))
      ->type_name("N")
      ->capture_default_str();
  command
      .add_option("--reject", options.settings.reject,
                  "Leave out corners whose residual exceeds this many standard deviations. 0 keeps all.")
      ->transform(cli::real_number(0, 1000))
      ->type_name("K")
      ->capture_default_str();
  command.add_option("--min-corners", options.settings.min_corners, "Leave out images with fewer usable corners.")
      ->transform(cli::whole_number(6, 40000))
      ->type_name("N")
      ->capture_default_str();
  cli::add_pixel_options(command, options.pixels);
  cli::begin_group(command, "Laser");
  command
      .add_option("--laser", options.laser,
                  "Images of the laser's line on the chessboard, of the same poses in the same order, or a folder of "
                  "them. Darken the room for them.")
      ->type_name("IMAGE");
  command
      .add_option(
          "--laser-channel", options.laser_channel,
          "Channel to take of the laser's images, if it is not that of --channel: red-difference for a red laser "
          "in colour images.")
      ->check(cli::one_of(images::channel_names()))
      ->type_name("CHANNEL");
  command.add_option("--laser-threshold", options.settings.threshold, "The line is brighter than this grey value.")
      ->transform(cli::whole_number(0, 254))
      ->type_name("T")
      ->capture_default_str();
  command
      .add_option("--rig", options.rig,
                  "With --laser: rig of kind light-section whose pixel pitch, rates, conveyor and measuring settings "
                  "are copied to rig.yaml.")
      ->type_name("RIG")
      ->capture_default_str();
  cli::begin_group(command, "Output");
  command.add_option("--out", options.out, "Folder for the results.")->type_name("DIR")->required();
  cli::add_files(command, "IMAGE", options.images,
                 "Plain images of the chessboard in several poses, or a folder of them.")
      ->required();
}

}  // namespace

CLI::App* add_camera_command(CLI::App& calibrate) {
  CLI::App* command = cli::add_command(
      calibrate,
      {.name = "camera",
       .purpose = "Calibrates a camera alone from plain images of a chessboard, and a laser's plane.",
       .details =
           "Record the chessboard in 5 or more poses that lean in different directions. With --laser, record in "
           "each pose a second image with the laser's line on it; camera and laser then form a light section.\n\n"
           "The output folder gets camera.yaml (OpenCV YAML), report.json, and with --laser rig.yaml, which "
           "`selfproj inspect` takes. If the poses do not determine the result, nothing is written and the "
           "exit status is 1.",
       .examples = R"(
# A camera and a laser's plane (needs your files)
selfproj calibrate camera --chessboard 9x7 --square 20 --out line1 boards/*.png \
  --laser lines/*.png
)"});
  const auto options = std::make_shared<CameraOptions>();
  add_camera_options(*command, *options);
  // The options that `calibrate` itself requires are not required for this command.
  command->preparse_callback([&calibrate](std::size_t /*arguments*/) {
    for (CLI::Option* option : calibrate.get_options()) {
      option->required(false);
    }
  });
  command->callback([options] { run_camera(*options); });
  return command;
}

}  // namespace selfproj::app
