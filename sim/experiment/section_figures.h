// What a light-section measurement of A1 or A2 says of heights, steps and marks, against the truth.
#ifndef SELFPROJ_SIM_EXPERIMENT_SECTION_FIGURES_H
#define SELFPROJ_SIM_EXPERIMENT_SECTION_FIGURES_H

#include <array>
#include <cstddef>
#include <vector>

#include "sim/experiment/evaluation.h"
#include "sim/experiment/light_section.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"

namespace selfproj {

inline constexpr int kStepColumns = 3;  // columns left out on each side of a height step or part edge

// What a method found in one mode, against the truth. Lengths in mm, centroids in pixels.
struct SectionFigures {
  HeightErrors errors;           // without what is within kStepColumns of a height step or part edge, in any direction
  HeightErrors errors_beyond_2;  // the same with 2 columns
  HeightErrors errors_beyond_1;  // with 1
  HeightErrors errors_at_edges;  // the same, but with what is near an edge that runs across the belt, along the line
  CentroidRange range;           // in the frames in which the line lies on the part
  std::vector<double> steps;     // of A2: mean height of the treads, away from marks and edges
  std::vector<double> mark_depth;  // of A2: of ○ × ▽
};

// Self-projection, or the straight line, in each of kAllModes.
struct MethodFigures {
  int rows = 0;  // of the camera image
  std::array<SectionFigures, kAllModes.size()> modes;
};

// `scene` is one on the conveyor (ConveyedScene); `treads`: how many it has side by side, 0..3.
MethodFigures section_figures(const Measurement& measurement, const LightSection& setup, const Scene& scene,
                              std::size_t treads, const RenderOptions& render);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_SECTION_FIGURES_H
