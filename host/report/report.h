// Pages for a human reader, each a single self-contained file: an inspection, moments, an experiment.
#ifndef SELFPROJ_HOST_REPORT_REPORT_H
#define SELFPROJ_HOST_REPORT_REPORT_H

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/report/facts.h"
#include "host/report/frame_picture.h"
#include "host/report/map_picture.h"
#include "host/report/page.h"
#include "selfproj/images/float_image.h"

namespace selfproj::report {

// The program's additions to the collected data. All of it is optional.
struct ReportParts {
  std::string title = "Inspection";
  std::vector<Fact> counters;            // counters of the driver and of checks: "lost_board", ...
  std::vector<Fact> settings;            // scene, engine, device, ...
  std::vector<std::string> doubts = {};  // why the result is to be doubted, each a sentence
  std::vector<ReportTable> tables;
  std::optional<CameraPicture> camera;
  std::vector<Fact> highlights;  // after those of the map
  double difference_mm = 0;      // at most at this difference the colours of the page end
};

// The contents of the report.
struct ReportData {
  std::string title;
  std::string subtitle;          // rig, mode, threshold
  std::vector<Fact> highlights;  // shown first
  std::vector<std::string> doubts;
  std::vector<Fact> counters;
  std::vector<Fact> settings;
  std::vector<ReportTable> tables;
  std::optional<CameraPicture> camera;
  images::FloatImage height;      // mm; rows are frames
  images::FloatImage difference;  // mm
  bool of_parts = false;          // frames without a part have no difference
  MapScale difference_colours;
  images::FloatImage y;  // mm, of the same shape
  MapPitch pitch;
};

// A map as a page draws it: its labels are text of the page, which stays readable at any width.
struct ReportMap {
  images::FloatImage values;
  MapScale scale;
  MapPitch pitch;
};

struct ReportPicture {
  std::string title;
  std::string png;
  std::string note;                   // printed below it
  std::optional<ReportMap> map = {};  // shown by a page instead of the PNG
};

// A map as a picture: labelled_map_png for a file, and the map itself for a page.
ReportPicture shown_map(const std::string& title, const images::FloatImage& map, const MapScale& scale,
                        const MapPitch& pitch, const std::string& note = {});

// A page of plots, pictures and tables, in this order.
struct ReportPage {
  std::string title;
  std::string subtitle;
  std::vector<std::pair<std::string, std::string>> links = {};  // text, file beside the page
  std::vector<Fact> highlights;                                 // shown first
  std::vector<std::string> doubts;
  std::vector<ReportPlot> plots;
  std::vector<ReportPicture> pictures;
  std::vector<ReportTable> tables;
  std::vector<Fact> counters;
  std::vector<Fact> settings;
};
std::string page_html(const ReportPage& page);

// The page as text.
std::string report_html(const ReportData& data);

// The report on images of unknown geometry: their moments, and where the line is in them.
struct MomentsReport {
  std::string title;
  std::string subtitle;  // source of the images, mode, threshold
  std::vector<Fact> highlights;
  std::vector<std::string> doubts;
  std::vector<Fact> counters;
  std::vector<Fact> settings;
  std::vector<CameraPicture> cameras;  // images to show
};

// The page as text: the images with the line found in them, and a table of its properties.
std::string report_html(const MomentsReport& data);

}  // namespace selfproj::report

#endif  // SELFPROJ_HOST_REPORT_REPORT_H
