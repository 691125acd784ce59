#include "host/app/calibrate_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstddef>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/calibration/calibrate.h"
#include "host/calibration/calibration_output.h"
#include "host/calibration/capture.h"
#include "host/io/frame_options.h"
#include "host/io/image_files.h"
#include "host/io/output_folder.h"
#include "host/io/progress.h"
#include "host/io/user_error.h"
#include "host/rig/calibration_file.h"
#include "host/rig/rig.h"
#include "host/rig/rig_calibration.h"
#include "host/structured_light/gray_sequence.h"
#include "model/gray_decoder.h"

namespace selfproj {
namespace {

struct CalibrateOptions {
  std::string chessboard;
  std::string projector;
  std::string corners = "homography";
  std::string channel;
  std::string rig = "scanner";
  std::string out;
  DecodeSettings decode;
  CalibrateSettings calibrate;
  std::vector<std::string> poses;
};

// The rig of the calibration, or why there can be none.
std::string rig_yaml(const CalibrateOptions& options, CalibrationReport& report) {
  try {
    const Rig rig = rig_of(report.calibration, load_rig(options.rig));
    const double error = pinhole_error(rig, report.mean_distance_mm);
    if (std::isfinite(error)) {
      report.warnings.push_back(fmt::format(
          "commands that take the rig as pinholes (all but depth) see z up to {:.3g} mm off at z = {:.0f} mm", error,
          report.mean_distance_mm));
    }
    return to_yaml(rig);
  } catch (const std::invalid_argument& error) {
    report.warnings.push_back(fmt::format("no rig.yaml: {}", error.what()));
    return {};
  }
}

void run_calibrate(CalibrateOptions options) {
  constexpr int kMostCorners = 200;
  const FrameSize corners = size_of_text("--board", options.chessboard, kMostCorners);
  if (corners.columns < 3 || corners.rows < 3) {
    throw UserError("--board",
                    fmt::format("is {}; at least 3 inner corners are needed along both sides", options.chessboard));
  }
  const FrameSize projector = size_of_text("--projector", options.projector, 1 << GrayDecoder::kMaxBits);
  if (std::set<std::string>(options.poses.begin(), options.poses.end()).size() != options.poses.size()) {
    throw UserError("POSE", "a folder is there twice");
  }
  CalibrateSettings& settings = options.calibrate;
  settings.chessboard.columns = corners.columns;
  settings.chessboard.rows = corners.rows;
  settings.projector_columns = projector.columns;
  settings.projector_rows = projector.rows;
  settings.corners.method = options.corners == "direct" ? CornerMethod::direct : CornerMethod::homography;
  static_cast<void>(load_rig(options.rig));
  OutputFolder folder(options.out);
  const GraySequence sequence(projector.columns, projector.rows);
  std::vector<std::vector<std::string>> files;
  for (const std::string& pose : options.poses) {
    files.push_back(files_of_folder(pose));
  }
  std::vector<PoseReport> poses;
  {
    Progress progress("pose", options.poses.size());
    for (std::size_t i = 0; i < options.poses.size(); ++i) {
      const Capture capture =
          decode_capture(options.poses[i], files[i], sequence, options.decode, channel_of(options.channel));
      poses.push_back(observe_pose(options.poses[i], capture, settings));
      progress.update(i + 1);
    }
  }
  CalibrationReport report = calibrate(std::move(poses), settings);
  const std::string rig = rig_yaml(options, report);
  if (!rig.empty()) {
    folder.append("rig.yaml", rig);
  }
  folder.append(
      "calibration.yaml",
      calibration_yaml(report.calibration, {report.bundle.camera_rms, report.bundle.projector_rms, report.bundle.rms}));
  folder.append("report.json", report_json(report));
  folder.append("corners.csv", corner_table(report));
  folder.append("coverage.png", coverage_picture(report));
  folder.append("residuals.png", residual_picture(report));
  folder.commit();
  fmt::print("{}→ {}\n", report_text(report), folder.name());
}

}  // namespace

void add_calibrate_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "calibrate", "Calibrate camera and projector from captures of a chessboard under the patterns of `pattern gray`");
  const auto options = std::make_shared<CalibrateOptions>();
  CalibrateSettings& settings = options->calibrate;
  command->add_option("--board", options->chessboard, "Inner corners of the board, along both sides")
      ->type_name("NxM")
      ->required();
  command->add_option("--square", settings.chessboard.square_mm, "Side of a square")
      ->check(CLI::PositiveNumber)
      ->type_name("MM")
      ->required();
  command->add_option("--projector", options->projector, "Columns and rows of the projector")
      ->type_name("WxH")
      ->required();
  command
      ->add_option("--corners", options->corners,
                   "How a corner is found in the projector: by a local homography, or by a direct polynomial fit")
      ->check(CLI::IsMember({"homography", "direct"}))
      ->capture_default_str();
  command
      ->add_option("--window", settings.corners.window_px,
                   "Half the side of the window around a corner (default: 0.7 of the corners' spacing)")
      ->check(CLI::Range(2.0, 1000.0))
      ->type_name("PX");
  command
      ->add_option("--max-sd", settings.corners.max_sd_px,
                   "Corners of a greater standard deviation in the projector are left out")
      ->check(CLI::PositiveNumber)
      ->type_name("PX")
      ->capture_default_str();
  command->add_option("--min-corners", settings.min_corners, "Poses of fewer usable corners are left out")
      ->check(CLI::Range(6, 40000))
      ->type_name("N")
      ->capture_default_str();
  command
      ->add_option("--reject", settings.reject,
                   "Corners whose residual is more than so many standard deviations are left out; 0: none")
      ->check(CLI::Range(0.0, 1000.0))
      ->type_name("K")
      ->capture_default_str();
  const CLI::IsMember distortions({0, 1, 2, 4, 5});
  command
      ->add_option("--camera-distortion", settings.free.camera,
                   "How many of k1, k2, p1, p2, k3 are estimated, the others being 0")
      ->check(distortions)
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--projector-distortion", settings.free.projector, "Likewise of the projector")
      ->check(distortions)
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--threshold", options->decode.threshold, "Differences of a pair up to this are ambiguous")
      ->check(CLI::Range(0, 255))
      ->type_name("T")
      ->capture_default_str();
  command
      ->add_option("--contrast", options->decode.contrast,
                   "Pixels where the white image is not more than this above the black one have no code")
      ->check(CLI::Range(0, 255))
      ->type_name("T")
      ->capture_default_str();
  command->add_option("--channel", options->channel, "What to take of colour images")
      ->check(CLI::IsMember(channel_names()));
  command
      ->add_option("--rig", options->rig,
                   "Rig of which rig.yaml keeps what calibration does not tell: pitches, rates, conveyor, measuring")
      ->type_name("RIG")
      ->capture_default_str();
  command->add_option("--out", options->out, "Folder for the results, written whole or not at all")
      ->type_name("DIR")
      ->required();
  command
      ->add_option("POSE", options->poses,
                   "Folders of images, one a pose, each the whole sequence in the order of its names")
      ->type_name("DIR")
      ->required();
  command->callback([options] { run_calibrate(*options); });
}

}  // namespace selfproj
