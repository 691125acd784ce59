// Compares measured heights and differences with the truth. In all maps rows are frames and columns are image columns;
// values are in mm, NaN if there is none. Masks have one entry for each entry of the map.
#ifndef SELFPROJ_LAB_EVALUATION_H
#define SELFPROJ_LAB_EVALUATION_H

#include <cstdint>
#include <functional>
#include <vector>

#include "host/images/float_image.h"

namespace selfproj {

using Mask = std::vector<std::uint8_t>;

// The true height over the plane at a place (x, y) of the camera's frame during frame `frame` (from 0).
using TrueHeight = std::function<double(int frame, double x, double y)>;

// 1 for the entries within `columns` columns or `rows` rows of a step of the map `truth`, and for those without a
// value. There a line of finite width lies on two heights at the same time. A step is where two neighbours, along a row
// or along a column, differ by more than `min_step`, or only one of them has a value. An entry beside a step is within
// 1 of it.
Mask near_steps(const FloatImage& truth, double min_step, int columns, int rows);

// The same within a rectangle: 1 for the entries that are within `columns` >= 1 columns and `rows` >= 1 rows of a step,
// those beside its corners as well. Hidden rigs are judged like this (lab/scripts/hidden_rig_figures.py).
Mask around_steps(const FloatImage& truth, double min_step, int columns, int rows);

struct HeightErrors {
  std::int64_t points = 0;    // points compared
  std::int64_t left_out = 0;  // points left out near steps
  std::int64_t missing = 0;   // entries without a point that are not near steps
  double max = 0;             // largest magnitude
  double rms = 0;
  double mean = 0;

  // The share of entries without a point among those that are not near steps, 0..1.
  [[nodiscard]] double missing_share() const {
    return points + missing > 0 ? static_cast<double>(missing) / static_cast<double>(points + missing) : 0;
  }
};

// Compares each point's height with the truth at its own x and y. Throws std::invalid_argument if the sizes differ.
HeightErrors height_errors(const FloatImage& height, const FloatImage& x, const FloatImage& y, const Mask& left_out,
                           const TrueHeight& truth);

// The values of a map where the mask is `label`.
struct RegionValues {
  std::int64_t count = 0;  // if 0, the others are NaN
  double mean = 0;
  double median = 0;
};
RegionValues values_in(const FloatImage& map, const Mask& mask, std::uint8_t label);

// How far a region lies below its surroundings in the map `difference` (positive towards the camera). It is the
// difference of the medians, so that points at the edges do not count. NaN if either is empty.
double depth_of(const FloatImage& difference, const Mask& mask, std::uint8_t region, std::uint8_t surroundings);

// max - min of the centroids C in each row (frame), over entries where `left_out` is 0. Rows with fewer than two do not
// count. If no row counts, all values are 0.
struct CentroidRange {
  double greatest = 0;  // over the rows
  double median = 0;
};
CentroidRange centroid_range(const FloatImage& centroid, const Mask& left_out, int first_row, int rows);

}  // namespace selfproj

#endif  // SELFPROJ_LAB_EVALUATION_H
