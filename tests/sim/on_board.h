// Points of a chessboard in space, from the definition of its place.
#ifndef SELFPROJ_TESTS_SIM_ON_BOARD_H
#define SELFPROJ_TESTS_SIM_ON_BOARD_H

#include "sim/scene/optics.h"
#include "sim/scene/targets.h"

namespace selfproj::test {

// The point at (across, down) squares from the first inner corner.
inline selfproj::sim::Point3 on_board(const sim::ChessboardShape& shape, const sim::ChessboardPlace& place,
                                      double across, double down) {
  const double i = shape.square_mm * (across - (shape.across - 1) / 2.0);
  const double j = shape.square_mm * (down - (shape.down - 1) / 2.0);
  return {place.middle.x + i * place.right.x + j * place.below.x,
          place.middle.y + i * place.right.y + j * place.below.y,
          place.middle.z + i * place.right.z + j * place.below.z};
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_SIM_ON_BOARD_H
