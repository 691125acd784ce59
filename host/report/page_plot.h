// Plots on a page.
#ifndef SELFPROJ_HOST_REPORT_PAGE_PLOT_H
#define SELFPROJ_HOST_REPORT_PAGE_PLOT_H

#include <string>
#include <vector>

namespace selfproj {

// One line of a plot; NaN leaves a gap.
struct ReportTrace {
  std::vector<double> x;
  std::vector<double> y;
  const char* style = "a";  // "a" or "b"
  std::string name;
};

// Traces over one another, with one scale. Left out where there is nothing to draw.
struct ReportPlot {
  std::string title;
  std::string x_label;
  std::string y_label;
  std::vector<ReportTrace> traces;
  double min_span = 1;  // of the vertical scale
};

// Appends the plot as HTML with an SVG in it.
void add_plot(std::string& html, const ReportPlot& plot);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_REPORT_PAGE_PLOT_H
