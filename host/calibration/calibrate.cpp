#include "host/calibration/calibrate.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <exception>
#include <limits>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/calibration/bundle_solver.h"
#include "host/calibration/capture.h"
#include "host/calibration/chessboard.h"
#include "host/calibration/model_choice.h"
#include "host/calibration/plates.h"
#include "host/calibration/starts.h"
#include "host/files/numbers.h"
#include "host/images/frame_options.h"
#include "selfproj/files/user_error.h"
#include "selfproj/rig/calibration.h"
#include "selfproj/rig/optics.h"

namespace selfproj::calibration {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kDegrees = 180 / std::numbers::pi;

// Whether the corners turn the other way round in the projector than in the camera.
bool is_mirrored(const std::vector<View>& views) {
  double sum = 0;
  for (const View& view : views) {
    for (std::size_t i = 0; i + 2 < view.sights.size(); ++i) {
      const Sight& a = view.sights[i];
      const Sight& b = view.sights[i + 1];
      const Sight& c = view.sights[view.sights.size() - 1];
      const double camera = (b.camera - a.camera).cross(c.camera - a.camera);
      const double projector = (b.projector - a.projector).cross(c.projector - a.projector);
      sum += camera * projector < 0 ? -1 : 1;
    }
  }
  return sum < 0;
}

// The length above which a residual is not noise: `factor` standard deviations of one direction, which is `noise`, or
// the estimate from the median length if that is greater. At least a hundredth of a pixel, so that exact data lose
// nothing.
double limit_of(const std::vector<std::vector<cv::Vec2d>>& residuals, double factor, double noise) {
  constexpr double kPerMedian = 0.8493;  // for Rayleigh's distribution: 1/sqrt(2 ln 2)
  constexpr double kMin = 0.01;
  std::vector<double> lengths;
  for (const auto& view : residuals) {
    for (const cv::Vec2d& residual : view) {
      lengths.push_back(cv::norm(residual));
    }
  }
  return std::max(kMin, factor * std::max(noise, kPerMedian * files::median_of(lengths)));
}

double hull_share(const std::vector<cv::Point2f>& points, cv::Size size) {
  std::vector<cv::Point2f> hull;
  cv::convexHull(points, hull);
  return cv::contourArea(hull) / (static_cast<double>(size.width) * size.height);
}

// Connects poses and corners with the views made of them.
struct Index {
  std::vector<View> views;
  std::vector<std::size_t> pose;  // pose of each view
  std::optional<Plates> plates;   // under these views
};

class Calibrator {
 public:
  Calibrator(std::vector<PoseReport> poses, const CalibrateSettings& settings) {
    report_.poses = std::move(poses);
    report_.settings = settings;
  }

  CalibrationReport run() {
    check_sizes();
    if (report_.settings.bent) {
      report_.shape = board_modes(report_.settings.chessboard);
    }
    leave_out_poor_poses();
    Index index = used();
    report_.mirrored = is_mirrored(index.views);
    index = used();
    choose(index);
    refuse_plates(index);
    while (report_.settings.reject > 0 && reject_all(index)) {
      choose(index);
    }
    check_starts(index.views, model_settings(index), report_.model);
    report_.bundle = report_.model.result;
    fit_alone(index);
    finish(index);
    refuse_scale(index);
    report_.warnings = warnings_of(report_);
    return std::move(report_);
  }

 private:
  void check_sizes() {
    if (report_.poses.empty()) {
      throw UserError("calibrate", "there are no captures");
    }
    const PoseReport& first = report_.poses.front();
    for (const PoseReport& pose : report_.poses) {
      if (pose.rows != first.rows || pose.columns != first.columns) {
        throw UserError(pose.name,
                        fmt::format("has images of {}, but {} of {}", images::size_text(pose.rows, pose.columns),
                                    first.name, images::size_text(first.rows, first.columns)));
      }
    }
    camera_size_ = {first.columns, first.rows};
    projector_size_ = {report_.settings.projector_columns, report_.settings.projector_rows};
  }

