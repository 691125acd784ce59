// Targets for the calibration of heights, with flaws of their own: a flat plate at a known height, and a block of known
// steps.
#ifndef SELFPROJ_SIM_SCENE_TARGETS_H
#define SELFPROJ_SIM_SCENE_TARGETS_H

#include <array>
#include <cstdint>
#include <vector>

#include "sim/scene/scene.h"

namespace selfproj {

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

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_TARGETS_H
