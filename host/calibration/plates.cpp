#include "host/calibration/plates.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <iterator>
#include <numbers>
#include <numeric>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "selfproj/rig/calibration.h"

namespace selfproj::calibration {
namespace {

cv::Matx33d matrix_of(const cv::Vec3d& rotation) {
  cv::Matx33d matrix;
  cv::Rodrigues(rotation, matrix);
  return matrix;
}

}  // namespace

Plates::Plates(const std::vector<double>& heights, const std::vector<double>& belt_mm, const PlateTolerance& tolerance,
               double side_mm)
    : heights_mm(heights) {
  for (std::size_t k = 0; k < heights.size(); ++k) {
    for (const double place : belt_mm) {
      places.push_back({static_cast<int>(k), heights[k], place});
    }
  }
  const double even = 1 / std::numbers::sqrt3;  // the standard deviation of what is even within -1 and 1
  const double lean = even * tolerance.parallel_mm / side_mm;
  const double fence = even * tolerance.fence_mm;
  deviations = {lean, lean, fence / side_mm, fence, fence, even * tolerance.height_mm};
  scale_deviation = even * tolerance.square;
  moved = belt_mm.size() > 1;
}

Pose square_pose(const std::vector<PlanePoint>& points) {
  std::complex<double> board_mean = 0;
  std::complex<double> ray_mean = 0;
  for (const PlanePoint& point : points) {
    board_mean += point.board;
    ray_mean += point.ray;
  }
  const auto count = static_cast<double>(points.size());
  board_mean /= count;
  ray_mean /= count;
  std::complex<double> product = 0;
  double squares = 0;
  for (const PlanePoint& point : points) {
    product += (point.ray - ray_mean) * std::conj(point.board - board_mean);
    squares += std::norm(point.board - board_mean);
  }
  const std::complex<double> turn = product / squares;  // its length is 1 / z
  const std::complex<double> at = (ray_mean - turn * board_mean) / std::abs(turn);
  return {{0, 0, std::arg(turn)}, {at.real(), at.imag(), 1 / std::abs(turn)}};
}

void start_belt(const Plates& plates, Bundle& bundle) {
  Belt& belt = bundle.belt;
  belt.plate_off.assign(plates.count(), {});
  belt.scale = 0;
  const auto first =
      std::find_if(plates.places.begin(), plates.places.end(), [](const PlatePlace& p) { return p.plate >= 0; });
  if (first == plates.places.end()) {
    return;
  }
  belt.pose = bundle.chessboard[static_cast<std::size_t>(first - plates.places.begin())];
  const cv::Matx33d turn = matrix_of(belt.pose.rotation);
  cv::Vec2d way(0, 0);
  double ways = 0;
  for (std::size_t a = 0; a < plates.places.size(); ++a) {
    for (std::size_t b = a + 1; b < plates.places.size(); ++b) {
      const double moved = plates.places[b].belt_mm - plates.places[a].belt_mm;
      if (plates.places[a].plate >= 0 && plates.places[a].plate == plates.places[b].plate && moved != 0) {
        const cv::Vec3d by = turn.t() * (bundle.chessboard[b].translation - bundle.chessboard[a].translation);
        way += cv::Vec2d(by[0], by[1]) / moved;
        ways += 1;
      }
    }
  }
  belt.way = ways > 0 ? way / ways : cv::Vec2d(0, 1);
  belt.pose.translation -=
      turn * cv::Vec3d(belt.way[0] * first->belt_mm, belt.way[1] * first->belt_mm, -first->height_mm);
}

namespace {

// Where a lens sees the middle of a chessboard that is square to its axis.
cv::Vec3d middle_of(const View& view, const rig::Lens& lens, const cv::Point3d& middle) {
  std::vector<PlanePoint> points;
  for (const Sight& sight : view.sights) {
    if (const auto ray = lens.ray({sight.camera.x, sight.camera.y})) {
      points.push_back({{sight.chessboard.x - middle.x, sight.chessboard.y - middle.y}, {(*ray)[0], (*ray)[1]}});
    }
  }
  return square_pose(points).translation;
}

// What is left of the values when the straight line over the heights that fits all of them best, or all but `left_out`,
// is taken out: a free focal length or a free lean adds such a line.
std::vector<double> off_line(const std::vector<double>& heights, const std::vector<double>& values,
                             std::optional<std::size_t> left_out = {}) {
  double count = 0;
  double height = 0;
  double value = 0;
  for (std::size_t k = 0; k < heights.size(); ++k) {
    if (k != left_out) {
      count += 1;
      height += heights[k];
      value += values[k];
    }
  }
  height /= count;
  value /= count;
  double squares = 0;
  double products = 0;
  for (std::size_t k = 0; k < heights.size(); ++k) {
    if (k != left_out) {
      squares += (heights[k] - height) * (heights[k] - height);
      products += (heights[k] - height) * (values[k] - value);
    }
  }
  std::vector<double> off;
  for (std::size_t k = 0; k < heights.size(); ++k) {
    off.push_back(values[k] - value - products / squares * (heights[k] - height));
  }
  return off;
}

// The same for several axes together: lengths.
std::vector<double> lengths_off_line(const std::vector<double>& heights, const std::vector<std::vector<double>>& axes,
                                     std::optional<std::size_t> left_out = {}) {
  std::vector<double> lengths(heights.size(), 0);
  for (const std::vector<double>& values : axes) {
    const std::vector<double> off = off_line(heights, values, left_out);
    std::transform(off.begin(), off.end(), lengths.begin(), lengths.begin(),
                   [](double x, double length) { return std::hypot(x, length); });
  }
  return lengths;
}

// How far the plates are from where they are said to be, along x, y and z, by the camera alone, but for straight lines
// over the heights.
std::array<std::vector<double>, 3> shifts_of(const std::vector<View>& views, const Plates& plates,
                                             const Bundle& found) {
  const rig::Lens lens = lens_of(found.camera);
  cv::Point3d middle(0, 0, 0);
  for (const View& view : views) {
    for (const Sight& sight : view.sights) {
      middle = {std::max(middle.x, sight.chessboard.x / 2), std::max(middle.y, sight.chessboard.y / 2), 0};
    }
  }
  cv::Matx33d turn;
  cv::Rodrigues(found.belt.pose.rotation, turn);
  std::array<std::vector<double>, 3> shifts;
  for (std::size_t k = 0; k < plates.count(); ++k) {
    cv::Vec3d sum;
    double count = 0;
    for (std::size_t v = 0; v < views.size(); ++v) {
      const PlatePlace& place = plates.places[v];
      if (place.plate == static_cast<int>(k)) {
        const cv::Vec3d way = turn * cv::Vec3d(found.belt.way[0], found.belt.way[1], 0);
        sum += middle_of(views[v], lens, middle) - place.belt_mm * way + cv::Vec3d(0, 0, place.height_mm);
        count += 1;
      }
    }
    if (count > 0) {
      for (std::size_t axis = 0; axis < shifts.size(); ++axis) {
        shifts.at(axis).push_back(sum[static_cast<int>(axis)] / count);
      }
    }
  }
  return shifts;
}

// One plate that is off bends the line through all of them, and may leave a greater rest at its neighbour than at
// itself. So each plate in turn is left out: that one is off without which the others fit. Returns the plates without
// which no other is off by more than the limit; none if more than one is off.
std::vector<std::size_t> suspects_of(const std::vector<double>& heights, const std::vector<std::vector<double>>& axes,
                                     double limit) {
  constexpr double kAsGood = 2;    // rests that differ by less do not tell one plate from the other,
  constexpr double kNothing = 10;  // nor do rests of less than this part of the limit
  std::vector<double> rests;
  for (std::size_t k = 0; k < heights.size(); ++k) {
    std::vector<double> rest = lengths_off_line(heights, axes, k);
    rest[k] = 0;
    rests.push_back(*std::max_element(rest.begin(), rest.end()));
  }
  const double least = *std::min_element(rests.begin(), rests.end());
  std::vector<std::size_t> suspects;
  for (std::size_t k = 0; k < heights.size(); ++k) {
    if (rests[k] <= limit && rests[k] <= std::max(kAsGood * least, limit / kNothing)) {
      suspects.push_back(k);
    }
  }
  return suspects;
}

// The plate that is off by more than its tolerance, if there is one.
std::string fault_of_places(const std::vector<View>& views, const Plates& plates, const Bundle& found) {
  constexpr double kMaxOff = 5;     // standard deviations
  constexpr double kUnseen = 2e-4;  // of the distance: what a camera of narrow view does not see of a height
  const double unseen = kUnseen * cv::norm(found.belt.pose.translation);
  const std::array<std::vector<double>, 3> shifts = shifts_of(views, plates, found);
  if (shifts[2].size() != plates.count()) {  // poses may have been left out, but no plate loses both
    return {};
  }
  const std::vector<double>& heights = plates.heights_mm;
  const std::vector<std::vector<double>> level{shifts[2]};
  const std::vector<std::vector<double>> place{shifts[0], shifts[1]};
  const auto share = [&](const std::vector<std::vector<double>>& axes, double limit) {
    const std::vector<double> off = lengths_off_line(heights, axes);
    return *std::max_element(off.begin(), off.end()) / limit;
  };
  const double level_limit = kMaxOff * plates.deviations[5] + unseen;
  const double place_limit = kMaxOff * plates.deviations[3] + unseen;
  const double off_level = share(level, level_limit);
  const double off_place = share(place, place_limit);
  if (!(std::max(off_level, off_place) > 1)) {
    return {};
  }
  const bool higher = off_level > off_place;
  const std::vector<std::size_t> suspects =
      higher ? suspects_of(heights, level, level_limit) : suspects_of(heights, place, place_limit);
  if (suspects.empty()) {
    return higher
               ? "more than one plate lies higher or lower than said; the order of the poses or the heights are wrong"
               : "more than one plate lies beside the others; push them against the fence";
  }
  std::vector<double> suspected;
  std::transform(suspects.begin(), suspects.end(), std::back_inserter(suspected),
                 [&](std::size_t k) { return heights[k]; });
  const std::string which = fmt::format("{:g}", fmt::join(suspected, " or "));
  if (suspects.size() > 1) {
    return higher ? fmt::format("one of the plates at {} mm lies higher or lower than said, or is not flat", which)
                  : fmt::format("one of the plates at {} mm lies beside the others; push it against the fence", which);
  }
  const std::size_t k = suspects.front();
  if (higher) {
    const double down = off_line(heights, shifts[2], k)[k];
    return fmt::format("the plate at {} mm lies {:.2f} mm {} than said; its height is wrong, or it is not flat", which,
                       std::abs(down), down < 0 ? "higher" : "lower");
  }
  return fmt::format("the plate at {} mm lies {:.2f} mm beside the others; push it against the fence", which,
                     lengths_off_line(heights, place, k)[k]);
}

}  // namespace

std::string fault_of_plates(const std::vector<View>& views, const Plates& plates, const Bundle& found) {
  std::string fault = fault_of_places(views, plates, found);
  if (!fault.empty()) {
    return fault;
  }
  constexpr double kMaxScale = 0.02;  // of what a millimetre of the belt moves
  const double way = plates.unit(found.belt) * cv::norm(found.belt.way);
  if (plates.moved && !(std::abs(way - 1) <= kMaxScale)) {
    return fmt::format("a millimetre of the belt moves the chessboard by {:.4f} mm; --moves or --square is wrong", way);
  }
  return {};
}

std::string fault_of_scale(const DrawnScale& drawn, double distance_mm, double focal_px) {
  // 0 within the tolerance, else the direction.
  const auto off = [](double value, double least, double most, double tolerance) {
    return value > most * (1 + tolerance) ? 1 : !(value >= least * (1 - tolerance)) ? -1 : 0;
  };
  const int distance = off(distance_mm, drawn.distance_mm, drawn.distance_mm, drawn.distance_tolerance);
  const int focal = off(focal_px, drawn.min_focal_px, drawn.max_focal_px, drawn.focal_tolerance);
  if (distance == 0 && focal == 0) {
    return {};
  }
  // With right squares a wrong factor of the heights changes both alike; wrong squares change the focal length alone.
  const double times = distance_mm / drawn.distance_mm;
  const std::string reason = distance == 0 ? "--square or the focal length of --rig is likely wrong"
                             : distance * focal < 0
                                 ? "--square or --rig is likely wrong"
                                 : fmt::format("the heights of --plates are likely all {:.2f} times the true ones{}",
                                               times, focal == 0 ? ", or plane_z_mm of --rig is" : "");
  return fmt::format(
      "the plates put the belt {:.0f} mm away and the camera's focal length at {:.0f} px; --rig draws {:.0f} mm ± {:g} "
      "% and {:.0f} px ± {:g} %: {}",
      distance_mm, focal_px, drawn.distance_mm, 100 * drawn.distance_tolerance, drawn.min_focal_px,
      100 * drawn.focal_tolerance, reason);
}

BeltReport belt_report(const Plates& plates, BundleResult& result) {
  constexpr double kDegreesARadian = 180 / std::numbers::pi;
  Bundle& found = result.bundle;
  const double unit = plates.unit(found.belt);
  const double unit_sd = plates.scale_deviation * result.scale_deviation;
  found.stereo.translation *= unit;
  found.belt.pose.translation *= unit;
  for (Pose& pose : found.chessboard) {
    pose.translation *= unit;
  }
  for (int i = 0; i < 3; ++i) {
    double& sd = result.deviation.stereo.translation[i];
    sd = std::hypot(sd, unit_sd * found.stereo.translation[i]);
  }
  result.baseline_deviation = std::hypot(result.baseline_deviation, unit_sd * cv::norm(found.stereo.translation));
  cv::Matx33d turn;
  cv::Rodrigues(found.belt.pose.rotation, turn);
  const cv::Vec3d way = cv::normalize(turn * cv::Vec3d(found.belt.way[0], found.belt.way[1], 0));
  const cv::Vec3d normal(turn(0, 2), turn(1, 2), turn(2, 2));
  BeltReport report;
  report.pose = {{way[0], way[1], way[2]}, {normal[0], normal[1], normal[2]}};
  report.moved = plates.moved;
  report.plane_z_mm = normal.dot(found.belt.pose.translation);
  report.way = unit * cv::norm(found.belt.way);
  report.squares = unit;
  report.squares_sd = unit_sd;
  report.lean_deg_sd = kDegreesARadian * result.lean_deviation;
  return report;
}

namespace {

// What a rig says of distance and focal length. A camera that the rig only draws may have the focal length that is
// printed on its lens; focused on the belt, the image lies a little further behind the lens than that.
DrawnScale scale_of(const rig::Rig& rig, double focal_px, DrawnScale scale) {
  const double focal_mm = rig.camera.focal_length_mm;
  scale.distance_mm = rig.plane_z_mm;
  scale.min_focal_px = scale.max_focal_px = focal_px;
  if (!rig.calibration && rig.plane_z_mm > 2 * focal_mm) {
    scale.max_focal_px *= rig.plane_z_mm / (rig.plane_z_mm - focal_mm);
  }
  return scale;
}

}  // namespace

Plates plates_over(const rig::Rig& rig, const Chessboard& chessboard, const std::vector<double>& heights_mm,
                   const std::vector<double>& belt_mm, const PlateTolerance& tolerance, const DrawnScale& tolerances) {
  const double side = chessboard.square_mm * (std::max(chessboard.columns, chessboard.rows) - 1);
  Plates plates(heights_mm, belt_mm, tolerance, side);
  const rig::Calibration drawn = rig::calibration_of(rig);
  const auto lens_of = [](const rig::Lens& l) { return LensParameters{l.fx, l.fy, l.cx, l.cy}; };
  plates.camera = lens_of(drawn.camera);
  plates.projector = lens_of(drawn.projector);
  cv::Rodrigues(drawn.rotation, plates.stereo.rotation);
  plates.stereo.translation = drawn.translation;
  plates.scale = scale_of(rig, drawn.camera.fx, tolerances);
  return plates;
}

}  // namespace selfproj::calibration
