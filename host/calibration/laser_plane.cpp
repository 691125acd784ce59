#include "host/calibration/laser_plane.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/calibration/bundle.h"
#include "host/calibration/bundle_solver.h"
#include "host/files/numbers.h"
#include "host/images/frame_options.h"
#include "selfproj/files/user_error.h"
#include "selfproj/rig/calibration.h"

namespace selfproj::calibration {
namespace {

// The camera's corners of an image, for the least squares.
View view_of(const BoardImage& image, const Chessboard& board) {
  View view;
  for (std::size_t i = 0; i < image.corners.size(); ++i) {
    if (image.used[i]) {
      const int corner = static_cast<int>(i);
      view.sights.push_back({corner, board.place(corner), image.corners[i], {}});
    }
  }
  return view;
}

class CameraCalibrator {
 public:
  CameraCalibrator(std::vector<BoardImage> images, const CameraSettings& settings) {
    report_.images = std::move(images);
    report_.settings = settings;
  }

  CameraReport run() {
    if (report_.images.empty()) {
      throw UserError("calibrate camera", "there are no images");
    }
    const BoardImage& first = report_.images.front();
    for (const BoardImage& image : report_.images) {
      if (image.rows != first.rows || image.columns != first.columns) {
        throw UserError(image.name, fmt::format("is {}, but {} is {}", images::size_text(image.rows, image.columns),
                                                first.name, images::size_text(first.rows, first.columns)));
      }
    }
    if (report_.settings.bent) {
      report_.shape = board_modes(report_.settings.chessboard);
    }
    collect();
    choose();
    while (report_.settings.reject > 0 && reject()) {
      collect();
      choose();
    }
    check_starts(views_, model_settings(), report_.model);
    for (std::size_t v = 0; v < views_.size(); ++v) {
      report_.images[report_.image_of_view[v]].rms_px = report_.model.result.view_camera_rms[v];
    }
    return std::move(report_);
  }

 private:
  // The views of the images that can be used.
  void collect() {
    views_.clear();
    report_.image_of_view.clear();
    std::string reasons;
    for (std::size_t i = 0; i < report_.images.size(); ++i) {
      BoardImage& image = report_.images[i];
      if (image.reason.empty() && image.used_corners() < report_.settings.min_corners) {
        image.reason = fmt::format("only {} of {} corners can be used; {} are needed", image.used_corners(),
                                   report_.settings.chessboard.corners(), report_.settings.min_corners);
      }
      if (image.reason.empty()) {
        views_.push_back(view_of(image, report_.settings.chessboard));
        report_.image_of_view.push_back(i);
      } else {
        reasons += fmt::format("; {}: {}", image.name, image.reason);
      }
    }
    if (views_.size() < 2) {
      throw UserError("calibrate camera", fmt::format("{} of {} images can be used; at least 2 are needed, and 5 or "
                                                      "more in different directions advised{}",
                                                      views_.size(), report_.images.size(), reasons));
    }
  }

  [[nodiscard]] ModelSettings model_settings() const {
    const BoardImage& first = report_.images.front();
    ModelSettings settings;
    settings.camera = {first.columns, first.rows};
    settings.free = {report_.settings.distortion, 0};
    settings.shape = report_.shape.empty() ? nullptr : &report_.shape;
    settings.with_projector = false;
    return settings;
  }

  void choose() {
    try {
      report_.model = choose_model(views_, model_settings());
    } catch (const std::runtime_error& error) {
      throw UserError("calibrate camera", error.what());
    } catch (const std::invalid_argument& error) {
      throw UserError("calibrate camera", error.what());
    }
  }

  // Leaves out corners that are too far off. Returns whether there were any.
  bool reject() {
    constexpr double kMin = 0.01;  // px, so that exact data lose nothing
    const BundleResult& found = report_.model.result;
    const double limit = std::max(kMin, report_.settings.reject * found.bundle.noise.camera);
    bool any = false;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      BoardImage& image = report_.images[report_.image_of_view[v]];
      for (std::size_t i = 0; i < views_[v].sights.size(); ++i) {
        if (cv::norm(found.camera_residuals[v][i]) > limit) {
          image.used[static_cast<std::size_t>(views_[v].sights[i].corner)] = false;
          any = true;
        }
      }
    }
    return any;
  }

  CameraReport report_;
  std::vector<View> views_;
};

// A chessboard in space: its plane, and how far its surface is from it.
class BoardInSpace {
 public:
  BoardInSpace(const CameraReport& camera, std::size_t view) : board_(camera.settings.chessboard) {
    const Bundle& found = camera.model.result.bundle;
    const Pose& pose = found.chessboard[view];
    cv::Rodrigues(pose.rotation, turn_);
    at_ = pose.translation;
    const std::vector<CornerModes>* shape = camera.shape.empty() ? nullptr : &camera.shape;
    for (int i = 0; i < board_.corners(); ++i) {
      Sight sight;
      sight.corner = i;
      sight.chessboard = board_.place(i);
      height_.push_back(place_on_board(sight, found, shape)[2]);
    }
  }

