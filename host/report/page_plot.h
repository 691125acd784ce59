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

}  // namespace selfproj

#endif  // SELFPROJ_HOST_REPORT_PAGE_PLOT_H
