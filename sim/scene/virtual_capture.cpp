#include "sim/scene/virtual_capture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "sim/scene/parallel.h"
#include "sim/scene/pattern_set.h"
#include "sim/scene/pinhole.h"

namespace selfproj {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(Point3 p) { return {p.x, p.y, p.z}; }

// The truth about the rig, from the renderer's matrices: the pixels of the optical axes, and the scale from tangents to
// pixels. Pixels are (row, column); rows and lines are along x and Xp.
Json truth_of(const Rig& rig) {
  const auto pinhole = [](const Pinhole& p, Point3 axis, Point3 row_axis, Point3 column_axis) {
    const PixelPoint middle = p.project(p.centre() + axis);
    return Json{{"row_focal_px", p.project(p.centre() + axis + row_axis).row - middle.row},
                {"column_focal_px", p.project(p.centre() + axis + column_axis).column - middle.column},
                {"row_centre_px", middle.row},
                {"column_centre_px", middle.column},
                {"centre_mm", json_of(p.centre())}};
  };
  const Pinhole camera = Pinhole::of_camera(rig.camera);
  const Pinhole projector = Pinhole::of_projector(rig.projector);
  const Point3 y{0, 1, 0};
  const Point3 axis = projector.axis();
  return {{"camera", pinhole(camera, camera.axis(), {1, 0, 0}, y)},
          {"projector", pinhole(projector, axis, {axis.z, 0, -axis.x}, y)}};
}

// Renders frames first, first + 1, ... under the patterns into files whose names begin with `prefix`.
void capture(const Rig& rig, const Scene& scene, const std::vector<ProjectedLight>& patterns, int first,
             const std::string& prefix, const CaptureSettings& settings, OutputFolder& out) {
  const PatternRenderer renderer(rig, scene, settings.render, settings.threads);
  std::mutex mutex;
  const auto count = static_cast<int>(patterns.size());
  const int digits = count > 100 ? 3 : 2;
  parallel_for(count, settings.threads, [&](int i) {
    Image image{rig.camera.rows, rig.camera.columns, std::vector<std::uint8_t>(rig.camera.pixels())};
    renderer.render(first + i, patterns[static_cast<std::size_t>(i)], image.pixels);
    const std::string bytes = encode_png(image);
    const std::lock_guard lock(mutex);
    out.append(fmt::format("{}image_{:0{}}.png", prefix, i, digits), bytes);
    settings.done();
  });
}

}  // namespace

Image pattern_image(const FloatImage& pattern) {
  constexpr float kFull = 255;
  Image image{pattern.rows, pattern.columns, std::vector<std::uint8_t>(pattern.values.size())};
  std::transform(pattern.values.begin(), pattern.values.end(), image.pixels.begin(),
                 [](float value) { return static_cast<std::uint8_t>(std::lround(kFull * value)); });
  return image;
}

void take_images(const PatternRenderer& renderer, const PatternShots& shots,
                 const std::function<void(int i, const ImageView& image)>& take) {
  constexpr int kBatch = 8;
  const Rig& rig = renderer.rig();
  std::array<std::vector<std::uint8_t>, kBatch> images;
  for (int begin = 0; begin < shots.count; begin += kBatch) {
    const int size = std::min(kBatch, shots.count - begin);
    parallel_for(size, 0, [&](int i) {
      auto& image = images.at(static_cast<std::size_t>(i));
      image.resize(rig.camera.pixels());
      const ProjectedLight light = project_image(rig, shots.pattern(begin + i), renderer.options());
      renderer.render(shots.first + begin + i, light, std::span(image));
    });
    for (int i = 0; i < size; ++i) {
      take(begin + i,
           {images.at(static_cast<std::size_t>(i)).data(), rig.camera.rows, rig.camera.columns, rig.camera.columns});
    }
  }
}

void capture_scene(const Rig& rig, const Scene& scene, const std::vector<ProjectedLight>& patterns,
                   const CaptureSettings& settings, OutputFolder& out) {
  capture(rig, scene, patterns, 0, "", settings, out);
}

void capture_chessboard(const Rig& rig, const ChessboardShape& shape, const std::vector<ChessboardPlace>& places,
                        const std::vector<ProjectedLight>& patterns, const CaptureSettings& settings,
                        OutputFolder& out) {
  Json truth = truth_of(rig);
  for (std::size_t k = 0; k < places.size(); ++k) {
    const ChessboardPlace& place = places[k];
    truth["poses"].push_back(
        {{"middle_mm", json_of(place.middle)}, {"right", json_of(place.right)}, {"below", json_of(place.below)}});
    capture(rig, ChessboardScene(rig, shape, place), patterns, static_cast<int>(k * patterns.size()),
            fmt::format("pose_{:02}/", k + 1), settings, out);
  }
  out.append("truth.json", truth.dump(2) + "\n");
}

}  // namespace selfproj
