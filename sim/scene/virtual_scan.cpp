#include "sim/scene/virtual_scan.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "host/images/image_files.h"
#include "host/light_section/scan.h"
#include "host/structured_light/gray_sequence.h"
#include "host/structured_light/self_reference.h"
#include "sim/scene/parallel.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/virtual_capture.h"

namespace selfproj {

int scan_images(const Rig& rig, ScanMethod method) {
  return method == ScanMethod::gray_codes ? GrayPointScan(rig).count() : LinePointScan(rig).count();
}

ProjectorPoints scan_points(const Rig& rig, const Scene& scene, const RenderOptions& options, ScanMethod method,
                            const std::function<void()>& done) {
  Rig scanned = rig;
  scanned.imaging.seed += 1;
  const PatternRenderer renderer(scanned, scene, options);
  const auto points_of = [&](auto& scan, const std::function<Image(int)>& pattern) {
    take_images(renderer, {.count = scan.count(), .pattern = pattern}, [&](int /*i*/, const ImageView& image) {
      scan.add(image);
      done();
    });
    return scan.points();
  };
  if (method == ScanMethod::gray_codes) {
    GrayPointScan scan(rig);
    const GraySequence sequence(rig.projector.columns, rig.projector.lines);
    return points_of(scan, [&](int i) { return Image{sequence.rows(), sequence.columns(), sequence.image(i)}; });
  }
  LinePointScan scan(rig);
  return points_of(scan, [&](int i) { return pattern_image(scan_pattern(rig, i)); });
}

std::vector<std::vector<double>> scan_centroids(const Rig& rig, const RealRig& real, const Scene& scene,
                                                const FloatImage& pattern, const RenderOptions& options,
                                                std::span<const Mode> modes) {
  constexpr int kFrames = 16;
  RealRig scanned = real;
  scanned.rig.imaging.seed += 1;
  const Renderer renderer(scanned, scene, pattern, options);
  const int first = std::max(0, scene.frames() / 2 - kFrames / 2);
  std::vector<std::vector<std::uint8_t>> images(kFrames, std::vector<std::uint8_t>(rig.camera.pixels()));
  parallel_for(kFrames, 0, [&](int i) { renderer.render(first + i, std::span(images[static_cast<std::size_t>(i)])); });
  std::vector<std::vector<double>> result;
  for (const Mode mode : modes) {
    Rig measured = rig;
    measured.measure.mode = mode;
    CentroidMean mean(measured);
    for (const auto& image : images) {
      mean.add({image.data(), rig.camera.rows, rig.camera.columns, rig.camera.columns});
    }
    result.push_back(mean.centroids());
  }
  return result;
}

}  // namespace selfproj
