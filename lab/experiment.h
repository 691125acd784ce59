// Runs the experiments of the thesis by their names, prints them, and writes their files.
#ifndef SELFPROJ_LAB_EXPERIMENT_H
#define SELFPROJ_LAB_EXPERIMENT_H

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sim/scene/renderer.h"
#include "sim/scene/virtual_capture.h"
#include "sim/scene/world.h"

namespace selfproj::lab {

// The options of an experiment.
struct ExperimentOptions {
  std::string name;                   // A1, A2, B1 to B4, B7, B8, robustness, remedies, parts
  std::string rig = {};               // built-in or a file; empty: that of the experiment
  std::string out = {};               // folder for the report and the files behind it; empty: none
  std::vector<std::string> off = {};  // names of kErrorSources
  sim::World world = {};              // disturbances of the images

  [[nodiscard]] sim::RenderOptions render() const {
    sim::RenderOptions result = sim::options_without(off);
    result.world = world;
    return result;
  }

  // For robustness, and but for the next two remedies:
  int cameras = 40;
  int strengths = 5;
  sim::WorldFile parameters = {};  // of the disturbances
  int coarser = 1;

  int seeds = 2;  // for remedies: on which each is measured

  // For A1, A2 and, but for the last three, parts:
  bool null_test = false;                // Route::null_test
  std::uint64_t perturbed_rig_seed = 1;  // SectionOptions::perturbed_rig_seed
  bool residual = true;                  // measure the reference's own residual and remove it
  bool sources = false;                  // also make the table of error sources
  std::optional<int> every = {};  // take only every n-th frame; nothing: every one, and every 70th for robustness

  // For parts:
  std::uint64_t parts = 2000;  // PartDetectionOptions
  std::uint64_t good_parts = 1000;
  std::uint64_t parts_seed = 2;
  bool verdict = false;
  std::uint64_t line_parts = 0;

  // For B1:
  int paths = 10;               // GrayMotionOptions::paths
  std::uint64_t path_seed = 0;  // GrayMotionOptions::path_seed

  // For B2:
  int pools = 6;                // GrayMotionOptions::pools
  std::uint64_t pool_seed = 0;  // GrayMotionOptions::pool_seed

  // For B4, B7 and B8:
  sim::ScanMethod scan = sim::ScanMethod::lines;
  std::optional<int> e = {};  // e of (4.20); nothing: that of the experiment
};

// Prints the experiment's tables and writes its files. Throws UserError about options, rig and folder, and CheckFailed
// if a goal of the project is not reached.
void run_experiment(const ExperimentOptions& options);

}  // namespace selfproj::lab

#endif  // SELFPROJ_LAB_EXPERIMENT_H
