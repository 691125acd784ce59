#include "host/calibration/bundle_solver.h"

#include <ceres/manifold.h>
#include <ceres/ordered_groups.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <glog/logging.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <numeric>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <utility>
#include <vector>

#include "host/calibration/bundle_cost.h"
#include "host/calibration/bundle_covariance.h"
#include "host/calibration/plates.h"

namespace selfproj::calibration {
namespace {

using bundle_cost::kLens;
using bundle_cost::kPose;
using bundle_cost::kView;
using bundle_cost::plate_cost;
using bundle_cost::PriorCost;
using bundle_cost::ViewCost;

constexpr double kMinNoise = 1e-6;  // pixels, so that exact data have a finite weight

// What is random, in the order of the residuals.
using Kind = int;
constexpr Kind kCamera = 0;
constexpr Kind kProjector = 1;
constexpr Kind kBend = 2;
constexpr Kind kStretch = 3;
constexpr Kind kOwn = 4;
constexpr Kind kKinds = 5;
constexpr Kind kKnown = kKinds;  // of known size: what plates are off

std::array<double*, kKinds> parts_of(BundleNoise& noise) {
  return {&noise.camera, &noise.projector, &noise.bend, &noise.stretch, &noise.own};
}

// Which of the coefficients of a lens are held.
std::vector<int> held(int free) {
  std::vector<int> indices;
  for (int i = kPinholeParameters + free; i < kLens; ++i) {
    indices.push_back(i);
  }
  return indices;
}

// The problem, with the unknowns in the form that Ceres takes. Neither copied nor moved: Ceres points into it.
class Fit {
 public:
  Fit(const std::vector<View>& views, const Bundle& start, const BundleOptions& options, bool poses_only)
      : views_(views), options_(options), poses_only_(poses_only), from_(start), noise_(start.noise) {
    std::copy(start.camera.begin(), start.camera.end(), camera_.begin());
    std::copy(start.projector.begin(), start.projector.end(), projector_.begin());
    put(start.stereo, stereo_.data());
    shape_ = start.shape;
    blocks_.resize(views.size());
    for (std::size_t v = 0; v < views.size(); ++v) {
      put(start.chessboard[v], blocks_[v].data());
      if (v < start.own_bend.size()) {
        std::copy(start.own_bend[v].begin(), start.own_bend[v].end(), blocks_[v].begin() + kPose);
      }
      sights_ += views[v].sights.size();
    }
    put(start.belt.pose, belt_.data());
    way_ = {start.belt.way[0], start.belt.way[1], start.belt.scale};
    plate_off_ = start.belt.plate_off;
    add_residuals();
    hold();
  }
  Fit(const Fit&) = delete;
  Fit& operator=(const Fit&) = delete;
  ~Fit() = default;

  void solve() {
    constexpr int kMaxRounds = 15;
    constexpr double kSettled = 0.05;  // relative change of a standard deviation
    constexpr double kRough = 1e-7;    // relative change of the cost at which a minimization ends
    constexpr double kFine = 1e-13;
    for (int round = 0; options_.estimate_noise && round < kMaxRounds; ++round) {
      minimize(kRough);
      if (estimate_noise() < kSettled) {
        break;
      }
    }
    minimize(options_.deviations ? kFine : kRough);
  }

  [[nodiscard]] BundleResult result() {
    BundleResult result;
    result.bundle = bundle();
    result.cost = cost_;
    add_lengths(result);
    return result;
  }

  // The normal matrix, its unknowns in the order of BundleLayout.
  [[nodiscard]] Eigen::MatrixXd normal() { return normal_matrix(linearize().jacobian); }

  [[nodiscard]] BundleLayout layout() const {
    return {options_.free, options_.projector, options_.shape != nullptr, views_.size()};
  }

  // Throws std::invalid_argument if there are fewer equations than unknowns.
  void check_equations() const {
    const int projector = options_.projector ? kPinholeParameters + options_.free.projector + kPose : 0;
    const int unknowns =
        kPinholeParameters + options_.free.camera + projector + kPose * static_cast<int>(views_.size());
    if (!(static_cast<int>(sights_) * (options_.projector ? 4 : 2) > unknowns)) {
      throw std::invalid_argument("fewer equations than unknowns");
    }
  }

