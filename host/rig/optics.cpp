#include "selfproj/rig/optics.h"

#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "selfproj/rig/calibration.h"

namespace selfproj::rig {
namespace {

// The square of the smallest ray length at which the radial part of the lens stops growing; infinite if it never does.
double reach_of(const Lens& lens) {
  constexpr double kStep = 1e-3;
  constexpr double kMax = 10;  // the tangent of 84 degrees
  const auto [k1, k2, p1, p2, k3, k4, k5, k6] = lens.k;
  double before = 0;
  for (double r = kStep; r < kMax; r += kStep) {
    const double s = r * r;
    const double image = r * (1 + s * (k1 + s * (k2 + s * k3))) / (1 + s * (k4 + s * (k5 + s * k6)));
    if (!(image > before)) {
      return (r - kStep) * (r - kStep);
    }
    before = image;
  }
  return std::numeric_limits<double>::infinity();
}

// The full model, with rows in the place of x. A laser has no projector.
Calibration model_of(const Rig& rig) {
  if (!rig.light_plane) {
    return with_axes_exchanged(calibration_of(rig));
  }
  Rig camera = rig;
  camera.projector = {
      .x_mm = 1, .focal_length_mm = 1, .lines = 1, .columns = 1, .line_pitch_mm = 1, .column_pitch_mm = 1};
  camera.calibration->projector = {.fx_px = 1, .fy_px = 1};
  return with_axes_exchanged(calibration_of(camera));
}

// The rows are the axes of the belt: along, across, away from the camera; columns are the camera's axes, rows first.
cv::Matx33d belt_of(const RigBeltPose& pose) {
  const cv::Vec3d z = cv::normalize(cv::Vec3d(pose.normal[1], pose.normal[0], pose.normal[2]));
  cv::Vec3d x(pose.direction[1], pose.direction[0], pose.direction[2]);
  x = cv::normalize(x - x.dot(z) * z);
  const cv::Vec3d y = z.cross(x);
  return {x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]};
}

}  // namespace

RigOptics::RigOptics(const Rig& rig)
    : rig_(rig),
      calibration_(model_of(rig)),
      camera_reach_(reach_of(calibration_.camera)),
      projector_reach_(reach_of(calibration_.projector)) {
  if (rig.heights) {
    correction_.emplace(rig.camera, *rig.heights);
  }
  if (rig.belt_pose) {
    belt_ = belt_of(*rig.belt_pose);
    calibration_.rotation = calibration_.rotation * belt_.t();
  }
  if (rig.light_plane) {
    const auto& n = rig.light_plane->normal;
    normal_ = belt_ * cv::Vec3d(n[1], n[0], n[2]);
    return;
  }
  const std::optional<cv::Vec2d> middle = ray({0.5 * (rig.camera.rows - 1), 0.5 * (rig.camera.columns - 1)});
  sign_ = middle && track(*middle, rig.plane_z_mm).by_z.line > 0 ? 1 : -1;
  fall_sign_ = middle && fall(calibration_.rotation * cv::Vec3d((*middle)[0], (*middle)[1], 1)) < 0 ? -1 : 1;
}

cv::Vec3d RigOptics::projector_centre() const { return -(calibration_.rotation.t() * calibration_.translation); }

std::optional<cv::Vec2d> RigOptics::ray(const CameraPlace& place) const {
  const std::optional<cv::Vec2d> ray = calibration_.camera.ray({place.row, place.column});
  if (!ray || ray->dot(*ray) > camera_reach_) {
    return std::nullopt;
  }
  const cv::Vec3d direction = belt_ * cv::Vec3d((*ray)[0], (*ray)[1], 1);
  return direction[2] > 0 ? std::optional(cv::Vec2d(direction[0] / direction[2], direction[1] / direction[2]))
                          : std::nullopt;
}

std::optional<CameraPlace> RigOptics::seen(const cv::Vec3d& point) const {
  const cv::Vec3d at = belt_.t() * point;
  const cv::Vec2d ray(at[0] / at[2], at[1] / at[2]);
  if (!(at[2] > 0) || ray.dot(ray) > camera_reach_) {
    return std::nullopt;
  }
  const cv::Vec2d pixel = calibration_.camera.pixel(ray);
  return CameraPlace{pixel[0], pixel[1]};
}

std::optional<ProjectorPlace> RigOptics::lit_by(const cv::Vec3d& point) const {
  const cv::Vec3d at = to_projector(point);
  const cv::Vec2d ray(at[0] / at[2], at[1] / at[2]);
  if (!(at[2] > 0) || ray.dot(ray) > projector_reach_) {
    return std::nullopt;
  }
  const cv::Vec2d pixel = calibration_.projector.pixel(ray);
  return ProjectorPlace{pixel[0], pixel[1]};
}