  void leave_out_poor_poses() {
    constexpr double kDark = 0.1;  // about half of a chessboard is white
    std::size_t left = 0;
    for (PoseReport& pose : report_.poses) {
      if (pose.reason.empty() && pose.used() == 0) {
        pose.reason =
            pose.lit_share < kDark
                ? fmt::format(
                      "its chessboard is seen, but hardly the projector's light: in {:.1f} % of its pixels "
                      "white exceeds black by the contrast that is asked for; it needs more of this light, or "
                      "less of any other (or white and black are in another order)",
                      100 * pose.lit_share)
                : "its chessboard is seen, but no corner has codes; the images are likely in another order than the "
                  "patterns";
      } else if (pose.reason.empty() && pose.used() < report_.settings.min_corners) {
        pose.reason = fmt::format("only {} of {} corners can be used; {} are needed", pose.used(),
                                  report_.settings.chessboard.corners(), report_.settings.min_corners);
      }
      left += pose.reason.empty() ? 1 : 0;
    }
    if (left >= 2) {
      return;
    }
    std::string reasons;
    for (const PoseReport& pose : report_.poses) {
      if (!pose.reason.empty()) {
        reasons += fmt::format("; {}: {}", pose.name, pose.reason);
      }
    }
    throw UserError("calibrate", fmt::format("{} of {} poses can be used; at least 2 are needed, and 3 or more in "
                                             "different directions advised{}",
                                             left, report_.poses.size(), reasons));
  }

  [[nodiscard]] Index used() const {
    Index index;
    for (std::size_t p = 0; p < report_.poses.size(); ++p) {
      const PoseReport& pose = report_.poses[p];
      if (!pose.reason.empty()) {
        continue;
      }
      index.pose.push_back(p);
      index.views.push_back(view_of(pose, report_.settings, report_.mirrored));
    }
    if (report_.settings.plates) {
      index.plates = plates_under(index.pose);
    }
    return index;
  }

  // The plates under the poses of the views. Rows of a mirrored projector count from below.
  [[nodiscard]] Plates plates_under(const std::vector<std::size_t>& poses) const {
    Plates plates = *report_.settings.plates;
    const std::vector<PlatePlace> all = std::exchange(plates.places, {});
    for (const std::size_t pose : poses) {
      plates.places.push_back(pose < all.size() ? all[pose] : PlatePlace{});
    }
    if (report_.mirrored) {
      plates.projector[1] *= -1;
      plates.projector[3] = projector_size_.height - 1 - plates.projector[3];
    }
    return plates;
  }

  // Throws UserError if the plates are not where they are said to be.
  void refuse_plates(const Index& index) const {
    if (index.plates) {
      const std::string fault = fault_of_plates(index.views, *index.plates, report_.bundle.bundle);
      if (!fault.empty()) {
        throw UserError("--plates", fault);
      }
    }
  }

  // A calibration whose scale contradicts the drawings must not be used. Where the starts disagree as well, a wrong
  // scale is the likely reason: lenses so far from the drawings are hard to find.
  void refuse_scale(const Index& index) {
    if (!report_.belt) {
      return;
    }
    const std::string fault =
        fault_of_scale(index.plates->scale, report_.belt->plane_z_mm, report_.bundle.bundle.camera[0]);
    if (!fault.empty()) {
      report_.model.refusal = fault;
    }
  }

  [[nodiscard]] ModelSettings model_settings(const Index& index) const {
    return {camera_size_, projector_size_, report_.settings.free, shape(), index.plates ? &*index.plates : nullptr};
  }

  [[nodiscard]] const std::vector<CornerModes>* shape() const {
    return report_.shape.empty() ? nullptr : &report_.shape;
  }

  void choose(const Index& index) {
    try {
      report_.model = choose_model(index.views, model_settings(index));
    } catch (const std::runtime_error& error) {
      throw UserError("calibrate", error.what());
    } catch (const std::invalid_argument& error) {
      throw UserError("calibrate", error.what());
    }
    report_.bundle = report_.model.result;
  }

