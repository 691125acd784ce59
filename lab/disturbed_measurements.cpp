#include "lab/disturbed_measurements.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "host/light_section/pattern.h"
#include "host/light_section/scan.h"
#include "host/structured_light/match_table.h"
#include "host/structured_light/self_reference.h"
#include "host/structured_light/self_scanner.h"
#include "lab/cuboids.h"
#include "lab/image_profiler.h"
#include "lab/structured_light.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/rig/calibration.h"
#include "selfproj/structured_light/scanner.h"
#include "selfproj/structured_light/triangulation.h"
#include "sim/cosim/light_section.h"
#include "sim/scene/parallel.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scenes.h"
#include "sim/scene/virtual_capture.h"

namespace selfproj::lab {
namespace {

constexpr float kNotCompared = std::numeric_limits<float>::quiet_NaN();
constexpr double kReachOnPart = 63;  // mm along the belt from the part's middle: 2 mm from its ends

// Whether the surface is level around a place: within 0.7 mm (three columns) across the belt, and within 1.4 mm along
// it, because the light sheet may meet the surface there.
bool is_level(const sim::Scene& scene, double x, double y, double t) {
  constexpr double kAcross = 0.7;
  constexpr double kAlong = 1.4;
  constexpr double kStep = 0.05;  // mm
  const sim::HeightRange range = scene.range({x - kAlong, x + kAlong, y - kAcross, y + kAcross}, t, t);
  return range.high - range.low <= kStep;
}

// Each mode with all lit pixels of a column, then each with the strongest run.
std::vector<model::Measure> all_settings(int threshold) {
  std::vector<model::Measure> settings;
  for (const model::Select select : {model::Select::all, model::Select::strongest}) {
    for (const model::Mode mode : sim::kAllModes) {
      settings.push_back({.mode = mode, .threshold = threshold, .select = select});
    }
  }
  return settings;
}

std::string name_of(const model::Measure& measure) {
  const auto* const name = std::find_if(images::kModes.begin(), images::kModes.end(),
                                        [&](const auto& entry) { return entry.second == measure.mode; });
  return std::string(name->first) + (measure.select == model::Select::strongest ? ", strongest run" : "");
}

// The rig that measures like this.
rig::Rig with_measure(rig::Rig rig, const model::Measure& measure) {
  rig.measure.apply(measure);
  return rig;
}

// A cycle of each method.
images::FloatImage self_projected_depth(const sim::PatternRenderer& renderer,
                                        const structured_light::SelfReference& reference,
                                        const structured_light::DepthLimits& limits) {
  constexpr int kBelow = 8;  // e of (4.20), as in B4
  const rig::Rig& rig = renderer.rig();
  const structured_light::MatchTable table(rig, reference, structured_light::MatchSettings{.e = kBelow});
  structured_light::SelfScanner scanner(rig, reference, table, rig.measure.code_threshold, limits);
  scan_cycle(
      renderer, 0, reference.stripes.bits,
      [&](int i) { return structured_light::self_projected_pattern(reference, i); },
      [](int /*i*/, const model::ImageView& /*image*/) {}, scanner);
  return scanner.depth();
}

images::FloatImage conventional_depth(const sim::PatternRenderer& renderer,
                                      const structured_light::DepthLimits& limits) {
  constexpr int kBits = 8;
  const rig::Rig& rig = renderer.rig();
  const int coded = std::min(kCodedLines, rig.projector.lines);
  const structured_light::PlaneTriangulation triangulation(rig, kBits, limits, rig::central_lines(rig, coded, kBits));
  structured_light::Scanner scanner(triangulation, {.threshold = rig.measure.code_threshold});
  scan_cycle(
      renderer, 0, kBits, [&](int i) { return structured_light::gray_pattern(rig, kBits, coded, i); },
      [](int /*i*/, const model::ImageView& /*image*/) {}, scanner);
  return scanner.depth();
}

}  // namespace

DisturbedStairs::DisturbedStairs(const rig::Rig& rig, int every, int reference_frames)
    : rig_(rig),
      reference_frames_(reference_frames),
      part_(sim::make_scene("stairs-marked", rig)),
      good_(sim::make_scene("stairs", rig)) {
  pattern_ = light_section::draw_pattern(rig, light_section::pattern_of_curve(rig, sim::curve_of_scene(rig, *good_)));
  const auto& belt = dynamic_cast<const sim::ConveyedScene&>(*part_);
  const auto time_of = [&](int frame) { return frame / rig_.camera.frame_rate_hz; };
  for (int frame = every / 2; frame < part_->frames(); frame += every) {
    if (std::abs(belt.position(time_of(frame))) < kReachOnPart) {
      frames_.push_back(frame);
    }
  }
  truth_ = images::FloatImage(static_cast<int>(frames_.size()), rig.camera.columns);
  const sim::LineRenderer ideal(rig, *part_, pattern_);
  sim::parallel_for(truth_.rows, 0, [&](int i) {
    const std::span<float> row{truth_.row(i), static_cast<std::size_t>(truth_.columns)};
    const int frame = frames_[static_cast<std::size_t>(i)];
    ideal.truth(frame, row);
    for (std::size_t column = 0; column < row.size(); ++column) {
      const double z = rig_.plane_z_mm - static_cast<double>(row[column]);
      const double yc = rig_.camera.pixel_pitch_mm * (static_cast<double>(column) - 0.5 * (rig_.camera.columns - 1));
      row[column] = std::isnan(z) || !is_level(*part_, 0, z * yc / rig_.camera.focal_length_mm, time_of(frame))
                        ? kNotCompared
                        : row[column];
    }
  });
}

std::vector<WayOfMeasuring> DisturbedStairs::measure(const sim::World& world, std::int64_t noise_seed) const {
  rig::Rig rig = rig_;
  rig.imaging.seed = noise_seed;
  sim::RenderOptions options;
  options.world = world;
  const light_section::ReferenceProfile known =
      light_section::reference_of_curve(rig, sim::curve_of_scene(rig, *good_));
  rig::Rig scanned = rig;
  scanned.imaging.seed += 1000;  // the good part's images have noise of their own
  const sim::LineRenderer good(scanned, *good_, pattern_, options);
  std::vector<std::vector<std::uint8_t>> images(static_cast<std::size_t>(reference_frames_),
                                                std::vector<std::uint8_t>(rig.camera.pixels()));
  const int first = good_->frames() / 2 - reference_frames_ / 2;
  sim::parallel_for(reference_frames_, 0,
                    [&](int i) { good.render(first + i, std::span(images[static_cast<std::size_t>(i)])); });
  std::vector<ImageProfiler> profilers;
  std::vector<WayOfMeasuring> ways;
  const auto view_of = [&](const std::vector<std::uint8_t>& pixels) {
    return model::ImageView{pixels.data(), rig.camera.rows, rig.camera.columns, rig.camera.columns};
  };
  for (const model::Measure& measure : all_settings(rig.measure.threshold)) {
    const rig::Rig measuring = with_measure(rig, measure);
    light_section::CentroidMean mean(measuring);  // as `selfproj pattern --residual`
    for (const auto& image : images) {
      mean.add(view_of(image));
    }
    profilers.emplace_back(measuring, light_section::without_residual(measuring, known, mean.centroids()));
    ways.push_back({name_of(measure), {}});
  }
  const sim::LineRenderer renderer(rig, *part_, pattern_, options);
  std::vector<std::vector<ErrorSpread>> by_frame(frames_.size(), std::vector<ErrorSpread>(ways.size()));
  sim::parallel_for(static_cast<int>(frames_.size()), 0, [&](int i) {
    std::vector<std::uint8_t> pixels(rig.camera.pixels());
    renderer.render(frames_[static_cast<std::size_t>(i)], std::span(pixels));
    light_section::Profile profile;
    profile.resize(rig.camera.columns);
    for (std::size_t w = 0; w < ways.size(); ++w) {
      ImageProfiler profiler = profilers[w];  // a board of its own for each thread
      profiler.profile(view_of(pixels), profile.view());
      for (int column = 0; column < rig.camera.columns; ++column) {
        const auto height = static_cast<double>(truth_.row(i)[column]);
        if (!std::isnan(height)) {
          const auto z = static_cast<double>(profile.z[static_cast<std::size_t>(column)]);
          by_frame[static_cast<std::size_t>(i)][w].add(rig.plane_z_mm - z - height);
        }
      }
    }
  });
  for (const auto& frame : by_frame) {
    for (std::size_t w = 0; w < ways.size(); ++w) {
      ways[w].errors.add(frame[w]);
    }
  }
  return ways;
}

int DisturbedStairs::half_of_the_line(const sim::World& world) const {
  sim::RenderOptions options;
  options.world = world;
  std::vector<std::uint8_t> pixels(rig_.camera.pixels());
  sim::LineRenderer(rig_, *good_, pattern_, options).render(good_->frames() / 2, std::span(pixels));
  const auto columns = static_cast<std::size_t>(rig_.camera.columns);
  std::vector<std::uint8_t> brightest(columns, 0);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    brightest[i % columns] = std::max(brightest[i % columns], pixels[i]);
  }
  const auto middle = brightest.begin() + static_cast<std::ptrdiff_t>(columns / 2);
  std::nth_element(brightest.begin(), middle, brightest.end());
  return *middle / 2;
}

