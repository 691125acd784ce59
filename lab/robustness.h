// Experiment "robustness": what each disturbance of the world does to A2 and B4, over its strength.
#ifndef SELFPROJ_LAB_ROBUSTNESS_H
#define SELFPROJ_LAB_ROBUSTNESS_H

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "host/report/report.h"
#include "sim/scene/world.h"

namespace selfproj::lab {

struct RobustnessOptions {
  sim::WorldFile world;       // the parameters of the disturbances
  int every = 70;             // A2 takes only every n-th frame
  int reference_frames = 16;  // of the good part, for its residual
  int cameras = 40;           // with their own defect pixels, for the share of false points
  std::size_t strengths = 5;  // of each disturbance, 1..5
  int coarser = 1;            // B4 has this many times fewer pixels along each side
};

struct RobustnessResult {
  std::vector<report::ReportTable> tables;
  std::vector<report::ReportTable>
      curves;                            // the same over the strength of each disturbance; `data` has them as numbers
  std::vector<std::string> not_reached;  // one line for each bound of the false points that does not hold
  std::string data;                      // all figures as numbers, JSON
  report::ReportPage page;
};

// A point that is off by more than this is false, mm.
inline constexpr double kFalseMm = 0.3;
// The same for B4, whose codes are worth 3 to 6 mm.
inline constexpr double kFalseCodeMm = 10;

// The greatest share of false points that the strongest run may leave on painted metal and on matt plastic.
inline constexpr double kMaxFalse = 1e-4;

// `progress` gets the number of worlds done and of all.
RobustnessResult run_robustness(const RobustnessOptions& options,
                                const std::function<void(std::size_t, std::size_t)>& progress);

}  // namespace selfproj::lab

#endif  // SELFPROJ_LAB_ROBUSTNESS_H
