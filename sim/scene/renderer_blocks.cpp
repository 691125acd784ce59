// The sub-pixels of a line's renderer, block by block.
#include <algorithm>
#include <array>
#include <cstddef>

#include "sim/scene/ray.h"
#include "sim/scene/renderer.h"

namespace selfproj {
namespace {

bool is_level(HeightRange heights) { return heights.high - heights.low <= kHeightTolerance; }

}  // namespace

// The grey value that the projector's light adds at a surface point.
double Renderer::grey(const Hit& hit, double t, double highest) const {
  const double light = projector_.depth(hit.point) > 0 ? light_.at(projector_.project(hit.point), hit.point.z) : 0;
  return light > 0 ? (rig_.imaging.white - rig_.imaging.ambient) * light * surface_.lit_share(hit, t, highest) *
                         surface_.reflectance(hit, t)
                   : 0;
}

double Renderer::ambient() const { return surface_.even_albedo() ? 0 : rig_.imaging.ambient - rig_.imaging.dark; }

// Without projected light a pixel needs only one sample.
void Renderer::sample_dark(const Light& light, int row, int column, HeightRange heights, BlockValues& values) const {
  for (int i = 0; i < kBlockSide; ++i) {
    for (int j = 0; j < kBlockSide; ++j) {
      float& value = values[static_cast<std::size_t>(i * kBlockSide + j)];
      if (i % kSub == 0 && j % kSub == 0) {
        const int pixel_row = row + i / kSub;
        const int pixel_column = column + j / kSub;
        const Hit h =
            surface_.hit({static_cast<double>(pixel_row), static_cast<double>(pixel_column)}, light.middle, heights);
        value = static_cast<float>(ambient() * surface_.albedo(h.point, light.middle));
      } else {
        value = values[static_cast<std::size_t>((i - i % kSub) * kBlockSide + j - j % kSub)];
      }
    }
  }
}

// The instants of the exposure are dealt out so that each comes equally often in every row and in every column of
// sub-pixels. Even if a block is not level, or not wholly in the light, the surface that this pixel sees may be. Then
// slope and shadow are known for all rays that meet the level.
void Renderer::sample_pixel(const Light& light, PixelPoint first, HeightRange heights, LitSurface::Shadow shadow,
                            float* to) const {
  std::array<Point3, std::size_t{kSub} * kSub> sights{};
  for (std::size_t k = 0; k < sights.size(); ++k) {
    const std::size_t down = k / kSub;
    const std::size_t across = k % kSub;
    sights[k] = surface_.sight(
        {first.row + static_cast<double>(down) / kSub, first.column + static_cast<double>(across) / kSub});
  }
  HeightRange level = heights;
  if (shadow == LitSurface::Shadow::some) {
    const Box tangents = tangents_of(sights);
    level = is_level(heights) ? heights : surface_.plateau(tangents, light.first(), light.last(), heights);
    if (is_level(level)) {
      shadow = surface_.shadow_on_level(tangents, level.low, light.first(), light.last(), light.heights.high);
    }
  }
  for (int k = 0; k < kSub * kSub; ++k) {
    const int i = k / kSub;
    const int j = k % kSub;
    double sum = 0;
    for (int pass = 0; pass < light.passes; ++pass) {
      const int instant = (i + j) % kSub * light.passes + pass;
      const double t = light.middle + light.exposure * ((instant + 0.5) / (kSub * light.passes) - 0.5);
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

bool Renderer::sample_block(const Light& light, int down, int across, BlockValues& values) const {
  const std::size_t block = grid_.block(down, across);
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
  const int row = down * kBlock - grid_.margin();
  const int column = across * kBlock - grid_.margin();
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
  constexpr double kFirst = 0.5 / kSub - 0.5;  // the first sub-pixel's middle, from the pixel's
  for (int i = 0; i < kBlock; ++i) {
    for (int j = 0; j < kBlock; ++j) {
      sample_pixel(light, {row + i + kFirst, column + j + kFirst}, heights, shadow,
                   values.data() + static_cast<std::ptrdiff_t>(i * kBlockSide + j) * kSub);
    }
  }
  if (keeps && shadow == LitSurface::Shadow::none) {
    levels_->keep(block, {heights.low, {values.begin(), values.end()}});
  }
  return true;
}

void Renderer::sample_strip(const Light& light, int down, Strip& strip) const {
  BlockValues values{};
  strip.first = strip.last = 0;
  for (int across = 0; across < grid_.across(); ++across) {
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

}  // namespace selfproj
