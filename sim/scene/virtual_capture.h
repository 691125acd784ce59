// Images that the simulated camera takes of a scene that stands still, under whole patterns of the projector: passed on
// one after another, written into a folder as a real camera would leave them, or decoded as a scan of a reference.
#ifndef SELFPROJ_SIM_SCENE_VIRTUAL_CAPTURE_H
#define SELFPROJ_SIM_SCENE_VIRTUAL_CAPTURE_H

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "host/files/output_folder.h"
#include "host/images/image_files.h"
#include "host/structured_light/point_scan.h"
#include "selfproj/images/float_image.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"
#include "sim/scene/targets.h"

namespace selfproj::sim {

// A pattern of light 0..1 as the 8-bit image for a projector.
images::Image pattern_image(const images::FloatImage& pattern);

// Consecutive images of one scene: image i is frame first + i (for its noise) under pattern(i).
struct PatternShots {
  int count = 0;
  int first = 0;
  std::function<images::Image(int i)> pattern;  // projector lines x columns; several threads may call it at once
};

// Renders them with several threads and passes the images on in order: take(i, image).
void take_images(const PatternRenderer& renderer, const PatternShots& shots,
                 const std::function<void(int i, const model::ImageView& image)>& take);

// Settings for a capture into a folder.
struct CaptureSettings {
  RenderOptions render;
  int threads = 0;                     // 0: one for each core
  std::string prefix = {};             // of the files' names, such as `inner/`
  std::function<void()> done = [] {};  // called after each image, never by two threads at once
};

// The images of a scene under each pattern, in pixels of the rig's bits, frames 0, 1, ..., in files image_00.png and so
// on, with three digits for more than 100 patterns. Throws as PatternRenderer does.
void capture_scene(const PerturbedRig& actual, const Scene& scene, const std::vector<ProjectedLight>& patterns,
                   const CaptureSettings& settings, files::OutputFolder& out);

// The same for a chessboard at each of the places: pose_01/image_00.png and so on, and truth.json with the renderer's
// pinholes of camera and projector (pixels and mm) and the places.
void capture_chessboard(const PerturbedRig& actual, const ChessboardShape& shape, const ChessboardFlaws& flaws,
                        const std::vector<ChessboardPlace>& places, const std::vector<ProjectedLight>& patterns,
                        const CaptureSettings& settings, files::OutputFolder& out);

// The same for a rig with a laser, where no patterns are shown: boards/pose_01.png and so on in room light, and
// lines/pose_01.png and so on in the dark, with the laser's line.
void capture_chessboard_and_laser(const PerturbedRig& actual, const ChessboardShape& shape,
                                  const ChessboardFlaws& flaws, const std::vector<ChessboardPlace>& places,
                                  const CaptureSettings& settings, files::OutputFolder& out);

// The line of the laser, as the projector that stands for it throws it.
ProjectedLight laser_light(const PerturbedRig& actual, const RenderOptions& options);

// How a reference is scanned for structured light before the measurement. The noise of scans has seed + 1, so that it
// differs from the measurement's.
enum class ScanMethod {
  lines,       // a bright line at each of the projector's lines, then at each of its columns
  gray_codes,  // Gray codes along both axes, those of `selfproj pattern gray`
};

// The number of images in such a scan.
int scan_images(const rig::Rig& rig, ScanMethod method);

// The projector point that each camera pixel sees on the scene. `done` is called after each image.
structured_light::ProjectorPoints scan_points(const rig::Rig& rig, const Scene& scene, const RenderOptions& options,
                                              ScanMethod method, const std::function<void()>& done);

// Centroids C of the light section in each of the modes, rows from 1, one for each column: means over 16 frames in the
// middle of the scene's way, NaN if a column is not lit as the rig asks. `actual` is the rig that takes the images, and
// `rig` the one believed to take them; their images have one size.
std::vector<std::vector<double>> scan_centroids(const rig::Rig& rig, const PerturbedRig& actual, const Scene& scene,
                                                const images::FloatImage& pattern, const RenderOptions& options,
                                                std::span<const model::Mode> modes);

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_SCENE_VIRTUAL_CAPTURE_H
