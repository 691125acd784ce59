#include "host/calibration/board_shape.h"

#include <cmath>
#include <cstddef>
#include <vector>

namespace selfproj {
namespace {

using Values = std::vector<double>;  // one for each corner

double dot(const Values& a, const Values& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum += a[i] * b[i];
  }
  return sum;
}

// Legendre's polynomial of this degree.
double legendre(int degree, double x) {
  double before = 0;
  double now = 1;
  for (int n = 0; n < degree; ++n) {
    const double next = ((2 * n + 1) * x * now - n * before) / (n + 1);
    before = now;
    now = next;
  }
  return now;
}

// The places of the corners from -1 to 1 along both sides.
struct Grid {
  explicit Grid(const Chessboard& chessboard) : board(chessboard) {
    for (int i = 0; i < board.corners(); ++i) {
      x.push_back(2.0 * (i % board.columns) / (board.columns - 1) - 1);
      const int row = i / board.columns;
      y.push_back(2.0 * row / (board.rows - 1) - 1);
    }
  }

  // P_i(x) P_j(y) without the part that is a motion of the plane, and with root mean square `rms`; 0 if there are too
  // few corners to tell it from a lower degree.
  [[nodiscard]] Values mode(int i, int j, double rms) const {
    Values values(x.size(), 0.0);
    if (i >= board.columns || j >= board.rows) {
      return values;
    }
    for (std::size_t k = 0; k < x.size(); ++k) {
      values[k] = legendre(i, x[k]) * legendre(j, y[k]);
    }
    for (const Values& moved : {Values(x.size(), 1.0), x, y}) {  // orthogonal to each other
      const double share = dot(values, moved) / dot(moved, moved);
      for (std::size_t k = 0; k < x.size(); ++k) {
        values[k] -= share * moved[k];
      }
    }
    scale(values, dot(values, values), rms);
    return values;
  }

  void scale(Values& values, double squares, double rms) const {
    constexpr double kNothing = 1e-9;
    const double length = std::sqrt(squares / static_cast<double>(x.size()));
    for (double& value : values) {
      value *= length > kNothing ? rms / length : 0;
    }
  }

  Chessboard board;
  Values x, y;
};

}  // namespace

std::vector<CornerModes> board_modes(const Chessboard& chessboard) {
  constexpr int kLeastDegree = 2;
  constexpr int kMostDegree = 5;
  const Grid grid(chessboard);
  std::vector<CornerModes> modes(grid.x.size());
  std::size_t bend = 0;
  for (int degree = kLeastDegree; degree <= kMostDegree; ++degree) {
    for (int j = 0; j <= degree; ++j, ++bend) {
      const Values values = grid.mode(degree - j, j, 1.0 / (degree - 1));
      for (std::size_t k = 0; k < modes.size(); ++k) {
        modes[k].bend[bend] = values[k];
      }
    }
  }
  // Stretched along x and squeezed along y; sheared without a turn; bent within the plane.
  const double width = chessboard.columns - 1;
  const double height = chessboard.rows - 1;
  Values along(grid.x);
  Values across(grid.y);
  for (std::size_t k = 0; k < modes.size(); ++k) {
    along[k] *= width;
    across[k] *= height;
  }
  const double squares = dot(along, along) + dot(across, across);
  grid.scale(along, squares, 1);
  grid.scale(across, squares, 1);
  std::size_t stretch = 2;
  for (std::size_t k = 0; k < modes.size(); ++k) {
    modes[k].stretch[0] = {along[k], -across[k]};
    modes[k].stretch[1] = {across[k], along[k]};
  }
  for (int j = 0; j <= kLeastDegree; ++j, stretch += 2) {
    const Values values = grid.mode(kLeastDegree - j, j, 1);
    for (std::size_t k = 0; k < modes.size(); ++k) {
      modes[k].stretch[stretch] = {values[k], 0};
      modes[k].stretch[stretch + 1] = {0, values[k]};
    }
  }
  return modes;
}

}  // namespace selfproj
