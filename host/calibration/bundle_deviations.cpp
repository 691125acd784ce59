#include "host/calibration/bundle_deviations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <vector>

namespace selfproj {
namespace {

// Takes standard deviations out of a covariance, one unknown after the other.
class Taker {
 public:
  Taker(const Eigen::MatrixXd& covariance, double factor) : covariance_(covariance), factor_(factor) {}

  double next() {
    const double variance = covariance_(at_, at_);
    ++at_;
    return factor_ * std::sqrt(std::max(0.0, variance));
  }
  void skip(int count) { at_ += count; }
  [[nodiscard]] int at() const { return at_; }

  Pose pose() {
    Pose pose;
    for (int i = 0; i < 3; ++i) {
      pose.rotation[i] = next();
    }
    for (int i = 0; i < 3; ++i) {
      pose.translation[i] = next();
    }
    return pose;
  }

  // A lens of `free` coefficients, of which the first `estimated` are of interest.
  void lens(LensParameters& lens, int free, int estimated) {
    for (int i = 0; i < kPinholeParameters + estimated; ++i) {
      lens[static_cast<std::size_t>(i)] = next();
    }
    skip(free - estimated);
  }

 private:
  const Eigen::MatrixXd& covariance_;
  double factor_;
  int at_ = 0;
};

}  // namespace

double widening_of(std::size_t views) {
  const double freedom = static_cast<double>(views) - 1;  // Cornish and Fisher's expansion at one standard deviation
  return 1 + 0.5 / freedom + 0.25 / (freedom * freedom);
}

void add_distortion_prior(Eigen::MatrixXd& normal, const BundleLayout& layout, const FreeDistortion& estimated) {
  constexpr std::array<double, 5> kUsual{0.2, 0.3, 0.001, 0.001, 0.3};  // k1, k2, p1, p2, k3
  const auto add = [&](int lens, int first, int last) {
    for (int i = first; i < last; ++i) {
      const int at = lens + kPinholeParameters + i;
      normal(at, at) += 1 / std::pow(kUsual.at(static_cast<std::size_t>(i)), 2);
    }
  };
  add(0, estimated.camera, layout.free.camera);
  if (layout.projector) {
    add(layout.camera_lens(), estimated.projector, layout.free.projector);
  }
}

cv::Mat1d distortion_covariance(const Eigen::MatrixXd& covariance, const BundleLayout& layout) {
  std::vector<int> places;
  for (int i = 0; i < layout.free.camera; ++i) {
    places.push_back(kPinholeParameters + i);
  }
  for (int i = 0; layout.projector && i < layout.free.projector; ++i) {
    places.push_back(layout.camera_lens() + kPinholeParameters + i);
  }
  const int count = static_cast<int>(places.size());
  cv::Mat1d result(count, count);
  for (int a = 0; a < count; ++a) {
    for (int b = 0; b < count; ++b) {
      result(a, b) = covariance(places[static_cast<std::size_t>(a)], places[static_cast<std::size_t>(b)]);
    }
  }
  return result;
}

void fill_deviations(const Eigen::MatrixXd& covariance, const BundleLayout& layout, const FreeDistortion& estimated,
                     BundleResult& result) {
  const double widening = layout.views > 1 ? widening_of(layout.views) : 1;
  Taker take(covariance, widening);
  Bundle& deviation = result.deviation;
  take.lens(deviation.camera, layout.free.camera, estimated.camera);
  if (layout.projector) {
    take.lens(deviation.projector, layout.free.projector, estimated.projector);
    const int translation = take.at() + 3;
    deviation.stereo = take.pose();
    const cv::Vec3d t = cv::normalize(result.bundle.stereo.translation);
    const Eigen::Vector3d along(t[0], t[1], t[2]);
    const Eigen::Matrix3d block = covariance.block<3, 3>(translation, translation);
    result.baseline_deviation = widening * std::sqrt(std::max(0.0, along.dot(block * along)));
  }
  take.skip(layout.shaped ? kSharedModes : 0);
  for (std::size_t v = 0; v < layout.views; ++v) {
    deviation.chessboard.push_back(take.pose());
    take.skip(layout.shaped ? kOwnModes : 0);
  }
}

}  // namespace selfproj
