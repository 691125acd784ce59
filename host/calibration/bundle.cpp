#include "host/calibration/bundle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <vector>

namespace selfproj {
namespace {

constexpr int kPose = 6;
constexpr int kDistortion = 5;

// The positions of the unknowns: both lenses, the pose between them, the chessboard's poses.
struct Layout {
  int camera_free;     // free coefficients of the camera's lens
  int projector_free;  // free coefficients of the projector's
  int views;

  [[nodiscard]] int projector() const { return camera_free; }
  [[nodiscard]] int stereo() const { return camera_free + projector_free; }
  [[nodiscard]] int view(int i) const { return stereo() + kPose * (1 + i); }
  [[nodiscard]] int count() const { return view(views); }
};

void add_pose(Pose& pose, const cv::Mat1d& change, int at) {
  for (int i = 0; i < 3; ++i) {
    pose.rotation[i] += change(at + i);
    pose.translation[i] += change(at + 3 + i);
  }
}

Bundle changed(const Bundle& from, const cv::Mat1d& change, const Layout& layout) {
  Bundle to = from;
  for (int i = 0; i < layout.camera_free; ++i) {
    to.camera[static_cast<std::size_t>(i)] += change(i);
  }
  for (int i = 0; i < layout.projector_free; ++i) {
    to.projector[static_cast<std::size_t>(i)] += change(layout.projector() + i);
  }
  add_pose(to.stereo, change, layout.stereo());
  for (int v = 0; v < layout.views; ++v) {
    add_pose(to.chessboard[static_cast<std::size_t>(v)], change, layout.view(v));
  }
  return to;
}

// Pixels of points, with derivatives in OpenCV's order: rotation 3, translation 3, focal lengths 2, centre 2,
// distortion 5.
std::vector<cv::Point2d> project(const std::vector<cv::Point3d>& points, const Pose& pose, const LensParameters& lens,
                                 cv::Mat& derivative) {
  const cv::Matx33d matrix(lens[0], 0, lens[2], 0, lens[1], lens[3], 0, 0, 1);
  const cv::Vec<double, kDistortion> distortion(lens[4], lens[5], lens[6], lens[7], lens[8]);
  std::vector<cv::Point2d> pixels;
  derivative.release();  // parts taken of it before stay valid
  cv::projectPoints(points, pose.rotation, pose.translation, matrix, distortion, pixels, derivative);
  return pixels;
}

// The column of OpenCV's derivatives at which those of a lens begin, in the order of LensParameters.
constexpr int kLensColumn = 6;

// Residuals and derivatives of one view; rows 2i and 2i + 1 belong to sight i.
struct Linear {
  std::vector<cv::Vec2d> camera, projector;  // residuals
  cv::Mat1d camera_by_lens, camera_by_view;
  cv::Mat1d projector_by_lens, projector_by_stereo, projector_by_view;
};

Linear linearize(const View& view, const Bundle& bundle, std::size_t v) {
  std::vector<cv::Point3d> points;
  points.reserve(view.sights.size());
  for (const Sight& sight : view.sights) {
    points.push_back(sight.chessboard);
  }
  Linear linear;
  cv::Mat derivative;
  const Pose& pose = bundle.chessboard[v];
  const std::vector<cv::Point2d> in_camera = project(points, pose, bundle.camera, derivative);
  linear.camera_by_view = derivative.colRange(0, kPose);
  linear.camera_by_lens = derivative.colRange(kLensColumn, kLensColumn + static_cast<int>(kLensParameters));

  Pose both;
  cv::Mat rotation_by_view;
  cv::Mat rotation_by_view_t;
  cv::Mat rotation_by_stereo;
  cv::Mat rotation_by_stereo_t;
  cv::Mat translation_by_view;
  cv::Mat translation_by_view_t;
  cv::Mat translation_by_stereo;
  cv::Mat translation_by_stereo_t;
  cv::composeRT(pose.rotation, pose.translation, bundle.stereo.rotation, bundle.stereo.translation, both.rotation,
                both.translation, rotation_by_view, rotation_by_view_t, rotation_by_stereo, rotation_by_stereo_t,
                translation_by_view, translation_by_view_t, translation_by_stereo, translation_by_stereo_t);
  const std::vector<cv::Point2d> in_projector = project(points, both, bundle.projector, derivative);
  linear.projector_by_lens = derivative.colRange(kLensColumn, kLensColumn + static_cast<int>(kLensParameters));
  const auto chain = [&](const cv::Mat& r, const cv::Mat& r_t, const cv::Mat& t, const cv::Mat& t_t) {
    cv::Mat1d inner(kPose, kPose);
    r.copyTo(inner(cv::Range(0, 3), cv::Range(0, 3)));
    r_t.copyTo(inner(cv::Range(0, 3), cv::Range(3, 6)));
    t.copyTo(inner(cv::Range(3, 6), cv::Range(0, 3)));
    t_t.copyTo(inner(cv::Range(3, 6), cv::Range(3, 6)));
    return cv::Mat1d(derivative.colRange(0, kPose) * inner);
  };
  linear.projector_by_view = chain(rotation_by_view, rotation_by_view_t, translation_by_view, translation_by_view_t);
  linear.projector_by_stereo =
      chain(rotation_by_stereo, rotation_by_stereo_t, translation_by_stereo, translation_by_stereo_t);

  for (std::size_t i = 0; i < points.size(); ++i) {
    linear.camera.emplace_back(view.sights[i].camera - in_camera[i]);
    linear.projector.emplace_back(view.sights[i].projector - in_projector[i]);
  }
  return linear;
}

double squares(const std::vector<cv::Vec2d>& residuals) {
  double sum = 0;
  for (const cv::Vec2d& residual : residuals) {
    sum += residual.dot(residual);
  }
  return sum;
}

// Weights of the residuals: one over their variance in one direction.
struct Weights {
  double camera = 1;
  double projector = 1;
};

double cost_of(const std::vector<Linear>& views, const Weights& weights) {
  double cost = 0;
  for (const Linear& view : views) {
    cost += weights.camera * squares(view.camera) + weights.projector * squares(view.projector);
  }
  return cost;
}

// Adds weight A^T B to the block of the normal matrix at (row, column).
void add_block(cv::Mat1d& normal, int row, int column, double weight, const cv::Mat1d& a, const cv::Mat1d& b) {
  normal(cv::Rect(column, row, b.cols, a.cols)) += weight * (a.t() * b);
}

void add_right(cv::Mat1d& right, int row, double weight, const cv::Mat1d& a, const std::vector<cv::Vec2d>& residuals) {
  const cv::Mat1d column(static_cast<int>(2 * residuals.size()), 1,
                         const_cast<double*>(residuals.front().val));  // NOLINT: read only
  right(cv::Rect(0, row, 1, a.cols)) += weight * (a.t() * column);
}

void normal_equations(const std::vector<Linear>& views, const Weights& weights, const Layout& layout, cv::Mat1d& normal,
                      cv::Mat1d& right) {
  normal = cv::Mat1d::zeros(layout.count(), layout.count());
  right = cv::Mat1d::zeros(layout.count(), 1);
  for (int v = 0; v < layout.views; ++v) {
    const Linear& view = views[static_cast<std::size_t>(v)];
    struct Part {
      int at;
      cv::Mat1d by;
    };
    const std::array<Part, 2> camera{
        {{0, view.camera_by_lens.colRange(0, layout.camera_free)}, {layout.view(v), view.camera_by_view}}};
    const std::array<Part, 3> projector{
        {{layout.projector(), view.projector_by_lens.colRange(0, layout.projector_free)},
         {layout.stereo(), view.projector_by_stereo},
         {layout.view(v), view.projector_by_view}}};
    for (const Part& a : camera) {
      for (const Part& b : camera) {
        add_block(normal, a.at, b.at, weights.camera, a.by, b.by);
      }
      add_right(right, a.at, weights.camera, a.by, view.camera);
    }
    for (const Part& a : projector) {
      for (const Part& b : projector) {
        add_block(normal, a.at, b.at, weights.projector, a.by, b.by);
      }
      add_right(right, a.at, weights.projector, a.by, view.projector);
    }
  }
}

std::vector<Linear> linearize_all(const std::vector<View>& views, const Bundle& bundle) {
  std::vector<Linear> result;
  result.reserve(views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    result.push_back(linearize(views[v], bundle, v));
  }
  return result;
}

// The unknowns have units of pixels, radians and mm, so they are scaled by the normal matrix's diagonal.
cv::Mat1d scale_of(const cv::Mat1d& normal) {
  cv::Mat1d scale(normal.rows, 1);
  for (int i = 0; i < normal.rows; ++i) {
    scale(i) = normal(i, i) > 0 ? 1 / std::sqrt(normal(i, i)) : 1;
  }
  return scale;
}

// The inverse of the normal matrix. Directions in which it vanishes have infinite variance.
cv::Mat1d covariance_of(const cv::Mat1d& normal) {
  constexpr double kNothing = 1e-13;  // eigenvalue of the scaled matrix that counts as 0, relative to the greatest
  const cv::Mat1d scale = scale_of(normal);
  const cv::Mat1d scaled(normal.mul(scale * scale.t()));
  cv::Mat1d values;
  cv::Mat1d vectors;
  cv::eigen(scaled, values, vectors);
  cv::Mat1d inverse(normal.rows, normal.cols, 0.0);
  for (int k = 0; k < values.rows; ++k) {
    const cv::Mat1d vector(vectors.row(k).t());
    inverse += (1 / std::max(values(k), kNothing * values(0))) * (vector * vector.t());
  }
  return cv::Mat1d(inverse.mul(scale * scale.t()));
}

// The variances of the residuals of camera and projector.
struct SumsOfSquares {
  double camera = 0;
  double projector = 0;
};

SumsOfSquares sums_of(const std::vector<Linear>& views) {
  SumsOfSquares sums;
  for (const Linear& view : views) {
    sums.camera += squares(view.camera);
    sums.projector += squares(view.projector);
  }
  return sums;
}

// One over the variance in one direction of residuals with this sum of squares.
double weight_of(double sum, std::size_t sights) {
  constexpr double kLeastNoise = 1e-6;  // pixels, so that exact data have a finite weight
  const double per_direction = std::sqrt(sum / (2.0 * static_cast<double>(sights)));
  return 1 / std::pow(std::max(kLeastNoise, per_direction), 2);
}

// Levenberg-Marquardt over the views, with its state.
class Solver {
 public:
  Solver(const std::vector<View>& views, const Bundle& start, const FreeDistortion& free)
      : views_(views),
        layout_{kPinhole + free.camera, kPinhole + free.projector, static_cast<int>(views.size())},
        bundle_(start) {
    for (const View& view : views) {
      sights_ += view.sights.size();
    }
    if (!(equations() > layout_.count())) {
      throw std::invalid_argument("calibration: fewer equations than unknowns");
    }
    linear_ = linearize_all(views, start);
  }

