// Targets for calibration with flaws of their own: a flat plate, a block of steps, and a chessboard with its places.
#ifndef SELFPROJ_SIM_SCENE_TARGETS_H
#define SELFPROJ_SIM_SCENE_TARGETS_H

#include <array>
#include <cstdint>
#include <vector>

#include "selfproj/rig/rig.h"
#include "sim/scene/optics.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/scene.h"

namespace selfproj::sim {

// What a target may deviate by from what it is sold as. Real ones are drawn evenly within these bounds.
struct TargetTolerance {
  double height_mm = 0;    // of a plate's or tread's height, to either side
  double flatness_mm = 0;  // from the lowest point of a plate or block to its highest
};

// A plate that covers the whole belt. Its surface is wavy, in lengths from 60 mm (a scraped plate) to 800 mm (tilt and
// bow over the part that the camera sees).
class FlatPlate : public Scene {
 public:
  FlatPlate(double height_mm, const TargetTolerance& tolerance, std::uint64_t seed);

  [[nodiscard]] int frames() const override { return 1; }
  [[nodiscard]] double height(double x, double y, double t) const override;
  [[nodiscard]] HeightRange range(const Box& box, double t0, double t1) const override;
  [[nodiscard]] Smoothness smoothness(const Box& box) const override;
  [[nodiscard]] double speed() const override { return 0; }

 private:
  struct Wave {
    double amplitude;
    double along_x, along_y;  // radians for each mm
    double phase;
  };
  double height_;
  std::array<Wave, 5> waves_{};
};

// Treads side by side across the belt, `tread_mm` wide each, endless along it, with vertical faces, and the belt beside
// them. Each tread is level.
class StepBlock : public Scene {
 public:
  // `shift_mm`: y of the block's middle.
  StepBlock(std::vector<double> heights_mm, double tread_mm, double shift_mm, const TargetTolerance& tolerance,
            std::uint64_t seed);

  [[nodiscard]] int frames() const override { return 1; }
  [[nodiscard]] double height(double x, double y, double t) const override;
  [[nodiscard]] HeightRange range(const Box& box, double t0, double t1) const override;
  [[nodiscard]] double speed() const override { return 0; }

  // The treads' true heights.
  [[nodiscard]] const std::vector<double>& heights() const { return heights_; }

 private:
  std::vector<double> heights_;
  double tread_;
  double begin_;  // y of the first tread's edge
};

// A chessboard in space, for calibration: a white plane with black squares.

// Inner corners along the image's columns (y) and rows (x) if the board is not turned, and the side of a square in mm.
struct ChessboardShape {
  int across = 0;
  int down = 0;
  double square_mm = 0;
};

// What a printed board has instead: sides of its squares by these factors, and a bend.
struct ChessboardFlaws {
  double across_scale = 1;
  double down_scale = 1;
  // How far the board's surface is from its plane, mm, by u², u v and v², where u and v are 1 at the middles of the
  // outermost squares across and down. It stays level beyond them.
  std::array<double, 3> bend_mm{};
};

// Flaws drawn evenly: scales within 1 +- `scale`, each part of the bend within +- `bend_mm`.
ChessboardFlaws drawn_flaws(double scale, double bend_mm, std::uint64_t seed);

// The position of the board: its middle, and the directions of `across` and `down` on it, perpendicular and of length
// 1. Corner (i, j) is at middle + square ((i - (across - 1)/2) right + (j - (down - 1)/2) below).
struct ChessboardPlace {
  Point3 middle;
  Point3 right{0, 1, 0};
  Point3 below{1, 0, 0};
};

// The board's whole plane: white, with (across + 1) x (down + 1) squares, every second one black. Edges between white
// and black are linear over the distance between two of the renderer's sub-pixels, so that their grid does not show.
class ChessboardScene : public Scene {
 public:
  // Throws std::invalid_argument if the plane is steeper than 80 degrees.
  ChessboardScene(const rig::Rig& rig, const ChessboardShape& shape, const ChessboardPlace& place,
                  const ChessboardFlaws& flaws = {});

  [[nodiscard]] int frames() const override { return 1; }
  [[nodiscard]] double height(double x, double y, double t) const override;
  [[nodiscard]] HeightRange range(const Box& box, double t0, double t1) const override;
  [[nodiscard]] double albedo(double x, double y, double t) const override;
  [[nodiscard]] bool even_albedo() const override { return false; }
  [[nodiscard]] Smoothness smoothness(const Box& box) const override;
  [[nodiscard]] bool is_plain(const Box& box) const override;
  [[nodiscard]] double speed() const override { return 0; }

  static constexpr double kBlack = 0.06;  // albedo of a black square

 private:
  // The distance of the board's surface from its plane at a place on it, mm from its middle.
  [[nodiscard]] double bend(double right, double below) const;

  // Bounds of the places on the board of what lies in the rectangle, mm from its middle.
  struct Part {
    double right_0, right_1, below_0, below_1;
  };
  [[nodiscard]] Part part_in(const Box& box) const;

  ChessboardShape shape_;
  ChessboardPlace place_;
  ChessboardFlaws flaws_;
  bool bent_;
  Point3 normal_;
  double steepest_bend_ = 0;  // bound of the slope that the bend adds to z
  double plane_z_;
  double edge_;     // width of an edge, in squares
  double dx_, dy_;  // slopes of z on the plane along x and y
};

// Heights of a plate that carries the board, and places of the belt on which it lies, in mm.
struct PlateVisits {
  std::vector<double> heights_mm, belt_mm;
};

// What the plate may be off, to either side.
struct PlateFlaws {
  double height_mm = 0;
  double parallel_mm = 0;  // of one end of the board above the other, along both of its sides
  double fence_mm = 0;     // of its place on the belt, and of one end of the board beside the other
};

// The places of a board on a plate over the belt, along the camera's rows, height by height and there belt place by
// belt place. A laser need not light it. The plate is put down anew at each height, with flaws drawn evenly; then only
// the belt moves it, along x. The middle of its way is where camera and projector both look. Throws UserError if one of
// them does not see all of the board at a place.
std::vector<ChessboardPlace> places_on_plates(const PerturbedRig& actual, const ChessboardShape& shape,
                                              const PlateVisits& visits, const PlateFlaws& flaws, std::uint64_t seed);

// `count` places of the board in which camera and projector see it whole, with a margin of one square around it. In the
// first place it faces the camera, in the middle of the area of the rig's plane that both see. In the others it leans
// by `tilt_deg` in as many directions, nearer and further away, and is turned and shifted as far as the margin allows,
// so that the corners fill both images. A laser must cross the board in each place. Throws UserError if a place has no
// room; then a smaller board is needed.
std::vector<ChessboardPlace> chessboard_places(const PerturbedRig& actual, const ChessboardShape& shape, int count,
                                               double tilt_deg);

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_SCENE_TARGETS_H
