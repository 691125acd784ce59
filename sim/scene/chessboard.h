// A chessboard in space, for calibration: a plane that is white but for the black squares.
#ifndef SELFPROJ_SIM_SCENE_CHESSBOARD_H
#define SELFPROJ_SIM_SCENE_CHESSBOARD_H

#include <vector>

#include "host/rig/rig.h"
#include "sim/scene/pinhole.h"
#include "sim/scene/scene.h"

namespace selfproj {

// Inner corners along the image's columns (y) and rows (x) where the board is not turned, and the side of a square, mm.
struct ChessboardShape {
  int across = 0;
  int down = 0;
  double square_mm = 0;
};

// Where the board is: its middle, and the directions of `across` and `down` on it, of length 1 and perpendicular to
// each other. Corner (i, j) is at middle + square ((i - (across - 1)/2) right + (j - (down - 1)/2) below).
struct ChessboardPlace {
  Point3 middle;
  Point3 right{0, 1, 0};
  Point3 below{1, 0, 0};
};

// The board's plane, everywhere: white, with (across + 1) x (down + 1) squares, every second one black. From white to
// black it goes linearly over the way between two of the renderer's sub-pixels, so that their grid does not show.
class ChessboardScene : public Scene {
 public:
  // Throws std::invalid_argument where the plane is steeper than 80 degrees.
  ChessboardScene(const Rig& rig, const ChessboardShape& shape, const ChessboardPlace& place);

  [[nodiscard]] int frames() const override { return 1; }
  [[nodiscard]] double height(double x, double y, double t) const override;
  [[nodiscard]] HeightRange range(const Box& box, double t0, double t1) const override;
  [[nodiscard]] double albedo(double x, double y, double t) const override;
  [[nodiscard]] bool even_albedo() const override { return false; }
  [[nodiscard]] double speed() const override { return 0; }

  static constexpr double kBlack = 0.06;  // what a black square throws back

 private:
  ChessboardShape shape_;
  ChessboardPlace place_;
  double plane_z_;
  double edge_;     // width of an edge, in squares
  double dx_, dy_;  // of z on the plane by x and y
};

// `count` places of the board in which camera and projector see it whole, with a margin of one square around its
// squares: the first faces the camera in the middle of what both see of the rig's plane, the others lean by `tilt_deg`
// in as many directions, further and nearer, and turned and shifted as far as the margin allows so that the corners
// fill both images. Throws UserError where a place finds no room: a smaller board is needed.
std::vector<ChessboardPlace> chessboard_places(const Rig& rig, const ChessboardShape& shape, int count,
                                               double tilt_deg);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_CHESSBOARD_H
