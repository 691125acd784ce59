// Tests the derivatives of the bundle's residuals against differences.
#include "host/calibration/bundle_cost.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "host/calibration/chessboard.h"

namespace selfproj::test {
namespace {

using namespace calibration::bundle_cost;  // NOLINT(google-build-using-namespace)

struct Problem {
  // A board that leans, `turned` by an angle about an axis, before lenses with all kinds of distortion.
  explicit Problem(double turned) : modes(calibration::board_modes(board)) {
    std::mt19937_64 random(11);
    std::normal_distribution<double> normal;
    for (int i = 0; i < board.corners(); ++i) {
      calibration::Sight sight;
      sight.corner = i;
      sight.chessboard = {20.0 * (i % board.columns), 20.0 * (i - i % board.columns) / board.columns, 0};
      view.sights.push_back(sight);
    }
    lens = {900, 880, 310, 250, -0.3, 0.2, 0.01, -0.02, 0.1};
    stereo = {0.1, -0.3, 0.05, 5, -140, 20};
    pose = {0.6 * turned, -0.5 * turned, 0.3 * turned, -40, -30, 300};
    while (pose.size() < kView) {
      pose.push_back(normal(random));
    }
    for (double& c : shape) {
      c = normal(random);
    }
  }

  calibration::Chessboard board{7, 5, 20};
  std::vector<calibration::CornerModes> modes;
  calibration::BundleNoise noise{0.1, 0.2, 0.5, 0.1, 0.3};
  calibration::View view;
  std::vector<double> lens, stereo, pose, shape = std::vector<double>(calibration::kSharedModes);
};

void expect_derivatives(const ViewCost& cost, std::vector<std::vector<double>> blocks) {
  const auto count = static_cast<std::size_t>(cost.num_residuals());
  std::vector<std::vector<double>> jacobians;
  std::vector<const double*> parameters;
  std::vector<double*> to;
  for (const std::vector<double>& block : blocks) {
    jacobians.emplace_back(count * block.size(), std::nan(""));
    parameters.push_back(block.data());
  }
  for (std::vector<double>& jacobian : jacobians) {
    to.push_back(jacobian.data());
  }
  std::vector<double> residuals(count);
  ASSERT_TRUE(cost.Evaluate(parameters.data(), residuals.data(), to.data()));
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    for (std::size_t i = 0; i < blocks[b].size(); ++i) {
      const double at = blocks[b][i];
      const double step = 1e-5 * (1 + 0.01 * std::abs(at));
      std::array<std::vector<double>, 2> moved{std::vector<double>(count), std::vector<double>(count)};
      for (const int side : {0, 1}) {
        blocks[b][i] = at + (side == 0 ? -step : step);
        ASSERT_TRUE(cost.Evaluate(parameters.data(), moved.at(static_cast<std::size_t>(side)).data(), nullptr));
      }
      blocks[b][i] = at;
      for (std::size_t k = 0; k < count; ++k) {
        const double expected = (moved[1][k] - moved[0][k]) / (2 * step);
        EXPECT_NEAR(jacobians[b][k * blocks[b].size() + i], expected, 1e-4 + 1e-6 * std::abs(expected))
            << "block " << b << ", parameter " << i << ", residual " << k;
      }
    }
  }
}

TEST(BundleCost, DerivativesAreDifferences) {
  for (const double turned : {1.0, 0.0, 3.0}) {
    SCOPED_TRACE(turned);
    const Problem p(turned);
    expect_derivatives(ViewCost(ViewCost::InCamera(), p.view, &p.modes, p.noise), {p.lens, p.pose, p.shape});
    expect_derivatives(ViewCost(ViewCost::InProjector(), p.view, &p.modes, p.noise),
                       {p.lens, p.stereo, p.pose, p.shape});
  }
}

TEST(BundleCost, PriorIsTheLastOfItsBlock) {
  const PriorCost<2, 3> prior;
  const std::array<double, 3> block{7, 8, 9};
  const double* parameters = block.data();
  std::array<double, 2> residuals{};
  std::array<double, 6> jacobian{};
  double* to = jacobian.data();
  ASSERT_TRUE(prior.Evaluate(&parameters, residuals.data(), &to));
  EXPECT_EQ(residuals, (std::array<double, 2>{8, 9}));
  EXPECT_EQ(jacobian, (std::array<double, 6>{0, 1, 0, 0, 0, 1}));
}

}  // namespace
}  // namespace selfproj::test