std::vector<ProjectorPlace> RigOptics::epipolar_line(const cv::Vec2d& ray, double z_first, double z_last,
                                                     int count) const {
  const cv::Vec3d first = to_projector({ray[0] * z_first, ray[1] * z_first, z_first});
  const cv::Vec3d last = to_projector({ray[0] * z_last, ray[1] * z_last, z_last});
  const cv::Vec2d from(first[0] / first[2], first[1] / first[2]);
  const cv::Vec2d to(last[0] / last[2], last[1] / last[2]);
  std::vector<ProjectorPlace> places;
  for (int i = 0; i < count && first[2] > 0 && last[2] > 0; ++i) {
    const cv::Vec2d flat = from + (to - from) * (static_cast<double>(i) / (count - 1));
    if (flat.dot(flat) > projector_reach_) {
      return {};
    }
    const cv::Vec2d pixel = calibration_.projector.pixel(flat);
    places.push_back({pixel[0], pixel[1]});
  }
  return places;
}

std::optional<cv::Vec3d> RigOptics::light_of(const ProjectorPlace& place) const {
  const std::optional<cv::Vec2d> ray = calibration_.projector.ray({place.line, place.column});
  if (!ray || ray->dot(*ray) > projector_reach_) {
    return std::nullopt;
  }
  return calibration_.rotation.t() * cv::Vec3d((*ray)[0], (*ray)[1], 1);
}

RigOptics::Track RigOptics::track(const cv::Vec2d& ray, double z) const {
  const cv::Vec3d direction = calibration_.rotation * cv::Vec3d(ray[0], ray[1], 1);
  const cv::Vec3d at = direction * z + calibration_.translation;
  const cv::Vec2d flat(at[0] / at[2], at[1] / at[2]);
  cv::Matx22d lens;
  const cv::Vec2d pixel = calibration_.projector.pixel(flat, lens);
  const cv::Vec2d by_z =
      lens * (cv::Vec2d(direction[0] - flat[0] * direction[2], direction[1] - flat[1] * direction[2]) * (1 / at[2]));
  const bool folded = flat.dot(flat) > projector_reach_;
  return {{pixel[0], pixel[1]}, {by_z[0], by_z[1]}, folded ? -1 : at[2]};
}

std::optional<double> RigOptics::meet_plane(const cv::Vec2d& ray) const {
  const double z = rig_.light_plane->distance_mm / normal_.dot({ray[0], ray[1], 1});
  return z > 0 && std::isfinite(z) ? std::optional(z) : std::nullopt;
}

// Newton's method along the ray. It starts where the ray meets the plane of the line without distortion.
std::optional<double> RigOptics::meet(const cv::Vec2d& ray, const LightSheet& sheet) const {
  constexpr int kSteps = 30;
  constexpr double kClose = 1e-7;
  if (rig_.light_plane) {
    return meet_plane(ray);
  }
  const std::optional<cv::Vec2d> flat = calibration_.projector.ray({sheet.line, sheet.at_column});
  if (!flat) {
    return std::nullopt;
  }
  const cv::Vec3d direction = calibration_.rotation * cv::Vec3d(ray[0], ray[1], 1);
  if (!(fall(direction) * fall_sign_ > 0)) {
    return std::nullopt;
  }
  const cv::Vec3d& t = calibration_.translation;
  double z = ((*flat)[0] * t[2] - t[0]) / (direction[0] - (*flat)[0] * direction[2]);
  if (!(z > 0) || !(track(ray, z).depth > 0)) {
    z = rig_.plane_z_mm;
  }
  for (int step = 0; step < kSteps; ++step) {
    const Track at = track(ray, z);
    if (!(z > 0 && at.depth > 0)) {
      return std::nullopt;
    }
    const double off = at.place.line - sheet.line - sheet.slope * (at.place.column - sheet.at_column);
    const double slope = at.by_z.line - sheet.slope * at.by_z.column;
    const double change = off / slope;
    z -= change;
    if (std::abs(change) < kClose) {
      return at.by_z.line * sign_ > 0 ? std::optional(z) : std::nullopt;
    }
  }
  return std::nullopt;
}

double RigOptics::z_per_line(const cv::Vec2d& ray, double z) const {
  return rig_.light_plane ? 0 : 1 / std::abs(track(ray, z).by_z.line);
}

double RigOptics::corrected(const CameraPlace& place, double z) const {
  return correction_ ? z - correction_->at(place.row, place.column, rig_.plane_z_mm - z) : z;
}

// The correction changes little with height, so a few steps are enough.
double RigOptics::uncorrected(const CameraPlace& place, double z) const {
  constexpr int kSteps = 20;
  constexpr double kClose = 1e-9;
  double result = z;
  for (int step = 0; correction_ && step < kSteps; ++step) {
    const double off = corrected(place, result) - z;
    result -= off;
    if (std::abs(off) < kClose) {
      break;
    }
  }
  return result;
}

}  // namespace selfproj::rig