  // Runs Levenberg-Marquardt until a step gains next to nothing or no step gains anything.
  void minimize() {
    constexpr int kMostSteps = 200;
    constexpr double kDone = 1e-12;  // relative change of the sum of squares
    for (int step = 0; step < kMostSteps; ++step) {
      weigh();
      const double cost = cost_of(linear_, weights_);
      const double gain = improve(cost);
      if (gain <= kDone * cost) {
        return;
      }
    }
  }

  [[nodiscard]] BundleResult result() const {
    BundleResult result;
    result.bundle = bundle_;
    add_residuals(result);
    add_deviations(result);
    return result;
  }

 private:
  static constexpr int kPinhole = 4;  // parameters of a lens before its distortion

  [[nodiscard]] double equations() const { return 4 * static_cast<double>(sights_); }

  // Estimates the noise of camera and projector from their current residuals.
  void weigh() {
    const SumsOfSquares sums = sums_of(linear_);
    if (!std::isfinite(sums.camera + sums.projector)) {
      throw std::runtime_error("calibration: the least squares do not converge");
    }
    weights_ = {weight_of(sums.camera, sights_), weight_of(sums.projector, sights_)};
  }

  // Takes the first step that does not increase `cost`, with more and more damping. Returns the decrease of the cost,
  // or -1 if there is no such step.
  double improve(double cost) {
    constexpr double kLeastDamping = 1e-12;
    constexpr double kMostDamping = 1e12;
    cv::Mat1d normal;
    cv::Mat1d right;
    normal_equations(linear_, weights_, layout_, normal, right);
    const cv::Mat1d scale = scale_of(normal);
    while (damping_ < kMostDamping) {
      cv::Mat1d damped(normal.mul(scale * scale.t()));
      damped.diag() += damping_;
      cv::Mat1d change;
      if (cv::solve(damped, right.mul(scale), change, cv::DECOMP_CHOLESKY)) {
        const Bundle tried = changed(bundle_, cv::Mat1d(change.mul(scale)), layout_);
        std::vector<Linear> there = linearize_all(views_, tried);
        const double cost_there = cost_of(there, weights_);
        if (cost_there <= cost) {
          bundle_ = tried;
          linear_ = std::move(there);
          damping_ = std::max(kLeastDamping, damping_ / 10);
          return cost - cost_there;
        }
      }
      damping_ *= 10;
    }
    return -1;
  }

