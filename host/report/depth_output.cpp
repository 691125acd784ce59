#include "host/report/depth_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/files/json_text.h"
#include "host/files/numbers.h"
#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "host/report/facts.h"
#include "host/report/map_picture.h"
#include "selfproj/driver/counters.h"
#include "selfproj/images/float_image.h"
#include "selfproj/structured_light/point_cloud.h"

namespace selfproj::report {

namespace {

// The median of the depths in mm; 1 if there is none.
float median_depth(const images::FloatImage& depth) {
  std::vector<float> values;
  std::copy_if(depth.values.begin(), depth.values.end(), std::back_inserter(values),
               [](float value) { return !std::isnan(value); });
  return values.empty() ? 1 : files::median_of(std::move(values));
}

double distance(const structured_light::Point3f& a, const structured_light::Point3f& b) {
  return std::hypot(static_cast<double>(a.x - b.x), static_cast<double>(a.y - b.y), static_cast<double>(a.z - b.z));
}

}  // namespace

double depth_unit(const images::FloatImage& depth) {
  constexpr double kMax = 65535;
  double largest = 0;
  for (const float z : depth.values) {
    largest = std::isfinite(z) ? std::max(largest, static_cast<double>(z)) : largest;
  }
  double unit = kDepthUnit;
  while (largest > kMax * unit) {
    unit *= 2;
  }
  return unit;
}

std::string depth_png(const images::FloatImage& depth) {
  const double unit = depth_unit(depth);
  std::vector<std::uint16_t> units(depth.values.size());
  std::transform(depth.values.begin(), depth.values.end(), units.begin(), [unit](float z) {
    constexpr double kMax = 65535;
    return std::isnan(z)
               ? std::uint16_t{0}
               : static_cast<std::uint16_t>(std::lround(std::clamp(static_cast<double>(z) / unit, 0.0, kMax)));
  });
  return images::encode_png16(depth.rows, depth.columns, units);
}

ReportPicture shown_depth(const structured_light::Triangulation& triangulation, const images::FloatImage& depth,
                          const std::string& title) {
  const float z = median_depth(depth);
  const auto columns = static_cast<std::size_t>(depth.columns);
  const std::size_t row = static_cast<std::size_t>(depth.rows) / 2 - (depth.rows > 1 ? 1 : 0);
  const std::size_t column = columns / 2 - (columns > 1 ? 1 : 0);
  const std::size_t at = row * columns + column;
  const structured_light::Point3f middle = triangulation.point(at, z);
  const double down = depth.rows > 1 ? distance(middle, triangulation.point(at + columns, z)) : 1;
  const double right = columns > 1 ? distance(middle, triangulation.point(at + 1, z)) : 1;
  const bool rows_are_x = triangulation.rows_are_x();
  const MapPitch pitch{down, right, rows_are_x ? "x" : "y", rows_are_x ? "y" : "x"};
  return shown_map(title, depth, height_scale(depth), pitch);
}

std::string depth_picture(const structured_light::Triangulation& triangulation, const images::FloatImage& depth,
                          const std::string& title) {
  return shown_depth(triangulation, depth, title).png;
}

std::vector<structured_light::Point3f> points_of(const structured_light::Triangulation& triangulation,
                                                 const images::FloatImage& depth) {
  std::vector<structured_light::Point3f> points;
  for (std::size_t i = 0; i < depth.values.size(); ++i) {
    if (!std::isnan(depth.values[i])) {
      points.push_back(triangulation.point(i, depth.values[i]));
    }
  }
  return points;
}

std::string cloud_ply(const structured_light::Triangulation& triangulation, const images::FloatImage& depth,
                      const structured_light::LightOfPixels* light) {
  const MapScale scale = height_scale(depth);
  structured_light::PlyText ply(depth.values.size(), light != nullptr);
  for (std::size_t i = 0; i < depth.values.size(); ++i) {
    if (std::isnan(depth.values[i])) {
      continue;
    }
    const structured_light::Point3f point = triangulation.point(i, depth.values[i]);
    const Colour colour = colour_at(scale.map, (static_cast<double>(point.z) - scale.low) / (scale.high - scale.low));
    ply.add(point, colour.red, colour.green, colour.blue, light != nullptr ? light->intensity[i] : 0.0F,
            light != nullptr ? light->contrast[i] : 0.0F);
  }
  return ply.file(std::string("millimetres, ") + triangulation.axes() + ", colour by z" +
                  (light != nullptr
                       ? "; intensity: grey value under light; quality: contrast of the finest pattern, in "
                         "grey values"
                       : ""));
}

std::string shares_csv(const std::vector<structured_light::OfImage<structured_light::DepthShares>>& shares) {
  std::string text = "pair";
  for (int state = 0; state < structured_light::kPointStates; ++state) {
    text += fmt::format(",{}", structured_light::name_of(static_cast<structured_light::PointState>(state)));
  }
  text += '\n';
  for (const structured_light::OfImage<structured_light::DepthShares>& image : shares) {
    fmt::format_to(std::back_inserter(text), "{},{}\n", image.number, fmt::join(image.value.count, ","));
  }
  return text;
}

namespace {

using Json = nlohmann::ordered_json;

// Numbers that are not finite become null.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json depth_json(const images::FloatImage& depth) {
  std::vector<float> values;
  std::copy_if(depth.values.begin(), depth.values.end(), std::back_inserter(values),
               [](float value) { return !std::isnan(value); });
  if (values.empty()) {
    return nullptr;
  }
  std::sort(values.begin(), values.end());
  return {{"min", values.front()}, {"median", values[values.size() / 2]}, {"max", values.back()}};
}

// Angle between the plane's normal and z.
double tilt_deg(const structured_light::PlaneFit& fit) {
  return std::atan(std::hypot(fit.a, fit.b)) * 180 / std::numbers::pi;
}

Json plane_json(const structured_light::PlaneFit& plane) {
  return {{"points", plane.points},
          {"points_not_on_it", plane.left_out},
          {"z_on_axis_mm", number(plane.z0)},
          {"z_per_x", number(plane.a)},
          {"z_per_y", number(plane.b)},
          {"tilt_deg", number(tilt_deg(plane))},
          {"residual_rms_mm", number(plane.rms)},
          {"residual_max_mm", number(plane.greatest)},
          {"rounding_rms_mm", number(plane.rounding_rms)}};
}

// The newest depth image.
Json newest_json(const structured_light::DepthRun& run, const structured_light::DepthGeometry& geometry) {
  const std::size_t total = run.shares.total();
  Json pixels;
  Json shares;
  for (int i = 0; i < structured_light::kPointStates; ++i) {
    const auto state = static_cast<structured_light::PointState>(i);
    pixels[structured_light::name_of(state)] = run.shares.of(state);
    shares[structured_light::name_of(state)] = static_cast<double>(run.shares.of(state)) / static_cast<double>(total);
  }
  Json json{{"pixels", total},
            {"measurable", total - run.shares.of(structured_light::PointState::not_measurable)},
            {"by_state", pixels},
            {"share", shares},
            {"z_mm", depth_json(run.depth)}};
  if (geometry.row_bits > 0) {
    json["median_residual_px"] = number(run.median_residual_px);
  }
  if (!run.moved.empty()) {
    const structured_light::Foreground& moved = run.moved.back().value;
    json["moved"] = {{"pixels", moved.pixels}, {"x", number(moved.x)}, {"y", number(moved.y)}, {"z", number(moved.z)}};
  }
  return json;
}

std::string summary(const structured_light::DepthRun& run, const DepthReport& report) {
  const structured_light::DepthGeometry& geometry = report.setup.geometry;
  Json json;
  json["geometry"] = geometry.rig.empty() ? geometry.calibration : geometry.rig;
  if (run.device) {
    json["device"] = device_json(report.device, *run.device);
  } else {
    json["images"] = report.images;
    json["threshold"] = report.setup.scanner.threshold;
    json["median"] = report.setup.scanner.median;
    json["strict"] = report.setup.scanner.strict;
  }
  json["rows"] = run.depth.rows;
  json["columns"] = run.depth.columns;
  json["bits"] = geometry.bits;
  json["row_bits"] = geometry.row_bits;
  for (const auto& [name, lines] : {std::pair{"lines", geometry.lines}, {"row_lines", geometry.row_lines}}) {
    if (lines > 0) {
      json[name] = lines;
    }
  }
  json["depth_images"] = run.depth_images;
  json["depth_png_mm_per_unit"] = depth_unit(run.depth);
  json["newest"] = newest_json(run, geometry);
  if (!report.doubts.empty()) {
    json["doubts"] = report.doubts;
  }
  if (report.comparison) {
    const structured_light::CloudComparison& comparison = *report.comparison;
    json["compare"] = {{"file", report.cloud},
                       {"exchange_xy", report.axes.exchange_xy},
                       {"opengl", report.axes.opengl},
                       {"points", comparison.ours},
                       {"points_of_file", comparison.theirs},
                       {"median_mm", number(comparison.median_mm)},
                       {"points_within_1_mm", number(comparison.ours_within)},
                       {"points_of_file_within_1_mm", number(comparison.theirs_within)}};
  }
  if (report.plane) {
    json["plane"] = plane_json(*report.plane);
  }
  return files::json_text(json, 2) + "\n";
}

// One line for each depth image: pair,pixels,x,y,z. If nothing moved, pixels is 0 and the rest is empty.
std::string moved_csv(const std::vector<structured_light::OfImage<structured_light::Foreground>>& all) {
  std::string text = "pair,pixels,x,y,z\n";
  for (const auto& [image, moved] : all) {
    if (moved.pixels == 0) {
      fmt::format_to(std::back_inserter(text), "{},0,,,\n", image);
    } else {
      fmt::format_to(std::back_inserter(text), "{},{},{:.4f},{:.4f},{:.4f}\n", image, moved.pixels, moved.x, moved.y,
                     moved.z);
    }
  }
  return text;
}

}  // namespace

