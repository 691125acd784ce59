#include "host/app/guided_poses.h"

#include <fmt/format.h>

#include <cstddef>
#include <cstdio>
#include <iostream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/calibration/calibrate.h"
#include "host/calibration/pose_advice.h"
#include "host/cli/command_line.h"
#include "host/images/image_files.h"
#include "host/images/image_sequence.h"
#include "selfproj/files/user_error.h"
#include "selfproj/structured_light/gray_sequence.h"

namespace selfproj::app {
namespace {

struct CapturedPose {
  calibration::PoseReport report;
  std::vector<std::string> images;  // as PNG
};

void say(const std::string& text) {
  fmt::print("{}\n", text);
  static_cast<void>(std::fflush(stdout));  // a pipe would hold it back while the command waits
}

// Captures the chessboard under all patterns. Sets the size of the projector in `settings`, and keeps the settle time
// in `options`.
CapturedPose capture_pose(CaptureOptions& options, const calibration::DecodeSettings& decode,
                          calibration::CalibrateSettings& settings, const std::string& name, const std::string& out) {
  std::optional<structured_light::GraySequence> gray;
  const Captured captured = capture_in_memory(options, out, [&](const capture::CaptureSizes& sizes) {
    settings.projector_columns = sizes.projector_columns;
    settings.projector_rows = sizes.projector_rows;
    gray.emplace(sizes.projector_columns, sizes.projector_rows);
    return gray_patterns(*gray, gray->count());
  });
  options.settle_ms = captured.record.settle.settle_ms;  // so that only the first capture measures it
  images::ImageSequence images = captured.sequence();
  const calibration::Capture capture = calibration::decode_capture(name, images, *gray, decode);
  cli::note_doubt(name, capture.contradiction);
  CapturedPose pose{.report = calibration::observe_pose(name, capture, settings), .images = {}};
  if (pose.report.reason.empty()) {
    for (const images::Image& image : captured.images) {
      pose.images.push_back(images::encode_png(image));
    }
  }
  return pose;
}

calibration::PoseAdvice advice_on(const std::vector<CapturedPose>& taken, const calibration::Chessboard& chessboard) {
  calibration::PoseAdvice advice(chessboard);
  for (const CapturedPose& pose : taken) {
    advice.add(pose.report);
  }
  return advice;
}

}  // namespace

std::vector<calibration::PoseReport> capture_guided_poses(const CaptureOptions& options,
                                                          const calibration::DecodeSettings& decode,
                                                          calibration::CalibrateSettings& settings,
                                                          files::OutputFolder& folder) {
  folder.check("pose_01/image_0001.png");  // before the poses, which nobody wants to take twice
  CaptureOptions capture = options;
  std::vector<CapturedPose> taken;
  for (;;) {
    const calibration::PoseAdvice advice = advice_on(taken, settings.chessboard);
    if (advice.enough()) {
      say("The poses taken so far are enough to calibrate.");
    }
    say(fmt::format("Pose {}: {}.", taken.size() + 1, advice.next()));
    say("Press Enter to capture it. Or type u to discard the last pose, or d to calibrate, and press Enter:");
    std::string line;
    if (!std::getline(std::cin, line) || line == "d") {
      break;
    }
    if (line == "u") {
      say(taken.empty() ? "There is no pose to discard." : fmt::format("Pose {} is discarded.", taken.size()));
      taken.resize(taken.empty() ? 0 : taken.size() - 1);
      continue;
    }
    if (!line.empty()) {
      say(fmt::format("'{}' is not one of the answers.", line));
      continue;
    }
    std::optional<CapturedPose> pose;
    try {
      pose = capture_pose(capture, decode, settings, fmt::format("pose_{:02}", taken.size() + 1), folder.name());
    } catch (const UserError& error) {
      if (taken.empty()) {
        throw;
      }
      say(fmt::format("This pose was not captured: {}", error.what()));  // those before must not be lost
      continue;
    }
    if (!pose->report.reason.empty()) {
      say(fmt::format("This pose is not used: {}", pose->report.reason));
      continue;
    }
    say(fmt::format("{} of {} corners were found in camera and projector.", pose->report.used(),
                    settings.chessboard.corners()));
    taken.push_back(std::move(*pose));
    say(advice_on(taken, settings.chessboard).covered());
  }
  if (taken.size() < 2) {
    throw CheckFailed(fmt::format("{}: {} taken; at least two are needed, and nothing is written", folder.name(),
                                  taken.empty() ? "no pose was" : "only one pose was"));
  }
  std::vector<calibration::PoseReport> poses;
  for (CapturedPose& pose : taken) {
    for (std::size_t i = 0; i < pose.images.size(); ++i) {
      folder.append(fmt::format("{}/image_{:04}.png", pose.report.name, i + 1), pose.images[i]);
    }
    poses.push_back(std::move(pose.report));
  }
  return poses;
}

}  // namespace selfproj::app