  // Each lens by itself, for its RMS.
  void fit_alone(const Index& index) {
    const auto rms = [&](const std::vector<View>& views, const Bundle& start, int free) {
      BundleOptions options;
      options.plates = index.plates ? &*index.plates : nullptr;
      options.free.camera = free;
      options.shape = shape();
      options.projector = false;
      try {
        return solve_bundle(views, start, options).camera_rms;
      } catch (const std::exception&) {  // too little for one lens alone
        return kNan;
      }
    };
    const Bundle& both = report_.bundle.bundle;
    report_.camera_alone_rms = rms(index.views, both, report_.model.free.camera);
    std::vector<View> views = index.views;
    Bundle start = both;
    start.camera = both.projector;
    start.noise.camera = both.noise.projector;
    for (std::size_t v = 0; v < views.size(); ++v) {
      for (Sight& sight : views[v].sights) {
        sight.camera = sight.projector;
      }
      const Pose& pose = both.chessboard[v];
      cv::composeRT(pose.rotation, pose.translation, both.stereo.rotation, both.stereo.translation,
                    start.chessboard[v].rotation, start.chessboard[v].translation);
    }
    cv::composeRT(both.belt.pose.rotation, both.belt.pose.translation, both.stereo.rotation, both.stereo.translation,
                  start.belt.pose.rotation, start.belt.pose.translation);
    report_.projector_alone_rms = rms(views, start, report_.model.free.projector);
  }

  // Removes corners until none is too far off in the model chosen, or a whole pose goes. Returns whether any was
  // removed.
  bool reject_all(Index& index) {
    bool any = false;
    while (reject(index)) {
      any = true;
      const std::size_t poses = index.views.size();
      leave_out_poor_poses();
      index = used();
      if (index.views.size() != poses) {
        break;
      }
      refit(index.views, model_settings(index), report_.model);
      report_.bundle = report_.model.result;
    }
    return any;
  }

  // Removes corners that are too far off in the camera or in the projector. Returns whether there were any.
  bool reject(const Index& index) {
    const BundleResult& found = report_.bundle;
    const double camera_limit = limit_of(found.camera_residuals, report_.settings.reject, found.bundle.noise.camera);
    const double projector_limit =
        limit_of(found.projector_residuals, report_.settings.reject, found.bundle.noise.projector);
    bool any = false;
    for (std::size_t v = 0; v < index.views.size(); ++v) {
      for (std::size_t i = 0; i < index.views[v].sights.size(); ++i) {
        const double camera = cv::norm(found.camera_residuals[v][i]);
        const double projector = cv::norm(found.projector_residuals[v][i]);
        if (camera <= camera_limit && projector <= projector_limit) {
          continue;
        }
        Corner& corner =
            report_.poses[index.pose[v]].corners[static_cast<std::size_t>(index.views[v].sights[i].corner)];
        corner.used = false;
        corner.reason =
            camera > camera_limit
                ? fmt::format("residual of {:.3f} px in the camera; the limit is {:.3f}", camera, camera_limit)
                : fmt::format("residual of {:.3f} px in the projector; the limit is {:.3f}", projector,
                              projector_limit);
        any = true;
      }
    }
    return any;
  }

