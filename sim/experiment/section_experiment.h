// The experiments A1 and A2 of the thesis in simulation, with their published figures beside the measured ones.
#ifndef SELFPROJ_SIM_EXPERIMENT_SECTION_EXPERIMENT_H
#define SELFPROJ_SIM_EXPERIMENT_SECTION_EXPERIMENT_H

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "host/report/report.h"
#include "host/rig/rig.h"
#include "sim/experiment/light_section.h"
#include "sim/experiment/section_figures.h"
#include "sim/scene/renderer.h"

namespace selfproj {

struct SectionOptions {
  Rig rig;
  RenderOptions render;
  bool residual = true;  // the reference is measured once, and each column's remaining offset kept
  bool sources = false;  // also the table of error sources
  int every = 1;         // every so many frames only
  int threads = 0;       // 0: one a core
};

struct SectionResult {
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
SectionResult run_section_experiment(const std::string& name, const SectionOptions& options,
                                     const std::function<void(std::size_t, std::size_t)>& progress);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_SECTION_EXPERIMENT_H
