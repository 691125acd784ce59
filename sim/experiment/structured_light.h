// What the experiments with structured light have in common: B4 (cuboids.h), B7 and B8 (moving_things.h).
#ifndef SELFPROJ_SIM_EXPERIMENT_STRUCTURED_LIGHT_H
#define SELFPROJ_SIM_EXPERIMENT_STRUCTURED_LIGHT_H

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "host/io/float_image.h"
#include "host/report/report.h"

namespace selfproj {

using ProgressOfImages = std::function<void(std::size_t done, std::size_t all)>;

// Lines, the central ones of the projector, over which the conventional method has its codes.
constexpr int kCodedLines = 512;

// An experiment's tables, pictures and what does not hold of what is wanted.
struct StructuredLightResult {
  std::vector<ReportTable> tables;
  std::vector<std::string> not_reached;
  ReportPage page;
  FloatImage depth, difference, truth;  // mm
  std::string series;                   // CSV of what was measured in every depth image; empty: nothing moves
};

// A number in a table; a dash where it is NaN.
std::string figure_text(double value, int digits = 2);

// a - b, pixel by pixel; NaN where one of them is. The images have one size.
FloatImage minus(const FloatImage& a, const FloatImage& b);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_STRUCTURED_LIGHT_H