nlohmann::ordered_json device_json(const std::string& uri, const structured_light::DeviceCounts& counts) {
  nlohmann::ordered_json json = {{"uri", uri}};
  for (const driver::CounterName& name : driver::kCounterNames) {
    json[name.key] = counts.counters.*name.field;
  }
  json["incomplete"] = counts.incomplete;
  return json;
}

std::string losses_of(const structured_light::DeviceCounts& counts) {
  return losses_text(counts.counters) +
         (counts.incomplete > 0 ? fmt::format(", incomplete images {}", counts.incomplete) : std::string());
}

ReportPicture write_depth(const structured_light::DepthRun& run, const DepthReport& report,
                          files::OutputFolder& folder) {
  const std::string title =
      fmt::format("depth z, {} of {} pixels", run.shares.of(structured_light::PointState::valid), run.shares.total());
  folder.append("depth.tiff", images::encode_float_tiff("depth.tiff", run.depth));
  folder.append("depth.png", depth_png(run.depth));
  ReportPicture picture = shown_depth(*run.triangulation, run.depth, title);
  folder.append("depth_colour.png", picture.png);
  folder.append("cloud.ply", cloud_ply(*run.triangulation, run.depth, run.light ? &*run.light : nullptr));
  folder.append("shares.csv", shares_csv(run.all_shares));
  if (!run.moved.empty()) {
    folder.append("moved.csv", moved_csv(run.moved));
  }
  if (run.moved_depth) {
    folder.append("moved.tiff", images::encode_float_tiff("moved.tiff", *run.moved_depth));
  }
  folder.append("summary.json", summary(run, report));
  return picture;
}