rig::Rig coarser_rig(rig::Rig rig, int factor) {
  rig.camera.rows /= factor;
  rig.camera.columns /= factor;
  rig.camera.pixel_pitch_mm *= factor;
  rig.projector.lines /= factor;
  rig.projector.columns /= factor;
  rig.projector.line_pitch_mm *= factor;
  rig.projector.column_pitch_mm *= factor;
  return rig;
}

DisturbedCuboids::DisturbedCuboids(const rig::Rig& rig)
    : rig_(rig),
      part_(sim::make_scene("cuboids-marked", rig)),
      good_(sim::make_scene("cuboids", rig)),
      truth_(rig.camera.rows, rig.camera.columns) {
  const sim::PatternRenderer ideal(rig, *part_);
  ideal.lit_depth(0, truth_.values);
  const std::vector<Face> faces = face_interiors(rig, truth_);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    truth_.values[i] = faces[i] == Face::none ? kNotCompared : truth_.values[i];
  }
}

std::vector<WayOfMeasuring> DisturbedCuboids::measure(const sim::World& world, const CuboidSettings& settings,
                                                      std::int64_t noise_seed) const {
  rig::Rig rig = rig_;
  rig.imaging.seed = noise_seed;
  rig.measure.code_threshold =
      settings.threshold > 0 ? static_cast<int>(settings.threshold) : rig.measure.code_threshold;
  sim::RenderOptions options;
  options.world = world;
  if (settings.exposure != 1) {
    options.world.saturation = world.saturation.value_or(sim::Saturation{});
    options.world.saturation->exposure *= settings.exposure;
  }
  structured_light::DepthLimits limits;
  if (settings.highest > 0) {
    constexpr double kBelowPlane = 15;  // mm
    limits = {rig.plane_z_mm - settings.highest, rig.plane_z_mm + kBelowPlane};
  }
  const auto errors_of = [&](const images::FloatImage& depth) {
    ErrorSpread errors;
    for (std::size_t i = 0; i < truth_.values.size(); ++i) {
      if (!std::isnan(truth_.values[i])) {
        errors.add(static_cast<double>(depth.values[i]) - static_cast<double>(truth_.values[i]));
      }
    }
    return errors;
  };
  const structured_light::SelfReference reference = structured_light::make_self_reference(
      rig, sim::scan_points(rig, *good_, options, sim::ScanMethod::gray_codes, [] {}),
      structured_light::Stripes{.width = static_cast<int>(settings.width)});
  const sim::PatternRenderer renderer(rig, *part_, options);
  return {{"self-projected, 4 bits", errors_of(self_projected_depth(renderer, reference, limits))},
          {"conventional, 8 bits", errors_of(conventional_depth(renderer, limits))}};
}

}  // namespace selfproj::lab
