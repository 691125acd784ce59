// Moments of images of unknown geometry: their table, the centroid of every column, and a page that shows the line
// found.
#ifndef SELFPROJ_HOST_REPORT_LINE_IMAGES_H
#define SELFPROJ_HOST_REPORT_LINE_IMAGES_H

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "host/files/output_folder.h"
#include "host/report/report.h"
#include "host/report/tables.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/rig/rig.h"

namespace selfproj::report {

// What the page says beside the lines.
struct LineFacts {
  std::string title;
  std::vector<Fact> counters;
  std::vector<Fact> settings;
  std::vector<std::string> doubts = {};  // why the result is to be doubted, each a sentence
};

class LineImages {
 public:
  // For images of this size. Of the measurement only what the board's registers say matters, and what is ambiguous.
  LineImages(int rows, int columns, const rig::RigMeasure& measure)
      : rows_(rows), columns_(columns), measure_(measure), csv_(moments_csv_header(measure.of_board().select)) {}

  // Adds a frame's results; frames count from 1. `runs` may have more columns, which padded a frame; they are left out.
  void add(std::size_t frame, model::Runs runs);

  // The picture of a frame, with its ambiguous columns marked. The image has the size given above, or more columns.
  [[nodiscard]] CameraPicture picture(std::size_t frame, images::Image image, model::Runs runs) const;

  // Writes summary.json, moments.csv, centroid.tiff (32-bit float; rows are frames; pixels count from 1; NaN if unlit)
  // and report.html. There were `frames` frames. The page shows `pictures`.
  void write(files::OutputFolder& folder, const LineFacts& facts, std::size_t frames,
             const std::vector<CameraPicture>& pictures) const;

  // Columns with light, and those of them that are ambiguous.
  [[nodiscard]] std::int64_t lit() const;
  [[nodiscard]] std::int64_t ambiguous() const { return ambiguous_; }

 private:
  [[nodiscard]] std::vector<std::uint8_t> ambiguous_of(const model::Runs& runs) const;
  [[nodiscard]] std::string summary(const LineFacts& facts) const;
  [[nodiscard]] MomentsReport report(const LineFacts& facts, std::size_t frames,
                                     const std::vector<CameraPicture>& pictures) const;

  int rows_;
  int columns_;
  rig::RigMeasure measure_;
  std::string csv_;
  std::vector<float> centroids_;
  std::int64_t ambiguous_ = 0;
};

}  // namespace selfproj::report

#endif  // SELFPROJ_HOST_REPORT_LINE_IMAGES_H
