// Measurements of A2 and B4 in a world that is not ideal, against the truth of the part.
#ifndef SELFPROJ_LAB_DISTURBED_MEASUREMENTS_H
#define SELFPROJ_LAB_DISTURBED_MEASUREMENTS_H

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "lab/evaluation.h"
#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/scene.h"
#include "sim/scene/world.h"

namespace selfproj::lab {

// The errors of one way to measure.
struct WayOfMeasuring {
  std::string name;
  ErrorSpread errors;
};

// A2: the marked stairs under the pattern of the good part, whose residual is measured in the same world. Only places
// away from height steps count, whatever is measured there.
class DisturbedStairs {
 public:
  // Takes every `every`-th frame in which the line lies on the part, and this many of the good part.
  DisturbedStairs(const rig::Rig& rig, int every, int reference_frames);

  // Each mode, first with all lit pixels of a column, then with its strongest run. `noise_seed` is that of the frames'
  // noise.
  [[nodiscard]] std::vector<WayOfMeasuring> measure(const sim::World& world, std::int64_t noise_seed = 1) const;

  // Half of the grey value that the line has at its brightest, in the median over the columns of a frame of the good
  // part: a threshold above a reflection that is less than half as bright.
  [[nodiscard]] int half_of_the_line(const sim::World& world) const;

  [[nodiscard]] const rig::Rig& rig() const { return rig_; }

 private:
  rig::Rig rig_;
  int reference_frames_;
  std::unique_ptr<sim::Scene> part_, good_;
  images::FloatImage pattern_;
  std::vector<int> frames_;
  images::FloatImage truth_;  // height, mm; rows are frames_; NaN where nothing is compared
};

// The scanner's rig with so many times fewer pixels along each side of camera and projector.
rig::Rig coarser_rig(rig::Rig rig, int factor);

// How the cuboids are measured.
struct CuboidSettings {
  double threshold = 0;  // of the binarization, grey values; 0: the rig's
  double width = 2;      // of the narrowest self-projected stripe, camera rows
  double highest = 0;    // mm over the plane; what is higher, or deeper than 15 mm below it, is no point; 0: any is
  double exposure = 1;   // factor of all light, with which a pixel's well fills at white
};

// B4: the marked cuboids by 4 self-projected bits, whose reference is scanned by Gray codes in the same world, and by 8
// conventional bits. The interiors of all faces count, the plane as well.
class DisturbedCuboids {
 public:
  explicit DisturbedCuboids(const rig::Rig& rig);
  // `noise_seed` is that of the images' noise.
  [[nodiscard]] std::vector<WayOfMeasuring> measure(const sim::World& world, const CuboidSettings& settings = {},
                                                    std::int64_t noise_seed = 1) const;

 private:
  rig::Rig rig_;
  std::unique_ptr<sim::Scene> part_, good_;
  images::FloatImage truth_;  // z, mm; NaN where nothing is compared
};

}  // namespace selfproj::lab

#endif  // SELFPROJ_LAB_DISTURBED_MEASUREMENTS_H