namespace {

ReportTable shares_table(const structured_light::DepthShares& shares) {
  ReportTable table{.title = "Pixels of the newest depth image", .header = {"state", "pixels", "%"}, .rows = {}};
  for (int i = 0; i < structured_light::kPointStates; ++i) {
    const auto state = static_cast<structured_light::PointState>(i);
    table.rows.push_back({structured_light::name_of(state), std::to_string(shares.of(state)),
                          fmt::format("{:.1f}", 100.0 * static_cast<double>(shares.of(state)) /
                                                    static_cast<double>(std::max<std::size_t>(shares.total(), 1)))});
  }
  return table;
}

// What the pages of depth images share: pixels with a depth, and from where to where it goes.
std::vector<Fact> depth_highlights(const structured_light::DepthShares& shares, const images::FloatImage& depth,
                                   std::size_t images) {
  std::vector<Fact> facts = {
      {"depth_images", "depth images", static_cast<std::int64_t>(images)},
      {"valid", "pixels with a depth",
       fmt::format("{:.1f}", 100 * static_cast<double>(shares.of(structured_light::PointState::valid)) /
                                 static_cast<double>(std::max<std::size_t>(shares.total(), 1))),
       "%"}};
  std::vector<float> z;
  std::copy_if(depth.values.begin(), depth.values.end(), std::back_inserter(z),
               [](float value) { return !std::isnan(value); });
  if (!z.empty()) {
    const auto [low, high] = std::minmax_element(z.begin(), z.end());
    facts.push_back({"z", "z", fmt::format("{:.1f} … {:.1f}", *low, *high), "mm"});
  }
  return facts;
}

}  // namespace

