// Experiments A1 and A2 in simulation, with published and measured figures side by side.
#ifndef SELFPROJ_LAB_SECTION_EXPERIMENT_H
#define SELFPROJ_LAB_SECTION_EXPERIMENT_H

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host/report/report.h"
#include "host/rig/rig.h"
#include "lab/learned_rig.h"
#include "lab/section_figures.h"
#include "sim/cosim/light_section.h"
#include "sim/scene/renderer.h"

namespace selfproj {

// How the experiments know rig and good part. The thesis's way: the rig is calibrated from images and the good part is
// scanned. A null test knows both perfectly, so that only the errors of the method remain.
enum class Route { learned, null_test };

struct SectionOptions {
  Rig rig;  // as drawn
  RenderOptions render;
  Route route = Route::learned;     // learned: null tests are made as well
  std::uint64_t real_rig_seed = 1;  // of the rig that takes the images on route learned (hidden_rig)
  LearningSettings learning;        // its targets' flaws are drawn by real_rig_seed
  bool residual = true;             // measure the reference once, and keep each column's remaining offset
  bool sources = false;             // also make the table of error sources, by null tests
  int every = 1;                    // take only every n-th frame
  int threads = 0;                  // 0: one for each core
};

struct SectionResult {
  std::string name;              // A1, A2
  MethodFigures self_projected;  // by the route
  MethodFigures conventional;
  MethodFigures null_self_projected;  // by null tests, if the route is another
  MethodFigures null_conventional;
  Measurement measurement;               // self-projected, by the route
  double checked_mm = 0;                 // LearnedRig::checked_mm
  std::vector<ReportTable> tables;       // published and measured figures; sources of error
  std::vector<std::string> not_reached;  // one line for each figure of the project's own that was not reached
  std::vector<Fact> conditions;          // conditions of the measurement: line peak, ambient light, noise, ...
};

// Runs A1 or A2: both methods over all frames. `progress` gets the number of images and frames done and of all. Throws
// UserError for an unknown experiment, and as rig, scene and learn_rig do.
SectionResult run_section_experiment(const std::string& name, const SectionOptions& options,
                                     const std::function<void(std::size_t, std::size_t)>& progress);

}  // namespace selfproj

#endif  // SELFPROJ_LAB_SECTION_EXPERIMENT_H
