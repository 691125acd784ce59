#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "host/app/commands.h"
#include "host/app/scanner_run.h"
#include "host/cli/command_line.h"
#include "host/files/input_file.h"
#include "host/files/json_text.h"
#include "host/files/numbers.h"
#include "host/files/output_folder.h"
#include "host/report/facts.h"
#include "host/report/map_picture.h"
#include "host/report/page.h"
#include "host/report/report.h"
#include "host/structured_light/cloud_axes.h"
#include "selfproj/files/user_error.h"
#include "selfproj/images/float_image.h"
#include "selfproj/structured_light/point_cloud.h"

namespace selfproj::app {
namespace {

struct CompareOptions {
  std::string a, b, out;
  double within_mm = 0.1;
  std::optional<double> most_mm;     // nothing: nothing is demanded
  structured_light::CloudAxes axes;  // of B
};

// Differences of maps are signed, distances of clouds are not.
struct Comparison {
  std::string what;            // "difference" or "distance"
  std::vector<double> values;  // mm, in ascending order
  std::size_t of_a = 0;        // values or points of each
  std::size_t of_b = 0;
  bool is_signed = false;
  std::string doubt = {};
  std::vector<report::ReportPicture> pictures;
};

constexpr std::array<double, 7> kPercentiles{0.1, 1, 5, 50, 95, 99, 99.9};

// The value that this percentage of the sorted values does not exceed.
double percentile(const std::vector<double>& sorted, double percent) {
  const auto at = static_cast<std::ptrdiff_t>(std::ceil(0.01 * percent * static_cast<double>(sorted.size()))) - 1;
  return sorted[static_cast<std::size_t>(std::max<std::ptrdiff_t>(at, 0))];
}

// "-0.000" is 0.
std::string mm_text(double value) { return fmt::format("{:.3f}", std::abs(value) < 0.0005 ? 0.0 : value); }

bool is_cloud(const std::string& file) { return files::read_input(file, files::kMostImageBytes).starts_with("ply"); }

std::size_t finite(const images::FloatImage& map) {
  return static_cast<std::size_t>(
      std::count_if(map.values.begin(), map.values.end(), [](float value) { return std::isfinite(value); }));
}

const report::MapPitch kCells{1, 1, "rows", "columns", "cells"};  // a map does not say how far apart they are

Comparison compare_maps(const CompareOptions& options, files::OutputFolder& folder) {
  const images::FloatImage a = images::read_float_tiff(options.a);
  const images::FloatImage b = images::read_float_tiff(options.b);
  if (a.rows != b.rows || a.columns != b.columns) {
    throw UserError(options.b, fmt::format("has {} x {} values, {} has {} x {}; maps are compared value by value",
                                           b.columns, b.rows, options.a, a.columns, a.rows));
  }
  Comparison result{"difference, B less A", {}, finite(a), finite(b), true, {}, {}};
  images::FloatImage difference(a.rows, a.columns, images::kNoValue);
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    difference.values[i] = b.values[i] - a.values[i];
    if (std::isfinite(difference.values[i])) {
      result.values.push_back(static_cast<double>(difference.values[i]));
    }
  }
  if (result.values.empty()) {
    throw UserError(options.b, "has no value where " + options.a + " has one");
  }
  result.pictures.push_back(
      {"Difference, B less A (mm)",
       report::labelled_map_png(difference, report::difference_scale(difference), kCells, "difference (mm)"),
       "Red: B is greater. Grey: one of them has no value. Bars are in cells.",
       report::ReportMap{difference, report::difference_scale(difference), kCells}});
  folder.append("difference.tiff", images::encode_float_tiff("difference.tiff", difference));
  folder.append("difference.png", result.pictures.front().png);
  return result;
}

Comparison compare_clouds(const CompareOptions& options, files::OutputFolder& folder) {
  const std::vector<structured_light::Point3f> a = structured_light::read_ply(options.a);
  std::vector<structured_light::Point3f> b = structured_light::read_ply(options.b);
  for (const auto& [file, cloud] : {std::pair(options.a, &a), {options.b, &b}}) {
    if (cloud->empty()) {
      throw UserError(file, "has no points");
    }
  }
  const structured_light::NearestPoint nearest(a);
  Comparison result{"distance from each point of B to the nearest of A", {}, a.size(), b.size(), false, {}, {}};
  if (options.axes.as_they_are()) {
    result.doubt = doubt_about_axes(nearest, b, "A", "--");
  }
  for (structured_light::Point3f& point : b) {
    point = options.axes.of(point);
  }
  for (const structured_light::Point3f& point : b) {
    result.values.push_back(nearest.distance(point));
  }
  std::vector<double> sorted = result.values;
  std::sort(sorted.begin(), sorted.end());
  const double most = std::max(percentile(sorted, 99), 1e-6);
  structured_light::PlyText ply(b.size());
  for (std::size_t i = 0; i < b.size(); ++i) {
    const report::Colour colour = report::colour_at(report::ColourMap::sequential, result.values[i] / most);
    ply.add(b[i], colour.red, colour.green, colour.blue);
  }
  folder.append("distance.ply",
                ply.file(fmt::format("millimetres, colour by distance, 0 (dark) to {:.4g} mm (light)", most)));
  return result;
}

// How many values lie in each of 100 even steps; the outermost steps hold what is beyond, too.
struct Histogram {
  double low = 0, step = 0;
  std::vector<std::size_t> counts;
};

Histogram histogram_of(const Comparison& comparison) {
  constexpr int kSteps = 100;
  const double high = std::max({std::abs(percentile(comparison.values, 99.9)),
                                std::abs(percentile(comparison.values, comparison.is_signed ? 0.1 : 99.9)), 1e-6});
  Histogram histogram;
  histogram.low = comparison.is_signed ? -high : 0;
  histogram.step = (high - histogram.low) / kSteps;
  histogram.counts.resize(kSteps);
  for (const double value : comparison.values) {
    const double at = std::clamp((value - histogram.low) / histogram.step, 0.0, kSteps - 1.0);
    ++histogram.counts[static_cast<std::size_t>(at)];
  }
  return histogram;
}

struct Figures {
  double mean = 0, rms = 0, within = 0, largest = 0;
};

Figures figures_of(const Comparison& comparison, double within_mm) {
  Figures f;
  for (const double value : comparison.values) {
    f.mean += value;
    f.rms += value * value;
    f.within += std::abs(value) <= within_mm ? 1 : 0;
    f.largest = std::max(f.largest, std::abs(value));
  }
  const auto count = static_cast<double>(comparison.values.size());
  f.mean /= count;
  f.rms = std::sqrt(f.rms / count);
  f.within /= count;
  return f;
}

void write_report(const CompareOptions& options, const Comparison& comparison, const Figures& f,
                  files::OutputFolder& folder) {
  const Histogram histogram = histogram_of(comparison);
  std::string csv = "from_mm,to_mm,count\n";
  report::ReportPlot plot{"Histogram: " + comparison.what, "mm", "count", {{{}, {}, "a", comparison.what}}, 1};
  for (std::size_t i = 0; i < histogram.counts.size(); ++i) {
    const double from = histogram.low + static_cast<double>(i) * histogram.step;
    csv += fmt::format("{:.6g},{:.6g},{}\n", from, from + histogram.step, histogram.counts[i]);
    for (const double x : {from, from + histogram.step}) {
      plot.traces[0].x.push_back(x);
      plot.traces[0].y.push_back(static_cast<double>(histogram.counts[i]));
    }
  }
  report::ReportTable table{"Percentiles of the " + comparison.what, {"percent", "not above, mm"}, {}, ""};
  nlohmann::ordered_json percentiles;
  for (const double percent : kPercentiles) {
    const double value = percentile(comparison.values, percent);
    table.rows.push_back({fmt::format("{:g}", percent), mm_text(value)});
    percentiles[fmt::format("{:g}", percent)] = value;
  }
  const std::vector<report::Fact> facts{{"compared", "compared", static_cast<std::int64_t>(comparison.values.size())},
                                        {"mean_mm", "mean", f.mean, "mm"},
                                        {"rms_mm", "RMS", f.rms, "mm"},
                                        {"largest_mm", "largest", f.largest, "mm"},
                                        {"within", fmt::format("share within {:g} mm", options.within_mm), f.within}};
  report::ReportPage page;
  page.title = "Comparison";
  page.subtitle = "A: " + options.a + ", B: " + options.b;
  page.highlights = facts;
  if (!comparison.doubt.empty()) {
    page.doubts = {"B: " + comparison.doubt};
  }
  for (std::size_t i = 1; i <= 3; ++i) {
    page.highlights[i].value = mm_text(std::get<double>(facts[i].value));
  }
  page.highlights.back().value = fmt::format("{:.2f}", 100 * f.within);
  page.highlights.back().unit = "%";
  page.plots = {plot};
  page.pictures = comparison.pictures;
  page.tables = {table};
  page.settings = {{"of_a", "values of A", static_cast<std::int64_t>(comparison.of_a)},
                   {"of_b", "values of B", static_cast<std::int64_t>(comparison.of_b)}};
  for (const auto& [given, key, label] : {std::tuple{options.axes.exchange_xy, "exchange_xy", "x and y of B exchanged"},
                                          {options.axes.opengl, "opengl", "y and z of B with the opposite sign"}}) {
    if (given) {
      page.settings.push_back({key, label, std::string("yes")});
    }
  }
  nlohmann::ordered_json json{{"a", options.a}, {"b", options.b}, {"what", comparison.what}};
  if (!comparison.is_signed) {
    json["exchange_xy"] = options.axes.exchange_xy;
    json["opengl"] = options.axes.opengl;
  }
  if (!comparison.doubt.empty()) {
    json["doubts"] = {comparison.doubt};
  }
  json.update(report::facts_json(facts));
  json["within_mm"] = options.within_mm;
  json["of_a"] = comparison.of_a;
  json["of_b"] = comparison.of_b;
  json["percentiles_mm"] = percentiles;
  folder.append("histogram.csv", csv);
  folder.append("summary.json", files::json_text(json, 2) + "\n");
  folder.append("report.html", report::page_html(page));
}

void run_compare(const CompareOptions& options) {
  const bool clouds = is_cloud(options.a);
  if (clouds != is_cloud(options.b)) {
    throw UserError(options.b, fmt::format("is a {}, {} a {}; two maps or two clouds are compared",
                                           clouds ? "map" : "cloud", options.a, clouds ? "cloud" : "map"));
  }
  if (!clouds && !options.axes.as_they_are()) {
    throw UserError(options.axes.exchange_xy ? "--exchange-xy" : "--opengl", "is for clouds");
  }
  files::OutputFolder folder(options.out);
  Comparison comparison = clouds ? compare_clouds(options, folder) : compare_maps(options, folder);
  std::sort(comparison.values.begin(), comparison.values.end());
  const Figures f = figures_of(comparison, options.within_mm);
  write_report(options, comparison, f, folder);
  folder.commit();
  cli::note_doubt(options.b, comparison.doubt);
  fmt::print("{}: mean {}, RMS {}, largest {} mm; {:.2f} % within {:g} mm → {}\n", clouds ? "distance" : "difference",
             mm_text(f.mean), mm_text(f.rms), mm_text(f.largest), 100 * f.within, options.within_mm, options.out);
  if (options.most_mm && !(f.largest <= *options.most_mm)) {
    throw CheckFailed(
        fmt::format("--check: {} mm at most are allowed, and {} were found", *options.most_mm, mm_text(f.largest)));
  }
}

}  // namespace

