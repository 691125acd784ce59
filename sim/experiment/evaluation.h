// How far measured heights and differences are from the truth, where that is known. All maps have rows = frames and
// columns = image columns, mm, NaN where there is no value; masks have one entry for each of theirs.
#ifndef SELFPROJ_SIM_EXPERIMENT_EVALUATION_H
#define SELFPROJ_SIM_EXPERIMENT_EVALUATION_H

#include <cstdint>
#include <functional>
#include <vector>

#include "host/io/float_image.h"

namespace selfproj {

using Mask = std::vector<std::uint8_t>;

// The true height over the plane at a place (x, y) of the camera's frame while frame `frame` (from 0) is taken.
using TrueHeight = std::function<double(int frame, double x, double y)>;

// 1 for the entries within `columns` columns, or within `rows` rows, of a step of the map `truth`, and for those
// without a value: there a line of finite width lies on two heights at once. A step is where neighbours, along a row or
// along a column, differ by more than `min_step`, or one of them has a value and the other has none. An entry beside a
// step is within 1 of it.
Mask near_steps(const FloatImage& truth, double min_step, int columns, int rows);

struct HeightErrors {
  std::int64_t points = 0;    // compared
  std::int64_t left_out = 0;  // points that are near steps
  std::int64_t missing = 0;   // entries not near steps that have no point
  double max = 0;             // of the magnitude
  double rms = 0;
  double mean = 0;

  // Of the entries not near steps, those without a point; 0..1.
  [[nodiscard]] double missing_share() const {
    return points + missing > 0 ? static_cast<double>(missing) / static_cast<double>(points + missing) : 0;
  }
};

// Compares each point's height with the truth at its own x and y. Throws std::invalid_argument where the sizes differ.
HeightErrors height_errors(const FloatImage& height, const FloatImage& x, const FloatImage& y, const Mask& left_out,
                           const TrueHeight& truth);

// What the values of a map are like where the mask is `label`.
struct RegionValues {
  std::int64_t count = 0;  // 0: the others are NaN
  double mean = 0;
  double median = 0;
};
RegionValues values_in(const FloatImage& map, const Mask& mask, std::uint8_t label);

// How far a region lies below its surroundings in the map `difference` (towards the camera positive): the difference of
// the medians, so that points at its edge do not count. NaN where one of them is empty.
double depth_of(const FloatImage& difference, const Mask& mask, std::uint8_t region, std::uint8_t surroundings);

// Of the centroids C of each row (frame), without those where `left_out` is not 0: max - min. Rows with fewer than two
// do not count; without any, all is 0.
struct CentroidRange {
  double greatest = 0;  // over the rows
  double median = 0;
};
CentroidRange centroid_range(const FloatImage& centroid, const Mask& left_out, int first_row, int rows);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_EVALUATION_H
