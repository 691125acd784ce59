// Chessboards, sizes and lenses on their way between Python and calibration.
#ifndef SELFPROJ_PYTHON_BINDINGS_CHESSBOARDS_H
#define SELFPROJ_PYTHON_BINDINGS_CHESSBOARDS_H

#include <cstddef>
#include <cstring>
#include <opencv2/core/matx.hpp>
#include <utility>
#include <vector>

#include "host/calibration/chessboard.h"
#include "python/bindings/arrays.h"
#include "selfproj/rig/calibration.h"

namespace selfproj::python {

using Size = std::pair<int, int>;  // columns, rows

// Throws ValueError.
inline calibration::Chessboard chessboard_of(const Size& corners, double square_mm) {
  require(corners.first >= 3 && corners.second >= 3 && corners.first <= 200 && corners.second <= 200,
          "corners: must be 3..200 along both sides");
  require(square_mm > 0 && square_mm < 1e6, "square_mm: must be above 0");
  return {.columns = corners.first, .rows = corners.second, .square_mm = square_mm};
}

// A matrix of OpenCV as an array.
template <int Rows, int Columns>
Out<double> array_of_matrix(const cv::Matx<double, Rows, Columns>& matrix) {
  const std::vector<std::size_t> shape =
      Columns == 1 ? std::vector<std::size_t>{Rows} : std::vector<std::size_t>{Rows, Columns};
  auto array = new_array<double>(shape);
  std::memcpy(array.data(), matrix.val, sizeof matrix.val);
  return array;
}

inline Out<double> camera_matrix(const rig::Lens& lens) {
  return array_of_matrix(cv::Matx33d(lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1));
}

// k1, k2, p1, p2, k3, k4, k5, k6.
inline Out<double> distortion(const rig::Lens& lens) {
  auto array = new_array<double>({lens.k.size()});
  std::memcpy(array.data(), lens.k.data(), sizeof lens.k);
  return array;
}

}  // namespace selfproj::python

#endif  // SELFPROJ_PYTHON_BINDINGS_CHESSBOARDS_H