 private:
  static void put(const Pose& pose, double* to) {
    for (int i = 0; i < 3; ++i) {
      to[i] = pose.rotation[i];
      to[3 + i] = pose.translation[i];
    }
  }
  static Pose pose_at(const double* from) { return {{from[0], from[1], from[2]}, {from[3], from[4], from[5]}}; }

  // Adds residuals, of which `counts` are of these kinds in succession.
  template <typename... Blocks>
  void add(std::initializer_list<std::pair<Kind, int>> counts, ceres::CostFunction* cost, Blocks*... blocks) {
    residuals_.push_back(problem_.AddResidualBlock(cost, nullptr, blocks...));
    for (const auto& [kind, count] : counts) {
      kinds_.insert(kinds_.end(), static_cast<std::size_t>(count), kind);
    }
  }

  void add_residuals() {
    using SharedPrior = PriorCost<kSharedModes, kSharedModes>;
    using OwnPrior = PriorCost<kOwnModes, kView>;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      add({{kCamera, 2 * static_cast<int>(views_[v].sights.size())}},
          new ViewCost(ViewCost::InCamera(), views_[v], options_.shape, noise_), camera_.data(), blocks_[v].data(),
          shape_.data());
    }
    for (std::size_t v = 0; v < views_.size() && options_.projector; ++v) {
      add({{kProjector, 2 * static_cast<int>(views_[v].sights.size())}},
          new ViewCost(ViewCost::InProjector(), views_[v], options_.shape, noise_), projector_.data(), stereo_.data(),
          blocks_[v].data(), shape_.data());
    }
    if (shaped()) {
      add({{kBend, kBendModes}, {kStretch, kStretchModes}}, new SharedPrior, shape_.data());
      for (auto& block : blocks_) {
        add({{kOwn, kOwnModes}}, new OwnPrior, block.data());
      }
    }
    if (options_.plates != nullptr) {
      add_plates(*options_.plates);
    }
  }

  void add_plates(const Plates& plates) {
    for (std::size_t v = 0; v < views_.size(); ++v) {
      const PlatePlace& place = plates.places[v];
      if (place.plate >= 0) {
        add({{kKnown, kPose}}, plate_cost(place, plates), belt_.data(), way_.data(),
            plate_off_[static_cast<std::size_t>(place.plate)].data(), blocks_[v].data());
      }
    }
    for (auto& off : plate_off_) {
      add({{kKnown, kPose}}, new PriorCost<kPose, kPose>, off.data());
    }
    add({{kKnown, 1}}, new PriorCost<1, 3>, way_.data());
  }

  // Puts what is estimated in order, and holds the rest.
  void hold() {
    const auto hold_some = [&](double* block, int size, const std::vector<int>& which) {
      if (!which.empty()) {
        problem_.SetManifold(block, new ceres::SubsetManifold(size, which));
      }
    };
    std::vector<int> own_bend(kOwnModes);
    std::iota(own_bend.begin(), own_bend.end(), kPose);
    hold_some(camera_.data(), kLens, held(options_.free.camera));
    order_ = {camera_.data()};
    if (options_.projector) {
      hold_some(projector_.data(), kLens, held(options_.free.projector));
      order_.insert(order_.end(), {projector_.data(), stereo_.data()});
    }
    if (shaped()) {
      order_.push_back(shape_.data());
    } else {
      problem_.SetParameterBlockConstant(shape_.data());
    }
    for (auto& block : blocks_) {
      order_.push_back(block.data());
      if (!shaped()) {
        hold_some(block.data(), kView, own_bend);
      }
    }
    if (options_.plates != nullptr) {
      order_.insert(order_.end(), {belt_.data(), way_.data()});
      hold_some(way_.data(), 3, options_.plates->moved ? std::vector<int>{} : std::vector<int>{0, 1});
      for (auto& off : plate_off_) {
        order_.push_back(off.data());
      }
    }
    if (poses_only_) {
      problem_.SetParameterBlockConstant(camera_.data());
      problem_.SetParameterBlockConstant(projector_.data());
      problem_.SetParameterBlockConstant(stereo_.data());
    }
  }

  // Whether the shape is estimated.
  [[nodiscard]] bool shaped() const { return options_.shape != nullptr && !poses_only_; }

