// The experiments A1 and A2 of the thesis in simulation, with their published figures beside the measured ones.
#ifndef SELFPROJ_SIM_EXPERIMENT_EXPERIMENT_H
#define SELFPROJ_SIM_EXPERIMENT_EXPERIMENT_H

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "host/report/report.h"
#include "host/rig/rig.h"
#include "sim/experiment/evaluation.h"
#include "sim/experiment/light_section.h"
#include "sim/scene/renderer.h"

namespace selfproj {

struct ExperimentOptions {
  Rig rig;
  RenderOptions render;
  bool residual = true;  // the reference is measured once, and each column's remaining offset kept
  bool sources = false;  // also the table of error sources
  int every = 1;         // every so many frames only
  int threads = 0;       // 0: one a core
};

// What a method found in one mode, against the truth. Lengths in mm, centroids in pixels.
struct ExperimentFigures {
  HeightErrors errors;             // without what is within 3 columns of a height step or part edge, in any direction
  HeightErrors errors_beyond_2;    // the same with 2 columns
  HeightErrors errors_beyond_1;    // with 1
  HeightErrors errors_at_edges;    // the same, but with what is near an edge that runs across the belt, along the line
  CentroidRange range;             // in the frames in which the line lies on the part
  std::vector<double> steps;       // of A2: mean height of the treads, away from marks and edges
  std::vector<double> mark_depth;  // of A2: of ○ × ▽
};

// Self-projection, or the straight line, in each of kAllModes.
struct MethodFigures {
  int rows = 0;  // of the camera image
  std::array<ExperimentFigures, kAllModes.size()> modes;
};

struct ExperimentResult {
  std::string name;  // A1, A2
  MethodFigures self_projected;
  MethodFigures conventional;
  Measurement measurement;               // self-projected
  std::vector<ReportTable> tables;       // published and measured; sources of error
  std::vector<std::string> not_reached;  // what does not hold of what the project has set itself, a line each
  std::vector<Fact> conditions;          // of the measurement: line peak, ambient light, noise, ...
};

// Runs A1 or A2: both methods over all frames. `progress` is told how many frames of how many are done. Throws
// UserError: an unknown experiment, or what rig and scene say.
ExperimentResult run_experiment(const std::string& name, const ExperimentOptions& options,
                                const std::function<void(std::size_t, std::size_t)>& progress);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_EXPERIMENT_H