std::string depth_page(const structured_light::DepthRun& run, const DepthReport& report, const ReportPicture& picture) {
  ReportPage page;
  page.title = "Depth image";
  const structured_light::DepthGeometry& geometry = report.setup.geometry;
  page.subtitle =
      fmt::format("{} · {} bits · {}", geometry.rig.empty() ? geometry.calibration : "rig " + geometry.rig,
                  geometry.bits, report.device.empty() ? fmt::format("{} images", report.images) : report.device);
  page.highlights = depth_highlights(run.shares, run.depth, run.depth_images);
  if (report.plane && std::isfinite(report.plane->rms)) {
    page.highlights.push_back({"plane_rms_mm", "distance from the plane, RMS", report.plane->rms, "mm"});
  }
  if (report.comparison) {
    page.highlights.push_back(
        {"median_mm", "median distance from " + report.cloud, report.comparison->median_mm, "mm"});
  }
  page.doubts = report.doubts;
  page.pictures = {picture};
  page.tables = {shares_table(run.shares)};
  page.settings = {
      {"threshold", "threshold of a pair's difference", static_cast<std::int64_t>(report.setup.scanner.threshold)},
      {"median", "median of 3 × 3", std::string(report.setup.scanner.median ? "yes" : "no")}};
  if (geometry.lines > 0) {
    page.settings.push_back({"lines", "projector lines that the codes cover", geometry.lines});
  }
  if (geometry.limits.min_z_mm > 0 || std::isfinite(geometry.limits.max_z_mm)) {
    page.settings.push_back({"limits", "limits of z",
                             fmt::format("{:g} to {:g}", geometry.limits.min_z_mm, geometry.limits.max_z_mm), "mm"});
  }
  return page_html(page);
}

std::string match_page(const MatchReport& report, const structured_light::MatchTable& table,
                       const structured_light::SelfScanner& scanner, const MatchPictures& pictures) {
  ReportPage page;
  page.title = "Depth by self-projected stripes";
  page.subtitle = fmt::format("rig {} · reference {} · {} bits", report.rig, report.reference, report.bits);
  page.highlights = depth_highlights(report.all_shares.back().value, scanner.depth(), report.depth_images);
  page.highlights.insert(page.highlights.end(), report.parts.highlights.begin(), report.parts.highlights.end());
  if (!report.doubt.empty()) {
    page.doubts = {report.doubt};
  }
  page.pictures = {pictures.difference, pictures.depth};
  page.tables = report.parts.tables;
  page.tables.push_back(shares_table(report.all_shares.back().value));
  page.counters = report.line;
  page.settings = {
      {"e", "cells below the reference that are searched (e)", static_cast<std::int64_t>(report.settings.e)},
      {"threshold", "threshold of a pair's difference", static_cast<std::int64_t>(report.threshold)},
      {"missing", "codes of the reference without a match", fmt::format("{:.2f}", 100 * table.missing()), "%"},
      {"doubled", "codes of the reference with several candidates", fmt::format("{:.2f}", 100 * table.doubled()), "%"}};
  page.settings.insert(page.settings.end(), report.parts.settings.begin(), report.parts.settings.end());
  return page_html(page);
}

