#include "host/calibration/calibration_output.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace selfproj {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegreesARadian = 180 / std::numbers::pi;
constexpr std::array<const char*, kLensParameters> kLensNames{"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"};

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
  const Lens& l = report.calibration.projector;
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
  json["greatest_angle_between_poses_deg"] = report.greatest_angle_deg;
  json["mean_distance_mm"] = report.mean_distance_mm;
  for (const PoseReport& pose : report.poses) {
    Json entry{{"name", pose.name}, {"decoded_share", pose.decoded_share}, {"corners", pose.corners.size()}};
    entry["used"] = pose.reason.empty() ? pose.used() : 0;
    if (pose.reason.empty()) {
      entry["angle_deg"] = pose.angle_deg;
      entry["camera_rms_px"] = pose.camera_rms;
      entry["projector_rms_px"] = pose.projector_rms;
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
  return json.dump(2) + "\n";
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
        "the pixels decoded\n",
        pose.name, pose.used(), pose.corners.size(), pose.camera_rms, pose.projector_rms, pose.angle_deg,
        100 * pose.decoded_share);
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

}  // namespace selfproj