  void add_residuals(BundleResult& result) const {
    SumsOfSquares all;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      const auto count = static_cast<double>(views_[v].sights.size());
      const double camera = squares(linear_[v].camera);
      const double projector = squares(linear_[v].projector);
      result.view_camera_rms.push_back(std::sqrt(camera / count));
      result.view_projector_rms.push_back(std::sqrt(projector / count));
      result.camera_residuals.push_back(linear_[v].camera);
      result.projector_residuals.push_back(linear_[v].projector);
      all.camera += camera;
      all.projector += projector;
    }
    const auto count = static_cast<double>(sights_);
    result.camera_rms = std::sqrt(all.camera / count);
    result.projector_rms = std::sqrt(all.projector / count);
    result.rms = std::sqrt((all.camera + all.projector) / (2 * count));
  }

  void add_deviations(BundleResult& result) const {
    cv::Mat1d normal;
    cv::Mat1d right;
    normal_equations(linear_, weights_, layout_, normal, right);
    // Residuals are smaller than the noise, because the unknowns absorb part of it.
    const cv::Mat1d covariance(covariance_of(normal) * (equations() / (equations() - layout_.count())));
    const auto of = [&](int i) { return std::sqrt(std::max(0.0, covariance(i, i))); };
    const auto pose_of = [&](int at) {
      return Pose{{of(at), of(at + 1), of(at + 2)}, {of(at + 3), of(at + 4), of(at + 5)}};
    };
    Bundle& deviation = result.deviation;
    for (int i = 0; i < layout_.camera_free; ++i) {
      deviation.camera[static_cast<std::size_t>(i)] = of(i);
    }
    for (int i = 0; i < layout_.projector_free; ++i) {
      deviation.projector[static_cast<std::size_t>(i)] = of(layout_.projector() + i);
    }
    deviation.stereo = pose_of(layout_.stereo());
    for (int v = 0; v < layout_.views; ++v) {
      deviation.chessboard.push_back(pose_of(layout_.view(v)));
    }
    const cv::Vec3d along = cv::normalize(bundle_.stereo.translation);
    const int t = layout_.stereo() + 3;
    const cv::Mat1d block = covariance(cv::Rect(t, t, 3, 3));
    const cv::Matx33d of_translation(block.clone().ptr<double>());
    result.baseline_deviation = std::sqrt(std::max(0.0, along.dot(of_translation * along)));
  }

  const std::vector<View>& views_;
  Layout layout_;
  std::size_t sights_ = 0;
  Bundle bundle_;
  std::vector<Linear> linear_;  // linearized at bundle_
  Weights weights_;
  double damping_ = 1e-3;
};

}  // namespace

BundleResult solve_bundle(const std::vector<View>& views, const Bundle& start, const FreeDistortion& free) {
  Solver solver(views, start, free);
  solver.minimize();
  return solver.result();
}

}  // namespace selfproj
