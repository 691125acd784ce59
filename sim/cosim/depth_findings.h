// The motion in the depth images of a scene as facts, plots and a table, compared with the truth.
#ifndef SELFPROJ_SIM_COSIM_DEPTH_FINDINGS_H
#define SELFPROJ_SIM_COSIM_DEPTH_FINDINGS_H

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "host/report/report.h"
#include "host/structured_light/foreground.h"
#include "sim/scene/scene_info.h"

namespace selfproj {

// A measurement from one depth image, and the same from the true depths; lengths in mm, NaN if there is none.
struct DepthSample {
  std::size_t frame = 0;  // frame of this run, from 1, that completed the code image
  double t = 0;           // time in s of the frame in the middle of the code's cycle
  Foreground moved, true_moved;
  double front = std::numeric_limits<double>::quiet_NaN();  // SceneAnalysis::wave_front
  double true_front = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> z, true_z;  // SceneAnalysis::key_taps: z at the pixels of the keys, of what moved
};

struct DepthFindings {
  std::vector<Fact> facts;
  std::vector<ReportPlot> plots;
  std::string table_name;
  std::string table;  // CSV
};

DepthFindings findings_of(SceneAnalysis analysis, const std::vector<DepthSample>& samples);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_COSIM_DEPTH_FINDINGS_H
