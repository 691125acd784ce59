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

#include "host/files/json_text.h"
#include "host/images/image_files.h"
#include "host/light_section/pattern.h"
#include "host/light_section/scan.h"
#include "host/structured_light/self_reference.h"
#include "selfproj/structured_light/gray_sequence.h"
#include "sim/scene/optics.h"
#include "sim/scene/parallel.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/projected_light.h"

namespace selfproj::sim {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(Point3 p) { return {p.x, p.y, p.z}; }

// The truth about the rig, from the renderer's matrices: pixels of the optical axes, scales from tangents to pixels,
// the lenses' coefficients (x along columns, y along rows), places and axes in the world. Pixels are (row, column);
// rows and lines are along x, so that the scale of a projector whose lines count against x is negative.
Json truth_of(const PerturbedRig& actual) {
  const auto pinhole = [](const Pinhole& p) {
    const Pinhole::Intrinsics& k = p.intrinsics();
    const BrownLens::Coefficients& c = p.lens().coefficients();
    const double side = p.axes()[0].x < 0 ? -1 : 1;
    return Json{{"row_focal_px", side * k.row_scale},
                {"column_focal_px", k.column_scale},
                {"row_centre_px", k.row_0},
                {"column_centre_px", k.column_0},
                {"distortion", {{"k1", c.k1}, {"k2", c.k2}, {"p1", side * c.p1}, {"p2", c.p2}, {"k3", c.k3}}},
                {"centre_mm", json_of(p.centre())},
                {"along_rows", json_of(side * p.axes()[0])},
                {"along_columns", json_of(p.axes()[1])},
                {"axis", json_of(p.axis())}};
  };
  return {{"camera", pinhole(actual.camera)}, {"projector", pinhole(actual.projector)}};
}

// Renders frames first, first + 1, ... under the patterns into files whose names begin with `prefix`.
void capture(const PerturbedRig& actual, const Scene& scene, const std::vector<ProjectedLight>& patterns, int first,
             const std::string& prefix, const CaptureSettings& settings, files::OutputFolder& out) {
  const rig::Rig& rig = actual.rig;
  const PatternRenderer renderer(actual, scene, settings.render, settings.threads);
  std::mutex mutex;
  const auto count = static_cast<int>(patterns.size());
  const int digits = count > 100 ? 3 : 2;
  parallel_for(count, settings.threads, [&](int i) {
    const ProjectedLight& pattern = patterns[static_cast<std::size_t>(i)];
    const auto take = [&]<typename Pixel>(images::ImageOf<Pixel> image) {
      image.pixels.resize(rig.camera.pixels());
      renderer.render(first + i, pattern, std::span(image.pixels));
      return images::encode_png(image);
    };
    const std::string bytes = rig.measure.bits() > spec::kPixelBits
                                  ? take(images::WideImage{rig.camera.rows, rig.camera.columns, {}})
                                  : take(images::Image{rig.camera.rows, rig.camera.columns, {}});
    const std::lock_guard lock(mutex);
    out.append(fmt::format("{}{}image_{:0{}}.png", settings.prefix, prefix, i, digits), bytes);
    settings.done();
  });
}

}  // namespace

images::Image pattern_image(const images::FloatImage& pattern) {
  constexpr float kFull = 255;
  images::Image image{pattern.rows, pattern.columns, std::vector<std::uint8_t>(pattern.values.size())};
  std::transform(pattern.values.begin(), pattern.values.end(), image.pixels.begin(),
                 [](float value) { return static_cast<std::uint8_t>(std::lround(kFull * value)); });
  return image;
}

