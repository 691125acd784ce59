#include "host/report/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "host/files/text.h"
#include "host/report/map_picture.h"
#include "host/report/tables.h"

namespace selfproj::report {

namespace {

std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string result;
  result.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8U | (k < count ? static_cast<std::uint8_t>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      result += k <= count ? kDigits[group >> (18 - 6 * k) & 63U] : '=';
    }
  }
  return result;
}

// 1234567 as "1 234 567", with thin spaces at which lines do not break.
std::string grouped(std::int64_t value) {
  const std::string digits = std::to_string(value < 0 ? -value : value);
  std::string result = value < 0 ? "−" : "";
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) {
      result += "\u202f";
    }
    result += digits[i];
  }
  return result;
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : files::shown(text)) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

std::string picture_html(std::string_view png, std::string_view alternative) {
  return fmt::format("<img alt=\"{}\" src=\"data:image/png;base64,{}\">", escaped(alternative), base64(png));
}

std::string fact_html(const Fact& fact) {
  return std::visit(
      [](const auto& value) -> std::string {
        using Value = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<Value, std::int64_t>) {
          return grouped(value);
        } else if constexpr (std::is_same_v<Value, double>) {
          return fmt::format("{:.6g}", value);
        } else {
          return escaped(value);
        }
      },
      fact.value);
}

namespace {

constexpr std::string_view kStyle = R"css(
:root { color-scheme: light dark; --page: #f5f6f8; --card: #ffffff; --ink: #1b1f24; --dim: #5b6470; --rule: #dfe3e8;
  --grid: #e9ecf0; --a: #c2410c; --b: #2563a8; }
@media (prefers-color-scheme: dark) { :root { --page: #121417; --card: #1b1e23; --ink: #e6e9ed; --dim: #9aa4b0;
  --rule: #30353c; --grid: #2a2f36; --a: #fb923c; --b: #6cb2f5; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--ink); font: 15px/1.5 system-ui, "Segoe UI", Roboto,
  "Helvetica Neue", "DejaVu Sans", sans-serif; }
main { max-width: 1120px; margin: 0 auto; padding: 28px 20px 48px; }
h1 { font-size: 26px; line-height: 1.2; margin: 0 0 4px; }
h2 { font-size: 17px; margin: 0 0 12px; }
p { margin: 0; }
.dim { color: var(--dim); }
.small { font-size: 13px; }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(150px, 1fr)); gap: 12px; margin: 20px 0; }
.card { background: var(--card); border: 1px solid var(--rule); border-radius: 10px; padding: 16px 18px; min-width: 0; }
.tile { padding: 12px 16px; }
.tile b { display: block; font-size: 20px; font-weight: 600; line-height: 1.3; font-variant-numeric: tabular-nums; }
.tile b span { font-size: 14px; font-weight: 400; }
.two { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 420px), 1fr)); gap: 16px; }
section { margin-top: 16px; }
.map { position: relative; }
.map img, .camera img { display: block; width: 100%; height: auto; border-radius: 4px; }
.bars { display: flex; flex-wrap: wrap; gap: 6px 24px; align-items: flex-end; margin-top: 8px; }
.bar { font-size: 12px; color: var(--dim); white-space: nowrap; }
.bar i { display: block; height: 4px; background: var(--ink); margin-bottom: 2px; }
.upright { position: absolute; left: 0; width: 4px; background: var(--ink); }
.withx { padding-left: 46px; position: relative; }
.upright + span { position: absolute; left: -38px; width: 34px; text-align: right; font-size: 12px; line-height: 1.25;
  color: var(--dim); transform: translateY(-50%); }
