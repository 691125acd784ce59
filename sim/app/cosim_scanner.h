// selfproj-sim cosim with a scene of rig B: pattern images through camera, board and driver to depth images.
#ifndef SELFPROJ_SIM_APP_COSIM_SCANNER_H
#define SELFPROJ_SIM_APP_COSIM_SCANNER_H

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/report/report.h"
#include "host/rig/rig.h"
#include "host/structured_light/moved.h"
#include "sim/platform/platform.h"
#include "sim/scene/renderer.h"

namespace selfproj {

struct ScannerCosimOptions {
  std::string scene;
  std::string engine = "rtl";
  std::string rig = "scanner";
  std::optional<int> threshold;  // of the binarization (4.15); nothing: the rig's
  std::optional<std::int64_t> seed;
  RenderOptions render = {};
  std::string without = {};  // the same in words
  std::size_t first = 1;
  std::optional<std::size_t> count;
  int bits = 8;
  bool median = true;
  int e = 0;                        // (4.20), of self-projected structured light alone
  double min_difference_mm = 10;    // from the background, of what counts as moved
  SteadySettings steady = {10, 6};  // likewise
  int bus_stall = 0;
  std::string out = {};
  std::vector<std::size_t> pictures = {};  // frames of the run, from 1; empty: four of them
  std::string packets = {};
};

// Whether a scene is one of rig B.
bool is_scanner_scene(const std::string& scene);

// Throws UserError, and CheckFailed where something differs from the model.
void run_scanner_cosim(const ScannerCosimOptions& options);

// What runs with a scanner have in common. All throw UserError about the option.
// The platform for codes of such a rig.
PlatformOptions scanner_platform(const ScannerCosimOptions& options, const Rig& rig);
// Frames of the run, where the scene has `total`.
std::size_t frames_of_run(const ScannerCosimOptions& options, std::size_t total);
// Of the frames of a run those that complete code images and are to be shown.
std::vector<std::size_t> pictured_frames(const ScannerCosimOptions& options, std::size_t total);
// summary.json of a page.
std::string summary_json(const ReportPage& page);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_APP_COSIM_SCANNER_H
