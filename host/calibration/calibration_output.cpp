#include "host/calibration/calibration_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/files/json_text.h"

namespace selfproj::calibration {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegreesARadian = 180 / std::numbers::pi;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json lens_json(const LensParameters& value, const LensParameters& deviation, int free) {
  Json json;
  for (std::size_t i = 0; i < kLensParameters; ++i) {
    const bool estimated = i < 4 + static_cast<std::size_t>(free);
    json[kLensNames[i]] = {{"value", value[i]}, {"sd", estimated ? number(deviation[i]) : Json("fixed")}};
  }
  return json;
}

// The projector's lens for rows that count from its first row. During the fit, rows of a mirrored projector count from
// the last one.
LensParameters projector_lens(const CalibrationReport& report) {
  const rig::Lens& l = report.calibration.projector;
  return {l.fx, l.fy, l.cx, l.cy, l.k[0], l.k[1], l.k[2], l.k[3], l.k[4]};
}

std::string lens_text(const char* name, const LensParameters& value, const LensParameters& deviation, int free) {
  std::string text = fmt::format("{:10}", name);
  for (std::size_t i = 0; i < 4; ++i) {
    text += fmt::format(" {} {:.2f} ± {:.2f}{}", kLensNames[i], value[i], deviation[i], i < 3 ? "," : " px\n");
  }
  if (free > 0) {
    text += fmt::format("{:10}", "");
    for (std::size_t i = 4; i < 4 + static_cast<std::size_t>(free); ++i) {
      text += fmt::format(" {} {:.4f} ± {:.4f}{}", kLensNames[i], value[i], deviation[i],
                          i + 1 < 4 + static_cast<std::size_t>(free) ? "," : "\n");
    }
  }
  return text;
}

Json asked(int free) { return free == FreeDistortion::kByData ? Json("auto") : Json(free); }

Json model_json(const ModelChoice& model) {
  Json json{{"camera_distortion", model.free.camera}, {"projector_distortion", model.free.projector}};
  json["steps"] = Json::array();
  for (const ModelStep& step : model.steps) {
    json["steps"].push_back({{"camera_distortion", step.free.camera},
                             {"projector_distortion", step.free.projector},
                             {"chi_square", number(step.chi_square)},
                             {"limit", step.limit},
                             {"taken", step.taken}});
  }
  json["starts"] = {{"agreeing", model.agreeing}, {"worse", model.worse}, {"failed", model.failed}};
  return json;
}

Json checks_json(const std::vector<CheckReport>& checks) {
  Json json = Json::array();
  for (const CheckReport& check : checks) {
    Json entry{{"name", check.name}, {"corners", check.corners}};
    if (check.reason.empty()) {
      entry["camera_rms_px"] = check.camera_rms;
      entry["projector_rms_px"] = check.projector_rms;
      entry["scale_off"] = check.scale;
      entry["point_rms_mm"] = check.point_rms_mm;
    } else {
      entry["left_out"] = check.reason;
    }
    json.push_back(entry);
  }
  return json;
}

std::string checks_text(const std::vector<CheckReport>& checks) {
  std::string text;
  for (const CheckReport& check : checks) {
    text += check.reason.empty()
                ? fmt::format(
                      "check      {}: {} corners, RMS {:.3f} px in the camera, {:.3f} px in the projector\n"
                      "           triangulated: size {:+.3f} %, corners {:.3f} mm RMS off the chessboard\n",
                      check.name, check.corners, check.camera_rms, check.projector_rms, 100 * check.scale,
                      check.point_rms_mm)
                : fmt::format("check      {}: cannot be used: {}\n", check.name, check.reason);
  }
  return text;
}

const char* method_name(CornerMethod method) { return method == CornerMethod::homography ? "homography" : "direct"; }

}  // namespace

std::string corner_table(const CalibrationReport& report) {
  std::string table = "pose,corner,x,y,u,v,sd,used,dx,dy,du,dv,reason\n";
  const auto numbers = [](double a, double b, int digits) {
    return std::isnan(a) ? std::string(",") : fmt::format("{:.{}f},{:.{}f}", a, digits, b, digits);
  };
  for (const PoseReport& pose : report.poses) {
    for (std::size_t i = 0; i < pose.corners.size(); ++i) {
      const Corner& c = pose.corners[i];
      const bool used = c.used && pose.reason.empty();
      fmt::format_to(std::back_inserter(table), "{},{},{},{},{},{},{},\"{}\"\n", pose.name, i,
                     numbers(c.camera.x, c.camera.y, 4), numbers(c.projector.x, c.projector.y, 4),
                     std::isfinite(c.sd_px) ? fmt::format("{:.4f}", c.sd_px) : "", used ? 1 : 0,
                     used ? fmt::format("{},{}", numbers(c.camera_residual[0], c.camera_residual[1], 4),
                                        numbers(c.projector_residual[0], c.projector_residual[1], 4))
                          : ",,,",
                     !pose.reason.empty() ? pose.reason : c.reason);
    }
  }
  return table;
}

