#include "host/calibration/starts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>
#include <vector>

namespace selfproj::calibration {
namespace {

// The corners of one view for OpenCV; `place` selects the pixels.
struct Points {
  Points(const View& view, cv::Point2d Sight::*place) {
    for (const Sight& sight : view.sights) {
      board.emplace_back(sight.chessboard);
      seen.emplace_back(sight.*place);
    }
  }
  std::vector<cv::Point3f> board;
  std::vector<cv::Point2f> seen;
};

cv::Matx33d matrix_of(const LensParameters& l) { return {l[0], 0, l[2], 0, l[1], l[3], 0, 0, 1}; }

// Zhang's closed form for the focal length, with the principal point in the middle of the image; a usual lens where it
// says nothing.
LensParameters first_lens(const std::vector<View>& views, cv::Size size, cv::Point2d Sight::*place) {
  constexpr double kUsual = 1.2;  // of the image's longer side
  constexpr double kSane = 20;    // times shorter or longer than that is no lens
  std::vector<std::vector<cv::Point3f>> board;
  std::vector<std::vector<cv::Point2f>> seen;
  for (const View& view : views) {
    const Points points(view, place);
    board.push_back(points.board);
    seen.push_back(points.seen);
  }
  const double usual = kUsual * std::max(size.width, size.height);
  const auto sane = [&](double f) { return std::isfinite(f) && f > usual / kSane && f < usual * kSane; };
  LensParameters lens{usual, usual, 0.5 * (size.width - 1), 0.5 * (size.height - 1)};
  try {
    const cv::Mat1d matrix = cv::initCameraMatrix2D(board, seen, size, 1);
    if (sane(matrix(0, 0))) {
      lens[0] = lens[1] = matrix(0, 0);
    }
  } catch (const cv::Exception&) {  // NOLINT(bugprone-empty-catch): the usual lens stays
  }
  return lens;
}

// The pose of a view in front of a lens without distortion: the likelier one, or with `other` the one that leans the
// other way.
std::optional<Pose> pose_of(const View& view, const LensParameters& lens, cv::Point2d Sight::*place, bool other) {
  const Points points(view, place);
  std::vector<cv::Vec3d> rotations;
  std::vector<cv::Vec3d> translations;
  try {
    cv::solvePnPGeneric(points.board, points.seen, matrix_of(lens), cv::noArray(), rotations, translations, false,
                        cv::SOLVEPNP_IPPE);
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  if (rotations.empty()) {
    return std::nullopt;
  }
  const std::size_t which = other ? rotations.size() - 1 : 0;
  cv::Matx33d turned;
  cv::Rodrigues(rotations[which], turned);
  for (const Sight& sight : view.sights) {
    const double z = (turned * cv::Vec3d(sight.chessboard.x, sight.chessboard.y, 0) + translations[which])[2];
    if (!(z > 0)) {
      return std::nullopt;
    }
  }
  return Pose{rotations[which], translations[which]};
}

// Projector from camera. Each view gives one pose; the one nearest to all others is taken.
Pose stereo_pose(const std::vector<Pose>& in_camera, const std::vector<Pose>& in_projector) {
  std::vector<Pose> all;
  for (std::size_t i = 0; i < in_camera.size(); ++i) {
    cv::Matx33d rc;
    cv::Matx33d rp;
    cv::Rodrigues(in_camera[i].rotation, rc);
    cv::Rodrigues(in_projector[i].rotation, rp);
    const cv::Matx33d r = rp * rc.t();
    Pose pose;
    cv::Rodrigues(r, pose.rotation);
    pose.translation = in_projector[i].translation - r * in_camera[i].translation;
    all.push_back(pose);
  }
  const auto off = [&](const Pose& pose) {
    double sum = 0;
    for (const Pose& other : all) {
      sum += cv::norm(pose.rotation - other.rotation) +
             cv::norm(pose.translation - other.translation) / (1 + cv::norm(other.translation));
    }
    return sum;
  };
  return *std::min_element(all.begin(), all.end(), [&](const Pose& a, const Pose& b) { return off(a) < off(b); });
}

// How a start differs from the first one: factors of the focal lengths, and shifts of the principal points in parts of
// the image.
struct Change {
  double camera_focal = 1, projector_focal = 1;
  double camera_x = 0, camera_y = 0;
  double projector_x = 0, projector_y = 0;
  bool other_lean = false;
};

LensParameters changed(LensParameters lens, cv::Size size, double focal, double x, double y) {
  lens[0] *= focal;
  lens[1] *= focal;
  lens[2] += x * size.width;
  lens[3] += y * size.height;
  return lens;
}

// The pose of a view square to the axis of a camera without distortion.
Pose square_pose_of(const View& view, const LensParameters& lens) {
  std::vector<PlanePoint> points;
  for (const Sight& sight : view.sights) {
    points.push_back({{sight.chessboard.x, sight.chessboard.y},
                      {(sight.camera.x - lens[2]) / lens[0], (sight.camera.y - lens[3]) / lens[1]}});
  }
  return square_pose(points);
}

}  // namespace

std::vector<Bundle> bundle_starts_of(const std::vector<View>& views, const Plates& plates, cv::Size camera,
                                     cv::Size projector) {
  const std::array<Change, 7> changes{
      {{}, {1.1, 1.1}, {0.9, 0.9}, {1.1, 0.9}, {0.9, 1.1}, {1, 1, 0.1, 0.1, 0, 0.1}, {1, 1, -0.1, 0.1, 0.1, -0.1}}};
  std::vector<Bundle> starts;
  for (const Change& c : changes) {
    Bundle start;
    start.camera = changed(plates.camera, camera, c.camera_focal, c.camera_x, c.camera_y);
    start.projector = changed(plates.projector, projector, c.projector_focal, c.projector_x, c.projector_y);
    start.stereo = plates.stereo;
    for (std::size_t v = 0; v < views.size(); ++v) {
      const bool lies = plates.places[v].plate >= 0;
      start.chessboard.push_back(lies ? square_pose_of(views[v], start.camera)
                                      : chessboard_pose(views[v], start.camera));
    }
    start_belt(plates, start);
    starts.push_back(start);
  }
  return starts;
}

std::vector<Bundle> bundle_starts(const std::vector<View>& views, cv::Size camera, cv::Size projector) {
  const std::array<Change, 9> changes{{{},
                                       {1.5, 1.5},
                                       {0.7, 0.7},
                                       {1.5, 0.7},
                                       {0.7, 1.5},
                                       {1, 1, 0.25, 0.25, 0, 0.5},
                                       {1, 1, -0.25, -0.25, 0, -0.5},
                                       {1, 1, 0.25, -0.25, 0.25, 0.25},
                                       {1, 1, 0, 0, 0, 0, true}}};
  const LensParameters camera_lens = first_lens(views, camera, &Sight::camera);
  const LensParameters projector_lens = first_lens(views, projector, &Sight::projector);
  std::vector<Bundle> starts;
  for (const Change& c : changes) {
    Bundle start;
    start.camera = changed(camera_lens, camera, c.camera_focal, c.camera_x, c.camera_y);
    start.projector = changed(projector_lens, projector, c.projector_focal, c.projector_x, c.projector_y);
    std::vector<Pose> in_projector;
    for (const View& view : views) {
      const std::optional<Pose> a = pose_of(view, start.camera, &Sight::camera, c.other_lean);
      const std::optional<Pose> b = pose_of(view, start.projector, &Sight::projector, c.other_lean);
      if (!a || !b) {
        break;
      }
      start.chessboard.push_back(*a);
      in_projector.push_back(*b);
    }
    if (in_projector.size() == views.size()) {
      start.stereo = stereo_pose(start.chessboard, in_projector);
      starts.push_back(start);
    }
  }
  return starts;
}

std::vector<Bundle> camera_starts(const std::vector<View>& views, cv::Size camera) {
  const std::array<Change, 7> changes{
      {{}, {1.5}, {0.7}, {1, 1, 0.25, 0.25}, {1, 1, -0.25, -0.25}, {1, 1, 0.25, -0.25}, {1, 1, 0, 0, 0, 0, true}}};
  const LensParameters lens = first_lens(views, camera, &Sight::camera);
  std::vector<Bundle> starts;
  for (const Change& c : changes) {
    Bundle start;
    start.camera = changed(lens, camera, c.camera_focal, c.camera_x, c.camera_y);
    for (const View& view : views) {
      const std::optional<Pose> pose = pose_of(view, start.camera, &Sight::camera, c.other_lean);
      if (!pose) {
        break;
      }
      start.chessboard.push_back(*pose);
    }
    if (start.chessboard.size() == views.size()) {
      starts.push_back(start);
    }
  }
  return starts;
}

Pose chessboard_pose(const View& view, const LensParameters& camera) {
  return pose_of(view, camera, &Sight::camera, false).value_or(Pose{});
}

}  // namespace selfproj::calibration
