// Structured light measured in simulation: a reference scanned, patterns projected, depth images compared with the
// truth. The experiment B4 of the thesis, and what those of moving_things.h need, too.
#ifndef SELFPROJ_SIM_EXPERIMENT_STRUCTURED_LIGHT_H
#define SELFPROJ_SIM_EXPERIMENT_STRUCTURED_LIGHT_H

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host/io/float_image.h"
#include "host/io/image_files.h"
#include "host/report/report.h"
#include "host/rig/rig.h"
#include "host/structured_light/match_table.h"
#include "host/structured_light/point_scan.h"
#include "host/structured_light/self_reference.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"

namespace selfproj {

using ProgressOfImages = std::function<void(std::size_t done, std::size_t all)>;

// Scans the scene with the simulated camera: 768 + 1024 lines, or Gray codes along both axes (those of `selfproj
// pattern gray`). `done` is called after each image.
ProjectorPoints scan_points(const Rig& rig, const Scene& scene, const RenderOptions& options, bool gray_codes,
                            const std::function<void()>& done);

// A number in a table; a dash where there is none.
std::string figure_text(double value, int digits = 2);

// A pattern of light 0..1 as the 8-bit image that a projector is given.
Image pattern_image(const FloatImage& pattern);

// The camera's images of a still scene under the patterns, one after another from frame `first` on.
std::vector<Image> images_of(const Rig& rig, const Scene& scene, const RenderOptions& options,
                             const std::vector<FloatImage>& patterns, int first = 0);

// What is matched of the true codes of a scene: for every pixel on which the projector's light falls, whose true place
// lies within the window.
struct MatchShares {
  std::size_t pixels = 0;
  double wrong = 0;      // share of them whose match is another place: by more than half the cell and a line
  double none = 0;       // share without a match
  std::size_t far = 0;   // pixels 2^m cells or more from a step of the reference, in the camera's image
  double far_wrong = 0;  // share of those
};
MatchShares match_shares(const Rig& rig, const SelfReference& reference, const MatchSettings& settings,
                         const FloatImage& true_z, const FloatImage& reference_z);

struct StructuredLightOptions {
  Rig rig;
  RenderOptions render;
  bool gray_scan = false;
  int e = 8;
  Stripes stripes;
  std::vector<int> conventional_bits{8, 7, 6, 5, 4};
};

// Lines, the central ones of the projector, over which the conventional method has its codes.
constexpr int kCodedLines = 512;

// An experiment's tables, pictures and what does not hold of what is wanted.
struct StructuredLightResult {
  std::vector<ReportTable> tables;
  std::vector<std::string> not_reached;
  ReportPage page;
  FloatImage depth, difference, truth;  // mm
  std::string series;                   // CSV of what was measured in every depth image; empty: nothing moves
};

// B4.
StructuredLightResult run_cuboids(const StructuredLightOptions& options, const ProgressOfImages& progress);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_STRUCTURED_LIGHT_H
