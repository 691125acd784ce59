#include "sim/scene/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/lit_surface.h"
#include "sim/scene/parallel.h"

namespace selfproj::sim {
namespace {

constexpr double kAnyTime = 1e6;  // s
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

const images::FloatImage& checked(const images::FloatImage& pattern, const rig::RigProjector& projector) {
  check_pattern(pattern, projector);
  return pattern;
}

bool is_level(HeightRange heights) { return heights.high - heights.low <= kHeightTolerance; }

}  // namespace

Renderer::Renderer(const PerturbedRig& actual, const Scene& scene, const RenderOptions& options)
    : rig_(actual.rig),
      scene_(scene),
      options_(options),
      fold_(rig_.camera, options.camera_blur ? rig_.imaging.camera_blur_px : 0) {}

void Renderer::disturb(const PerturbedRig& actual, const Scene& scene, const LitSurface& surface) {
  disturbed_ = DisturbedCamera::of(actual, scene, surface, options_.world);
}

double Renderer::time_of_shot(int frame) const {
  const std::optional<Jitter>& jitter = options_.world.jitter;
  return time_of(frame) +
         (jitter ? lateness(*jitter, static_cast<std::uint64_t>(rig_.imaging.seed), frame, scene_.speed()) : 0);
}

void Renderer::render(int frame, const ProjectedLight& light, std::span<float> pixels) const {
  expose(frame, light, pixels);
  if (disturbed_) {
    disturbed_->add_light(
        {frame, time_of_shot(frame), rig_.camera.exposure_s, light, [&](std::span<float> z) { depths(frame, z); }},
        pixels);
  }
  add_noise(rig_.imaging, options_, frame, pixels);
  if (disturbed_) {
    disturbed_->add_faults(frame, pixels);
  }
  if (options_.quantization) {
    quantize(rig_.measure.bits(), pixels);
  }
}

void Renderer::render(int frame, const ProjectedLight& light, std::span<std::uint8_t> pixels) const {
  std::vector<float> values(pixels.size());
  render(frame, light, values);
  quantize(values, pixels);
}

void Renderer::render(int frame, const ProjectedLight& light, std::span<std::uint16_t> pixels) const {
  std::vector<float> values(pixels.size());
  render(frame, light, values);
  quantize(rig_.measure.bits(), values, pixels);
}

LineRenderer::LineRenderer(const PerturbedRig& actual, const Scene& scene, const images::FloatImage& pattern,
                           const RenderOptions& options)
    : Renderer(actual, scene, options),
      swinging_(options.world.vibration ? on_swinging_belt(scene, *options.world.vibration) : nullptr),
      camera_(actual.camera),
      projector_(actual.projector),
      surface_(actual, swinging_ ? *swinging_ : scene, options.falloff, options.world),
      light_(throw_light(actual.rig, checked(pattern, actual.rig.projector), options)),
      views_(actual, grid(), surface_.all_heights(-kAnyTime, kAnyTime)),
      levels_(std::make_unique<LevelBlocks>(grid().blocks())),
      column_views_(actual.camera, actual.rig.camera) {
  views_.set_light(light_);
  disturb(actual, swinging_ ? *swinging_ : scene, surface_);
}

void LineRenderer::set_pattern(const images::FloatImage& pattern) {
  light_ = throw_light(rig(), checked(pattern, rig().projector), options());
  views_.set_light(light_);
  levels_ = std::make_unique<LevelBlocks>(grid().blocks());
}

double LineRenderer::true_height(int frame, double x, double y) const { return scene().height(x, y, time_of(frame)); }

// The image without noise.
void LineRenderer::expose(int frame, const ProjectedLight& /*light*/, std::span<float> pixels) const {
  FrameLight light{time_of_shot(frame), exposure(), 1, {}};
  light.heights = surface_.all_heights(light.middle - light.exposure / 2, light.middle + light.exposure / 2);
  const double way = scene().speed() * light.exposure;  // in pixels of the nearest surface
  const double way_px =
      way * rig().camera.focal_length_mm / rig().camera.pixel_pitch_mm / (rig().plane_z_mm - light.heights.high);
  light.passes = std::clamp(static_cast<int>(std::ceil(way_px)), 1, 64);

  const double surroundings =
      rig().imaging.dark +
      (surface_.even_albedo() ? scene().albedo(0, 0, light.middle) * (rig().imaging.ambient - rig().imaging.dark) : 0);
  std::fill(pixels.begin(), pixels.end(), static_cast<float>(surroundings));
  SubPixelStrip strip(grid());
  for (int down = 0; down < grid().down(); ++down) {
    sample_strip(light, down, strip);
    if (strip.first < strip.last) {
      fold().add(strip, down, pixels);
    }
  }
}

void LineRenderer::depths(int frame, std::span<float> z) const {
  const double t = time_of_shot(frame);
  const HeightRange all = surface_.all_heights(t, t);
  const auto columns = static_cast<std::size_t>(rig().camera.columns);
  for (std::size_t i = 0; i < z.size(); ++i) {
    const std::size_t row = i / columns;
    const PixelPoint pixel{static_cast<double>(row), static_cast<double>(i % columns)};
    z[i] = static_cast<float>(surface_.hit(pixel, t, all).point.z);
  }
}

// The grey value that the projector's light adds at a surface point.
double LineRenderer::grey(const Hit& hit, double t, double highest) const {
  const double light = projector_.depth(hit.point) > 0 ? light_.at(projector_.project(hit.point), hit.point.z) : 0;
  return light > 0 ? (rig().imaging.white - rig().imaging.ambient) * light * surface_.lit_share(hit, t, highest) *
                         surface_.reflectance(hit, t)
                   : 0;
}

double LineRenderer::ambient() const { return surface_.even_albedo() ? 0 : rig().imaging.ambient - rig().imaging.dark; }

// Without projected light a pixel needs only one sample.
void LineRenderer::sample_dark(const FrameLight& light, int row, int column, HeightRange heights,
                               BlockValues& values) const {
  for (int i = 0; i < kBlockSide; ++i) {
    for (int j = 0; j < kBlockSide; ++j) {
      float& value = values[static_cast<std::size_t>(i * kBlockSide + j)];
      if (i % kSubPixels == 0 && j % kSubPixels == 0) {
        const int pixel_row = row + i / kSubPixels;
        const int pixel_column = column + j / kSubPixels;
        const Hit h =
            surface_.hit({static_cast<double>(pixel_row), static_cast<double>(pixel_column)}, light.middle, heights);
        value = static_cast<float>(ambient() * surface_.albedo(h.point, light.middle));
      } else {
        value = values[static_cast<std::size_t>((i - i % kSubPixels) * kBlockSide + j - j % kSubPixels)];
      }
    }
  }
}

// The instants of the exposure are dealt out so that each comes equally often in every row and in every column of
// sub-pixels. Even if a block is not level, or not wholly in the light, the surface that this pixel sees may be. Then
// slope and shadow are known for all rays that meet the level.
void LineRenderer::sample_pixel(const FrameLight& light, PixelPoint first, HeightRange heights,
                                LitSurface::Shadow shadow, float* to) const {
  std::array<Point3, std::size_t{kSubPixels} * kSubPixels> sights{};
  for (std::size_t k = 0; k < sights.size(); ++k) {
    const std::size_t down = k / kSubPixels;
    const std::size_t across = k % kSubPixels;
    sights[k] = surface_.sight(
        {first.row + static_cast<double>(down) / kSubPixels, first.column + static_cast<double>(across) / kSubPixels});
  }
  HeightRange level = heights;
  if (shadow == LitSurface::Shadow::some) {
    const Box tangents = tangents_of(sights);
    level = is_level(heights) ? heights : surface_.plateau(tangents, light.first(), light.last(), heights);
    if (is_level(level)) {
      shadow = surface_.shadow_on_level(tangents, level.low, light.first(), light.last(), light.heights.high);
    }
  }
  for (int k = 0; k < kSubPixels * kSubPixels; ++k) {
    const int i = k / kSubPixels;
    const int j = k % kSubPixels;
    double sum = 0;
    for (int pass = 0; pass < light.passes; ++pass) {
      const int instant = (i + j) % kSubPixels * light.passes + pass;
      const double t = light.middle + light.exposure * ((instant + 0.5) / (kSubPixels * light.passes) - 0.5);
      Hit h = surface_.hit_along(sights[static_cast<std::size_t>(k)], t, heights);
      const bool on_level = is_level(level) && h.height == level.low;
      h.level = h.level || on_level;
      if (!(on_level && shadow == LitSurface::Shadow::all)) {
        sum += grey(h, t, on_level && shadow == LitSurface::Shadow::none ? level.low : light.heights.high);
      }
      if (ambient() > 0) {
        sum += ambient() * surface_.albedo(h.point, t);
      }
    }
    to[i * kBlockSide + j] = static_cast<float>(sum / light.passes);
  }
}

bool LineRenderer::sample_block(const FrameLight& light, int down, int across, BlockValues& values) const {
  const std::size_t block = grid().block(down, across);
  const bool even = surface_.even_albedo();
  if (even && !views_.may_be_lit(block, light.heights)) {
    return false;
  }
  const Box& tangents = views_.tangents(block);
  const HeightRange heights = surface_.heights_between(tangents, light.first(), light.last(), light.heights);
  if (even && !views_.may_be_lit(block, heights)) {
    return false;
  }
  // With an even albedo a level block in the light is the same at all times.
  const bool keeps = even && is_level(heights) && light.passes == 1;
  const LevelBlocks::Kept* const kept = keeps ? levels_->find(block, heights.low) : nullptr;
  const int row = down * kBlockPixels - grid().margin();
  const int column = across * kBlockPixels - grid().margin();
  if (kept != nullptr ? kept->dark() : views_.is_dark(block, heights, light_)) {
    if (keeps && kept == nullptr) {
      levels_->keep(block, {heights.low, {}});
    }
    if (!even) {
      sample_dark(light, row, column, heights, values);
    }
    return !even;
  }
  const LitSurface::Shadow shadow = is_level(heights) ? surface_.shadow_on_level(tangents, heights.low, light.first(),
                                                                                 light.last(), light.heights.high)
                                                      : LitSurface::Shadow::some;
  if (even && shadow == LitSurface::Shadow::all) {
    return false;
  }
  if (kept != nullptr && shadow == LitSurface::Shadow::none) {
    std::copy(kept->values.begin(), kept->values.end(), values.begin());
    return true;
  }
  constexpr double kFirst = 0.5 / kSubPixels - 0.5;  // the first sub-pixel's middle, from the pixel's
  for (int i = 0; i < kBlockPixels; ++i) {
    for (int j = 0; j < kBlockPixels; ++j) {
      sample_pixel(light, {row + i + kFirst, column + j + kFirst}, heights, shadow,
                   values.data() + static_cast<std::ptrdiff_t>(i * kBlockSide + j) * kSubPixels);
    }
  }
  if (keeps && shadow == LitSurface::Shadow::none) {
    levels_->keep(block, {heights.low, {values.begin(), values.end()}});
  }
  return true;
}

void LineRenderer::sample_strip(const FrameLight& light, int down, SubPixelStrip& strip) const {
  BlockValues values{};
  strip.first = strip.last = 0;
  for (int across = 0; across < grid().across(); ++across) {
    if (!sample_block(light, down, across, values)) {
      continue;
    }
    if (strip.first == strip.last) {
      std::fill(strip.samples.begin(), strip.samples.end(), 0.0F);
      strip.first = across * kBlockSide;
    }
    strip.last = (across + 1) * kBlockSide;
    for (int i = 0; i < kBlockSide; ++i) {
      std::copy_n(values.data() + i * kBlockSide, kBlockSide, strip.row(i) + across * kBlockSide);
    }
  }
}

// The distance, in projector lines, between the light sheet and the point that a ray meets: negative on one side of the
// sheet; NaN where there is no light.
double LineRenderer::miss(Point3 sight, double t, HeightRange heights) const {
  const Hit h = surface_.hit_along(sight, t, heights);
  if (projector_.depth(h.point) <= 0) {
    return kNan;
  }
  const PixelPoint p = projector_.project(h.point);
  return p.row - light_.line_centre(p.column);
}

// 1 or -1 if all points at which the rays between these bounds of sights meet heights in this range certainly lie on
// one side of the sheet, with the sign that miss() has there; otherwise nothing.
std::optional<double> LineRenderer::side_of_sheet(const Box& tangents, HeightRange heights) const {
  constexpr double kRounding = 1e-3;  // mm, and more than the tolerance of heights
  const Point3 centre = camera_.centre();
  std::array<Point3, 8> points{};
  std::size_t count = 0;
  for (const double x : {tangents.x0, tangents.x1}) {
    for (const double y : {tangents.y0, tangents.y1}) {
      for (const double h : {heights.low - kRounding, heights.high + kRounding}) {
        points.at(count++) = centre + (rig().plane_z_mm - h - centre.z) * Point3{x, y, 1};
      }
    }
  }
  if (!std::all_of(points.begin(), points.end(), [&](Point3 p) { return projector_.sees(p); })) {
    return std::nullopt;
  }
  const std::optional<PixelBounds> b = projector_.bounds(points);
  constexpr double kLines = 1e-6;
  const auto centres = b ? light_.line_centres(b->column_0 - kLines, b->column_1 + kLines) : std::nullopt;
  if (!centres || (b->row_0 - kLines <= centres->high && b->row_1 + kLines >= centres->low)) {
    return std::nullopt;
  }
  return b->row_0 > centres->high ? 1 : -1;
}

// Whether the surface at this place of a column, between two of its rows, is on the light sheet and in the light.
std::optional<LitSurface::Hit> LineRenderer::hit_on_sheet(double row, int column, double above, double t,
                                                          HeightRange heights) const {
  constexpr int kHalvings = 24;
  const auto sight = [&](double at) { return surface_.sight({at, column + 0.0}); };
  double low = row - 0.5;
  double high = row + 0.5;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (low + high) / 2;
    ((miss(sight(middle), t, heights) < 0) == (above < 0) ? low : high) = middle;
  }
  constexpr double kThere = 0.01;  // a jump of the surface across the sheet is no crossing
  const Hit hit = surface_.hit_along(sight(low), t, heights);
  return std::abs(miss(sight(low), t, heights)) < kThere && surface_.lit_share(hit, t, heights.high) > 0
             ? std::optional(hit)
             : std::nullopt;
}

