// Compares a depth image of a thing that moves over a reference with the truth.
#ifndef SELFPROJ_LAB_THING_FIGURES_H
#define SELFPROJ_LAB_THING_FIGURES_H

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "host/images/float_image.h"

namespace selfproj {

// The thing to measure: whatever moves in these columns of the image.
struct Thing {
  std::string name;
  int column_0, column_1;
  double least;  // mm over the reference above which a pixel belongs to the thing, for its size
};

// The figures of one depth image.
struct ThingFigures {
  std::size_t pixels = 0;  // pixels that truly show the thing, in the projector's light
  std::size_t valid = 0;
  double square = 0;                   // sum of the squared errors of z
  double height = 0, true_height = 0;  // 95th percentile of the differences from the reference
  double rows = 0, true_rows = 0;      // extent in pixels
  double columns = 0, true_columns = 0;

  [[nodiscard]] double share() const { return static_cast<double>(valid) / static_cast<double>(pixels); }
  [[nodiscard]] double rms() const { return std::sqrt(square / static_cast<double>(valid)); }
};

// `depth` and `truth` are z in mm, NaN if there is none; differences from the reference are in mm, positive towards the
// camera. A pixel shows the thing if its true difference is more than 1 mm.
ThingFigures figures_of(const Thing& thing, const FloatImage& depth, const FloatImage& difference,
                        const FloatImage& truth, const FloatImage& true_difference);

// Summarizes all depth images of a thing by one method.
class ThingSummary {
 public:
  void add(const ThingFigures& f);

  // RMS error of z over the pixels of all images.
  [[nodiscard]] double rms() const { return std::sqrt(square_ / valid_); }

  // Cells of a table: number of depth images; valid, %; RMS error of z, and that of the worst image; mean error of the
  // height, and its largest; mean errors of rows and columns, and the largest error of either.
  [[nodiscard]] std::vector<std::string> cells() const;

 private:
  int images_ = 0;
  double pixels_ = 0, valid_ = 0, square_ = 0, worst_ = 0;
  double height_ = 0, height_most_ = 0, rows_ = 0, columns_ = 0, size_most_ = 0;
};

}  // namespace selfproj

#endif  // SELFPROJ_LAB_THING_FIGURES_H
