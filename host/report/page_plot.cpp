#include "host/report/page_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include "host/report/html_text.h"
#include "host/report/number_text.h"

namespace selfproj {
namespace {

// More points than pixels are useless. Keeps only the least and the greatest point of each run.
ReportTrace thinned(const ReportTrace& trace) {
  constexpr std::size_t kMost = 4000;
  if (trace.x.size() <= kMost) {
    return trace;
  }
  ReportTrace result{{}, {}, trace.style, trace.name};
  const std::size_t run = (2 * trace.x.size() + kMost - 1) / kMost;
  for (std::size_t begin = 0; begin < trace.x.size(); begin += run) {
    const std::size_t end = std::min(begin + run, trace.x.size());
    std::size_t least = begin;
    std::size_t greatest = begin;
    for (std::size_t i = begin; i < end; ++i) {
      least = std::isnan(trace.y[least]) || trace.y[i] < trace.y[least] ? i : least;
      greatest = std::isnan(trace.y[greatest]) || trace.y[i] > trace.y[greatest] ? i : greatest;
    }
    for (const std::size_t i : {std::min(least, greatest), std::max(least, greatest)}) {
      result.x.push_back(trace.x[i]);
      result.y.push_back(trace.y[i]);
    }
  }
  return result;
}

// The range of x and y in the plot, and its mapping to a square of 1000 x 1000 with y downwards.
struct Axes {
  double x_low = std::numeric_limits<double>::infinity();
  double x_high = -std::numeric_limits<double>::infinity();
  double y_low = std::numeric_limits<double>::infinity();
  double y_high = -std::numeric_limits<double>::infinity();

  [[nodiscard]] double place_x(double x) const { return 1000 * (x - x_low) / (x_high - x_low); }
  [[nodiscard]] double place_y(double y) const { return 1000 * (y_high - y) / (y_high - y_low); }
};

// Covers all points of the traces, with a margin above and below.
Axes axes_of(const ReportPlot& plot) {
  Axes axes;
  for (const ReportTrace& trace : plot.traces) {
    for (std::size_t i = 0; i < trace.x.size(); ++i) {
      if (!std::isnan(trace.y[i]) && !std::isnan(trace.x[i])) {
        axes.x_low = std::min(axes.x_low, trace.x[i]);
        axes.x_high = std::max(axes.x_high, trace.x[i]);
        axes.y_low = std::min(axes.y_low, trace.y[i]);
        axes.y_high = std::max(axes.y_high, trace.y[i]);
      }
    }
  }
  const double middle = (axes.y_low + axes.y_high) / 2;
  const double half = std::max(plot.min_span, (axes.y_high - axes.y_low) * 1.1) / 2;
  axes.y_low = middle - half;
  axes.y_high = middle + half;
  return axes;
}

// The title, and the key of the traces.
void add_key(std::string& html, const ReportPlot& plot) {
  auto to = std::back_inserter(html);
  fmt::format_to(to, "<section class=\"card\"><h2>{}</h2><div class=\"key\">", escaped(plot.title));
  for (const ReportTrace& trace : plot.traces) {
    fmt::format_to(to, "<span><svg viewBox=\"0 0 26 8\"><path class=\"{}\" d=\"M0 4H26\"/></svg>{}</span>", trace.style,
                   escaped(trace.name));
  }
  fmt::format_to(to, "<span>vertical: {}</span></div>", escaped(plot.y_label));
}

// A trace, with gaps at missing values.
void add_path(std::string& html, const ReportTrace& trace, const Axes& axes) {
  auto to = std::back_inserter(html);
  fmt::format_to(to, "<path class=\"{}\" d=\"", trace.style);
  bool pen_down = false;
  for (std::size_t i = 0; i < trace.x.size(); ++i) {
    if (std::isnan(trace.y[i]) || std::isnan(trace.x[i])) {
      pen_down = false;
      continue;
    }
    fmt::format_to(to, "{}{:.1f} {:.1f}", pen_down ? 'L' : 'M', axes.place_x(trace.x[i]), axes.place_y(trace.y[i]));
    pen_down = true;
  }
  html += "\"/>";
}

// `kind` and `side` belong to the style sheet: "xt" and "left", or "yt" and "top".
template <typename Place>
void add_numbers(std::string& html, const std::vector<double>& marks, const char* kind, const char* side,
                 const Place& place) {
  const double step = marks.size() > 1 ? marks[1] - marks[0] : 1;
  for (const double mark : marks) {
    fmt::format_to(std::back_inserter(html), "<span class=\"{}\" style=\"{}:{:.2f}%\">{}</span>", kind, side,
                   place(mark) / 10, tick_text(mark, step));
  }
}

}  // namespace

void add_plot(std::string& html, const ReportPlot& plot) {
  const Axes axes = axes_of(plot);
  if (!(axes.x_high > axes.x_low)) {
    return;
  }
  const std::vector<double> x_ticks = ticks(axes.x_low, axes.x_high, 6);
  const std::vector<double> y_ticks = ticks(axes.y_low, axes.y_high, 5);
  auto to = std::back_inserter(html);
  add_key(html, plot);
  fmt::format_to(to,
                 "<div class=\"plot\"><svg viewBox=\"0 0 1000 1000\" "
                 "preserveAspectRatio=\"none\" role=\"img\" aria-label=\"{}\">",
                 escaped(plot.title));
  for (const double tick : x_ticks) {
    fmt::format_to(to, "<line x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"0\" y2=\"1000\"/>", axes.place_x(tick));
  }
  for (const double tick : y_ticks) {
    fmt::format_to(to, "<line x1=\"0\" x2=\"1000\" y1=\"{0:.1f}\" y2=\"{0:.1f}\"/>", axes.place_y(tick));
  }
  for (const ReportTrace& trace : plot.traces) {
    add_path(html, thinned(trace), axes);
  }
  html += "</svg>";
  add_numbers(html, x_ticks, "xt", "left", [&](double x) { return axes.place_x(x); });
  add_numbers(html, y_ticks, "yt", "top", [&](double y) { return axes.place_y(y); });
  fmt::format_to(to, "<span class=\"xl\">{}</span></div></section>\n", escaped(plot.x_label));
}

}  // namespace selfproj
