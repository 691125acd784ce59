#include "host/report/match_output.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>

#include "host/images/float_image.h"
#include "host/report/depth_output.h"
#include "host/report/depth_summary.h"
#include "host/report/facts_json.h"
#include "host/report/map_picture.h"

namespace selfproj {
namespace {

std::string summary(const MatchTable& table, const MatchReport& report) {
  nlohmann::ordered_json json{{"rig", report.rig},
                              {"reference", report.reference},
                              {"bits", report.bits},
                              {"e", report.settings.e},
                              {"printed_direction", report.settings.printed_direction},
                              {"printed_window", report.settings.printed_window},
                              {"threshold", report.threshold},
                              {"images", report.images},
                              {"depth_images", report.depth_images},
                              {"codes_without_match", table.missing()},
                              {"codes_with_several_candidates", table.doubled()}};
  if (report.counts) {
    json["device"] = device_json(report.device, *report.counts);
  }
  if (!report.line.empty()) {
    json["line"] = facts_json(report.line);
  }
  for (int i = 0; i < kPointStates; ++i) {
    const auto state = static_cast<PointState>(i);
    json["newest"][name_of(state)] = report.all_shares.back().value.of(state);
  }
  return json.dump(2) + "\n";
}

}  // namespace

MatchPictures write_match(const Rig& rig, const MatchTable& table, const SelfScanner& scanner,
                          const MatchReport& report, OutputFolder& folder) {
  const double pitch = rig.plane_z_mm * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
  const FloatImage& depth = scanner.depth();
  const FloatImage& difference = scanner.difference();
  MatchPictures pictures{.depth = depth_picture(scanner.triangulation(), depth, "depth z"),
                         .difference = labelled_map_png(difference, difference_scale(difference), {pitch, pitch},
                                                        "difference from the reference, mm")};
  folder.append("depth.tiff", encode_float_tiff("depth.tiff", depth));
  folder.append("depth.png", depth_png(depth));
  folder.append("depth_colour.png", pictures.depth);
  folder.append("difference.tiff", encode_float_tiff("difference.tiff", difference));
  folder.append("difference.png", pictures.difference);
  folder.append("cloud.ply", cloud_ply(scanner.triangulation(), depth));
  folder.append("shares.csv", shares_csv(report.all_shares));
  folder.append("summary.json", summary(table, report));
  return pictures;
}

std::string match_text(const MatchTable& table, const MatchReport& report, const std::string& folder) {
  const DepthShares& newest = report.all_shares.back().value;
  const std::string losses = report.counts ? losses_of(*report.counts) + "; " : std::string();
  return fmt::format(
      "{} depth images: {}{} of {} pixels valid; codes without a match {:.2f} %, with several candidates {:.2f} % "
      "→ {}\n",
      report.depth_images, losses, newest.of(PointState::valid), newest.total(), 100 * table.missing(),
      100 * table.doubled(), folder);
}

}  // namespace selfproj