std::string report_json(const CalibrationReport& report) {
  const CalibrateSettings& settings = report.settings;
  const BundleResult& found = report.bundle;
  Json json;
  json["settings"] = {{"board", {settings.chessboard.columns, settings.chessboard.rows}},
                      {"square_mm", settings.chessboard.square_mm},
                      {"corners", method_name(settings.corners.method)},
                      {"window_px", settings.corners.window_px},
                      {"reject", settings.reject},
                      {"min_corners", settings.min_corners},
                      {"bent", settings.bent},
                      {"camera_distortion", asked(settings.free.camera)},
                      {"projector_distortion", asked(settings.free.projector)}};
  json["model"] = model_json(report.model);
  json["board"] = {{"range_mm", report.board_range_mm},
                   {"bend_sd_mm", found.bundle.noise.bend},
                   {"stretch_sd_mm", found.bundle.noise.stretch},
                   {"bend_of_single_poses_sd_mm", found.bundle.noise.own}};
  json["noise_px"] = {{"camera", found.bundle.noise.camera}, {"projector", found.bundle.noise.projector}};
  json["rms_px"] = {{"camera", found.camera_rms},
                    {"projector", found.projector_rms},
                    {"stereo", found.rms},
                    {"camera_alone", number(report.camera_alone_rms)},
                    {"projector_alone", number(report.projector_alone_rms)}};
  json["camera"] = lens_json(found.bundle.camera, found.deviation.camera, report.model.free.camera);
  json["projector"] = lens_json(projector_lens(report), found.deviation.projector, report.model.free.projector);
  json["projector"]["mirrored"] = report.mirrored;
  const Pose& stereo = found.bundle.stereo;
  for (int i = 0; i < 3; ++i) {
    const std::string axis(1, "xyz"[i]);
    json["pose"]["rotation_" + axis + "_deg"] = {{"value", kDegreesARadian * stereo.rotation[i]},
                                                 {"sd", number(kDegreesARadian * found.deviation.stereo.rotation[i])}};
    json["pose"]["translation_" + axis + "_mm"] = {{"value", stereo.translation[i]},
                                                   {"sd", number(found.deviation.stereo.translation[i])}};
  }
  json["pose"]["baseline_mm"] = {{"value", cv::norm(stereo.translation)}, {"sd", number(found.baseline_deviation)}};
  if (report.belt) {
    const BeltReport& belt = *report.belt;
    json["belt"] = {{"normal", belt.pose.normal},
                    {"plane_z_mm", belt.plane_z_mm},
                    {"lean_sd_deg", number(belt.lean_deg_sd)},
                    {"true_over_given_squares", {{"value", belt.squares}, {"sd", number(belt.squares_sd)}}}};
    if (belt.moved) {
      json["belt"]["direction"] = belt.pose.direction;
      json["belt"]["chessboard_mm_per_belt_mm"] = belt.way;
    }
  }
  json["coverage"] = {{"camera", report.camera_coverage}, {"projector", report.projector_coverage}};
  json["max_angle_between_poses_deg"] = report.max_angle_deg;
  json["mean_distance_mm"] = report.mean_distance_mm;
  for (const PoseReport& pose : report.poses) {
    Json entry{{"name", pose.name}, {"decoded_share", pose.decoded_share}, {"corners", pose.corners.size()}};
    entry["used"] = pose.reason.empty() ? pose.used() : 0;
    if (pose.reason.empty()) {
      entry["angle_deg"] = pose.angle_deg;
      entry["camera_rms_px"] = pose.camera_rms;
      entry["projector_rms_px"] = pose.projector_rms;
      if (pose.by_squares) {
        entry["found_by"] = kBySquares;
      }
    } else {
      entry["left_out"] = pose.reason;
    }
    Json left_out = Json::array();
    for (std::size_t i = 0; i < pose.corners.size(); ++i) {
      if (!pose.corners[i].used) {
        left_out.push_back({{"corner", i}, {"reason", pose.corners[i].reason}});
      }
    }
    entry["corners_left_out"] = left_out;
    json["poses"].push_back(entry);
  }
  json["checks"] = checks_json(report.checks);
  json["warnings"] = report.warnings;
  return files::json_text(json, 2) + "\n";
}

