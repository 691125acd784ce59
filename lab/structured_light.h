// The common part of the experiments with structured light: B4 (cuboids.h), B7 and B8 (moving_things.h).
#ifndef SELFPROJ_LAB_STRUCTURED_LIGHT_H
#define SELFPROJ_LAB_STRUCTURED_LIGHT_H

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "host/images/float_image.h"
#include "host/report/report.h"

namespace selfproj {

using ProgressOfImages = std::function<void(std::size_t done, std::size_t all)>;

// The number of central projector lines over which the conventional method has its codes.
constexpr int kCodedLines = 512;

// An experiment's tables and pictures, and the goals that it does not reach.
struct StructuredLightResult {
  std::vector<ReportTable> tables;
  std::vector<std::string> not_reached;
  ReportPage page;
  FloatImage depth, difference, truth;  // mm
  std::string series;                   // CSV of the measurements in every depth image; empty if nothing moves
};

// A number for a table; a dash for NaN.
std::string figure_text(double value, int digits = 2);

// a - b, pixel by pixel; NaN if either is NaN. The images have one size.
FloatImage minus(const FloatImage& a, const FloatImage& b);

}  // namespace selfproj

#endif  // SELFPROJ_LAB_STRUCTURED_LIGHT_H