void take_images(const PatternRenderer& renderer, const PatternShots& shots,
                 const std::function<void(int i, const model::ImageView& image)>& take) {
  constexpr int kBatch = 8;
  const rig::Rig& rig = renderer.rig();
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

void capture_scene(const PerturbedRig& actual, const Scene& scene, const std::vector<ProjectedLight>& patterns,
                   const CaptureSettings& settings, files::OutputFolder& out) {
  capture(actual, scene, patterns, 0, "", settings, out);
}

void capture_chessboard(const PerturbedRig& actual, const ChessboardShape& shape, const ChessboardFlaws& flaws,
                        const std::vector<ChessboardPlace>& places, const std::vector<ProjectedLight>& patterns,
                        const CaptureSettings& settings, files::OutputFolder& out) {
  Json truth = truth_of(actual);
  truth["chessboard"] = {
      {"across_scale", flaws.across_scale}, {"down_scale", flaws.down_scale}, {"bend_mm", flaws.bend_mm}};
  for (std::size_t k = 0; k < places.size(); ++k) {
    const ChessboardPlace& place = places[k];
    truth["poses"].push_back(
        {{"middle_mm", json_of(place.middle)}, {"right", json_of(place.right)}, {"below", json_of(place.below)}});
    capture(actual, ChessboardScene(actual.rig, shape, place, flaws), patterns, static_cast<int>(k * patterns.size()),
            fmt::format("pose_{:02}/", k + 1), settings, out);
  }
  out.append(settings.prefix + "truth.json", files::json_text(truth, 2) + "\n");
}

ProjectedLight laser_light(const PerturbedRig& actual, const RenderOptions& options) {
  return throw_light(actual.rig, light_section::draw_straight_line(actual.rig, kLaserLine), options);
}

void capture_chessboard_and_laser(const PerturbedRig& actual, const ChessboardShape& shape,
                                  const ChessboardFlaws& flaws, const std::vector<ChessboardPlace>& places,
                                  const CaptureSettings& settings, files::OutputFolder& out) {
  constexpr double kRoomLight = 0.7;  // of white
  PerturbedRig in_room = actual;
  in_room.rig.imaging.ambient = std::max(actual.rig.imaging.ambient, kRoomLight * actual.rig.imaging.white);
  const ProjectedLight line = laser_light(actual, settings.render);
  const ProjectedLight dark = throw_light(
      actual.rig, images::FloatImage(actual.rig.projector.lines, actual.rig.projector.columns), settings.render);
  Json truth = truth_of(actual);
  truth["chessboard"] = {
      {"across_scale", flaws.across_scale}, {"down_scale", flaws.down_scale}, {"bend_mm", flaws.bend_mm}};
  std::mutex mutex;
  parallel_for(static_cast<int>(places.size()), settings.threads, [&](int i) {
    const ChessboardPlace& place = places[static_cast<std::size_t>(i)];
    const ChessboardScene scene(actual.rig, shape, place, flaws);
    const auto take = [&](const PerturbedRig& with, const ProjectedLight& light, int frame) {
      images::Image image{with.rig.camera.rows, with.rig.camera.columns,
                          std::vector<std::uint8_t>(with.rig.camera.pixels())};
      PatternRenderer(with, scene, settings.render, 1).render(frame, light, image.pixels);
      return images::encode_png(image);
    };
    const std::string board = take(in_room, dark, 2 * i);
    const std::string laser = take(actual, line, 2 * i + 1);
    const std::lock_guard lock(mutex);
    out.append(fmt::format("{}boards/pose_{:02}.png", settings.prefix, i + 1), board);
    out.append(fmt::format("{}lines/pose_{:02}.png", settings.prefix, i + 1), laser);
    settings.done();
  });
  for (const ChessboardPlace& place : places) {
    truth["poses"].push_back(
        {{"middle_mm", json_of(place.middle)}, {"right", json_of(place.right)}, {"below", json_of(place.below)}});
  }
  out.append(settings.prefix + "truth.json", files::json_text(truth, 2) + "\n");
}

int scan_images(const rig::Rig& rig, ScanMethod method) {
  return method == ScanMethod::gray_codes ? structured_light::GrayPointScan(rig).count()
                                          : structured_light::LinePointScan(rig).count();
}

structured_light::ProjectorPoints scan_points(const rig::Rig& rig, const Scene& scene, const RenderOptions& options,
                                              ScanMethod method, const std::function<void()>& done) {
  rig::Rig scanned = rig;
  scanned.imaging.seed += 1;
  const PatternRenderer renderer(scanned, scene, options);
  const auto points_of = [&](auto& scan, const std::function<images::Image(int)>& pattern) {
    take_images(renderer, {.count = scan.count(), .pattern = pattern}, [&](int /*i*/, const model::ImageView& image) {
      scan.add(image);
      done();
    });
    return scan.points();
  };
  if (method == ScanMethod::gray_codes) {
    structured_light::GrayPointScan scan(rig);
    const structured_light::GraySequence sequence(rig.projector.columns, rig.projector.lines);
    return points_of(scan, [&](int i) {
      return images::Image{sequence.rows(), sequence.columns(), sequence.image(i)};
    });
  }
  structured_light::LinePointScan scan(rig);
  return points_of(scan, [&](int i) { return pattern_image(structured_light::scan_pattern(rig, i)); });
}

std::vector<std::vector<double>> scan_centroids(const rig::Rig& rig, const PerturbedRig& actual, const Scene& scene,
                                                const images::FloatImage& pattern, const RenderOptions& options,
                                                std::span<const model::Mode> modes) {
  constexpr int kFrames = 16;
  PerturbedRig scanned = actual;
  scanned.rig.imaging.seed += 1;
  const LineRenderer renderer(scanned, scene, pattern, options);
  const int first = std::max(0, scene.frames() / 2 - kFrames / 2);
  std::vector<std::vector<std::uint8_t>> images(kFrames, std::vector<std::uint8_t>(rig.camera.pixels()));
  parallel_for(kFrames, 0, [&](int i) { renderer.render(first + i, std::span(images[static_cast<std::size_t>(i)])); });
  std::vector<std::vector<double>> result;
  for (const model::Mode mode : modes) {
    rig::Rig measured = rig;
    measured.measure.mode = mode;
    light_section::CentroidMean mean(measured);
    for (const auto& image : images) {
      mean.add(model::ImageView{image.data(), rig.camera.rows, rig.camera.columns, rig.camera.columns});
    }
    result.push_back(mean.centroids());
  }
  return result;
}

}  // namespace selfproj::sim