std::string depth_text(const structured_light::DepthRun& run, const DepthReport& report, const std::string& folder) {
  std::string shares;
  for (int i = 0; i < structured_light::kPointStates; ++i) {
    const auto state = static_cast<structured_light::PointState>(i);
    if (state == structured_light::PointState::valid || run.shares.of(state) > 0) {
      shares += (shares.empty() ? "" : ", ") + structured_light::share_text(run.shares, state);
    }
  }
  const std::string how =
      report.device.empty() ? fmt::format("threshold {}", report.setup.scanner.threshold) : report.device;
  std::string text = fmt::format(
      "{} {} of {}, {} bits, {} → {}\n{}\n", run.depth_images, run.depth_images == 1 ? "depth image" : "depth images",
      images::size_text(run.depth.rows, run.depth.columns), report.setup.geometry.bits, how, folder, shares);
  const auto to = std::back_inserter(text);
  if (report.comparison) {
    const structured_light::CloudComparison& comparison = *report.comparison;
    fmt::format_to(
        to,
        "{}: median distance of our {} points to its {}: {:.3f} mm; within 1 mm: {:.1f} % of ours, {:.1f} % of its\n",
        report.cloud, comparison.ours, comparison.theirs, comparison.median_mm, 100 * comparison.ours_within,
        100 * comparison.theirs_within);
  }
  if (!report.plane) {
    return text;
  }
  const structured_light::PlaneFit& plane = *report.plane;
  if (std::isnan(plane.rms)) {
    fmt::format_to(to, "plane: {} points are too few, or on a line\n", plane.points);
  } else {
    fmt::format_to(to,
                   "plane through {} of {} points: z {:.3f} mm on the axis, leaning by {:.3f}°; residuals {:.3f} mm "
                   "RMS, {:.3f} mm at "
                   "most; rounding to whole codes predicts {:.3f} mm RMS\n",
                   plane.points, plane.points + plane.left_out, plane.z0, tilt_deg(plane), plane.rms, plane.greatest,
                   plane.rounding_rms);
  }
  return text;
}

namespace {

std::string summary(const structured_light::MatchTable& table, const images::FloatImage& depth,
                    const MatchReport& report) {
  nlohmann::ordered_json json{{"rig", report.rig},
                              {"reference", report.reference},
                              {"bits", report.bits},
                              {"e", report.settings.e},
                              {"printed_direction", report.settings.printed_direction},
                              {"printed_window", report.settings.printed_window},
                              {"threshold", report.threshold},
                              {"images", report.images},
                              {"depth_images", report.depth_images},
                              {"depth_png_mm_per_unit", depth_unit(depth)},
                              {"codes_without_match", table.missing()},
                              {"codes_with_several_candidates", table.doubled()}};
  if (!report.doubt.empty()) {
    json["doubts"] = {report.doubt};
  }
  if (report.counts) {
    json["device"] = device_json(report.device, *report.counts);
  }
  if (!report.line.empty()) {
    json["line"] = facts_json(report.line);
  }
  for (int i = 0; i < structured_light::kPointStates; ++i) {
    const auto state = static_cast<structured_light::PointState>(i);
    json["newest"][structured_light::name_of(state)] = report.all_shares.back().value.of(state);
  }
  return files::json_text(json, 2) + "\n";
}

}  // namespace

MatchPictures write_match(const structured_light::MatchTable& table, const structured_light::SelfScanner& scanner,
                          const MatchReport& report, files::OutputFolder& folder) {
  const images::FloatImage& depth = scanner.depth();
  const images::FloatImage& difference = scanner.difference();
  MatchPictures pictures{.depth = shown_depth(scanner.triangulation(), depth, "depth z"), .difference = {}};
  pictures.difference =
      shown_map("difference from the reference, mm", difference,
                difference_scale(difference, report.parts.difference_mm), pictures.depth.map.value().pitch);
  folder.append("depth.tiff", images::encode_float_tiff("depth.tiff", depth));
  folder.append("depth.png", depth_png(depth));
  folder.append("depth_colour.png", pictures.depth.png);
  folder.append("difference.tiff", images::encode_float_tiff("difference.tiff", difference));
  folder.append("difference.png", pictures.difference.png);
  folder.append("cloud.ply", cloud_ply(scanner.triangulation(), depth));
  folder.append("shares.csv", shares_csv(report.all_shares));
  folder.append("summary.json", summary(table, depth, report));
  return pictures;
}

std::string match_text(const structured_light::MatchTable& table, const MatchReport& report,
                       const std::string& folder) {
  const structured_light::DepthShares& newest = report.all_shares.back().value;
  const std::string losses = report.counts ? losses_of(*report.counts) + "; " : std::string();
  return fmt::format(
      "{} depth image{}: {}{} of {} pixels valid → {}\n"
      "of the reference's codes {:.2f} % have no match, {:.2f} % several candidates\n",
      report.depth_images, report.depth_images == 1 ? "" : "s", losses, newest.of(structured_light::PointState::valid),
      newest.total(), folder, 100 * table.missing(), 100 * table.doubled());
}

}  // namespace selfproj::report
