#include "host/report/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <vector>

#include "host/report/frame_picture.h"
#include "host/report/map_picture.h"
#include "host/report/page.h"
#include "selfproj/images/float_image.h"
#include "selfproj/light_section/profile.h"

namespace selfproj::report {
namespace {

enum class Along : std::uint8_t { rows, columns };

// The row (or column) of the map amid the greatest mean squares of the differences: it and those beside it have them,
// so that it is not the edge of a part. Only full rows count, and columns that have at least nine tenths of their
// values in them. Rows near the first and the last full one are left out, because the part's ends are there. -1 if
// there is none.
int most_different(const images::FloatImage& difference, Along along) {
  const auto count = static_cast<std::size_t>(along == Along::rows ? difference.rows : difference.columns);
  std::vector<double> squares(count, 0.0);
  std::vector<int> entries(count, 0);
  const std::vector<int> rows = full_rows(difference);
  const std::size_t ends = rows.size() / 20;
  for (std::size_t k = ends; k < rows.size() - ends; ++k) {
    const int r = rows[k];
    for (int c = 0; c < difference.columns; ++c) {
      const auto value = static_cast<double>(difference.row(r)[c]);
      if (!std::isnan(value)) {
        const auto at = static_cast<std::size_t>(along == Along::rows ? r : c);
        squares[at] += value * value;
        ++entries[at];
      }
    }
  }
  const int fullest = *std::max_element(entries.begin(), entries.end());
  std::vector<double> means(count, -1.0);  // of those that count
  for (std::size_t i = 0; i < count; ++i) {
    if (entries[i] > 0 && 10 * entries[i] >= 9 * fullest) {
      means[i] = squares[i] / entries[i];
    }
  }
  const std::size_t beside = std::min<std::size_t>(3, count / 20);
  const auto least_around = [&](std::size_t i) {
    const auto at = means.begin() + static_cast<std::ptrdiff_t>(i);
    return *std::min_element(at - static_cast<std::ptrdiff_t>(beside), at + static_cast<std::ptrdiff_t>(beside) + 1);
  };
  int best = -1;
  double most = -1;
  for (std::size_t i = beside; i + beside < count; ++i) {
    if (const double least = least_around(i); least > most) {
      most = least;
      best = static_cast<int>(i);
    }
  }
  const auto largest = std::max_element(means.begin(), means.end());
  return best >= 0 ? best : *largest >= 0 ? static_cast<int>(largest - means.begin()) : -1;
}

// Height over y of one frame, measured and of the reference. The reference's height is the measured one less the
// difference.
void add_profile_plot(std::string& html, const ReportData& data, int frame) {
  ReportTrace measured{{}, {}, "a", "measured"};
  ReportTrace reference{{}, {}, "b", "reference"};
  for (int c = 0; c < data.height.columns; ++c) {
    const auto y = static_cast<double>(data.y.row(frame)[c]);
    const auto height = static_cast<double>(data.height.row(frame)[c]);
    measured.x.push_back(y);
    measured.y.push_back(height);
    reference.x.push_back(y);
    reference.y.push_back(height - static_cast<double>(data.difference.row(frame)[c]));
  }
  add_plot(html, {.title = fmt::format("Profile of frame {}", frame + 1),
                  .x_label = "y, mm",
                  .y_label = "height, mm",
                  .traces = {measured, reference},
                  .min_span = 1});
}

void add_difference_plots(std::string& html, const ReportData& data, int frame, int column) {
  ReportTrace across{{}, {}, "a", "difference"};
  for (int c = 0; c < data.difference.columns; ++c) {
    across.x.push_back(static_cast<double>(data.y.row(frame)[c]));
    across.y.push_back(static_cast<double>(data.difference.row(frame)[c]));
  }
  ReportTrace along{{}, {}, "a", "difference"};
  const bool known = data.pitch.row_mm > 0;
  for (int r = 0; r < data.difference.rows; ++r) {
    along.x.push_back(r * (known ? data.pitch.row_mm : 1.0));
    along.y.push_back(static_cast<double>(data.difference.row(r)[column]));
  }
  html += "<div class=\"two\">";
  add_plot(html, {.title = fmt::format("Difference across, frame {}", frame + 1),
                  .x_label = "y, mm",
                  .y_label = "difference, mm",
                  .traces = {across},
                  .min_span = 0.2});
  add_plot(html, {.title = fmt::format("Difference along the belt, column {}", column + 1),
                  .x_label = known ? "way of the belt, mm" : "frame",
                  .y_label = "difference, mm",
                  .traces = {along},
                  .min_span = 0.2});
  html += "</div>";
}

// The properties of the line in one image: frame, lit columns, lowest, median and greatest row, lit pixels in a column,
// columns cut off by the border.
std::vector<std::string> line_row(const CameraPicture& camera) {
  std::vector<double> rows;
  double lit = 0;
  int cut_off = 0;
  for (std::size_t i = 0; i < camera.moments.m0.size(); ++i) {
    if (camera.moments.m0[i] > 0) {
      rows.push_back(static_cast<double>(camera.moments.m1[i]) / camera.moments.m0[i]);  // (3.2)
      lit += camera.moments.n[i];
      cut_off += static_cast<int>(light_section::line_is_cut_off(static_cast<float>(rows.back()),
                                                                 static_cast<float>(camera.moments.n[i]), 1,
                                                                 static_cast<float>(camera.image.rows)));
    }
  }
  const std::string frame = fmt::format("frame {}", camera.frame);
  if (rows.empty()) {
    return {frame, "0", "–", "–", "–", "–", "0"};
  }
  std::sort(rows.begin(), rows.end());
  return {frame,
          std::to_string(rows.size()),
          fmt::format("{:.2f}", rows.front()),
          fmt::format("{:.2f}", rows[rows.size() / 2]),
          fmt::format("{:.2f}", rows.back()),
          fmt::format("{:.1f}", lit / static_cast<double>(rows.size())),
          std::to_string(cut_off)};
}

}  // namespace

ReportPicture shown_map(const std::string& title, const images::FloatImage& map, const MapScale& scale,
                        const MapPitch& pitch, const std::string& note) {
  return {title, labelled_map_png(map, scale, pitch, title), note, ReportMap{map, scale, pitch}};
}

namespace {

void add_doubts(std::string& html, const std::vector<std::string>& doubts) {
  for (const std::string& doubt : doubts) {
    html += "<p role=\"alert\" style=\"color:#b2182b;font-weight:bold;margin:12px 0\">" + escaped(doubt) + "</p>\n";
  }
}

}  // namespace

std::string page_html(const ReportPage& page) {
  std::string html;
  add_head(html, page.title, page.subtitle, page.highlights);
  if (!page.links.empty()) {
    html += "<p class=\"small\">";
    for (const auto& [text, file] : page.links) {
      html += "<a href=\"" + escaped(file) + "\">" + escaped(text) + "</a> ";
    }
    html += "</p>\n";
  }
  add_doubts(html, page.doubts);
  for (const ReportPlot& plot : page.plots) {
    add_plot(html, plot);
  }
  html += "<section class=\"two\">";
  for (const ReportPicture& shown : page.pictures) {
    if (shown.map) {
      add_map(html, escaped(shown.title), escaped(shown.note), shown.map->values, shown.map->scale, shown.map->pitch);
      continue;
    }
    fmt::format_to(std::back_inserter(html), "<div class=\"card\"><h2>{}</h2><div class=\"camera\">{}</div>",
                   escaped(shown.title), picture_html(shown.png, shown.title));
    fmt::format_to(std::back_inserter(html), "<p class=\"dim small\" style=\"margin-top:8px\">{}</p></div>\n",
                   escaped(shown.note));
  }
  html += "</section>\n";
  for (const ReportTable& table : page.tables) {
    add_table(html, table);
  }
  add_foot(html, page.counters, page.settings);
  return html;
}

std::string report_html(const MomentsReport& data) {
  std::string html;
  add_head(html, data.title, data.subtitle, data.highlights);
  add_doubts(html, data.doubts);
  ReportTable table{"The line in the images",
                    {"", "columns with light", "row: least", "median", "greatest", "lit pixels a column",
                     "columns cut off by the border"},
                    {},
                    "Rows from 1, downwards; the row of a column is that of its centroid, M1 / M0. There is no rig, so "
                    "nothing is said about lengths. The moments of all frames are in moments.csv."};
  for (const CameraPicture& camera : data.cameras) {
    table.rows.push_back(line_row(camera));
  }
  add_table(html, table);
  html += "<div class=\"two\">";
  for (const CameraPicture& camera : data.cameras) {
    add_camera(html, camera, "");
  }
  html += "</div>\n";
  add_foot(html, data.counters, data.settings);
  return html;
}

std::string report_html(const ReportData& data) {
  std::string html;
  add_head(html, data.title, data.subtitle, data.highlights);
  add_doubts(html, data.doubts);
  html += "<div class=\"two\">";
  add_map(html, "Difference from the reference",
          std::string("Positive: nearer to the camera than the reference.") +
              (data.of_parts ? " Frames without a part are hatched." : ""),
          data.difference, data.difference_colours, data.pitch);
  add_map(html, "Height over the plane", "Rows are frames (along the belt), columns image columns.", data.height,
          height_scale(data.height), data.pitch);
  html += "</div>\n";
  for (const ReportTable& table : data.tables) {
    add_table(html, table);
  }
  const int frame = most_different(data.difference, Along::rows);
  const int column = most_different(data.difference, Along::columns);
  if (frame >= 0 && column >= 0) {
    add_profile_plot(html, data, frame);
    add_difference_plots(html, data, frame, column);
  }
  if (data.camera) {
    add_camera(html, *data.camera, "; rows along x downwards, columns along y");
  }
  add_foot(html, data.counters, data.settings);
  return html;
}

}  // namespace selfproj::report
