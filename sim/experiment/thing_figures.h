// What a depth image says of a thing that moves over a reference, against the truth.
#ifndef SELFPROJ_SIM_EXPERIMENT_THING_FIGURES_H
#define SELFPROJ_SIM_EXPERIMENT_THING_FIGURES_H

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "host/io/float_image.h"

namespace selfproj {

// What is to be measured: a moving thing in the part of the image with these columns.
struct Thing {
  std::string name;
  int column_0, column_1;
  double least;  // mm over the reference from which on a pixel belongs to it, for its size
};

// Of one depth image.
struct ThingFigures {
  std::size_t pixels = 0;  // that truly show it, in the projector's light
  std::size_t valid = 0;
  double square = 0;                   // of z against the truth
  double height = 0, true_height = 0;  // 95th of 100 parts of the differences from the reference
  double rows = 0, true_rows = 0;      // extent in pixels
  double columns = 0, true_columns = 0;

  [[nodiscard]] double share() const { return static_cast<double>(valid) / static_cast<double>(pixels); }
  [[nodiscard]] double rms() const { return std::sqrt(square / static_cast<double>(valid)); }
};

// `depth`, `truth`: z, mm, NaN where there is none; differences from the reference, mm, towards the camera positive.
// Pixels show the thing where the true difference is more than 1 mm.
ThingFigures figures_of(const Thing& thing, const FloatImage& depth, const FloatImage& difference,
                        const FloatImage& truth, const FloatImage& true_difference);

// All depth images of a thing by a method.
class ThingSummary {
 public:
  void add(const ThingFigures& f);

  // Of z, over the pixels of all images.
  [[nodiscard]] double rms() const { return std::sqrt(square_ / valid_); }

  // Depth images; valid, %; z RMS, that of the worst image; height, mean error, largest; rows, columns, mean errors;
  // the largest error of either.
  [[nodiscard]] std::vector<std::string> cells() const;

 private:
  int images_ = 0;
  double pixels_ = 0, valid_ = 0, square_ = 0, worst_ = 0;
  double height_ = 0, height_most_ = 0, rows_ = 0, columns_ = 0, size_most_ = 0;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_THING_FIGURES_H
