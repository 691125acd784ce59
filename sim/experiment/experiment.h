// The experiments of the thesis by their names: run, printed, written.
#ifndef SELFPROJ_SIM_EXPERIMENT_EXPERIMENT_H
#define SELFPROJ_SIM_EXPERIMENT_EXPERIMENT_H

#include <optional>
#include <string>
#include <vector>

#include "sim/scene/virtual_scan.h"

namespace selfproj {

// What a user asks of an experiment.
struct ExperimentOptions {
  std::string name;                   // A1, A2, B4, B7, B8
  std::string rig = {};               // built-in or a file; empty: that of the experiment
  std::string out = {};               // folder for the report and what it is made of; empty: none
  std::vector<std::string> off = {};  // names of kDisturbances

  // A1, A2.
  bool residual = true;  // measure and remove the reference's own
  bool sources = false;  // also the table of error sources
  int every = 1;         // every so many frames only

  // B4, B7, B8.
  ScanMethod scan = ScanMethod::lines;
  std::optional<int> e = {};  // of (4.20); nothing: that of the experiment
};

// Prints the experiment's tables and writes its files. Throws UserError about options, rig and folder, CheckFailed
// where a figure that the project has set itself is not reached.
void run_experiment(const ExperimentOptions& options);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_EXPERIMENT_H