  void finish(const Index& index) {
    if (index.plates) {
      report_.belt = belt_report(*index.plates, report_.bundle);
    }
    const BundleResult& found = report_.bundle;
    rig::Calibration& calibration = report_.calibration;
    calibration.camera = lens_of(found.bundle.camera);
    calibration.projector = lens_of(found.bundle.projector);
    if (report_.mirrored) {
      calibration.projector.fy *= -1;
      calibration.projector.cy = projector_size_.height - 1 - calibration.projector.cy;
    }
    cv::Rodrigues(found.bundle.stereo.rotation, calibration.rotation);
    calibration.translation = found.bundle.stereo.translation;
    calibration.camera_columns = camera_size_.width;
    calibration.camera_rows = camera_size_.height;
    calibration.projector_columns = projector_size_.width;
    calibration.projector_rows = projector_size_.height;

    std::vector<cv::Vec3d> normals;
    std::vector<cv::Point2f> in_camera;
    std::vector<cv::Point2f> in_projector;
    double distance = 0;
    for (std::size_t v = 0; v < index.views.size(); ++v) {
      PoseReport& pose = report_.poses[index.pose[v]];
      cv::Matx33d rotation;
      cv::Rodrigues(found.bundle.chessboard[v].rotation, rotation);
      normals.emplace_back(rotation(0, 2), rotation(1, 2), rotation(2, 2));
      pose.angle_deg = kDegrees * std::acos(std::min(1.0, std::abs(normals.back()[2])));
      pose.camera_rms = found.view_camera_rms[v];
      pose.projector_rms = found.view_projector_rms[v];
      for (std::size_t i = 0; i < index.views[v].sights.size(); ++i) {
        const Sight& sight = index.views[v].sights[i];
        Corner& corner = pose.corners[static_cast<std::size_t>(sight.corner)];
        corner.camera_residual = found.camera_residuals[v][i];
        corner.projector_residual = found.projector_residuals[v][i];
        if (report_.mirrored) {
          corner.projector_residual[1] *= -1;
        }
        in_camera.emplace_back(corner.camera);
        in_projector.emplace_back(corner.projector);
        distance += (rotation * cv::Vec3d(sight.chessboard.x, sight.chessboard.y, sight.chessboard.z))[2] +
                    found.bundle.chessboard[v].translation[2];
      }
    }
    for (const cv::Vec3d& a : normals) {
      for (const cv::Vec3d& b : normals) {
        report_.max_angle_deg =
            std::max(report_.max_angle_deg, kDegrees * std::acos(std::min(1.0, std::abs(a.dot(b)))));
      }
    }
    report_.board_range_mm = board_range(index);
    report_.mean_distance_mm = distance / static_cast<double>(in_camera.size());
    report_.camera_coverage = hull_share(in_camera, camera_size_);
    report_.projector_coverage = hull_share(in_projector, projector_size_);
  }

  // Highest less lowest corner of the shape that all poses share, mm.
  [[nodiscard]] double board_range(const Index& index) const {
    double low = 0;
    double high = 0;
    for (const View& view : index.views) {
      for (const Sight& sight : view.sights) {
        const double z = place_on_board(sight, report_.bundle.bundle, shape())[2];
        low = std::min(low, z);
        high = std::max(high, z);
      }
    }
    return high - low;
  }

  CalibrationReport report_;
  cv::Size camera_size_;
  cv::Size projector_size_;
};

}  // namespace

int PoseReport::used() const {
  return static_cast<int>(std::count_if(corners.begin(), corners.end(), [](const Corner& c) { return c.used; }));
}

namespace {

// The share of the pixels that are lit in the rectangle around these places; 1 without any.
double lit_share(const Capture& capture, const std::vector<cv::Point2d>& corners) {
  if (corners.empty() || capture.lit.empty()) {
    return 1;
  }
  std::vector<cv::Point2f> places(corners.begin(), corners.end());
  const cv::Rect box = cv::boundingRect(places) & cv::Rect(0, 0, capture.columns, capture.rows);
  std::size_t lit = 0;
  for (int row = box.y; row < box.y + box.height; ++row) {
    const auto first = capture.lit.begin() + static_cast<std::ptrdiff_t>(row) * capture.columns + box.x;
    lit += static_cast<std::size_t>(std::count(first, first + box.width, true));
  }
  return static_cast<double>(lit) / std::max(1, box.area());
}

}  // namespace

PoseReport observe_pose(const std::string& name, const Capture& capture, const CalibrateSettings& settings) {
  PoseReport pose;
  pose.name = name;
  pose.rows = capture.rows;
  pose.columns = capture.columns;
  pose.decoded_share = static_cast<double>(capture.decoded()) / static_cast<double>(capture.projector_column.size());
  const FoundChessboard found = find_chessboard(capture.mean, settings.chessboard);
  pose.reason = found.reason;
  pose.by_squares = found.by_squares;
  pose.lit_share = lit_share(capture, found.corners);
  for (const cv::Point2d& at : found.corners) {
    const CornerCode code = corner_code(capture, at, found.spacing_px, settings.corners);
    Corner corner;
    corner.camera = at;
    corner.projector = code.valid ? code.projector : cv::Point2d(kNan, kNan);
    corner.sd_px = code.sd_px;
    corner.used = code.valid;
    if (!code.valid) {
      corner.reason = std::isfinite(code.sd_px)
                          ? fmt::format("its place in the projector is uncertain by {:.2f} px; {} pixels decoded",
                                        code.sd_px, code.pixels)
                          : fmt::format("too few pixels around it are decoded ({})", code.pixels);
    }
    pose.corners.push_back(corner);
  }
  return pose;
}

