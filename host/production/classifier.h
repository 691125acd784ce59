// Good, bad or inconclusive: a placed part against its tolerance.
#ifndef SELFPROJ_HOST_PRODUCTION_CLASSIFIER_H
#define SELFPROJ_HOST_PRODUCTION_CLASSIFIER_H

#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "host/production/cutter.h"
#include "host/production/height_map.h"
#include "host/production/part_reference.h"
#include "host/production/part_result.h"
#include "host/production/tolerance.h"
#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"

namespace selfproj::production {

// The difference as far as at least a square of the smallest defect's area reaches it: the grey opening and closing by
// this square. What is smaller, as noise is, has gone from both. Places without a point stand between the two levels.
struct DefectLevels {
  cv::Mat1f high;  // opening
  cv::Mat1f low;   // closing
};
DefectLevels defect_levels(const images::FloatImage& difference, int side);

// The side of that square in cells, at least 1.
int defect_side(double min_defect_mm2, double pitch_mm);

// The cells of a polygon whose middle lies in it or on its border: 255, else 0.
cv::Mat1b region_cells(const ToleranceRegion& region, const MapGrid& grid);

// Whether a square of this side fits into the cells of a region; otherwise no defect is found there.
bool has_room(const cv::Mat1b& cells, int side);

// Places and classifies parts. Keeps what is the same for all of them.
class Classifier {
 public:
  // Throws UserError, naming `source`, as check_tolerance does.
  Classifier(const rig::Rig& rig, const SectionReference& section, const Tolerance& tolerance,
             const std::string& source);

  // The same for depth images, whose reference is a map on the rig's grid. Parts lie where the reference did. Throws as
  // check_map_tolerance does.
  Classifier(const rig::Rig& rig, const HeightCells& reference, const Tolerance& tolerance, const std::string& source);

  // The result of the part but for its number and delay, and its maps.
  //
  // The verdict is inconclusive if the board was restarted in the part, the run began or ended in it, it is too long,
  // it could not be placed or lies outside of what the tolerance allows; then no defect of it counts. Otherwise a
  // defect makes it bad, and without one a region that misses too many points makes it inconclusive.
  PartResult classify(const CutPart& part, PlacedMaps& maps) const;

  // Heights on the grid, less those of the reference.
  [[nodiscard]] images::FloatImage difference(const images::FloatImage& heights) const;

 private:
  void set_regions(const std::string& source);
  void place(const CutPart& part, PartResult& result) const;
  [[nodiscard]] HeightCells without_jumps(HeightCells cells) const;
  void find_defects(const PlacedMaps& maps, PartResult& result) const;

  rig::RigParts rule_;
  Tolerance tolerance_;
  MapGrid grid_;
  images::FloatImage reference_;                  // heights, NaN where there is none
  std::vector<std::pair<double, double>> jumps_;  // of the pattern: across, mm
  std::vector<cv::Mat1b> regions_;
};

}  // namespace selfproj::production

#endif  // SELFPROJ_HOST_PRODUCTION_CLASSIFIER_H
