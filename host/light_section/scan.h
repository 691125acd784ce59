// The reference as the original system found it: a straight line sweeps over the projector while the camera watches.
#ifndef SELFPROJ_HOST_LIGHT_SECTION_SCAN_H
#define SELFPROJ_HOST_LIGHT_SECTION_SCAN_H

#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/images/image_files.h"
#include "host/light_section/line_finder.h"
#include "selfproj/images/float_image.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/rig/rig.h"

namespace selfproj::light_section {

// The lines of a sweep: every `every`-th projector line at which the whole pattern fits, in ascending order.
std::vector<int> sweep_lines(const rig::Rig& rig, int every = 1);

// Where a column saw a line of a sweep.
struct LineSighting {
  double line = 0;
  double row = 0;  // of the centroid, from 0
  int column = 0;
  double light = 0;  // M0
};

// Adds what an image under the straight line `line` shows, column by column: the lines that `finder` finds. Throws
// std::invalid_argument if it has not the camera's size.
void add_sightings(LineFinder& finder, double line, const SensorView& image, std::vector<LineSighting>& seen);

// Leaves out of a whole sweep what has too little light in its column (LineFinder::least_light).
void leave_out_reflections(const rig::Rig& rig, std::vector<LineSighting>& seen);

// Whether the images of a sweep are those of its lines, as far as they can tell by themselves: from one line to the
// next the line of light moves in most columns as the geometry says, except at edges.
class SweepCheck {
 public:
  explicit SweepCheck(const rig::Rig& rig);

  // The image of the next line of the sweep; `name` is for messages. Throws std::invalid_argument if it has not the
  // camera's size.
  void add(double line, const SensorView& image, const std::string& name);

  // What the images contradict, as the end of a message; empty: nothing. They are in another order, or one of them is
  // late or exchanged with the next. Or a rig that sums all lit pixels of a column (no measure.runs) has summed a
  // second line in many of them.
  [[nodiscard]] std::string contradiction() const;

 private:
  struct Seen {
    double row = 0, light = 0;  // no light: no line
  };
  struct Image {
    double line;
    std::string name;
    std::vector<Seen> seen;  // of each column
    std::size_t lines;       // columns with a line
  };
  [[nodiscard]] std::size_t few() const { return std::max<std::size_t>(4, most_light_.size() / 16); }  // columns
  [[nodiscard]] std::optional<double> moved(const Image& from, const Image& to) const;

  LineFinder finder_;  // of the strongest run
  bool sums_;
  double rows_per_line_;
  std::vector<Image> images_;
  std::vector<double> most_light_;  // of any sighting of each column
  std::size_t lines_ = 0;           // found in all columns of all images
  std::size_t second_lines_ = 0;
};

// Assembles a sweep from its images, one at a time, in any order.
class LineScan {
 public:
  // `every`: the step of the sweep in lines.
  explicit LineScan(const rig::Rig& rig, int every = 1);

  // Adds the image that was seen under the straight line `line`. Throws std::invalid_argument if it has not the
  // camera's size.
  void add(double line, const SensorView& image);

  // The result of the sweep for each column: the line, with a fraction, at which the centroid crosses the middle row
  // (Xc = 0), and from it θ(β) and z_r(β) = x0 / tan θ(β) + z0 (3.8), or the same through the rig's lenses. A straight
  // line is fitted to the centroids within 4 rows of the middle, or within 1.5 steps of the sweep if that is more.
  // (Line and row are proportional to 1e-3 of a line there.) This averages the noise of several images. If lines cross
  // at several places, because light is thrown from one surface to another, the crossing with the most light counts. A
  // column is invalid if the line is not seen on both sides of the middle, or its light is too little
  // (LineFinder::least_light); but if it is seen near the middle at all, and neighbours on both sides agree, it has the
  // line between theirs.
  [[nodiscard]] ReferenceProfile reference() const;

 private:
  struct Sighting {
    double line;
    double row;  // centroid less the middle row
    double light;
  };
  [[nodiscard]] std::optional<double> crossing(std::vector<Sighting> seen, double least_light) const;
  [[nodiscard]] bool can_be_lit(double line) const;
  void bridge(std::vector<double>& lines) const;

  rig::Rig rig_;
  LineFinder finder_;
  double max_gap_;                                // most lines between neighbours of a run
  double rows_per_line_;                          // rows by which the image of the line moves on the plane
  double window_;                                 // rows on each side of the middle
  std::vector<std::vector<Sighting>> sightings_;  // sightings within the window, for each column
  std::vector<double> most_light_;                // of any sighting of each column
};

// Runs a whole sweep with anything that shows patterns and takes images: a real projector and camera, or a simulation.
ReferenceProfile scan_reference(const rig::Rig& rig,
                                const std::function<images::Image(const images::FloatImage& pattern)>& show_and_take,
                                int every = 1);

// Means of the columns' centroids over several images, for without_residual and reference_of_straight_line.
class CentroidMean {
 public:
  explicit CentroidMean(const rig::Rig& rig);

  // Adds an image of the camera's size; throws std::invalid_argument for another size.
  void add(const SensorView& image);

  // C, rows from 1, one for each column; NaN if more than half of the images had no line there.
  [[nodiscard]] std::vector<double> centroids() const;

  // Why the images are not those of a part that stands still; empty if they are. A tenth of the lit columns may move:
  // at the edges of good parts that were laid one after another.
  [[nodiscard]] std::string contradiction() const;

 private:
  LineFinder finder_;
  int images_ = 0;
  std::vector<double> sums_;
  std::vector<double> squares_;
  std::vector<int> counts_;
};

}  // namespace selfproj::light_section

#endif  // SELFPROJ_HOST_LIGHT_SECTION_SCAN_H
