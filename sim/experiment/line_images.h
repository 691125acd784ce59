// Moments of images of unknown geometry: their table, the centroid of every column, and a page that shows the line
// found.
#ifndef SELFPROJ_SIM_EXPERIMENT_LINE_IMAGES_H
#define SELFPROJ_SIM_EXPERIMENT_LINE_IMAGES_H

#include <cstddef>
#include <string>
#include <vector>

#include "host/io/output_folder.h"
#include "host/report/report.h"
#include "host/rig/rig.h"
#include "model/column_moments.h"
#include "sim/experiment/cosim_measurement.h"
#include "sim/experiment/moments_csv.h"

namespace selfproj {

class LineImages {
 public:
  // For images of this size. Only mode and threshold of the measurement matter.
  LineImages(int rows, int columns, const RigMeasure& measure) : rows_(rows), columns_(columns), measure_(measure) {}

  // Adds a frame's moments; frames count from 1.
  void add(std::size_t frame, const Moments& moments);

  // Writes summary.json, moments.csv, centroid.tiff (32-bit float; rows are frames; pixels count from 1; NaN if unlit)
  // and report.html. The board was given `frames` frames. The page shows `pictures`.
  void write(OutputFolder& folder, const CosimFacts& facts, std::size_t frames,
             const std::vector<CameraPicture>& pictures) const;

 private:
  [[nodiscard]] std::string summary(const CosimFacts& facts) const;
  [[nodiscard]] MomentsReport report(const CosimFacts& facts, std::size_t frames,
                                     const std::vector<CameraPicture>& pictures) const;

  int rows_;
  int columns_;
  RigMeasure measure_;
  std::string csv_ = kMomentsCsvHeader;
  std::vector<float> centroids_;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_LINE_IMAGES_H
