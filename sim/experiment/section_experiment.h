// Experiments A1 and A2 in simulation, with published and measured figures side by side.
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
  bool residual = true;  // measure the reference once, and keep each column's remaining offset
  bool sources = false;  // also make the table of error sources
  int every = 1;         // take only every n-th frame
  int threads = 0;       // 0: one for each core
};

struct SectionResult {
  std::string name;  // A1, A2
  MethodFigures self_projected;
  MethodFigures conventional;
  Measurement measurement;               // self-projected
  std::vector<ReportTable> tables;       // published and measured figures; sources of error
  std::vector<std::string> not_reached;  // one line for each figure of the project's own that was not reached
  std::vector<Fact> conditions;          // conditions of the measurement: line peak, ambient light, noise, ...
};

// Runs A1 or A2: both methods over all frames. `progress` gets the number of frames done and of all frames. Throws
// UserError for an unknown experiment, and as rig and scene do.
SectionResult run_section_experiment(const std::string& name, const SectionOptions& options,
                                     const std::function<void(std::size_t, std::size_t)>& progress);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_SECTION_EXPERIMENT_H