std::string report_text(const CalibrationReport& report) {
  const BundleResult& found = report.bundle;
  std::string text;
  for (const PoseReport& pose : report.poses) {
    if (!pose.reason.empty()) {
      text += fmt::format("{}: left out: {}\n", pose.name, pose.reason);
      continue;
    }
    text += fmt::format(
        "{}: {} of {} corners, RMS {:.3f} px in the camera, {:.3f} px in the projector, turned by {:.1f}°, {:.1f} % of "
        "the pixels decoded{}\n",
        pose.name, pose.used(), pose.corners.size(), pose.camera_rms, pose.projector_rms, pose.angle_deg,
        100 * pose.decoded_share, pose.by_squares ? fmt::format(", found by {}", kBySquares) : "");
    for (std::size_t i = 0; i < pose.corners.size(); ++i) {
      if (!pose.corners[i].used) {
        text += fmt::format("  corner {} left out: {}\n", i, pose.corners[i].reason);
      }
    }
  }
  const FreeDistortion& free = report.model.free;
  text += lens_text("camera", found.bundle.camera, found.deviation.camera, free.camera);
  text += lens_text("projector", projector_lens(report), found.deviation.projector, free.projector);
  const Pose& stereo = found.bundle.stereo;
  const cv::Vec3d& t = stereo.translation;
  const cv::Vec3d& dt = found.deviation.stereo.translation;
  const cv::Vec3d turn = kDegreesARadian * stereo.rotation;
  const cv::Vec3d dturn = kDegreesARadian * found.deviation.stereo.rotation;
  text += fmt::format("pose       rotation {:.4f} ± {:.4f}, {:.4f} ± {:.4f}, {:.4f} ± {:.4f}°\n", turn[0], dturn[0],
                      turn[1], dturn[1], turn[2], dturn[2]);
  text +=
      fmt::format("           T {:.3f} ± {:.3f}, {:.3f} ± {:.3f}, {:.3f} ± {:.3f} mm; baseline {:.3f} ± {:.3f} mm\n",
                  t[0], dt[0], t[1], dt[1], t[2], dt[2], cv::norm(t), found.baseline_deviation);
  text += fmt::format(
      "RMS        camera {:.3f} px ({:.3f} alone), projector {:.3f} px ({:.3f} alone), stereo {:.3f} px\n",
      found.camera_rms, report.camera_alone_rms, found.projector_rms, report.projector_alone_rms, found.rms);
  if (report.settings.bent) {
    text += fmt::format("board      bent by {:.3g} mm; a single pose by {:.2g} mm RMS more\n", report.board_range_mm,
                        found.bundle.noise.own);
  }
  if (report.belt) {
    const BeltReport& belt = *report.belt;
    text += fmt::format(
        "belt       {:.3f} mm away, tilt known to ± {:.4f}°; squares are {:.6f} ± {:.6f} of the given size\n",
        belt.plane_z_mm, belt.lean_deg_sd, belt.squares, belt.squares_sd);
    if (belt.moved) {
      text += fmt::format("           runs at {:.4f}° to the camera's columns; moves {:.5f} mm for each given mm\n",
                          kDegreesARadian * std::atan2(belt.pose.direction[0], belt.pose.direction[1]), belt.way);
    }
  }
  text += fmt::format("starts     {} of {} reach this fit, {} reach worse ones\n", report.model.agreeing,
                      report.model.agreeing + report.model.worse + report.model.failed, report.model.worse);
  text += checks_text(report.checks);
  if (report.mirrored) {
    text += "the projector shows its image mirrored: its fy is negative\n";
  }
  for (const std::string& warning : report.warnings) {
    text += fmt::format("warning: {}\n", warning);
  }
  return text;
}

namespace {

constexpr int kPanel = 520;  // the longer side of an image in a picture
constexpr int kGap = 24;
constexpr int kTitle = 28;
const cv::Scalar kInk(40, 40, 40);
const cv::Scalar kGrid(215, 215, 215);

cv::Scalar colour_of(std::size_t pose) {
  constexpr std::array<std::array<int, 3>, 8> kColours{{{180, 119, 31},
                                                        {14, 127, 255},
                                                        {44, 160, 44},
                                                        {40, 39, 214},
                                                        {189, 103, 148},
                                                        {75, 86, 140},
                                                        {194, 119, 227},
                                                        {127, 127, 127}}};
  const auto& c = kColours[pose % kColours.size()];
  return {static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2])};
}