.ramp { margin-top: 14px; font-size: 12px; color: var(--dim); }
.ramp .colours { height: 12px; border-radius: 3px; border: 1px solid var(--rule); }
.ramp .numbers { position: relative; height: 18px; }
.ramp .numbers span { position: absolute; transform: translateX(-50%); }
.none { display: inline-block; width: 22px; height: 12px; border-radius: 3px; vertical-align: -1px; margin-right: 6px;
  background: repeating-linear-gradient(135deg, #848484 0 4px, #b2b2b2 4px 6px); }
.plot { position: relative; height: 260px; margin: 4px 6px 38px 48px; border-left: 1px solid var(--rule);
  border-bottom: 1px solid var(--rule); }
.plot svg { position: absolute; inset: 0; width: 100%; height: 100%; overflow: hidden; }
.plot path, .plot line, .camera path { fill: none; vector-effect: non-scaling-stroke; }
.plot line { stroke: var(--grid); stroke-width: 1; }
.a { stroke: var(--a); stroke-width: 1.6; }
.b { stroke: var(--b); stroke-width: 1.6; stroke-dasharray: 6 4; }
.plot span { position: absolute; font-size: 12px; color: var(--dim); white-space: nowrap;
  font-variant-numeric: tabular-nums; }
.plot .xt { top: 100%; margin-top: 3px; transform: translateX(-50%); }
.plot .yt { right: 100%; margin-right: 6px; transform: translateY(-50%); }
.plot .xl { top: 100%; margin-top: 19px; right: 0; }
.key { font-size: 13px; color: var(--dim); margin-bottom: 10px; display: flex; flex-wrap: wrap; gap: 4px 18px; }
.key svg { width: 26px; height: 8px; margin-right: 6px; vertical-align: 1px; }
.key path { fill: none; }
.camera { position: relative; background: #000; border-radius: 4px; }
.camera svg { position: absolute; inset: 0; width: 100%; height: 100%; }
.wide { overflow-x: auto; }
.wide + p { margin-top: 10px; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { text-align: right; padding: 6px 0 6px 18px; border-top: 1px solid var(--rule); vertical-align: top; }
thead th { border-top: 0; color: var(--dim); font-weight: 500; font-size: 13px; vertical-align: bottom; }
th:first-child, td:first-child { text-align: left; padding-left: 0; font-weight: 400; min-width: 9em; }
.facts td { text-align: right; overflow-wrap: break-word; max-width: 56vw; }
.facts tr:first-child > * { border-top: 0; }
@media (max-width: 480px) { main { padding: 18px 12px 32px; } h1 { font-size: 22px; } .card { padding: 14px 12px; }
  .tiles { grid-template-columns: 1fr 1fr; gap: 8px; } .tile { padding: 10px 12px; } .tile b { font-size: 17px; }
  .plot { height: 220px; margin-left: 42px; } body { font-size: 14px; } th, td { padding-left: 12px; } }
@media print { body { background: none; } .card { break-inside: avoid; } }
)css";

void add_facts(std::string& html, std::string_view title, const std::vector<Fact>& facts) {
  if (facts.empty()) {
    return;
  }
  fmt::format_to(std::back_inserter(html), "<div class=\"card\"><h2>{}</h2><table class=\"facts\">", title);
  for (const Fact& fact : facts) {
    fmt::format_to(std::back_inserter(html), "<tr><th scope=\"row\">{}</th><td>{}{}{}</td></tr>", escaped(fact.label),
                   fact_html(fact), fact.unit.empty() ? "" : " ", escaped(fact.unit));
  }
  html += "</table></div>\n";
}

}  // namespace

void add_head(std::string& html, const std::string& title, const std::string& subtitle,
              const std::vector<Fact>& highlights) {
  auto to = std::back_inserter(html);
  fmt::format_to(to,
                 "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
                 "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">"
                 "<title>{0}</title><style>{1}</style></head><body><main>\n<h1>{0}</h1><p class=\"dim\">{2}</p>\n",
                 escaped(title), kStyle, escaped(subtitle));
  html += "<div class=\"tiles\">";
  for (const Fact& fact : highlights) {
    fmt::format_to(to, "<div class=\"card tile\"><b>{} <span>{}</span></b><span class=\"dim small\">{}</span></div>",
                   fact_html(fact), escaped(fact.unit), escaped(fact.label));
  }
  html += "</div>\n";
}

void add_table(std::string& html, const ReportTable& table) {
  fmt::format_to(std::back_inserter(html), "<section class=\"card\"><h2>{}</h2><div class=\"wide\"><table><thead><tr>",
                 escaped(table.title));
  for (const std::string& cell : table.header) {
    fmt::format_to(std::back_inserter(html), "<th scope=\"col\">{}</th>", escaped(cell));
  }
  html += "</tr></thead><tbody>";
  for (const auto& row : table.rows) {
    html += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) {
      html += i == 0 ? "<th scope=\"row\">" + escaped(row[i]) + "</th>" : "<td>" + escaped(row[i]) + "</td>";
    }
    html += "</tr>";
  }
  html += "</tbody></table></div>";
  if (!table.note.empty()) {
    fmt::format_to(std::back_inserter(html), "<p class=\"dim small\">{}</p>", escaped(table.note));
  }
  html += "</section>\n";
}

void add_camera(std::string& html, const CameraPicture& camera, std::string_view axes) {
  auto to = std::back_inserter(html);
  const int rows = camera.image.rows;
  const int columns = camera.image.columns;
  fmt::format_to(to,
                 "<section class=\"card\"><h2>Camera image of frame {}, with the line found</h2><div class=\"camera\">",
                 camera.frame);
  html += picture_html(images::encode_png(camera.image), "camera image");
  fmt::format_to(to,
                 "<svg viewBox=\"0 0 {} {}\" preserveAspectRatio=\"none\"><path stroke=\"#ff7a1a\" "
                 "stroke-width=\"1.8\" d=\"",
                 columns, rows);
  double last = std::numeric_limits<double>::quiet_NaN();
  for (int c = 0; c < columns; ++c) {
    const auto at = static_cast<std::size_t>(c);
    if (camera.moments.m0[at] == 0) {
      last = std::numeric_limits<double>::quiet_NaN();
      continue;
    }
    // Row C (from 1) has its centre at C - 1/2 in the picture.
    const double row = static_cast<double>(camera.moments.m1[at]) / camera.moments.m0[at] - 0.5;
    const bool joined = std::abs(row - last) <= 4;  // false if there is no last point
    fmt::format_to(to, "{}{:.1f} {:.2f}", joined ? 'L' : 'M', c + 0.5, row);
    if (!joined) {
      html += "h.01";  // a column on its own is seen too
    }
    last = row;
  }
  fmt::format_to(to,
                 "\"/></svg></div><p class=\"dim small\" style=\"margin-top:8px\">{} × {} px, 8 bit{}</p></section>\n",
                 rows, columns, axes);
}

void add_foot(std::string& html, const std::vector<Fact>& counters, const std::vector<Fact>& settings) {
  html += "<section class=\"two\">";
  add_facts(html, "Counters", counters);
  add_facts(html, "Settings", settings);
  html += "</section>\n</main></body></html>\n";
}

void add_map(std::string& html, std::string_view title, std::string_view explanation, const images::FloatImage& map,
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
                 "<span style=\"left:-50px;top:{:.2f}%\">{} {} {}</span></div>",
                 share, 100 - share / 2, pitch.row_axis, tick_text(along_x, along_x), known ? "mm" : "frames");
  fmt::format_to(to,
                 "<div class=\"bars\"><span class=\"bar\" style=\"width:{:.2f}%\"><i></i>{} {}&nbsp;mm</span></div>",
                 100 * along_y / width, pitch.column_axis, tick_text(along_y, along_y));
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

namespace {

// More points than pixels are useless. Keeps only the least and the greatest point of each run.
ReportTrace thinned(const ReportTrace& trace) {
  constexpr std::size_t kMax = 4000;
  if (trace.x.size() <= kMax) {
    return trace;
  }
  ReportTrace result{{}, {}, trace.style, trace.name};
  const std::size_t run = (2 * trace.x.size() + kMax - 1) / kMax;
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

}  // namespace selfproj::report
