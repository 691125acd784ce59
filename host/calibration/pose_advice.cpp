#include "host/calibration/pose_advice.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace selfproj::calibration {
namespace {

constexpr std::array<const char*, PoseAdvice::kSide* PoseAdvice::kSide> kPartNames = {
    "upper left",   "upper middle", "upper right",  "middle left", "central",
    "middle right", "lower left",   "lower middle", "lower right"};

constexpr std::array<const char*, kLeans> kLeanNames = {"none", "left", "right", "upper", "lower"};
constexpr std::array<const char*, kLeans> kOpposite = {"none", "right", "left", "lower", "upper"};

std::size_t index(Lean lean) { return static_cast<std::size_t>(lean); }

}  // namespace

Lean lean_of(const PoseReport& pose, const Chessboard& chessboard) {
  constexpr double kMin = 0.03;
  std::vector<cv::Point2d> board;
  std::vector<cv::Point2d> image;
  for (std::size_t i = 0; i < pose.corners.size(); ++i) {
    const int at = static_cast<int>(i);
    const int column = at % chessboard.columns;
    const int row = at / chessboard.columns;
    board.emplace_back(column - 0.5 * (chessboard.columns - 1), row - 0.5 * (chessboard.rows - 1));
    image.push_back(pose.corners[i].camera);
  }
  constexpr std::size_t kMinCorners = 4;
  const cv::Mat found = board.size() < kMinCorners ? cv::Mat() : cv::findHomography(board, image);
  if (found.empty()) {
    return Lean::none;
  }
  // The third row gives w, which is proportional to the distance. At the middle of the board its slope is (p, q) of a
  // square of the board; in the image that direction is (u, v).
  const cv::Matx33d h = found;
  const double w = h(2, 2);
  const double p = h(2, 0) / w;
  const double q = h(2, 1) / w;
  const double far = std::abs(p) * (chessboard.columns - 1) + std::abs(q) * (chessboard.rows - 1);
  if (far < kMin) {
    return Lean::none;
  }
  const double x = h(0, 2) / w;
  const double y = h(1, 2) / w;
  const double u = (h(0, 0) / w - x * p) * p + (h(0, 1) / w - x * q) * q;
  const double v = (h(1, 0) / w - y * p) * p + (h(1, 1) / w - y * q) * q;
  if (std::abs(u) >= std::abs(v)) {
    return u < 0 ? Lean::left : Lean::right;
  }
  return v < 0 ? Lean::upper : Lean::lower;
}

void PoseAdvice::add(const PoseReport& pose) {
  if (pose.corners.empty() || pose.rows < 1 || pose.columns < 1) {
    return;
  }
  ++poses_;
  ++leans_[index(lean_of(pose, chessboard_))];
  std::array<bool, kSide * kSide> hit{};
  for (const Corner& corner : pose.corners) {
    const auto part = [](double at, int pixels) {
      return std::clamp(static_cast<int>((at + 0.5) * kSide / pixels), 0, kSide - 1);
    };
    hit.at(static_cast<std::size_t>(part(corner.camera.y, pose.rows) * kSide + part(corner.camera.x, pose.columns))) =
        true;
  }
  for (std::size_t i = 0; i < hit.size(); ++i) {
    parts_.at(i) += hit.at(i) ? 1 : 0;
  }
}

bool PoseAdvice::enough() const {
  const auto empty = std::count(parts_.begin(), parts_.end(), 0);
  return poses_ >= kEnough && empty <= 1 && std::all_of(leans_.begin() + 1, leans_.end(), [](int n) { return n > 0; });
}

std::string PoseAdvice::covered() const {
  std::string missing;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    if (parts_.at(i) == 0) {
      missing += (missing.empty() ? "" : ", ") + std::string(kPartNames.at(i));
    }
  }
  const auto covered = static_cast<int>(parts_.size()) - std::count(parts_.begin(), parts_.end(), 0);
  return fmt::format(
      "covered: {} of {} parts of the image{}; poses with the left edge far {}, right {}, upper {}, lower {}, none {}",
      covered, parts_.size(), missing.empty() ? "" : " (missing: " + missing + ")", leans_[index(Lean::left)],
      leans_[index(Lean::right)], leans_[index(Lean::upper)], leans_[index(Lean::lower)], leans_[index(Lean::none)]);
}

// Distances to other parts count as often as these have poses.
std::size_t PoseAdvice::next_part() const {
  constexpr std::size_t kMiddle = kSide * kSide / 2;
  if (poses_ == 0) {
    return kMiddle;
  }
  const auto distance = [&](std::size_t part) {
    int sum = 0;
    for (std::size_t other = 0; other < parts_.size(); ++other) {
      const int rows = std::abs(static_cast<int>(part / kSide) - static_cast<int>(other / kSide));
      const int columns = std::abs(static_cast<int>(part % kSide) - static_cast<int>(other % kSide));
      sum += parts_.at(other) * (rows + columns);
    }
    return sum;
  };
  std::size_t best = 0;
  for (std::size_t part = 1; part < parts_.size(); ++part) {
    const bool fewer = parts_.at(part) < parts_.at(best);
    const bool equal = parts_.at(part) == parts_.at(best);
    if (fewer || (equal && distance(part) > distance(best))) {
      best = part;
    }
  }
  return best;
}

std::string PoseAdvice::next() const {
  std::size_t lean = 1;
  for (std::size_t other = 2; other < kLeans; ++other) {
    lean = leans_.at(other) < leans_.at(lean) ? other : lean;
  }
  return fmt::format(
      "place the chessboard in the {} part of the image, with its {} edge farther from the camera than its {} edge",
      kPartNames.at(next_part()), kLeanNames.at(lean), kOpposite.at(lean));
}

}  // namespace selfproj::calibration
