#include "host/report/page_parts.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "host/report/html_text.h"

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
  html += picture_html(image_png(camera.image), "camera image");
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

}  // namespace selfproj
