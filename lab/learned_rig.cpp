#include "lab/learned_rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "host/calibration/calibrate.h"
#include "host/calibration/capture.h"
#include "host/images/image_sequence.h"
#include "host/light_section/height_fit.h"
#include "host/light_section/line_finder.h"
#include "host/light_section/pattern.h"
#include "host/light_section/scan.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/structured_light/gray_sequence.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/scenes.h"
#include "sim/scene/targets.h"
#include "sim/scene/virtual_capture.h"

namespace selfproj::lab {
namespace {

constexpr sim::ChessboardShape kBoard{37, 3, 2.2};
constexpr double kPrintScale = 1e-4;  // relative error of the squares
constexpr double kBend = 0.01;        // how far the chessboard bends out of its plane, mm

// The camera that takes all images, each with noise of its own.
class TargetCamera {
 public:
  TargetCamera(const sim::PerturbedRig& actual, const sim::RenderOptions& options, std::function<void()> done)
      : actual_(actual), options_(options), done_(std::move(done)) {}

  // Takes an image of a scene that stands still under each pattern, and calls take(i, image).
  void take(const sim::Scene& scene, int count, const std::function<images::Image(int i)>& pattern,
            const std::function<void(int i, const model::ImageView& image)>& take) {
    const sim::PatternRenderer renderer(actual_, scene, options_);
    sim::take_images(renderer, {count, next_, pattern}, [&](int i, const model::ImageView& image) {
      take(i, image);
      done_();
    });
    next_ += count;
  }

  // The same under the lines of a sweep: calls take_line(line, image).
  void sweep(const sim::Scene& scene, int every_line,
             const std::function<void(double line, const model::ImageView& image)>& take_line) {
    const std::vector<int> lines = light_section::sweep_lines(actual_.rig, every_line);
    const auto line = [&](int i) { return static_cast<double>(lines[static_cast<std::size_t>(i)]); };
    take(
        scene, static_cast<int>(lines.size()),
        [&](int i) { return sim::pattern_image(light_section::draw_straight_line(actual_.rig, line(i))); },
        [&](int i, const model::ImageView& image) { take_line(line(i), image); });
  }

