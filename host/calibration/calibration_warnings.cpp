#include "host/calibration/calibration_warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace selfproj {
namespace {

// Limits within which a number counts as well constrained.
constexpr int kFewPoses = 3;
constexpr double kParallel = 15;         // degrees between the most different poses
constexpr double kPoorFocal = 0.01;      // relative standard deviation
constexpr double kPoorCentre = 0.01;     // standard deviation, of the image's longer side
constexpr double kPoorDistortion = 0.5;  // pixels at the outermost corner
constexpr double kPoorBaseline = 0.005;  // relative
constexpr double kPoorCoverage = 0.3;

// A lens from the least squares, and the used corners in its image. Rows of a mirrored projector count from below in
// both.
struct EstimatedLens {
  const char* name;
  LensParameters parameters, deviation;
  LensParameters shown;  // the parameters with rows counted as in the result
  cv::Size image;
  std::vector<cv::Point2d> corners;
};

// The greatest effect in pixels, at the outermost corner, of a distortion coefficient's standard deviation.
double distortion_px(const EstimatedLens& lens) {
  const LensParameters& p = lens.parameters;
  double greatest = 0;
  for (const cv::Point2d& corner : lens.corners) {
    greatest = std::max(greatest, std::hypot((corner.x - p[2]) / p[0], (corner.y - p[3]) / p[1]));
  }
  const double r2 = greatest * greatest;
  const std::array<double, 5> powers{greatest * r2, greatest * r2 * r2, 3 * r2, 3 * r2, greatest * r2 * r2 * r2};
  double px = 0;
  for (std::size_t i = 0; i < powers.size(); ++i) {
    px = std::max(px, p[0] * powers[i] * lens.deviation[4 + i]);
  }
  return px;
}

// With plates a centre and the lean of the camera stand in for each other; what they see together is known.
void warn_of_lens(const EstimatedLens& lens, bool plates, std::vector<std::string>& warnings) {
  const std::array<const char*, 4> names{"fx", "fy", "cx", "cy"};
  const auto warn = [&](std::size_t i, double limit, const char* of_what) {
    warnings.push_back(
        fmt::format("{} {} is {:.1f} px with a standard deviation of {:.2g} px: not constrained to {:g} %{}", lens.name,
                    names[i], lens.shown[i], lens.deviation[i], 100 * limit, of_what));
  };
  for (std::size_t i = 0; i < 2; ++i) {
    if (!(lens.deviation[i] <= kPoorFocal * lens.parameters[i])) {
      warn(i, kPoorFocal, "");
    }
  }
  const double side = std::max(lens.image.width, lens.image.height);
  for (std::size_t i = 2; i < names.size(); ++i) {
    if (!plates && !(lens.deviation[i] <= kPoorCentre * side)) {
      warn(i, kPoorCentre, " of the image");
    }
  }
  const double px = distortion_px(lens);
  if (!(px <= kPoorDistortion)) {
    warnings.push_back(
        fmt::format("{} distortion: a coefficient's standard deviation is worth {:.2g} px at the "
                    "outermost corner; estimate fewer coefficients or spread the corners wider",
                    lens.name, px));
  }
}

void warn_of_coverage(const char* name, double share, std::vector<std::string>& warnings) {
  if (share < kPoorCoverage) {
    warnings.push_back(fmt::format(
        "{}: corners cover only {:.0f} % of the image; beyond them the distortion is a guess", name, 100 * share));
  }
}

// Camera and projector.
std::array<EstimatedLens, 2> lenses_of(const CalibrationReport& report) {
  const BundleResult& found = report.bundle;
  const Calibration& calibration = report.calibration;
  EstimatedLens camera{"camera",
                       found.bundle.camera,
                       found.deviation.camera,
                       found.bundle.camera,
                       {calibration.camera_columns, calibration.camera_rows},
                       {}};
  EstimatedLens projector{"projector",
                          found.bundle.projector,
                          found.deviation.projector,
                          found.bundle.projector,
                          {calibration.projector_columns, calibration.projector_rows},
                          {}};
  const int last_row = calibration.projector_rows - 1;
  if (report.mirrored) {
    projector.shown[1] *= -1;
    projector.shown[3] = last_row - projector.shown[3];
  }
  for (const PoseReport& pose : report.poses) {
    for (const Corner& corner : pose.corners) {
      if (pose.reason.empty() && corner.used) {
        camera.corners.push_back(corner.camera);
        projector.corners.emplace_back(corner.projector.x,
                                       report.mirrored ? last_row - corner.projector.y : corner.projector.y);
      }
    }
  }
  return {camera, projector};
}

}  // namespace

std::vector<std::string> warnings_of(const CalibrationReport& report) {
  const BundleResult& found = report.bundle;
  std::vector<std::string> warnings;
  if (found.bundle.chessboard.size() < kFewPoses) {
    warnings.push_back(fmt::format("only {} poses: their noise, rather than the fit's residuals, decides",
                                   found.bundle.chessboard.size()));
  }
  // Plates are parallel; that they are at known heights tells what leaning poses would.
  if (!report.belt && report.greatest_angle_deg < kParallel) {
    warnings.push_back(
        fmt::format("all poses are parallel within {:.1f} degrees: focal lengths and distances cannot "
                    "be told apart well; turn the board by 20 to 45 degrees",
                    report.greatest_angle_deg));
  }
  for (const EstimatedLens& lens : lenses_of(report)) {
    warn_of_lens(lens, report.belt.has_value(), warnings);
  }
  const double baseline = cv::norm(found.bundle.stereo.translation);
  if (!(found.baseline_deviation <= kPoorBaseline * baseline)) {
    warnings.push_back(
        fmt::format("baseline {:.2f} mm with a standard deviation of {:.2g} mm: not constrained to {:g} %", baseline,
                    found.baseline_deviation, 100 * kPoorBaseline));
  }
  warn_of_coverage("camera", report.camera_coverage, warnings);
  warn_of_coverage("projector", report.projector_coverage, warnings);
  return warnings;
}

}  // namespace selfproj