void write(cv::Mat& picture, const std::string& text, cv::Point at, const cv::Scalar& colour = kInk) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.42, colour, 1, cv::LINE_AA);
}

std::string png_of(const cv::Mat& picture) {
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".png", picture, bytes)) {
    throw std::runtime_error("calibration: a picture cannot be written as PNG");
  }
  return {bytes.begin(), bytes.end()};
}

// Camera or projector, for code that treats both alike.
struct Instrument {
  const char* name;
  cv::Point2d Corner::*place;
  cv::Vec2d Corner::*residual;
  int columns, rows;
  double rms;
  double coverage;
};

std::array<Instrument, 2> instruments(const CalibrationReport& report) {
  const rig::Calibration& c = report.calibration;
  return {{{"camera", &Corner::camera, &Corner::camera_residual, c.camera_columns, c.camera_rows,
            report.bundle.camera_rms, report.camera_coverage},
           {"projector", &Corner::projector, &Corner::projector_residual, c.projector_columns, c.projector_rows,
            report.bundle.projector_rms, report.projector_coverage}}};
}

// A rectangle of the picture that shows an image, to scale.
struct Frame {
  cv::Rect area;
  double scale;

  [[nodiscard]] cv::Point at(const cv::Point2d& pixel) const {
    return {area.x + static_cast<int>(std::lround((pixel.x + 0.5) * scale)),
            area.y + static_cast<int>(std::lround((pixel.y + 0.5) * scale))};
  }
};

Frame frame_of(const Instrument& what, int left, int top) {
  const double scale = static_cast<double>(kPanel) / std::max(what.columns, what.rows);
  return {{left, top, static_cast<int>(std::lround(what.columns * scale)),
           static_cast<int>(std::lround(what.rows * scale))},
          scale};
}

int left_of(std::size_t panel) { return kGap + static_cast<int>(panel) * (kPanel + kGap); }
constexpr int kWidth = 3 * kGap + 2 * kPanel;

int tallest(const std::array<Instrument, 2>& both) {
  int height = 0;
  for (const Instrument& what : both) {
    height = std::max(height, frame_of(what, 0, 0).area.height);
  }
  return height;
}

// The value that `share` of the numbers do not exceed.
double quantile(std::vector<double> values, double share) {
  if (values.empty()) {
    return 0;
  }
  const auto i = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + i, values.end());
  return values[static_cast<std::size_t>(i)];
}

// The greatest of 1, 2 or 5 times a power of ten that is at most `limit`.
double round_step(double limit) {
  const double power = std::pow(10, std::floor(std::log10(limit)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= limit) {
      return factor * power;
    }
  }
  return power;
}

template <class Function>
void for_each_used(const CalibrationReport& report, const Function& function) {
  for (std::size_t p = 0; p < report.poses.size(); ++p) {
    if (report.poses[p].reason.empty()) {
      for (const Corner& corner : report.poses[p].corners) {
        if (corner.used) {
          function(p, corner);
        }
      }
    }
  }
}

void draw_scatter(cv::Mat& picture, const CalibrationReport& report, const Instrument& what, int left, int top) {
  std::vector<double> lengths;
  for_each_used(report, [&](std::size_t, const Corner& c) { lengths.push_back(cv::norm(c.*what.residual)); });
  const double reach = std::max(1e-6, 1.05 * quantile(lengths, 1));
  const double scale = 0.5 * kPanel / reach;
  const cv::Point centre(left + kPanel / 2, top + kPanel / 2);
  const double step = round_step(0.6 * reach);
  for (int k = -5; k <= 5; ++k) {
    const int off = static_cast<int>(std::lround(k * step * scale));
    if (std::abs(off) <= kPanel / 2) {
      cv::line(picture, {centre.x + off, top}, {centre.x + off, top + kPanel}, kGrid);
      cv::line(picture, {left, centre.y + off}, {left + kPanel, centre.y + off}, kGrid);
    }
  }
  for_each_used(report, [&](std::size_t pose, const Corner& c) {
    const cv::Vec2d r = c.*what.residual;
    cv::circle(picture,
               {centre.x + static_cast<int>(std::lround(r[0] * scale)),
                centre.y + static_cast<int>(std::lround(r[1] * scale))},
               2, colour_of(pose), cv::FILLED, cv::LINE_AA);
  });
  cv::rectangle(picture, {left, top, kPanel, kPanel}, kInk);
  write(picture, fmt::format("{}: residuals, RMS {:.3f} px; a square is {:g} px", what.name, what.rms, step),
        {left, top - 8});
}