  // The point that a ray (x, y, 1) meets between the outermost corners, if it is not near the edge of a square.
  [[nodiscard]] std::optional<cv::Vec3d> meet(const cv::Vec2d& ray) const {
    constexpr double kNear = 0.15;  // of a square
    constexpr int kRounds = 3;
    const cv::Vec3d direction = turn_.t() * cv::Vec3d(ray[0], ray[1], 1);
    const cv::Vec3d from = turn_.t() * at_;
    double height = 0;
    cv::Vec3d on;
    for (int i = 0; i < kRounds; ++i) {
      on = ((height + from[2]) / direction[2]) * direction - from;
      const double u = on[0] / board_.square_mm;
      const double v = on[1] / board_.square_mm;
      if (!(u > 0 && v > 0 && u < board_.columns - 1 && v < board_.rows - 1)) {
        return std::nullopt;
      }
      if (i + 1 == kRounds && (std::abs(v - std::round(v)) < kNear || std::abs(u - std::round(u)) < kNear)) {
        return std::nullopt;
      }
      height = height_at(u, v);
    }
    return turn_ * on + at_;
  }

 private:
  // Between the four corners around a place.
  [[nodiscard]] double height_at(double u, double v) const {
    const int column = static_cast<int>(u);
    const int row = static_cast<int>(v);
    const auto at = [&](int i, int j) { return height_[static_cast<std::size_t>(j * board_.columns + i)]; };
    const double across = u - column;
    const double down = v - row;
    return (1 - down) * ((1 - across) * at(column, row) + across * at(column + 1, row)) +
           down * ((1 - across) * at(column, row + 1) + across * at(column + 1, row + 1));
  }

  Chessboard board_;
  cv::Matx33d turn_;
  cv::Vec3d at_;
  std::vector<double> height_;  // of each corner over the plane
};

struct FittedPlane {
  Eigen::Vector3d normal, middle;
  Eigen::Vector3d extents;  // root mean squares along the plane's normal, its short side and its long one
  double rms = 0;
  std::vector<bool> on;
};

// Total least squares over the points that are on.
FittedPlane plane_of(const std::vector<Eigen::Vector3d>& points, std::vector<bool> on) {
  FittedPlane plane;
  plane.middle.setZero();
  double count = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (on[i]) {
      plane.middle += points[i];
      ++count;
    }
  }
  plane.middle /= count;
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (on[i]) {
      squares += (points[i] - plane.middle) * (points[i] - plane.middle).transpose();
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(squares / count);
  plane.normal = solver.eigenvectors().col(0);
  plane.extents = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  plane.rms = plane.extents[0];
  plane.on = std::move(on);
  return plane;
}

// The same without the points that are far off, by the median of the distances.
FittedPlane robust_plane(const std::vector<Eigen::Vector3d>& points) {
  constexpr int kRounds = 20;
  constexpr double kSpreads = 4.5 * 1.4826;
  constexpr double kMin = 1e-6;  // mm
  FittedPlane plane = plane_of(points, std::vector<bool>(points.size(), true));
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> distances;
    distances.reserve(points.size());
    for (const Eigen::Vector3d& point : points) {
      distances.push_back(std::abs(plane.normal.dot(point - plane.middle)));
    }
    const double limit = std::max(kMin, kSpreads * files::median_of(distances));
    std::vector<bool> on(points.size());
    std::transform(distances.begin(), distances.end(), on.begin(), [&](double d) { return d <= limit; });
    if (on == plane.on) {
      break;
    }
    plane = plane_of(points, std::move(on));
  }
  return plane;
}

}  // namespace

int BoardImage::used_corners() const { return static_cast<int>(std::count(used.begin(), used.end(), true)); }

BoardImage observe_board(const std::string& name, const images::Image& image, const Chessboard& chessboard,
                         const images::Image* light) {
  const FoundChessboard found =
      light != nullptr ? find_chessboard_under_line(image, *light, chessboard) : find_chessboard(image, chessboard);
  BoardImage result;
  result.name = name;
  result.reason = found.reason;
  result.by_squares = found.by_squares;
  result.rows = image.rows;
  result.columns = image.columns;
  result.corners = found.corners;
  result.used.assign(found.corners.size(), true);
  std::transform(found.hidden.begin(), found.hidden.end(), result.used.begin(), [](bool hidden) { return !hidden; });
  return result;
}

CameraReport calibrate_camera(std::vector<BoardImage> images, const CameraSettings& settings) {
  return CameraCalibrator(std::move(images), settings).run();
}

