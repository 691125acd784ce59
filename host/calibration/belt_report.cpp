#include "host/calibration/belt_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "host/rig/lens.h"

namespace selfproj {
namespace {

// Where a lens sees the middle of a chessboard that is square to its axis, as (x, y, z) by the similarity that fits the
// corners best.
cv::Vec3d middle_of(const View& view, const Lens& lens, const cv::Point3d& middle) {
  using Complex = std::complex<double>;
  std::vector<std::pair<Complex, Complex>> pairs;
  Complex board_mean = 0;
  Complex seen_mean = 0;
  for (const Sight& sight : view.sights) {
    if (const auto ray = lens.ray({sight.camera.x, sight.camera.y})) {
      pairs.emplace_back(Complex(sight.chessboard.x - middle.x, sight.chessboard.y - middle.y),
                         Complex((*ray)[0], (*ray)[1]));
      board_mean += pairs.back().first;
      seen_mean += pairs.back().second;
    }
  }
  const auto count = static_cast<double>(pairs.size());
  board_mean /= count;
  seen_mean /= count;
  Complex product = 0;
  double squares = 0;
  for (const auto& [board, seen] : pairs) {
    product += (seen - seen_mean) * std::conj(board - board_mean);
    squares += std::norm(board - board_mean);
  }
  const Complex turn = product / squares;  // its length is 1 / z
  const Complex at = (seen_mean - turn * board_mean) / std::abs(turn);
  return {at.real(), at.imag(), 1 / std::abs(turn)};
}

// Takes out the straight line over the heights that fits the values best: what a free focal length or a free lean adds.
void straighten(const std::vector<double>& heights, std::vector<double>& values) {
  const auto count = static_cast<double>(heights.size());
  const double mean_height = std::accumulate(heights.begin(), heights.end(), 0.0) / count;
  const double mean_value = std::accumulate(values.begin(), values.end(), 0.0) / count;
  double squares = 0;
  double products = 0;
  for (std::size_t k = 0; k < heights.size(); ++k) {
    squares += (heights[k] - mean_height) * (heights[k] - mean_height);
    products += (heights[k] - mean_height) * values[k];
  }
  for (std::size_t k = 0; k < heights.size(); ++k) {
    values[k] -= mean_value + products / squares * (heights[k] - mean_height);
  }
}

// How far the plates are from where they are said to be, along x, y and z, by the camera alone, but for straight lines.
std::array<std::vector<double>, 3> shifts_of(const std::vector<View>& views, const Plates& plates,
                                             const Bundle& found) {
  const LensParameters& p = found.camera;
  const Lens lens{p[0], p[1], p[2], p[3], {p[4], p[5], p[6], p[7], p[8], 0, 0, 0}};
  cv::Point3d middle(0, 0, 0);
  for (const View& view : views) {
    for (const Sight& sight : view.sights) {
      middle = {std::max(middle.x, sight.chessboard.x / 2), std::max(middle.y, sight.chessboard.y / 2), 0};
    }
  }
  cv::Matx33d turn;
  cv::Rodrigues(found.belt.pose.rotation, turn);
  std::array<std::vector<double>, 3> shifts;
  std::vector<double> heights;
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
      heights.push_back(plates.heights_mm[k]);
      for (std::size_t axis = 0; axis < shifts.size(); ++axis) {
        shifts.at(axis).push_back(sum[static_cast<int>(axis)] / count);
      }
    }
  }
  for (std::vector<double>& values : shifts) {
    straighten(heights, values);
  }
  return shifts;
}

// The plate that is farthest off, if one is off by more than its tolerance.
std::string fault_of_places(const std::vector<View>& views, const Plates& plates, const Bundle& found) {
  constexpr double kMostOff = 5;    // standard deviations
  constexpr double kUnseen = 2e-4;  // of the distance: what a camera of narrow view does not see of a height
  const double unseen = kUnseen * cv::norm(found.belt.pose.translation);
  const std::array<std::vector<double>, 3> shifts = shifts_of(views, plates, found);
  std::string fault;
  double greatest = 0;
  // Poses may have been left out, but no plate loses both.
  for (std::size_t k = 0; k < shifts[2].size() && shifts[2].size() == plates.count(); ++k) {
    const double higher = -shifts[2][k];
    const double beside = std::hypot(shifts[0][k], shifts[1][k]);
    if (std::abs(higher) > std::max(greatest, kMostOff * plates.deviations[5] + unseen)) {
      greatest = std::abs(higher);
      fault = fmt::format(
          "the plate at {:g} mm lies {:.2f} mm {} than said; its height or the order of the poses is "
          "wrong",
          plates.heights_mm[k], greatest, higher > 0 ? "higher" : "lower");
    }
    if (beside > std::max(greatest, kMostOff * plates.deviations[3] + unseen)) {
      greatest = beside;
      fault = fmt::format("the plate at {:g} mm lies {:.2f} mm beside the others; push it against the fence",
                          plates.heights_mm[k], beside);
    }
  }
  return fault;
}

}  // namespace

std::string fault_of_plates(const std::vector<View>& views, const Plates& plates, const Bundle& found) {
  std::string fault = fault_of_places(views, plates, found);
  if (!fault.empty()) {
    return fault;
  }
  constexpr double kMostScale = 0.02;  // of what a millimetre of the belt moves
  const double way = plates.unit(found.belt) * cv::norm(found.belt.way);
  if (plates.moved && !(std::abs(way - 1) <= kMostScale)) {
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
  const int focal = off(focal_px, drawn.least_focal_px, drawn.most_focal_px, drawn.focal_tolerance);
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
      distance_mm, focal_px, drawn.distance_mm, 100 * drawn.distance_tolerance, drawn.least_focal_px,
      100 * drawn.focal_tolerance, reason);
}

BeltReport belt_report(const Plates& plates, BundleResult& result) {
  constexpr double kDegrees = 180 / std::numbers::pi;
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
  report.lean_deg_sd = kDegrees * result.lean_deviation;
  return report;
}

}  // namespace selfproj
