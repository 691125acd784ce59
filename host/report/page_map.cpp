#include "host/report/page_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "host/report/colour_map.h"
#include "host/report/html_text.h"
#include "host/report/number_text.h"

namespace selfproj {

void add_map(std::string& html, std::string_view title, std::string_view explanation, const FloatImage& map,
             const MapScale& scale, const MapPitch& pitch) {
  constexpr int kLongest = 900;
  auto to = std::back_inserter(html);
  fmt::format_to(to, "<div class=\"card\"><h2>{}</h2><div class=\"withx\"><div class=\"map\">", title);
  html += picture_html(map_png(map, scale, map_size(map.rows, map.columns, pitch, kLongest)), title);
  const bool known = pitch.row_mm > 0;
  const double height = known ? map.rows * pitch.row_mm : map.rows;
  const double width = map.columns * pitch.column_mm;
  const double along_x = known ? round_down(height / 4) : std::max(1.0, std::floor(round_down(height / 4)));
  const double along_y = round_down(width / 4);
  const double share = std::min(100.0, 100 * along_x / height);
  fmt::format_to(to,
                 "<i class=\"upright\" style=\"left:-10px;bottom:0;height:{:.2f}%\"></i>"
                 "<span style=\"left:-50px;top:{:.2f}%\">x {} {}</span></div>",
                 share, 100 - share / 2, tick_text(along_x, along_x), known ? "mm" : "frames");
  fmt::format_to(to, "<div class=\"bars\"><span class=\"bar\" style=\"width:{:.2f}%\"><i></i>y {}&nbsp;mm</span></div>",
                 100 * along_y / width, tick_text(along_y, along_y));
  html += "<div class=\"ramp\"><div class=\"colours\" style=\"background:linear-gradient(90deg";
  constexpr int kStops = 16;
  for (int i = 0; i <= kStops; ++i) {
    const Colour colour = colour_at(scale.map, static_cast<double>(i) / kStops);
    fmt::format_to(to, ",#{:02x}{:02x}{:02x}", colour.red, colour.green, colour.blue);
  }
  html += ")\"></div><div class=\"numbers\">";
  const std::vector<double> marks = ticks(scale.low, scale.high, 5);
  const double step = marks.size() > 1 ? marks[1] - marks[0] : scale.high - scale.low;
  for (const double mark : marks) {
    fmt::format_to(to, "<span style=\"left:{:.2f}%\">{}</span>", 100 * (mark - scale.low) / (scale.high - scale.low),
                   tick_text(mark, step));
  }
  fmt::format_to(to,
                 "</div>mm · <i class=\"none\"></i>no value</div></div><p class=\"dim small\" "
                 "style=\"margin-top:10px\">{}</p></div>\n",
                 explanation);
}

}  // namespace selfproj