  void minimize(double tolerance) {
    const int most_steps = options_.deviations ? 300 : 60;
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    std::vector<double*> all;
    problem_.GetParameterBlocks(&all);
    for (double* block : all) {
      options.linear_solver_ordering->AddElementToGroup(block, 1);
    }
    for (auto& block : blocks_) {
      options.linear_solver_ordering->AddElementToGroup(block.data(), 0);
    }
    options.max_num_iterations = most_steps;
    options.function_tolerance = tolerance;
    options.gradient_tolerance = 1e-14;
    options.parameter_tolerance = 1e-12;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    cost_ = summary.final_cost;
    if (!summary.IsSolutionUsable() || !std::isfinite(cost_)) {
      throw std::runtime_error("the least squares do not converge");
    }
  }

  struct Linear {
    std::vector<double> residuals;
    ceres::CRSMatrix jacobian;
  };

  [[nodiscard]] Linear linearize() {
    Linear linear;
    ceres::Problem::EvaluateOptions options;
    options.parameter_blocks = order_;
    options.residual_blocks = residuals_;
    problem_.Evaluate(options, nullptr, &linear.residuals, nullptr, &linear.jacobian);
    return linear;
  }

  // One step of variance components. Returns the greatest relative change of a standard deviation.
  double estimate_noise() {
    const Linear linear = linearize();
    const std::vector<double> leverage = leverages(linear.jacobian, covariance_of(normal_matrix(linear.jacobian)));
    std::array<double, kKnown + 1> squares{};
    std::array<double, kKnown + 1> redundancy{};
    for (std::size_t row = 0; row < leverage.size(); ++row) {
      squares[kinds_[row]] += linear.residuals[row] * linear.residuals[row];
      redundancy[kinds_[row]] += 1 - leverage[row];
    }
    return apply(squares, redundancy);
  }

  double apply(const std::array<double, kKnown + 1>& squares, const std::array<double, kKnown + 1>& redundancy) {
    constexpr double kNoRedundancy = 1e-3;
    constexpr double kFastest = 20;  // a shape's standard deviation changes by no more than this factor at once
    double greatest = 0;
    const std::array<double*, kKinds> parts = parts_of(noise_);
    const double side = board_side(views_);
    for (int kind = 0; kind < kKinds; ++kind) {
      if (!(redundancy[static_cast<std::size_t>(kind)] > kNoRedundancy)) {
        continue;
      }
      double& part = *parts[static_cast<std::size_t>(kind)];
      const double before = part;
      double factor = std::sqrt(squares[static_cast<std::size_t>(kind)] / redundancy[static_cast<std::size_t>(kind)]);
      if (kind >= kBend) {
        factor = std::clamp(factor, 1 / kFastest, kFastest);
        part = std::clamp(before * factor, kMinShape * side, kMaxShape * side);
        rescale(kind, before / part);
      } else {
        part = std::max(kMinNoise, before * factor);
      }
      greatest = std::max(greatest, std::abs(part / before - 1));
    }
    return greatest;
  }

  // Keeps the shape when the unit of its coefficients changes.
  void rescale(Kind kind, double factor) {
    if (kind == kOwn) {
      for (auto& block : blocks_) {
        std::for_each(block.begin() + kPose, block.end(), [&](double& c) { c *= factor; });
      }
      return;
    }
    const auto first = shape_.begin() + (kind == kBend ? 0 : kBendModes);
    std::for_each(first, first + (kind == kBend ? kBendModes : kStretchModes), [&](double& c) { c *= factor; });
  }

  [[nodiscard]] Bundle bundle() const {
    Bundle bundle = from_;
    bundle.camera = camera_;
    bundle.projector = projector_;
    bundle.stereo = pose_at(stereo_.data());
    bundle.shape = shape_;
    bundle.noise = noise_;
    bundle.belt = {pose_at(belt_.data()), {way_[0], way_[1]}, way_[2], plate_off_};
    bundle.chessboard.clear();
    bundle.own_bend.clear();
    for (const auto& block : blocks_) {
      bundle.chessboard.push_back(pose_at(block.data()));
      bundle.own_bend.emplace_back();
      std::copy(block.begin() + kPose, block.end(), bundle.own_bend.back().begin());
    }
    return bundle;
  }

