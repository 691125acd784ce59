#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstddef>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/app/capture_run.h"
#include "host/app/commands.h"
#include "host/app/guided_poses.h"
#include "host/calibration/calibrate.h"
#include "host/calibration/calibration_output.h"
#include "host/calibration/capture.h"
#include "host/calibration/plates.h"
#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/files/output_folder.h"
#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/rig/calibration_file.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/gray_sequence.h"

namespace selfproj::app {
namespace {

constexpr const char* kAuto = "auto";

struct CalibrateOptions {
  std::string chessboard;
  std::string projector;
  std::string corners = "homography";
  images::PixelOptions pixels;
  std::string rig = "scanner";
  std::string out;
  std::string board = "bent";
  std::string camera_distortion = kAuto;
  std::string projector_distortion = kAuto;
  calibration::DecodeSettings decode;
  bool unchecked = false;
  calibration::CalibrateSettings calibrate;
  std::string plates;
  std::string moves;
  calibration::PlateTolerance tolerance;
  calibration::DrawnScale scale;
  std::vector<std::string> poses;
  std::vector<std::string> checks;
  CaptureOptions capture;  // with a camera the poses are taken now
};

int free_of(const std::string& option) {
  return option == kAuto ? calibration::FreeDistortion::kByData : std::stoi(option);
}

// The rig of the calibration, or the reason why it does not exist.
std::string rig_yaml(const CalibrateOptions& options, calibration::CalibrationReport& report) {
  try {
    return rig::to_yaml(calibration::calibrated_rig(report, rig::load_rig(options.rig)));
  } catch (const std::invalid_argument& error) {
    report.warnings.push_back(fmt::format("no rig.yaml: {}", error.what()));
    return {};
  }
}

// Heights and moves of plates, with the drawings of the rig as the place to start from.
void apply_plates(const CalibrateOptions& options, calibration::CalibrateSettings& settings) {
  constexpr std::size_t kMinPlates = 3;
  if (options.plates.empty() && !options.moves.empty()) {
    throw UserError("--moves", "is for --plates");
  }
  if (options.plates.empty()) {
    return;
  }
  const std::vector<double> heights = cli::ascending_lengths("--plates", options.plates);
  const std::vector<double> moves =
      options.moves.empty() ? std::vector<double>{0} : cli::ascending_lengths("--moves", options.moves);
  if (heights.size() < kMinPlates) {
    throw UserError("--plates", fmt::format("{} are too few; 3 or more heights are needed", heights.size()));
  }
  if (!options.moves.empty() && moves.size() < 2) {
    throw UserError("--moves", "two places of the belt are needed, to know which way it runs");
  }
  const std::size_t count = heights.size() * moves.size();
  if (options.poses.size() < count) {
    throw UserError("--plates", fmt::format("{} heights with {} places of the belt are {} poses; {} are given",
                                            heights.size(), moves.size(), count, options.poses.size()));
  }
  const rig::Rig rig = rig::load_rig(options.rig);
  if (rig.projector.columns != settings.projector_columns || rig.projector.lines != settings.projector_rows) {
    throw UserError("--rig",
                    fmt::format("its projector has {}, not {}; --plates starts from this rig",
                                images::size_text(rig.projector.lines, rig.projector.columns), options.projector));
  }
  settings.plates =
      calibration::plates_over(rig, settings.chessboard, heights, moves, options.tolerance, options.scale);
}

// Checks the options and puts them into options.calibrate.
void apply(CalibrateOptions& options) {
  constexpr int kMaxCorners = 200;
  const images::FrameSize corners = images::size_of_text("--chessboard", options.chessboard, kMaxCorners);
  if (corners.columns < 3 || corners.rows < 3) {
    throw UserError("--chessboard",
                    fmt::format("is {}; at least 3 inner corners are needed along both sides", options.chessboard));
  }
  const bool guided = !options.capture.camera.empty();
  if (guided
          ? !options.poses.empty() || !options.checks.empty() || !options.plates.empty() || !options.projector.empty()
          : options.poses.empty()) {
    throw guided ? UserError("--camera",
                             "takes the poses itself, at the display's resolution; leave out POSE, --check, "
                             "--plates and --projector")
                 : UserError("POSE", "is required, or --camera");
  }
  if (!guided && options.projector.empty()) {
    throw UserError("--projector", "is required");
  }
  const images::FrameSize projector =
      guided ? images::FrameSize{}
             : images::size_of_text("--projector", options.projector, 1 << model::GrayDecoder::kMaxBits);
  std::set<std::string> folders(options.poses.begin(), options.poses.end());
  if (folders.size() != options.poses.size()) {
    throw UserError("POSE", "a folder is given twice");
  }
  for (const std::string& check : options.checks) {
    if (!folders.insert(check).second) {
      throw UserError("--check", fmt::format("{} is given twice; a pose that takes part proves nothing", check));
    }
  }
  calibration::CalibrateSettings& settings = options.calibrate;
  settings.chessboard.columns = corners.columns;
  settings.chessboard.rows = corners.rows;
  settings.projector_columns = projector.columns;
  settings.projector_rows = projector.rows;
  settings.corners.method =
      options.corners == "direct" ? calibration::CornerMethod::direct : calibration::CornerMethod::homography;
  settings.bent = options.board == "bent";
  settings.free = {free_of(options.camera_distortion), free_of(options.projector_distortion)};
  static_cast<void>(rig::load_rig(options.rig));
  apply_plates(options, settings);
}

// Decodes the folders and finds the chessboard in each.
std::vector<calibration::PoseReport> observe(const std::vector<std::string>& folders, const CalibrateOptions& options) {
  const calibration::CalibrateSettings& settings = options.calibrate;
  const structured_light::GraySequence sequence(settings.projector_columns, settings.projector_rows);
  std::vector<std::vector<std::string>> files;
  for (const std::string& folder : folders) {
    files.push_back(images::files_of_folder(folder));
  }
  std::vector<calibration::PoseReport> poses;
  cli::Progress progress("pose", folders.size());
  for (std::size_t i = 0; i < folders.size(); ++i) {
    images::ImageSequence images(files[i], options.pixels.rule());
    const calibration::Capture capture = calibration::decode_capture(folders[i], images, sequence, options.decode);
    calibration::PoseReport& pose = poses.emplace_back(calibration::observe_pose(folders[i], capture, settings));
    if (options.unchecked) {
      cli::note_doubt(folders[i], capture.contradiction);
    } else if (pose.reason.empty() && pose.used() > 0) {
      pose.reason = capture.contradiction;
    }
    progress.update(i + 1);
  }
  return poses;
}

// After a refusal, poses that were taken live are written all the same, for nobody wants to take them twice. Returns
// how the error goes on.
std::string keep_poses(const CalibrateOptions& options, files::OutputFolder& folder) {
  if (options.capture.camera.empty()) {
    return "";
  }
  folder.commit();
  return fmt::format(
      "; the poses are kept: {0}/pose_* with --projector {1}x{2} instead of --camera calibrates from them, "
      "and from further ones",
      folder.name(), options.calibrate.projector_columns, options.calibrate.projector_rows);
}

void run_calibrate(CalibrateOptions options) {
  apply(options);
  files::OutputFolder folder(options.out);
  std::vector<calibration::PoseReport> taken;
  if (!options.capture.camera.empty()) {
    taken = capture_guided_poses(options.capture, options.decode, options.calibrate, folder);
  }
  const std::size_t parts = options.poses.size();
  std::vector<std::string> folders = options.poses;
  folders.insert(folders.end(), options.checks.begin(), options.checks.end());
  std::vector<calibration::PoseReport> poses = observe(folders, options);
  const std::vector<calibration::PoseReport> checks(poses.begin() + static_cast<std::ptrdiff_t>(parts), poses.end());
  poses.resize(parts);
  poses.insert(poses.end(), taken.begin(), taken.end());
  calibration::CalibrationReport report = calibration::calibrate(std::move(poses), options.calibrate);
  if (!report.model.refusal.empty()) {
    throw CheckFailed(fmt::format("calibrate: no rig: {}{}", report.model.refusal, keep_poses(options, folder)));
  }
  for (const calibration::PoseReport& check : checks) {
    report.checks.push_back(calibration::check_pose(check, report));
  }
  const std::string rig = rig_yaml(options, report);
  if (!rig.empty()) {
    folder.append("rig.yaml", rig);
  }
  folder.append("calibration.yaml",
                rig::calibration_yaml(report.calibration,
                                      {report.bundle.camera_rms, report.bundle.projector_rms, report.bundle.rms}));
  folder.append("report.json", calibration::report_json(report));
  folder.append("corners.csv", calibration::corner_table(report));
  folder.append("coverage.png", calibration::coverage_picture(report));
  folder.append("residuals.png", calibration::residual_picture(report));
  folder.commit();
  fmt::print("{}→ {}\n", calibration::report_text(report), folder.name());
}

void add_plate_options(CLI::App& command, CalibrateOptions& options) {
  cli::begin_group(command, "Plates: the chessboard lies at known heights over the belt");
  command
      .add_option("--plates", options.plates,
                  "Heights in mm of a plate that carries the chessboard, ascending. The first poses are those on it, "
                  "height by height and there place by place of the belt; further ones may lean freely. The least "
                  "squares start from --rig.")
      ->type_name("H,H,...");
  command
      .add_option(
          "--moves", options.moves,
          "Places of the belt in mm by its encoder, ascending, to which it takes the plate at each height. They "
          "tell which way the belt runs, which a light section must know.")
      ->type_name("X,X,...");
  command.add_option("--tolerance", options.tolerance.height_mm, "How far a height may be off, in mm.")
      ->transform(cli::number_above_zero(10))
      ->type_name("MM")
      ->capture_default_str();
  command
      .add_option("--parallel", options.tolerance.parallel_mm,
                  "How far one end of the chessboard may lie higher than the other, in mm.")
      ->transform(cli::number_above_zero(10))
      ->type_name("MM")
      ->capture_default_str();
  command
      .add_option("--square-tolerance", options.tolerance.square,
                  "How far the squares' side may be off, as a share. The heights tell the rest.")
      ->transform(cli::number_above_zero(0.1))
      ->type_name("SHARE")
      ->capture_default_str();
  command
      .add_option("--fence", options.tolerance.fence_mm,
                  "How far the plate may miss its place on the belt from height to height, in mm. Push it against a "
                  "fence that stands square to the belt.")
      ->transform(cli::number_above_zero(1000))
      ->type_name("MM")
      ->capture_default_str();
  command
      .add_option("--distance-tolerance", options.scale.distance_tolerance,
                  "How far the belt's distance may be from plane_z_mm of --rig, as a share. Only this and the focal "
                  "length tell of heights that are all wrong by one factor.")
      ->transform(cli::number_above_zero(10))
      ->type_name("SHARE")
      ->capture_default_str();
  command
      .add_option("--focal-tolerance", options.scale.focal_tolerance,
                  "How far the camera's focal length may be from that of --rig, as a share.")
      ->transform(cli::number_above_zero(10))
      ->type_name("SHARE")
      ->capture_default_str();
}

}  // namespace

void add_calibrate_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app,
      {.name = "calibrate",
       .purpose = "Calibrates camera and projector from captures of a chessboard under Gray-code patterns.",
       .details =
           "Project the patterns of `selfproj pattern gray` on a flat chessboard and capture one image of each. "
           "Repeat that for several poses of the chessboard, each in a folder of its own. Two poses are "
           "needed; use 5 or more that lean in different directions. With --camera the command takes them itself: it "
           "says which pose to take, waits for Enter, shows the patterns, and says what the poses cover.\n\n"
           "The output folder gets\n"
           "- calibration.yaml: camera, projector and the pose between them, as OpenCV YAML\n"
           "- rig.yaml: the same as a rig, unless a rig cannot describe it\n"
           "- report.json, corners.csv, coverage.png, residuals.png: how good it is, and what was left out\n\n"
           "Where the poses do not determine the result, the exit status is 1, and nothing is written but the poses "
           "that the command took itself.",
       .examples = R"(
# Capture a simulated chessboard in 4 poses, and calibrate from the captures.
selfproj pattern gray --projector 1024x768 --out patterns
selfproj-sim capture --rig scanner --patterns patterns --chessboard 9x7 --square 20 --poses 4 \
  --out captures
selfproj calibrate --chessboard 9x7 --square 20 --projector 1024x768 \
  --out calibration captures/pose_*

# Take the poses now (needs hardware)
selfproj calibrate --camera camera:192.168.1.20 --display 1 --chessboard 9x6 --square 25 \
  --out calibration
)"});
  const auto options = std::make_shared<CalibrateOptions>();
  calibration::CalibrateSettings& settings = options->calibrate;
  cli::begin_group(*command, "Chessboard and projector");
  command->add_option("--chessboard", options->chessboard, "Inner corners along the two sides of the chessboard.")
      ->type_name("NxM")
      ->required();
  command
      ->add_option("--square", settings.chessboard.square_mm,
                   "Side of a square in mm. Measure it: without --plates nothing shows that it is wrong, and all "
                   "lengths of the result are wrong by the same factor.")
      ->transform(cli::number_above_zero())
      ->type_name("MM")
      ->required();
  command
      ->add_option("--projector", options->projector,
                   "Columns and rows of the projector in pixels. Required without --camera.")
      ->type_name("WxH");
  command
      ->add_option("--rig", options->rig,
                   "Rig whose pixel pitches, rates, conveyor and measuring are copied to rig.yaml.")
      ->type_name("RIG")
      ->capture_default_str();
  add_plate_options(*command, *options);
  cli::begin_group(*command, "Live: the poses are taken now");
  command
      ->add_option("--camera", options->capture.camera,
                   "Camera and its settings, as `selfproj devices` lists them. The command says which pose to take, "
                   "waits for Enter, captures it, and says what is covered and what is missing.")
      ->type_name("URI");
  add_projector_options(*command, options->capture);
  cli::begin_group(*command, "Decoding");
  command
      ->add_option("--threshold", options->decode.threshold,
                   "A pair of images that differs by at most this many grey levels is ambiguous.")
      ->transform(cli::whole_number(0, 255))
      ->type_name("T")
      ->capture_default_str();
  command
      ->add_option("--contrast", options->decode.contrast,
                   "A pixel has a code where white is brighter than black by more than this many grey levels.")
      ->transform(cli::whole_number(0, 255))
      ->type_name("T")
      ->capture_default_str();
  cli::add_pixel_options(*command, options->pixels);
  cli::add_unchecked_option(*command, options->unchecked);
  cli::begin_group(*command, "Corners");
  command
      ->add_option("--corners", options->corners,
                   "How the projector position of a corner follows from the codes around it: by a local homography, or "
                   "by a polynomial fitted directly.")
      ->check(cli::one_of({"homography", "direct"}))
      ->type_name("METHOD")
      ->capture_default_str();
  command
      ->add_option("--window", settings.corners.window_px,
                   "Half the side of the window around a corner, in camera pixels.")
      ->transform(cli::real_number(2, 1000))
      ->type_name("PX")
      ->default_str("0.7 of the distance between corners");
  command
      ->add_option("--max-sd", settings.corners.max_sd_px,
                   "Leave out corners with a larger standard deviation in the projector, in projector pixels.")
      ->transform(cli::number_above_zero())
      ->type_name("PX")
      ->capture_default_str();
  command->add_option("--min-corners", settings.min_corners, "Leave out poses with fewer usable corners.")
      ->transform(cli::whole_number(6, 40000))
      ->type_name("N")
      ->capture_default_str();
  cli::begin_group(*command, "Estimation");
  command
      ->add_option("--reject", settings.reject,
                   "Leave out corners whose residual exceeds this many standard deviations. 0 keeps all.")
      ->transform(cli::real_number(0, 1000))
      ->type_name("K")
      ->capture_default_str();
  const std::vector<std::string> distortions = {kAuto, "0", "1", "2", "4", "5"};
  command
      ->add_option("--camera-distortion", options->camera_distortion,
                   "How many of k1, k2, p1, p2, k3 are estimated for the camera. The others are 0. auto: as many as "
                   "the captures support, without k3.")
      ->check(cli::one_of(distortions))
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--projector-distortion", options->projector_distortion, "The same for the projector.")
      ->check(cli::one_of(distortions))
      ->type_name("N")
      ->capture_default_str();
  command
      ->add_option("--board", options->board,
                   "bent: the chessboard's shape is estimated, as paper is never flat. flat: it is exactly flat.")
      ->check(cli::one_of({"bent", "flat"}))
      ->type_name("SHAPE")
      ->capture_default_str();
  command
      ->add_option("--check", options->checks,
                   "Folders of poses that take no part. For each, the output says how well the calibration explains "
                   "it.")
      ->type_name("POSE");
  cli::begin_group(*command, "Output");
  command->add_option("--out", options->out, "Folder for the results.")->type_name("DIR")->required();
  cli::add_files(
      *command, "POSE", options->poses,
      "Folders of images, one for each pose. Each holds the whole sequence, numbered in the order of the patterns.");
  add_camera_command(*command);
  add_belt_command(*command);
  add_heights_command(*command);
  command->callback([options, command] {
    if (!command->get_subcommands().empty()) {
      return;
    }
    run_calibrate(*options);
  });
}

}  // namespace selfproj::app
