// Heights, steps and marks from a light-section measurement of A1 or A2, compared with the truth.
#ifndef SELFPROJ_LAB_SECTION_FIGURES_H
#define SELFPROJ_LAB_SECTION_FIGURES_H

#include <array>
#include <cstddef>
#include <vector>

#include "lab/evaluation.h"
#include "sim/cosim/light_section.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"

namespace selfproj {

inline constexpr int kStepColumns = 3;  // columns left out on each side of a height step or part edge

// The results of a method in one mode, compared with the truth. Lengths in mm, centroids in pixels.
struct SectionFigures {
  HeightErrors errors;             // without points within kStepColumns of a height step or part edge, in any direction
  HeightErrors errors_beyond_2;    // without points within 2 columns
  HeightErrors errors_beyond_1;    // without points within 1 column
  HeightErrors errors_at_edges;    // like `errors`, but including points near edges across the belt, along the line
  CentroidRange range;             // over the frames in which the line lies on the part
  std::vector<double> steps;       // A2: mean heights of the treads, away from marks and edges
  std::vector<double> mark_depth;  // A2: depths of ○ × ▽
  // A2: how far the points on a mark are from where they truly are, in the worst of the marks, after a common shift of
  // all of them: a part may lie anywhere on the belt.
  double mark_place = 0;
};

// Self-projection or the straight line, in each of kAllModes.
struct MethodFigures {
  int rows = 0;  // rows of the camera image
  std::array<SectionFigures, kAllModes.size()> modes;
};

// Heights are compared with those of the points where the columns' viewing planes, the light sheet and the surface
// truly meet, by the rig that takes the images. `scene` must be on the conveyor (ConveyedScene). `treads` is the number
// of treads side by side, 0..3.
MethodFigures section_figures(const Measurement& measurement, const LightSection& setup, const Scene& scene,
                              std::size_t treads, const RenderOptions& render);

}  // namespace selfproj

#endif  // SELFPROJ_LAB_SECTION_FIGURES_H