  void add_lengths(BundleResult& result) {
    std::vector<double> residuals;
    ceres::Problem::EvaluateOptions options;
    options.residual_blocks = residuals_;
    problem_.Evaluate(options, nullptr, &residuals, nullptr, nullptr);
    std::size_t at = 0;
    const auto take = [&](double noise, std::vector<double>& view_rms, std::vector<std::vector<cv::Vec2d>>& lists) {
      double all = 0;
      for (const View& view : views_) {
        lists.emplace_back();
        double sum = 0;
        for (std::size_t i = 0; i < view.sights.size(); ++i, at += 2) {
          lists.back().emplace_back(noise * residuals[at], noise * residuals[at + 1]);
          sum += lists.back().back().dot(lists.back().back());
        }
        view_rms.push_back(std::sqrt(sum / static_cast<double>(view.sights.size())));
        all += sum;
      }
      return std::sqrt(all / static_cast<double>(sights_));
    };
    result.camera_rms = take(noise_.camera, result.view_camera_rms, result.camera_residuals);
    if (options_.projector) {
      result.projector_rms = take(noise_.projector, result.view_projector_rms, result.projector_residuals);
    }
    result.rms = std::hypot(result.camera_rms, result.projector_rms) / std::sqrt(options_.projector ? 2 : 1);
  }

  static constexpr double kMinShape = 1e-5;  // of the chessboard's side
  static constexpr double kMaxShape = 0.01;

  const std::vector<View>& views_;
  BundleOptions options_;
  bool poses_only_;
  Bundle from_;
  BundleNoise noise_;
  std::array<double, kLensParameters> camera_{}, projector_{};
  std::array<double, kPose> stereo_{};
  std::array<double, kSharedModes> shape_{};
  std::vector<std::array<double, kView>> blocks_;
  std::array<double, kPose> belt_{};
  std::array<double, 3> way_{};  // and scale
  std::vector<std::array<double, kPose>> plate_off_;
  std::size_t sights_ = 0;
  std::vector<double*> order_;
  std::vector<ceres::ResidualBlockId> residuals_;
  std::vector<Kind> kinds_;  // of each single residual
  double cost_ = 0;
  ceres::Problem problem_;
};

}  // namespace

BundleResult solve_bundle(const std::vector<View>& views, const Bundle& start, const BundleOptions& options) {
  FLAGS_minloglevel = google::GLOG_FATAL;  // what Ceres has to say is in the result
  Fit fit(views, start, options, false);
  fit.check_equations();
  fit.solve();
  BundleResult result = fit.result();
  if (!options.deviations) {
    return result;
  }
  result.distortion_covariance = distortion_covariance(covariance_of(fit.normal()), fit.layout());
  // What is held at 0 is not known to be 0.
  BundleOptions wide = options;
  wide.free.camera = std::max(options.free.camera, options.uncertain.camera);
  wide.free.projector = std::max(options.free.projector, options.uncertain.projector);
  Fit with_more(views, result.bundle, wide, false);
  Eigen::MatrixXd normal = with_more.normal();
  add_distortion_prior(normal, with_more.layout(), options.free);
  const Eigen::MatrixXd covariance = covariance_of(normal);
  fill_deviations(covariance, with_more.layout(), options.free, result);
  if (options.plates != nullptr) {
    fill_belt_deviations(covariance, *options.plates, result);
  }
  return result;
}

BundleResult locate_view(const View& view, const Bundle& bundle, const Pose& start,
                         const std::vector<CornerModes>* shape) {
  const std::vector<View> views{view};
  Bundle at = bundle;
  at.chessboard = {start};
  at.own_bend.assign(1, {});
  BundleOptions options;
  options.shape = shape;
  options.estimate_noise = false;
  Fit fit(views, at, options, true);
  fit.solve();
  return fit.result();
}

cv::Vec3d place_on_board(const Sight& sight, const Bundle& bundle, const std::vector<CornerModes>* shape) {
  const std::array<double, kOwnModes> none{};
  const Eigen::Vector3d place =
      bundle_cost::place(sight, bundle_cost::modes_at(shape, sight), bundle.noise, bundle.shape.data(), none.data());
  return {place[0], place[1], place[2]};
}

}  // namespace selfproj::calibration
