// The files and the text of `selfproj depth`.
#ifndef SELFPROJ_HOST_REPORT_DEPTH_SUMMARY_H
#define SELFPROJ_HOST_REPORT_DEPTH_SUMMARY_H

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "host/files/output_folder.h"
#include "host/structured_light/depth_run.h"
#include "host/structured_light/plane_fit.h"
#include "host/structured_light/point_cloud.h"

namespace selfproj {

// The counts of a device: every counter, for a terminal the losses.
nlohmann::ordered_json device_json(const std::string& uri, const DeviceCounts& counts);
std::string losses_of(const DeviceCounts& counts);

// The measurements, and the values computed from the newest depth image.
struct DepthReport {
  DepthSetup setup;
  std::string device;      // URI; empty for recorded images
  std::size_t images = 0;  // number of recorded images
  std::string cloud;       // file with which the points are compared
  std::optional<CloudComparison> comparison;
  std::optional<PlaneFit> plane;
};

// Writes pictures, cloud, tables and summary of the run, without the single depth images, and returns the picture of
// the newest one in colours, as PNG. Does not commit the folder. Throws UserError as OutputFolder does.
std::string write_depth(const DepthRun& run, const DepthReport& report, OutputFolder& folder);

// The same for the terminal: one line each on the depth images, on the comparison and on the plane. `folder` is where
// the files are.
std::string depth_text(const DepthRun& run, const DepthReport& report, const std::string& folder);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_REPORT_DEPTH_SUMMARY_H
