// Compares a depth image of a thing that moves over a reference with the truth.
#ifndef SELFPROJ_LAB_MOVING_THINGS_H
#define SELFPROJ_LAB_MOVING_THINGS_H

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "lab/structured_light.h"
#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/renderer.h"
#include "sim/scene/virtual_capture.h"

namespace selfproj::lab {

// The thing to measure: whatever moves in these columns of the image.
struct Thing {
  std::string name;
  int column_0, column_1;
  double least;    // mm over the reference above which a pixel belongs to the thing, for its size
  double max_rms;  // mm; goal of the self-projected method for the error of z, RMS
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
ThingFigures figures_of(const Thing& thing, const images::FloatImage& depth, const images::FloatImage& difference,
                        const images::FloatImage& truth, const images::FloatImage& true_difference);

// Summarizes all depth images of a thing by one method.
class ThingSummary {
 public:
  void add(const ThingFigures& f);

  // RMS error of z over the pixels of all images.
  [[nodiscard]] double rms() const { return std::sqrt(square_ / valid_); }

  // Mean error of the height.
  [[nodiscard]] double height() const { return height_ / images_; }

  // Cells of a table: number of depth images; valid, %; RMS error of z, and that of the worst image; mean error of the
  // height, and its largest; mean errors of rows and columns, and the largest error of either.
  [[nodiscard]] std::vector<std::string> cells() const;

 private:
  int images_ = 0;
  double pixels_ = 0, valid_ = 0, square_ = 0, worst_ = 0;
  double height_ = 0, max_height_ = 0, rows_ = 0, columns_ = 0, max_size_ = 0;
};

// Experiments B7 (mouse on a slider) and B8 (two hands): self-projected structured light of moving things, 500 depth
// images a second of simulated time.

// The experiment makes a depth image after every pair of images. It compares two methods on the same motion:
// conventional Gray codes of 8 bits, and self-projected codes of 4 bits. Each method also measures the things at rest,
// at their position in the middle of a window of 2m frames, where m is the number of bits. The difference is the error
// from motion.
struct MovingOptions {
  rig::Rig rig;
  sim::RenderOptions render;
  sim::ScanMethod scan = sim::ScanMethod::lines;  // how the reference is scanned
  int e = 0;        // e of (4.20) in the thesis: cells below the reference that are searched
  int first = 0;    // first frame
  int pairs = 0;    // depth images by each method; 0: all of the scene from `first` on
  int strips = 10;  // pictures by each method, or a few more; at these instants things are also measured at rest
};

// `name` is "B7" or "B8". The goal is that the error of z by the self-projected method is at most Thing::max_rms, RMS,
// and that of the height on average, too. In the result, `series` has one row of figures for each depth image and
// thing. Throws std::invalid_argument if the scene has too few frames, or e is out of range.
StructuredLightResult run_moving(const std::string& name, const MovingOptions& options,
                                 const ProgressOfImages& progress);

}  // namespace selfproj::lab

#endif  // SELFPROJ_LAB_MOVING_THINGS_H