void draw_arrows(cv::Mat& picture, const CalibrationReport& report, const Instrument& what, int left, int top) {
  constexpr double kLongest = 30;  // length in the picture of the 98 % quantile
  std::vector<double> lengths;
  for_each_used(report, [&](std::size_t, const Corner& c) { lengths.push_back(cv::norm(c.*what.residual)); });
  const Frame frame = frame_of(what, left, top);
  const double factor = kLongest / std::max(1e-9, quantile(lengths, 0.98));
  for_each_used(report, [&](std::size_t pose, const Corner& c) {
    const cv::Point from = frame.at(c.*what.place);
    const cv::Vec2d r = factor * (c.*what.residual);
    cv::arrowedLine(picture, from,
                    {from.x + static_cast<int>(std::lround(r[0])), from.y + static_cast<int>(std::lround(r[1]))},
                    colour_of(pose), 1, cv::LINE_AA, 0, 0.25);
  });
  cv::rectangle(picture, frame.area, kInk);
  write(picture,
        fmt::format("{}: where they are, {:.0f} times as long as in the image", what.name, factor / frame.scale),
        {left, top - 8});
}

void draw_legend(cv::Mat& picture, const CalibrationReport& report, int top) {
  for (std::size_t p = 0; p < report.poses.size(); ++p) {
    const PoseReport& pose = report.poses[p];
    const cv::Point at(kGap, top + 18 * static_cast<int>(p));
    cv::circle(picture, {at.x + 4, at.y - 4}, 4, colour_of(p), cv::FILLED, cv::LINE_AA);
    write(picture,
          pose.reason.empty() ? fmt::format("{}: {} of {} corners used, turned by {:.1f} degrees", pose.name,
                                            pose.used(), pose.corners.size(), pose.angle_deg)
                              : fmt::format("{}: left out, {}", pose.name, pose.reason),
          {at.x + 16, at.y});
  }
}

int legend_height(const CalibrationReport& report) { return 18 * static_cast<int>(report.poses.size()) + kGap; }

}  // namespace

std::string coverage_picture(const CalibrationReport& report) {
  const std::array<Instrument, 2> both = instruments(report);
  const int below = kTitle + tallest(both) + kGap;
  cv::Mat picture(below + legend_height(report), kWidth, CV_8UC3, cv::Scalar::all(255));
  for (std::size_t i = 0; i < both.size(); ++i) {
    const Instrument& what = both[i];
    const Frame frame = frame_of(what, left_of(i), kTitle);
    std::vector<cv::Point> points;
    for_each_used(report, [&](std::size_t, const Corner& c) { points.push_back(frame.at(c.*what.place)); });
    std::vector<cv::Point> hull;
    cv::convexHull(points, hull);
    cv::fillConvexPoly(picture, hull, cv::Scalar(240, 245, 235), cv::LINE_AA);
    for (std::size_t p = 0; p < report.poses.size(); ++p) {
      for (const Corner& corner : report.poses[p].corners) {
        const cv::Point2d place = corner.*what.place;
        if (std::isnan(place.x)) {
          continue;
        }
        if (corner.used && report.poses[p].reason.empty()) {
          cv::circle(picture, frame.at(place), 2, colour_of(p), cv::FILLED, cv::LINE_AA);
        } else {
          cv::drawMarker(picture, frame.at(place), colour_of(p), cv::MARKER_TILTED_CROSS, 7, 1, cv::LINE_AA);
        }
      }
    }
    cv::rectangle(picture, frame.area, kInk);
    write(picture,
          fmt::format("{}: {} x {}, {:.0f} % within the corners' hull", what.name, what.columns, what.rows,
                      100 * what.coverage),
          {frame.area.x, kTitle - 8});
  }
  draw_legend(picture, report, below + 8);
  return png_of(picture);
}

std::string residual_picture(const CalibrationReport& report) {
  const std::array<Instrument, 2> both = instruments(report);
  const int arrows = kTitle + kPanel + kGap + kTitle;
  const int below = arrows + tallest(both) + kGap;
  cv::Mat picture(below + legend_height(report), kWidth, CV_8UC3, cv::Scalar::all(255));
  for (std::size_t i = 0; i < both.size(); ++i) {
    draw_scatter(picture, report, both[i], left_of(i), kTitle);
    draw_arrows(picture, report, both[i], left_of(i), arrows);
  }
  draw_legend(picture, report, below + 8);
  return png_of(picture);
}

}  // namespace selfproj::calibration
