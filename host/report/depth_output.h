// Depth images as pictures, clouds and tables; the files and the text of `selfproj depth` and of `selfproj match`.
#ifndef SELFPROJ_HOST_REPORT_DEPTH_OUTPUT_H
#define SELFPROJ_HOST_REPORT_DEPTH_OUTPUT_H

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/files/output_folder.h"
#include "host/report/facts.h"
#include "host/report/report.h"
#include "host/structured_light/cloud_axes.h"
#include "host/structured_light/depth_run.h"
#include "host/structured_light/match_table.h"
#include "host/structured_light/plane_fit.h"
#include "host/structured_light/self_scanner.h"
#include "selfproj/images/float_image.h"
#include "selfproj/structured_light/point_cloud.h"
#include "selfproj/structured_light/triangulation.h"

namespace selfproj::report {

// Millimetres for one unit of the 16-bit picture.
inline constexpr double kDepthUnit = 0.05;

// The unit of a depth image's PNG: kDepthUnit, doubled as often as the largest depth needs to fit into 16 bits.
double depth_unit(const images::FloatImage& depth);

// 16-bit PNG: depth / depth_unit, rounded; 0 if there is no depth.
std::string depth_png(const images::FloatImage& depth);

// The picture in colours with colour bar and scale bars, as PNG. Scale bars hold for the median depth in the middle of
// the image.
std::string depth_picture(const structured_light::Triangulation& triangulation, const images::FloatImage& depth,
                          const std::string& title);

// The points that have a depth, in the order of the pixels; and the same as PLY in the colours of the picture, with
// what light the pixels got as intensity and quality, if that is given.
std::vector<structured_light::Point3f> points_of(const structured_light::Triangulation& triangulation,
                                                 const images::FloatImage& depth);
std::string cloud_ply(const structured_light::Triangulation& triangulation, const images::FloatImage& depth,
                      const structured_light::LightOfPixels* light = nullptr);

// One line for each depth image: pair,valid,not_measurable,...
std::string shares_csv(const std::vector<structured_light::OfImage<structured_light::DepthShares>>& shares);

// The counts of a device: every counter, for a terminal the losses.
nlohmann::ordered_json device_json(const std::string& uri, const structured_light::DeviceCounts& counts);
std::string losses_of(const structured_light::DeviceCounts& counts);

// The measurements, and the values computed from the newest depth image.
struct DepthReport {
  structured_light::DepthSetup setup;
  std::string device;                // URI; empty for recorded images
  std::size_t images = 0;            // number of recorded images
  std::string cloud;                 // file with which the points are compared
  structured_light::CloudAxes axes;  // that it was given
  std::optional<structured_light::CloudComparison> comparison;
  std::optional<structured_light::PlaneFit> plane;
  std::vector<std::string> doubts;  // why the result may be wrong
};

// Writes pictures, cloud, tables and summary of the run, without the single depth images, and returns the picture of
// the newest one in colours. Does not commit the folder. Throws UserError as OutputFolder does.
ReportPicture write_depth(const structured_light::DepthRun& run, const DepthReport& report,
                          files::OutputFolder& folder);

// The page of `selfproj depth` with that picture.
std::string depth_page(const structured_light::DepthRun& run, const DepthReport& report, const ReportPicture& picture);

// The same for the terminal: one line each on the depth images, on the comparison and on the plane. `folder` is where
// the files are.
std::string depth_text(const structured_light::DepthRun& run, const DepthReport& report, const std::string& folder);

// How the depth images were measured.
struct MatchReport {
  std::string rig;        // its name or file
  std::string reference;  // its folder
  int bits = 0;           // m of the reference
  structured_light::MatchSettings settings;
  int threshold = 0;       // threshold of a pair's difference
  std::size_t images = 0;  // number of recorded images
  std::vector<structured_light::OfImage<structured_light::DepthShares>>
      all_shares;           // shares of all depth images, at least one; of a device the newest
  std::string device = {};  // its URI, if there is one
  std::size_t depth_images = 0;
  std::optional<structured_light::DeviceCounts> counts = {};
  std::vector<Fact> line = {};  // what was counted of the parts of a running line
  ReportParts parts = {};       // the parts on its page
  std::string doubt = {};       // why the result may be wrong; empty: nothing is known
};

// The newest depth image and its difference from the reference in colours.
struct MatchPictures {
  ReportPicture depth;
  ReportPicture difference;
};

// Writes pictures, cloud, tables and summary of the scanner's newest depth image, and returns the pictures. Does not
// commit the folder. Throws UserError as OutputFolder does.
MatchPictures write_match(const structured_light::MatchTable& table, const structured_light::SelfScanner& scanner,
                          const MatchReport& report, files::OutputFolder& folder);

// The page of `selfproj match` with these pictures.
std::string match_page(const MatchReport& report, const structured_light::MatchTable& table,
                       const structured_light::SelfScanner& scanner, const MatchPictures& pictures);

// The same for the terminal, in one line. `folder` is where the files are.
std::string match_text(const structured_light::MatchTable& table, const MatchReport& report, const std::string& folder);

}  // namespace selfproj::report

#endif  // SELFPROJ_HOST_REPORT_DEPTH_OUTPUT_H
