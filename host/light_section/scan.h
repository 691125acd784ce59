// The reference as the original system found it: a straight line swept over the projector while the camera looks on.
#ifndef SELFPROJ_HOST_LIGHT_SECTION_SCAN_H
#define SELFPROJ_HOST_LIGHT_SECTION_SCAN_H

#include <functional>
#include <vector>

#include "host/io/float_image.h"
#include "host/io/image_files.h"
#include "host/light_section/reference.h"
#include "host/rig/rig.h"
#include "model/column_moments.h"

namespace selfproj {

// The lines of a sweep: every `every`-th line of the projector on which the pattern is whole, in ascending order.
std::vector<int> sweep_lines(const Rig& rig, int every = 1);

// Puts a sweep together, one image at a time, in any order.
class LineScan {
 public:
  // `every`: by how many lines the sweep moves on.
  explicit LineScan(const Rig& rig, int every = 1);

  // The image, of the camera's size, that was seen under the straight line `line`. Throws std::invalid_argument for
  // another size.
  void add(double line, const ImageView& image);

  // What the sweep says of each column: the line, with a fraction, at which its centroid crosses the middle row
  // (Xc = 0), thereby θ(β), and z_r(β) = x0 / tan θ(β) + z0 (3.8). The crossing is that of a straight line fitted to
  // the centroids within 4 rows of the middle, or 1.5 steps of the sweep if that is more (line against row, which are
  // proportional to 1e-3 of a line there), so that it averages the noise of several images. Where lines cross at
  // several places (light thrown from one surface to another), the crossing with the most light counts. Not valid where
  // the line is not seen on both sides of the middle.
  [[nodiscard]] ReferenceProfile reference() const;

 private:
  struct Sighting {
    double line;
    double row;  // centroid less middle row
    double light;
  };

  Rig rig_;
  double max_gap_;        // lines between neighbours of a run
  double rows_per_line_;  // that the line moves in the image on the plane
  double window_;         // rows on both sides of the middle
  Moments moments_;
  std::vector<std::vector<Sighting>> sightings_;  // of each column, those within the window
};

// A whole sweep with whatever shows patterns and takes images: a real projector and camera, or a simulation.
ReferenceProfile scan_reference(const Rig& rig, const std::function<Image(const FloatImage& pattern)>& show_and_take,
                                int every = 1);

// Means of the columns' centroids over several images, for without_residual and reference_of_straight_line.
class CentroidMean {
 public:
  explicit CentroidMean(const Rig& rig);

  // An image of the camera's size; throws std::invalid_argument for another.
  void add(const ImageView& image);

  // C, rows from 1, one a column; NaN where more than half of the images had no good centroid (too few lit pixels, too
  // many, the line cut off by the border).
  [[nodiscard]] std::vector<double> centroids() const;

 private:
  Rig rig_;
  Moments moments_;
  int images_ = 0;
  std::vector<double> sums_;
  std::vector<int> counts_;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_LIGHT_SECTION_SCAN_H