std::vector<cv::Point2d> line_centres(const images::Image& image, int threshold) {
  std::vector<cv::Point2d> centres;
  for (int c = 0; c < image.columns; ++c) {
    const auto at = [&](int r) {
      return static_cast<int>(image.pixels[static_cast<std::size_t>(r) * static_cast<std::size_t>(image.columns) +
                                           static_cast<std::size_t>(c)]);
    };
    int peak = 0;
    for (int r = 1; r < image.rows; ++r) {
      peak = at(r) > at(peak) ? r : peak;
    }
    int first = peak;
    int last = peak;
    while (first > 0 && at(first - 1) > threshold) {
      --first;
    }
    while (last + 1 < image.rows && at(last + 1) > threshold) {
      ++last;
    }
    if (at(peak) <= threshold || first == 0 || last == image.rows - 1) {
      continue;
    }
    double sum = 0;
    double moment = 0;
    for (int r = first; r <= last; ++r) {
      sum += at(r) - threshold;
      moment += r * static_cast<double>(at(r) - threshold);
    }
    centres.emplace_back(c, moment / sum);
  }
  return centres;
}

LaserPlane laser_plane(const CameraReport& camera, const std::vector<images::Image>& lines) {
  constexpr std::size_t kMinImages = 3;
  const rig::Lens lens = lens_of(camera.model.result.bundle.camera);
  std::vector<Eigen::Vector3d> points;
  std::vector<std::size_t> image_of_point;
  LaserPlane result;
  for (std::size_t v = 0; v < camera.image_of_view.size(); ++v) {
    const BoardInSpace board(camera, v);
    std::vector<Eigen::Vector3d> own;
    for (const cv::Point2d& centre : line_centres(lines[camera.image_of_view[v]], camera.settings.threshold)) {
      const std::optional<cv::Vec2d> ray = lens.ray({centre.x, centre.y});
      const std::optional<cv::Vec3d> at = ray ? board.meet(*ray) : std::nullopt;
      if (at) {
        own.emplace_back((*at)[0], (*at)[1], (*at)[2]);
      }
    }
    if (own.size() >= kMinLinePoints) {
      points.insert(points.end(), own.begin(), own.end());
      image_of_point.insert(image_of_point.end(), own.size(), result.images++);
    } else {
      result.without_line.push_back(camera.images[camera.image_of_view[v]].name);
    }
  }
  if (result.images < kMinImages) {
    throw UserError("--laser",
                    fmt::format("the line is found on {} chessboards; 3 or more are needed (it must cross the "
                                "squares and be brighter than --laser-threshold)",
                                result.images));
  }
  const FittedPlane plane = robust_plane(points);
  constexpr double kFlat = 0.02;  // the short side of a plane's points over the long one
  if (!(plane.extents[1] > kFlat * plane.extents[2])) {
    throw UserError("--laser", "the line lies in one place on all chessboards; lay them nearer and further away");
  }
  const double sign = plane.normal.dot(plane.middle) < 0 ? -1 : 1;
  const Eigen::Vector3d normal = sign * plane.normal;
  result.plane = {{normal[0], normal[1], normal[2]}, normal.dot(plane.middle)};
  result.points = static_cast<std::size_t>(std::count(plane.on.begin(), plane.on.end(), true));
  result.left_out = points.size() - result.points;
  result.rms_mm = plane.rms;
  // The jackknife: each image in turn left out.
  double turns = 0;
  double shifts = 0;
  for (std::size_t image = 0; image < result.images; ++image) {
    std::vector<bool> on = plane.on;
    for (std::size_t i = 0; i < on.size(); ++i) {
      on[i] = on[i] && image_of_point[i] != image;
    }
    const FittedPlane without = plane_of(points, on);
    turns += std::pow(without.normal.cross(normal).norm(), 2);
    shifts += std::pow(without.normal.dot(plane.middle - without.middle), 2);
  }
  const double factor = static_cast<double>(result.images - 1) / static_cast<double>(result.images);
  result.turn_sd_deg = std::sqrt(factor * turns) * 180 / std::numbers::pi;
  result.shift_sd_mm = std::sqrt(factor * shifts);
  constexpr double kKnown = 1;  // degree
  if (!(result.turn_sd_deg <= kKnown)) {
    throw UserError("--laser",
                    fmt::format("the lines do not lie in one plane: {:.2g} mm RMS, and the plane is known to "
                                "± {:.2g}° only; are boards and lines in the same order, and these the lines?",
                                result.rms_mm, result.turn_sd_deg));
  }
  return result;
}

rig::Rig rig_of_laser(const rig::Rig& drawn, const CameraReport& camera, const LaserPlane& laser) {
  const LensParameters& p = camera.model.result.bundle.camera;
  rig::Rig rig = drawn;
  rig.camera.rows = camera.images.front().rows;
  rig.camera.columns = camera.images.front().columns;
  rig.camera.focal_length_mm = 0.5 * (p[0] + p[1]) * rig.camera.pixel_pitch_mm;
  rig.calibration.emplace();
  rig.calibration->camera = {p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8]};
  rig.light_plane = laser.plane;
  rig.belt_pose.reset();
  rig.heights.reset();
  // At the edges of parts a column sees the line on the part and on the belt, and their mean is neither.
  rig.measure.runs = drawn.measure.runs.value_or(rig::RigRuns{.gap_rows = 1});
  rig.sources = rig::RigSources{.camera = rig::ValueSource::measured, .light = rig::ValueSource::measured};
  return rig;
}

}  // namespace selfproj::calibration
