// How many rows of the sensor a light section needs: what heights they leave, how well, and how fast they can come.
#ifndef SELFPROJ_HOST_LIGHT_SECTION_ROWS_H
#define SELFPROJ_HOST_LIGHT_SECTION_ROWS_H

#include <vector>

#include "selfproj/light_section/differential_profile.h"
#include "selfproj/rig/rig.h"

namespace selfproj::light_section {

// Of each column with a reference: the differences -dz from it, in mm and positive towards the camera, at the centroids
// that the sensor's rows give, four a row.
class RowTable {
 public:
  // `lit_rows`: rows that the line lights, > 0.
  RowTable(const rig::Rig& rig, const DifferentialProfiler& profiler, double lit_rows);

  // Columns with a reference.
  [[nodiscard]] int columns() const { return static_cast<int>(columns_.size()); }

  // What a region of these rows of the sensor (first from 0) measures: from `low_mm` below the reference to `high_mm`
  // above it, in at least `share` (0..1) of the columns. Nothing can be measured where low > high. A line must leave
  // the outermost rows dark, or it is cut off (line_is_cut_off).
  struct Range {
    double low_mm = 0, high_mm = 0;
  };
  [[nodiscard]] Range range(int first_row, int rows, double share) const;

  // The region of `rows` rows with the greatest range on both sides, that is min(-low, high), and this range.
  struct Choice {
    int first_row = 0;
    Range range;
    [[nodiscard]] double both_sides_mm() const { return range.high_mm < -range.low_mm ? range.high_mm : -range.low_mm; }
  };
  [[nodiscard]] Choice best(int rows, double share) const;

  // The height that one row means at the reference: the median of the columns, mm.
  [[nodiscard]] double mm_per_row() const;

 private:
  struct Column {
    double reference_row = 0;       // centroid of the reference, from 1
    std::vector<double> height_mm;  // by centroid; NaN where there is no point
  };
  [[nodiscard]] double height_at(const Column& column, double centroid) const;

  int rows_;
  double half_line_;
  std::vector<Column> columns_;
};

// The grey over the dark that the brightest row of a line reaches on the built-in scenes: about 0.7 of white.
inline constexpr double kPeakOfWhite = 0.7;

// Rows that a line lights: the middle of the rig's min_lit_px and half of its max_lit_px.
double usual_lit_rows(const rig::Rig& rig);

// The standard deviation of the centroid of a line, in rows, from the noise of the camera (RigImaging): a Gaussian line
// whose lit rows are four standard deviations, of a peak of `peak` grey values over the dark, each pixel with shot and
// read noise. With weights w = max(g - threshold, 0) (mode grey-over), at which pixels near the threshold come and go:
//     sigma² = sum_r (r - C)² var(w_r) / M0²,  M0 = sum_r mean(w_r),
// the mean over all places of the line within a row. Grey values are those of 8 bits, as in RigImaging. Infinite where
// nothing is lit.
double centroid_noise(const rig::RigImaging& imaging, double peak, double lit_rows, double threshold);

// The frames a second that the board's circuit takes: a frame takes rows times columns / 4 clocks, and no fewer than
// its packet needs (docs/using-the-circuits.md).
double board_rate_hz(const rig::Rig& rig, int rows, int columns);

// Bytes on the wire of Gigabit Ethernet for one packet of moments in datagrams of 1472 bytes, gaps and headers counted,
// and the frames a second that the wire carries.
double ethernet_rate_hz(const rig::Rig& rig, int columns);

}  // namespace selfproj::light_section

#endif  // SELFPROJ_HOST_LIGHT_SECTION_ROWS_H