// Where a column's rays cross the sheet. Parts of the column whose rays all end on one side of it are left out.
void LineRenderer::truth(int frame, std::span<float> heights, std::span<Point3> points) const {
  const double t = time_of(frame);
  const HeightRange all = surface_.all_heights(t, t);
  const ColumnViews& views = column_views_;
  for (int column = 0; column < rig().camera.columns; ++column) {
    int seen = 0;
    double height = kNan;
    std::optional<double> above;  // the miss at the upper edge of the row; nothing above the first one
    for (int part = 0; part < views.parts(); ++part) {
      const Box& tangents = views.tangents(column, part);
      const HeightRange near = surface_.heights_between(tangents, t, t, all);
      if (const auto side = side_of_sheet(tangents, near)) {
        above = side;
        continue;
      }
      const std::span<const Point3> edges = views.edges(column, part);
      for (int i = 0; i < views.rows_of(part); ++i) {
        const auto edge = static_cast<std::size_t>(i);
        above = above ? above : miss(edges[edge], t, all);
        const double below = miss(edges[edge + 1], t, all);
        if ((*above < 0) != (below < 0) && !std::isnan(*above) && !std::isnan(below)) {
          if (const auto hit = hit_on_sheet(views.first_row(part) + i, column, *above, t, all)) {
            ++seen;
            height = hit->height;
            if (!points.empty()) {
              points[static_cast<std::size_t>(column)] = hit->point;
            }
          }
        }
        above = below;
      }
    }
    heights[static_cast<std::size_t>(column)] = static_cast<float>(seen == 1 ? height : kNan);
  }
}

images::FloatImage LineRenderer::truth(int first, int count, int threads) const {
  images::FloatImage result(count, rig().camera.columns);
  parallel_for(count, threads, [&](int i) {
    truth(first + i, {result.row(i), static_cast<std::size_t>(result.columns)});
  });
  return result;
}

}  // namespace selfproj::sim
