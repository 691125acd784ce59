// Heights, steps and marks from a light-section measurement of A1 or A2, compared with the truth.
#ifndef SELFPROJ_LAB_SECTION_EXPERIMENT_H
#define SELFPROJ_LAB_SECTION_EXPERIMENT_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host/report/report.h"
#include "lab/evaluation.h"
#include "lab/learned_rig.h"
#include "lab/section_measurement.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"

namespace selfproj::lab {

inline constexpr int kStepColumns = 3;  // columns left out on each side of a height step or part edge

// How far points are from their true places, mm, along the belt (x) and across it (y), after a shift that all of them
// have in common: a part may lie anywhere on the belt.
struct PlaceErrors {
  double x_max = 0, x_rms = 0;
  double y_max = 0, y_rms = 0;
};

// The results of a method in one mode, compared with the truth. Lengths in mm, centroids in pixels.
struct SectionFigures {
  HeightErrors errors;             // without points within kStepColumns of a height step or part edge, in any direction
  HeightErrors errors_beyond_2;    // without points within 2 columns
  HeightErrors errors_beyond_1;    // without points within 1 column
  HeightErrors errors_at_edges;    // like `errors`, but including points near edges across the belt, along the line
  PlaceErrors places;              // of the points that `errors` compares
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
  std::array<SectionFigures, sim::kAllModes.size()> modes;
};

// Heights are compared with those of the points where the columns' viewing planes, the light sheet and the surface
// truly meet, by the rig that takes the images. `scene` must be on the conveyor (ConveyedScene). `treads` is the number
// of treads side by side, 0..3.
MethodFigures section_figures(const Measurement& measurement, const sim::LightSection& setup, const sim::Scene& scene,
                              std::size_t treads, const sim::RenderOptions& render);

// Experiments A1 and A2 in simulation, with published and measured figures side by side.

// How the experiments know rig and good part. The thesis's way: the rig is calibrated from images and the good part is
// scanned. A null test knows both perfectly, so that only the errors of the method remain.
enum class Route { learned, null_test };

struct SectionOptions {
  rig::Rig rig;  // as drawn
  sim::RenderOptions render;
  Route route = Route::learned;          // learned: null tests are made as well
  std::uint64_t perturbed_rig_seed = 1;  // of the rig that takes the images on route learned (hidden_rig)
  LearningSettings learning;             // its targets' flaws are drawn by perturbed_rig_seed
  bool residual = true;                  // measure the reference once, and keep each column's remaining offset
  bool sources = false;                  // also make the table of error sources, by null tests
  int every = 1;                         // take only every n-th frame
  int threads = 0;                       // 0: one for each core
};

struct SectionResult {
  std::string name;              // A1, A2
  MethodFigures self_projected;  // by the route
  MethodFigures conventional;
  MethodFigures null_self_projected;  // by null tests, if the route is another
  MethodFigures null_conventional;
  Measurement measurement;                  // self-projected, by the route
  double checked_mm = 0;                    // LearnedRig::checked_mm
  std::vector<report::ReportTable> tables;  // published and measured figures; sources of error
  std::vector<std::string> not_reached;     // one line for each figure of the project's own that was not reached
  std::vector<report::Fact> conditions;     // conditions of the measurement: line peak, ambient light, noise, ...
};

// Runs A1 or A2: both methods over all frames. `progress` gets the number of images and frames done and of all. Throws
// UserError for an unknown experiment, and as rig, scene and learn_rig do.
SectionResult run_section_experiment(const std::string& name, const SectionOptions& options,
                                     const std::function<void(std::size_t, std::size_t)>& progress);

}  // namespace selfproj::lab

#endif  // SELFPROJ_LAB_SECTION_EXPERIMENT_H
