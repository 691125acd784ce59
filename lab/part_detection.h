// Experiment "parts": which planted defects a running line finds, and how often it finds one where there is none.
#ifndef SELFPROJ_LAB_PART_DETECTION_H
#define SELFPROJ_LAB_PART_DETECTION_H

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host/images/image_files.h"
#include "host/report/report.h"
#include "sim/scene/renderer.h"

namespace selfproj::lab {

struct PartDetectionOptions {
  sim::RenderOptions render;
  std::uint64_t parts = 2000;            // with planted defects
  std::uint64_t good_parts = 1000;       // without, for the false alarms
  std::uint64_t learn_parts = 30;        // from which the tolerance is learned; other parts, of another seed
  std::uint64_t seed = 2;                // of the parts that are judged; the learned ones have seed - 1
  std::uint64_t perturbed_rig_seed = 1;  // of the rig that takes the images
  bool verdict =
      false;  // also by moments (VerdictRun); parts are shifted by up to 2 mm, and have the goal's defect alone
  bool null_test = false;  // the rig is known perfectly, and the good part's shape
  int threads = 0;         // 0: one for each core
  // Of how many parts, as many good ones as ones with the goal's defect, the images are in `line` of the result; these
  // parts all lie alike, and have their own noise.
  std::uint64_t line_parts = 0;
};

// How many defects were planted and found.
struct DetectionCount {
  std::uint64_t planted = 0;
  std::uint64_t found = 0;

  void add(bool is_found) {
    ++planted;
    found += is_found ? 1 : 0;
  }
  [[nodiscard]] double share() const {
    return planted > 0 ? static_cast<double>(found) / static_cast<double>(planted) : 0;
  }
};

// What the verdict by moments makes of the same parts, each judged where the host has placed it.
struct MomentDetection {
  DetectionCount of_host;           // of the goal's defects that the host finds, on the surface that is judged
  DetectionCount of_host_at_edges;  // of those that it finds and that reach into the strips along edges and walls
  DetectionCount of_others;         // of those that it does not find, or does not judge
  std::uint64_t good_parts = 0;
  std::uint64_t false_parts = 0;    // of these with a defect
  std::vector<std::string> missed;  // where those of the host lay that it did not find
};

// What a user of the product has: files that his commands take.
struct PartLine {
  std::string rig_yaml, reference_csv, tolerance_yaml;
  std::vector<images::Image> good, bad;  // frames of the good parts, and of those with a defect, one after another
};

struct PartDetectionResult {
  DetectionCount goal;              // kGoalSize, kGoalDepth, on the surface that is judged
  DetectionCount goal_at_edges;     // those that reach into the strips along edges and walls, which is not judged
  std::uint64_t parts = 0;          // all that were judged
  std::uint64_t false_defects = 0;  // where none was planted, on all parts
  std::uint64_t false_parts = 0;    // parts with such a defect
  std::uint64_t inconclusive = 0;
  MomentDetection moments;
  std::vector<report::ReportTable> tables;
  std::vector<std::string> not_reached;  // one line for each goal that is not reached
  std::string data;                      // all figures as numbers, JSON
  report::ReportPage page;
  PartLine line;
};

// The goals.
inline constexpr double kMinFound = 0.995;
inline constexpr double kMaxFalseParts = 0.001;
inline constexpr double kMinFoundOfHost = 0.999;  // by moments, of what the host finds; and no false alarm

// `progress` gets the number of images and parts done and of all.
PartDetectionResult run_part_detection(const PartDetectionOptions& options,
                                       const std::function<void(std::size_t, std::size_t)>& progress);

}  // namespace selfproj::lab

#endif  // SELFPROJ_LAB_PART_DETECTION_H