void add_compare_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app,
      {.name = "compare",
       .purpose = "Compares two maps, value by value, or two clouds, point by point.",
       .details =
           "Both must be in one frame: maps of one camera and one view, clouds in the same coordinates. A cloud of a "
           "rig has x down the image; --exchange-xy brings that of a calibration, and most others, into it. Maps are "
           "TIFF files of heights or depths, such as height.tiff and depth.tiff, and the result is B less A. Clouds "
           "are PLY files, and the result is the distance from each point of B to the nearest of A.\n\n"
           "The folder of --out gets\n"
           "- difference.tiff and difference.png of maps, in colours; of clouds distance.ply, B in colours\n"
           "- histogram.csv; summary.json with percentiles; report.html with all of them",
       .examples = R"(
# The stairs with and without carved marks, as they are measured.
selfproj-sim cosim --engine model --scene stairs --first 690 --count 20 --out good
selfproj-sim cosim --engine model --scene stairs-marked --first 690 --count 20 --out marked
selfproj compare --out compared good/height.tiff marked/height.tiff

# A scan against a cloud of the owner's, at most 1 mm away (needs your files)
selfproj compare --check 1 --out compared theirs.ply depth/cloud.ply
)"});
  const auto options = std::make_shared<CompareOptions>();
  command->add_option("A", options->a, "Map or cloud that the other is compared with.")->required();
  command->add_option("B", options->b, "Map or cloud.")->required();
  cli::begin_group(*command, "Comparing");
  command->add_option("--within", options->within_mm, "Also say which share is within this, to either side.")
      ->transform(cli::number_above_zero())
      ->type_name("MM")
      ->capture_default_str();
  command->add_option("--check", options->most_mm, "Fail, with status 1, where more is found anywhere.")
      ->transform(cli::number_above_zero())
      ->type_name("MM");
  command->add_flag("--exchange-xy", options->axes.exchange_xy, "Exchange x and y of the cloud B.");
  command->add_flag("--opengl", options->axes.opengl, "y and z of the cloud B have the opposite sign.");
  cli::begin_group(*command, "Output");
  command->add_option("--out", options->out, "Folder for pictures, tables and report.")->type_name("DIR")->required();
  command->callback([options] { run_compare(*options); });
}

}  // namespace selfproj::app
