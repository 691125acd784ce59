#include "host/report/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "host/io/float_image.h"
#include "host/light_section/profile.h"
#include "host/report/colour_map.h"
#include "host/report/frame_picture.h"
#include "host/report/map_picture.h"
#include "host/report/number_text.h"

namespace selfproj {
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

std::string escape(std::string_view text) {
  std::string result;
  for (const char c : text) {
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

std::string picture(std::string_view png, std::string_view alternative) {
  return fmt::format("<img alt=\"{}\" src=\"data:image/png;base64,{}\">", escape(alternative), base64(png));
}

// 1234567 as "1 234 567", with thin spaces that do not break.
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

std::string fact_text(const Fact& fact) {
  return std::visit(
      [](const auto& value) -> std::string {
        using Value = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<Value, std::int64_t>) {
          return grouped(value);
        } else if constexpr (std::is_same_v<Value, double>) {
          return fmt::format("{:.6g}", value);
        } else {
          return escape(value);
        }
      },
      fact.value);
}

void add_facts(std::string& html, std::string_view title, const std::vector<Fact>& facts) {
  if (facts.empty()) {
    return;
  }
  fmt::format_to(std::back_inserter(html), "<div class=\"card\"><h2>{}</h2><table class=\"facts\">", title);
  for (const Fact& fact : facts) {
    fmt::format_to(std::back_inserter(html), "<tr><th scope=\"row\">{}</th><td>{}{}{}</td></tr>", escape(fact.label),
                   fact_text(fact), fact.unit.empty() ? "" : " ", escape(fact.unit));
  }
  html += "</table></div>\n";
}

void add_table(std::string& html, const ReportTable& table) {
  fmt::format_to(std::back_inserter(html), "<section class=\"card\"><h2>{}</h2><div class=\"wide\"><table><thead><tr>",
                 escape(table.title));
  for (const std::string& cell : table.header) {
    fmt::format_to(std::back_inserter(html), "<th scope=\"col\">{}</th>", escape(cell));
  }
  html += "</tr></thead><tbody>";
  for (const auto& row : table.rows) {
    html += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) {
      html += i == 0 ? "<th scope=\"row\">" + escape(row[i]) + "</th>" : "<td>" + escape(row[i]) + "</td>";
    }
    html += "</tr>";
  }
  html += "</tbody></table></div>";
  if (!table.note.empty()) {
    fmt::format_to(std::back_inserter(html), "<p class=\"dim small\">{}</p>", escape(table.note));
  }
  html += "</section>\n";
}

// A map with its scale bars beside and below it, and what its colours mean.
void add_map(std::string& html, std::string_view title, std::string_view explanation, const FloatImage& map,
             const MapScale& scale, const MapPitch& pitch) {
  constexpr int kLongest = 900;
  auto to = std::back_inserter(html);
  fmt::format_to(to, "<div class=\"card\"><h2>{}</h2><div class=\"withx\"><div class=\"map\">", title);
  html += picture(map_png(map, scale, map_size(map.rows, map.columns, pitch, kLongest)), title);
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

using Trace = ReportTrace;

// More points than pixels are of no use: of each run of points the least and the greatest stay.
Trace thinned(const Trace& trace) {
  constexpr std::size_t kMost = 4000;
  if (trace.x.size() <= kMost) {
    return trace;
  }
  Trace result{{}, {}, trace.style, trace.name};
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

void add_plot(std::string& html, std::string_view title, const std::vector<Trace>& traces, std::string_view x_label,
              std::string_view y_label, double min_span) {
  double x_low = std::numeric_limits<double>::infinity();
  double x_high = -x_low;
  double y_low = x_low;
  double y_high = -x_low;
  for (const Trace& trace : traces) {
    for (std::size_t i = 0; i < trace.x.size(); ++i) {
      if (!std::isnan(trace.y[i]) && !std::isnan(trace.x[i])) {
        x_low = std::min(x_low, trace.x[i]);
        x_high = std::max(x_high, trace.x[i]);
        y_low = std::min(y_low, trace.y[i]);
        y_high = std::max(y_high, trace.y[i]);
      }
    }
  }
  if (!(x_high > x_low)) {
    return;
  }
  const double middle = (y_low + y_high) / 2;
  const double half = std::max(min_span, (y_high - y_low) * 1.1) / 2;
  y_low = middle - half;
  y_high = middle + half;
  const auto place_x = [&](double x) { return 1000 * (x - x_low) / (x_high - x_low); };
  const auto place_y = [&](double y) { return 1000 * (y_high - y) / (y_high - y_low); };
  auto to = std::back_inserter(html);
  fmt::format_to(to, "<section class=\"card\"><h2>{}</h2><div class=\"key\">", title);
  for (const Trace& trace : traces) {
    fmt::format_to(to, "<span><svg viewBox=\"0 0 26 8\"><path class=\"{}\" d=\"M0 4H26\"/></svg>{}</span>", trace.style,
                   trace.name);
  }
  fmt::format_to(to,
                 "<span>vertical: {}</span></div><div class=\"plot\"><svg viewBox=\"0 0 1000 1000\" "
                 "preserveAspectRatio=\"none\" role=\"img\" aria-label=\"{}\">",
                 y_label, title);
  const std::vector<double> x_ticks = ticks(x_low, x_high, 6);
  const std::vector<double> y_ticks = ticks(y_low, y_high, 5);
  for (const double tick : x_ticks) {
    fmt::format_to(to, "<line x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"0\" y2=\"1000\"/>", place_x(tick));
  }
  for (const double tick : y_ticks) {
    fmt::format_to(to, "<line x1=\"0\" x2=\"1000\" y1=\"{0:.1f}\" y2=\"{0:.1f}\"/>", place_y(tick));
  }
  for (const Trace& whole : traces) {
    const Trace trace = thinned(whole);
    fmt::format_to(to, "<path class=\"{}\" d=\"", trace.style);
    bool pen_down = false;
    for (std::size_t i = 0; i < trace.x.size(); ++i) {
      if (std::isnan(trace.y[i]) || std::isnan(trace.x[i])) {
        pen_down = false;
        continue;
      }
      fmt::format_to(to, "{}{:.1f} {:.1f}", pen_down ? 'L' : 'M', place_x(trace.x[i]), place_y(trace.y[i]));
      pen_down = true;
    }
    html += "\"/>";
  }
  html += "</svg>";
  const auto step_of = [](const std::vector<double>& marks) { return marks.size() > 1 ? marks[1] - marks[0] : 1; };
  for (const double tick : x_ticks) {
    fmt::format_to(to, "<span class=\"xt\" style=\"left:{:.2f}%\">{}</span>", place_x(tick) / 10,
                   tick_text(tick, step_of(x_ticks)));
  }
  for (const double tick : y_ticks) {
    fmt::format_to(to, "<span class=\"yt\" style=\"top:{:.2f}%\">{}</span>", place_y(tick) / 10,
                   tick_text(tick, step_of(y_ticks)));
  }
  fmt::format_to(to, "<span class=\"xl\">{}</span></div></section>\n", x_label);
}

// The row (column) of the map in which the differences are greatest, by their mean square, among full rows (and columns
// that have at least nine tenths of the values there); -1 where there is none. Rows near the first and the last full
// one, where the part's ends are, are left out.
int most_different(const FloatImage& difference, bool row_wise) {
  const auto count = static_cast<std::size_t>(row_wise ? difference.rows : difference.columns);
  std::vector<double> squares(count, 0.0);
  std::vector<int> entries(count, 0);
  const std::vector<int> rows = full_rows(difference);
  const std::size_t ends = rows.size() / 20;
  for (std::size_t k = ends; k < rows.size() - ends; ++k) {
    const int r = rows[k];
    for (int c = 0; c < difference.columns; ++c) {
      const auto value = static_cast<double>(difference.row(r)[c]);
      if (!std::isnan(value)) {
        const auto at = static_cast<std::size_t>(row_wise ? r : c);
        squares[at] += value * value;
        ++entries[at];
      }
    }
  }
  const int fullest = *std::max_element(entries.begin(), entries.end());
  int best = -1;
  double most = -1;
  for (std::size_t i = 0; i < count; ++i) {
    if (entries[i] > 0 && 10 * entries[i] >= 9 * fullest && squares[i] / entries[i] > most) {
      most = squares[i] / entries[i];
      best = static_cast<int>(i);
    }
  }
  return best;
}

// Height over y of one frame, measured and of the reference. The point of the reference is the measured one less the
// difference.
void add_profile_plot(std::string& html, const ReportData& data, int frame) {
  Trace measured{{}, {}, "a", "measured"};
  Trace reference{{}, {}, "b", "reference"};
  for (int c = 0; c < data.height.columns; ++c) {
    const auto y = static_cast<double>(data.y.row(frame)[c]);
    const auto height = static_cast<double>(data.height.row(frame)[c]);
    measured.x.push_back(y);
    measured.y.push_back(height);
    reference.x.push_back(y);
    reference.y.push_back(height - static_cast<double>(data.difference.row(frame)[c]));
  }
  add_plot(html, fmt::format("Profile of frame {}", frame + 1), {measured, reference}, "y, mm", "height, mm", 1.0);
}

void add_difference_plots(std::string& html, const ReportData& data, int frame, int column) {
  Trace across{{}, {}, "a", "difference"};
  for (int c = 0; c < data.difference.columns; ++c) {
    across.x.push_back(static_cast<double>(data.y.row(frame)[c]));
    across.y.push_back(static_cast<double>(data.difference.row(frame)[c]));
  }
  Trace along{{}, {}, "a", "difference"};
  const bool known = data.pitch.row_mm > 0;
  for (int r = 0; r < data.difference.rows; ++r) {
    along.x.push_back(r * (known ? data.pitch.row_mm : 1.0));
    along.y.push_back(static_cast<double>(data.difference.row(r)[column]));
  }
  html += "<div class=\"two\">";
  add_plot(html, fmt::format("Difference across, frame {}", frame + 1), {across}, "y, mm", "difference, mm", 0.2);
  add_plot(html, fmt::format("Difference along the belt, column {}", column + 1), {along},
           known ? "way of the belt, mm" : "frame", "difference, mm", 0.2);
  html += "</div>";
}

// `axes`: what rows and columns mean.
void add_camera(std::string& html, const CameraPicture& camera, std::string_view axes) {
  auto to = std::back_inserter(html);
  const int rows = camera.image.rows;
  const int columns = camera.image.columns;
  fmt::format_to(to,
                 "<section class=\"card\"><h2>Camera image of frame {}, with the line found</h2><div class=\"camera\">",
                 camera.frame);
  html += picture(image_png(camera.image), "camera image");
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
    const bool joined = std::abs(row - last) <= 4;  // false where there is none
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

// Everything up to the tiles of what is to be seen first.
void add_head(std::string& html, const std::string& title, const std::string& subtitle,
              const std::vector<Fact>& highlights) {
  auto to = std::back_inserter(html);
  fmt::format_to(to,
                 "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
                 "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">"
                 "<title>{0}</title><style>{1}</style></head><body><main>\n<h1>{0}</h1><p class=\"dim\">{2}</p>\n",
                 escape(title), kStyle, escape(subtitle));
  html += "<div class=\"tiles\">";
  for (const Fact& fact : highlights) {
    fmt::format_to(to, "<div class=\"card tile\"><b>{} <span>{}</span></b><span class=\"dim small\">{}</span></div>",
                   fact_text(fact), escape(fact.unit), escape(fact.label));
  }
  html += "</div>\n";
}

void add_foot(std::string& html, const std::vector<Fact>& counters, const std::vector<Fact>& settings) {
  html += "<section class=\"two\">";
  add_facts(html, "Counters", counters);
  add_facts(html, "Settings", settings);
  html += "</section>\n</main></body></html>\n";
}

// What the line is like in one image: frame, lit columns, lowest, median and greatest row, lit pixels a column, columns
// that the border cuts off.
std::vector<std::string> line_row(const CameraPicture& camera) {
  std::vector<double> rows;
  double lit = 0;
  int cut_off = 0;
  for (std::size_t i = 0; i < camera.moments.m0.size(); ++i) {
    if (camera.moments.m0[i] > 0) {
      rows.push_back(static_cast<double>(camera.moments.m1[i]) / camera.moments.m0[i]);  // (3.2)
      lit += camera.moments.n[i];
      cut_off +=
          static_cast<int>(line_is_cut_off(static_cast<float>(rows.back()), static_cast<float>(camera.moments.n[i]),
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

std::string page_html(const ReportPage& page) {
  std::string html;
  add_head(html, page.title, page.subtitle, page.highlights);
  for (const ReportPlot& plot : page.plots) {
    add_plot(html, escape(plot.title), plot.traces, escape(plot.x_label), escape(plot.y_label), plot.min_span);
  }
  html += "<section class=\"two\">";
  for (const ReportPicture& shown : page.pictures) {
    fmt::format_to(std::back_inserter(html), "<div class=\"card\"><h2>{}</h2><div class=\"camera\">{}</div>",
                   escape(shown.title), picture(shown.png, shown.title));
    fmt::format_to(std::back_inserter(html), "<p class=\"dim small\" style=\"margin-top:8px\">{}</p></div>\n",
                   escape(shown.note));
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
  html += "<div class=\"two\">";
  add_map(html, "Difference from the reference", "Positive: nearer to the camera than the reference.", data.difference,
          difference_scale(data.difference), data.pitch);
  add_map(html, "Height over the plane", "Rows are frames (along the belt), columns image columns.", data.height,
          height_scale(data.height), data.pitch);
  html += "</div>\n";
  for (const ReportTable& table : data.tables) {
    add_table(html, table);
  }
  const int frame = most_different(data.difference, true);
  const int column = most_different(data.difference, false);
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

}  // namespace selfproj