 private:
  const sim::PerturbedRig& actual_;
  sim::RenderOptions options_;
  std::function<void()> done_;
  int next_ = 1'000'000;  // frame number, which seeds the noise; a scene's own frames have smaller ones
};

// Returns the rig with its lenses, poses and belt calibrated by a chessboard on plates.
rig::Rig calibrated(const sim::PerturbedRig& actual, TargetCamera& camera, const LearningSettings& settings) {
  const rig::Rig& drawn = actual.rig;
  const structured_light::GraySequence sequence(drawn.projector.columns, drawn.projector.lines);
  calibration::CalibrateSettings calibration;
  calibration.chessboard = {kBoard.across, kBoard.down, kBoard.square_mm};
  calibration.projector_columns = drawn.projector.columns;
  calibration.projector_rows = drawn.projector.lines;
  const calibration::PlateTolerance tolerance;
  calibration.plates = calibration::plates_over(drawn, calibration.chessboard, settings.board_heights_mm,
                                                settings.belt_mm, tolerance, {});
  const sim::ChessboardFlaws flaws = sim::drawn_flaws(kPrintScale, kBend, settings.seed);
  const std::vector<sim::ChessboardPlace> places =
      sim::places_on_plates(actual, kBoard, {settings.board_heights_mm, settings.belt_mm},
                            {tolerance.height_mm, tolerance.parallel_mm, tolerance.fence_mm}, settings.seed);
  std::vector<calibration::PoseReport> poses;
  for (const sim::ChessboardPlace& place : places) {
    std::vector<images::Image> images;
    camera.take(
        sim::ChessboardScene(drawn, kBoard, place, flaws), sequence.count(),
        [&](int i) {
          return images::Image{sequence.rows(), sequence.columns(), sequence.image(i)};
        },
        [&](int /*i*/, const model::ImageView& image) {
          images.push_back({image.rows, image.columns, {image.pixels, image.pixels + drawn.camera.pixels()}});
        });
    const std::string name = fmt::format("pose {}", poses.size() + 1);
    images::ImageSequence captured(std::vector<std::string>(images.size(), name),
                                   [&](std::size_t i) { return images[i]; });
    poses.push_back(
        calibration::observe_pose(name, calibration::decode_capture(name, captured, sequence, {}), calibration));
  }
  const calibration::CalibrationReport report = calibration::calibrate(std::move(poses), calibration);
  if (!report.model.refusal.empty()) {
    throw CheckFailed(fmt::format("calibration of the rig: {}", report.model.refusal));
  }
  return calibration::calibrated_rig(report, drawn);
}

// Returns where the lines of a sweep are seen on a plate that is not quite flat and not quite at its height.
light_section::HeightPosition seen_on_plate(const rig::Rig& believed, TargetCamera& camera, double height_mm,
                                            const LearningSettings& settings) {
  const light_section::HeightSettings assumed;
  const sim::FlatPlate plate(height_mm, {assumed.tolerance_mm, assumed.flatness_mm},
                             100 * settings.seed + static_cast<std::uint64_t>(std::lround(height_mm)));
  light_section::HeightPosition position{fmt::format("plate at {:g} mm", height_mm), height_mm, {}};
  light_section::LineFinder finder(believed);
  camera.sweep(plate, settings.every_line, [&](double line, const model::ImageView& image) {
    light_section::add_sightings(finder, line, image, position.seen);
  });
  return position;
}

}  // namespace

int learning_images(const rig::Rig& drawn, const LearningSettings& settings) {
  const structured_light::GraySequence sequence(drawn.projector.columns, drawn.projector.lines);
  const std::size_t poses = settings.board_heights_mm.size() * settings.belt_mm.size();
  const std::size_t plates = settings.plate_heights_mm.size() + 1;
  return static_cast<int>(poses) * sequence.count() +
         static_cast<int>(plates * light_section::sweep_lines(drawn, settings.every_line).size());
}

LearnedRig learn_rig(const sim::PerturbedRig& actual, const sim::RenderOptions& options,
                     const LearningSettings& settings, const std::function<void()>& done) {
  TargetCamera camera(actual, options.ideal_world(), done);
  const rig::Rig believed = calibrated(actual, camera, settings);
  std::vector<light_section::HeightPosition> positions;
  for (const double height : settings.plate_heights_mm) {
    positions.push_back(seen_on_plate(believed, camera, height, settings));
  }
  LearnedRig learned;
  learned.rig = light_section::fit_heights(believed, positions, {}).rig;
  for (const light_section::HeightLevel& level :
       light_section::check_heights(learned.rig, {seen_on_plate(learned.rig, camera, kCheckedPlate, settings)}, {})) {
    learned.checked_mm = std::max({learned.checked_mm, std::abs(level.mean_mm), level.uneven_mm});
  }
  return learned;
}

int scanning_images(const rig::Rig& rig, int every_line) {
  return static_cast<int>(light_section::sweep_lines(rig, every_line).size());
}

sim::LightSection scanned_projection(const rig::Rig& learned, const sim::PerturbedRig& actual,
                                     const MakeScene& reference, const ScanSettings& settings,
                                     const std::function<void()>& done) {
  std::vector<light_section::LineScan> scans;
  for (const model::Mode mode : sim::kAllModes) {
    rig::Rig measured = learned;
    measured.measure.mode = mode;
    scans.emplace_back(measured, settings.every_line);
  }
  sim::PerturbedRig stopped = actual;
  stopped.rig.conveyor.speed_mm_per_s = 0;
  TargetCamera camera(stopped, settings.render, done);
  camera.sweep(*reference(stopped.rig), settings.every_line, [&](double line, const model::ImageView& image) {
    for (light_section::LineScan& scan : scans) {
      scan.add(line, image);
    }
  });
  sim::LightSection result{learned, actual, {}, {}};
  std::transform(scans.begin(), scans.end(), result.references.begin(),
                 [](const light_section::LineScan& scan) { return scan.reference(); });
  result.pattern = light_section::draw_pattern(
      learned,
      light_section::pattern_of_curve(learned, light_section::curve_of_reference(learned, result.references[0])));
  if (!settings.residual) {
    return result;
  }
  const auto centroids =
      sim::scan_centroids(learned, actual, *reference(actual.rig), result.pattern, settings.render, sim::kAllModes);
  for (std::size_t m = 0; m < sim::kAllModes.size(); ++m) {
    result.references[m] = light_section::without_residual(learned, result.references[m], centroids[m]);
  }
  return result;
}

sim::LightSection scanned_projection(const rig::Rig& learned, const sim::PerturbedRig& actual,
                                     const std::string& reference, const ScanSettings& settings,
                                     const std::function<void()>& done) {
  return scanned_projection(
      learned, actual, [&](const rig::Rig& rig) { return sim::make_scene(reference, rig); }, settings, done);
}

}  // namespace selfproj::lab
