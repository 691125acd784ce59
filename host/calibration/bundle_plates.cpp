#include "host/calibration/bundle_plates.h"

#include <algorithm>
#include <cstddef>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace selfproj {
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

}  // namespace selfproj
