// What `selfproj depth` leaves behind and says (host/structured_light/README.md has the files).
#ifndef SELFPROJ_HOST_REPORT_DEPTH_SUMMARY_H
#define SELFPROJ_HOST_REPORT_DEPTH_SUMMARY_H

#include <cstddef>
#include <optional>
#include <string>

#include "host/io/output_folder.h"
#include "host/structured_light/depth_run.h"
#include "host/structured_light/plane_fit.h"
#include "host/structured_light/point_cloud.h"

namespace selfproj {

// What was measured, and what was made of the newest depth image.
struct DepthReport {
  DepthSetup setup;
  std::string device;      // URI; empty where the images are recorded ones
  std::size_t images = 0;  // recorded ones
  std::string cloud;       // file that the points are compared with
  std::optional<CloudComparison> comparison;
  std::optional<PlaneFit> plane;
};

// Writes pictures, cloud, tables and summary of the run, all but the single depth images, without committing the
// folder. Throws UserError as OutputFolder.
void write_depth(const DepthRun& run, const DepthReport& report, OutputFolder& folder);

// The same for a reader of the terminal: a line on the depth images, and one on the comparison and the plane each.
// `folder` is where the files are.
std::string depth_text(const DepthRun& run, const DepthReport& report, const std::string& folder);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_REPORT_DEPTH_SUMMARY_H