View view_of(const PoseReport& pose, const CalibrateSettings& settings, bool mirrored) {
  View view;
  for (std::size_t i = 0; i < pose.corners.size(); ++i) {
    const Corner& corner = pose.corners[i];
    if (corner.used) {
      const cv::Point2d& seen = corner.projector;
      const double row = mirrored ? settings.projector_rows - 1 - seen.y : seen.y;
      view.sights.push_back(
          {static_cast<int>(i), settings.chessboard.place(static_cast<int>(i)), corner.camera, {seen.x, row}});
    }
  }
  return view;
}

CalibrationReport calibrate(std::vector<PoseReport> poses, const CalibrateSettings& settings) {
  return Calibrator(std::move(poses), settings).run();
}

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
  const auto warn = [&](std::size_t i, double limit, const char* of_what) {
    warnings.push_back(
        fmt::format("{} {} is {:.1f} px with a standard deviation of {:.2g} px: not constrained to {:g} %{}", lens.name,
                    kLensNames[i], lens.shown[i], lens.deviation[i], 100 * limit, of_what));
  };
  for (std::size_t i = 0; i < 2; ++i) {
    if (!(lens.deviation[i] <= kPoorFocal * lens.parameters[i])) {
      warn(i, kPoorFocal, "");
    }
  }
  const double side = std::max(lens.image.width, lens.image.height);
  for (std::size_t i = 2; i < kPinholeParameters; ++i) {
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
  const rig::Calibration& calibration = report.calibration;
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
  if (!report.belt && report.max_angle_deg < kParallel) {
    warnings.push_back(
        fmt::format("all poses are parallel within {:.1f} degrees: focal lengths and distances cannot "
                    "be told apart well; turn the board by 20 to 45 degrees",
                    report.max_angle_deg));
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

namespace {

// The point halfway between a camera pixel's ray and a projector pixel's, in the camera's frame; nothing if a lens has
// no ray for its pixel.
std::optional<cv::Vec3d> triangulated(const rig::Calibration& c, const Corner& corner) {
  const std::optional<cv::Vec2d> in_camera = c.camera.ray({corner.camera.x, corner.camera.y});
  const std::optional<cv::Vec2d> in_projector = c.projector.ray({corner.projector.x, corner.projector.y});
  if (!in_camera || !in_projector) {
    return std::nullopt;
  }
  const cv::Vec3d a((*in_camera)[0], (*in_camera)[1], 1);
  const cv::Vec3d b = c.rotation.t() * cv::Vec3d((*in_projector)[0], (*in_projector)[1], 1);
  const cv::Vec3d from = -(c.rotation.t() * c.translation);  // the projector's place
  const cv::Matx22d normal(a.dot(a), -a.dot(b), -a.dot(b), b.dot(b));
  const cv::Vec2d along = normal.inv() * cv::Vec2d(a.dot(from), -b.dot(from));
  return 0.5 * (along[0] * a + from + along[1] * b);
}

// Compares the triangulated corners with the chessboard, whose scale is free.
void measure(const PoseReport& pose, const View& view, const CalibrationReport& report, CheckReport& check) {
  const std::vector<CornerModes>* shape = report.shape.empty() ? nullptr : &report.shape;
  Eigen::Matrix3Xd on_board(3, static_cast<Eigen::Index>(view.sights.size()));
  Eigen::Matrix3Xd seen(3, on_board.cols());
  Eigen::Index count = 0;
  for (const Sight& sight : view.sights) {
    const auto point = triangulated(report.calibration, pose.corners[static_cast<std::size_t>(sight.corner)]);
    if (point) {
      const cv::Vec3d place = place_on_board(sight, report.bundle.bundle, shape);
      on_board.col(count) << place[0], place[1], place[2];
      seen.col(count++) << (*point)[0], (*point)[1], (*point)[2];
    }
  }
  constexpr Eigen::Index kMin = 4;
  if (count < kMin) {
    check.reason = "too few of its corners can be triangulated";
    return;
  }
  on_board.conservativeResize(3, count);
  seen.conservativeResize(3, count);
  const Eigen::Matrix4d map = Eigen::umeyama(on_board, seen, true);
  const Eigen::Matrix3Xd off =
      seen - ((map.topLeftCorner<3, 3>() * on_board).colwise() + map.topRightCorner<3, 1>()).eval();
  check.scale = map.topLeftCorner<3, 1>().norm() - 1;
  check.point_rms_mm = std::sqrt(off.squaredNorm() / static_cast<double>(count));
}

}  // namespace

CheckReport check_pose(const PoseReport& pose, const CalibrationReport& report) {
  CheckReport check;
  check.name = pose.name;
  check.corners = pose.used();
  check.reason = pose.reason;
  if (check.reason.empty() &&
      (pose.rows != report.calibration.camera_rows || pose.columns != report.calibration.camera_columns)) {
    check.reason = "its images have another size";
  }
  if (check.reason.empty() && check.corners < report.settings.min_corners) {
    check.reason = "too few of its corners can be used";
  }
  if (!check.reason.empty()) {
    return check;
  }
  const std::vector<CornerModes>* shape = report.shape.empty() ? nullptr : &report.shape;
  const View view = view_of(pose, report.settings, report.mirrored);
  try {
    const Pose start = chessboard_pose(view, report.bundle.bundle.camera);
    if (!(start.translation[2] > 0)) {
      throw std::runtime_error("no pose of the chessboard explains its corners");
    }
    const BundleResult found = locate_view(view, report.bundle.bundle, start, shape);
    check.camera_rms = found.camera_rms;
    check.projector_rms = found.projector_rms;
    measure(pose, view, report, check);
  } catch (const std::runtime_error& error) {
    check.reason = error.what();
  }
  return check;
}

namespace {

// Twice what a projector line is worth in z in the middle of the camera's image, at this distance.
double coarse(const rig::Rig& rig, double distance_mm) {
  const rig::RigOptics optics(rig);
  const auto ray = optics.ray({0.5 * (rig.camera.rows - 1), 0.5 * (rig.camera.columns - 1)});
  const double way = ray ? 2 * optics.z_per_line(*ray, distance_mm) : 0;
  return std::isfinite(way) ? way : 0;
}

}  // namespace

rig::Rig calibrated_rig(const CalibrationReport& report, const rig::Rig& drawn) {
  rig::Rig rig = rig::rig_of(report.calibration, drawn);
  if (report.belt) {
    if (report.belt->moved) {
      rig.belt_pose = report.belt->pose;
    }
    rig.plane_z_mm = report.belt->plane_z_mm;
  }
  if (rig.kind == rig::RigKind::light_section) {
    using rig::ValueSource;
    const rig::RigSources before = drawn.sources.value_or(rig::RigSources{});
    // Places of the belt are those of its encoder, and the chessboard has moved as far.
    rig.sources =
        rig::RigSources{.camera = ValueSource::measured,
                        .light = ValueSource::measured,
                        .belt = report.belt ? ValueSource::measured : before.belt,
                        .speed = before.speed,
                        .encoder = report.belt && report.belt->moved ? ValueSource::measured : before.encoder};
  }
  if (rig.kind == rig::RigKind::scanner) {
    // The limit of the drawn rig may be that of a much finer one.
    rig.measure.max_z_per_line_mm = std::max(rig.measure.max_z_per_line_mm, coarse(rig, report.mean_distance_mm));
  }
  return rig;
}

}  // namespace selfproj::calibration
