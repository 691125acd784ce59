// Experiment "remedies": what helps B4 against the disturbances that break it.
#ifndef SELFPROJ_LAB_CUBOID_REMEDIES_H
#define SELFPROJ_LAB_CUBOID_REMEDIES_H

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "host/report/report.h"
#include "lab/disturbed_measurements.h"
#include "lab/evaluation.h"
#include "sim/scene/world.h"

namespace selfproj::lab {

// A remedy with the setting that was best on seed 1, and the errors without and with it on other seeds together.
struct TriedRemedy {
  std::string disturbance, what, way;
  ErrorSpread without, with;
};

// Each remedy has a few settings. That which leaves the fewest false and missing points on seed 1 is measured on seeds
// 2 .. 1 + seeds: noise and a camera's faults are drawn anew, and the place of a second reflection. `progress` gets the
// number of measurements done and of all.
std::vector<TriedRemedy> try_cuboid_remedies(const DisturbedCuboids& cuboids, const sim::WorldFile& file, int seeds,
                                             const std::function<void(std::size_t, std::size_t)>& progress);

// What is tried, as a table, and as JSON.
report::ReportTable remedies_table(const std::vector<TriedRemedy>& tried, int seeds);
std::string remedies_data(const std::vector<TriedRemedy>& tried);

}  // namespace selfproj::lab

#endif  // SELFPROJ_LAB_CUBOID_REMEDIES_H
