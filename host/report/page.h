// The parts of a page: head, tables, camera images, maps, plots, foot. Each add_... function appends its HTML to
// `html`.
#ifndef SELFPROJ_HOST_REPORT_PAGE_H
#define SELFPROJ_HOST_REPORT_PAGE_H

#include <string>
#include <string_view>
#include <vector>

#include "host/report/facts.h"
#include "host/report/frame_picture.h"
#include "host/report/map_picture.h"
#include "selfproj/images/float_image.h"

namespace selfproj::report {

// The text with & < > and the double quote replaced by their HTML entities.
std::string escaped(std::string_view text);

// An <img> that contains the bytes of a PNG file. `alternative` is its text for those who cannot see it.
std::string picture_html(std::string_view png, std::string_view alternative);

// The value of the fact without its unit: integers in groups of three digits, other numbers with six significant
// digits.
std::string fact_html(const Fact& fact);

// The beginning of the file up to the tiles of `highlights`, which a reader sees first.
void add_head(std::string& html, const std::string& title, const std::string& subtitle,
              const std::vector<Fact>& highlights);

void add_table(std::string& html, const ReportTable& table);

// The image with a path through the centroids of the columns. `axes` says what rows and columns mean.
void add_camera(std::string& html, const CameraPicture& camera, std::string_view axes);

// Counters and settings side by side, and the end of the file.
void add_foot(std::string& html, const std::vector<Fact>& counters, const std::vector<Fact>& settings);

// Appends a map as HTML, with its scale bars beside and below it and an explanation of its colours. `title` and
// `explanation` are HTML.
void add_map(std::string& html, std::string_view title, std::string_view explanation, const images::FloatImage& map,
             const MapScale& scale, const MapPitch& pitch);

// One line of a plot; NaN leaves a gap.
struct ReportTrace {
  std::vector<double> x;
  std::vector<double> y;
  const char* style = "a";  // "a" or "b"
  std::string name;
};

// Traces in one plot with one scale. A plot without anything to draw is left out.
struct ReportPlot {
  std::string title;
  std::string x_label;
  std::string y_label;
  std::vector<ReportTrace> traces;
  double min_span = 1;  // least span of the vertical scale
};

// Appends the plot as HTML with an SVG in it.
void add_plot(std::string& html, const ReportPlot& plot);

}  // namespace selfproj::report

#endif  // SELFPROJ_HOST_REPORT_PAGE_H
