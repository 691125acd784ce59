#include "sim/scene/still_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/scene/lens_kernel.h"
#include "sim/scene/parallel.h"
#include "sim/scene/ray.h"

namespace selfproj {

StillSurface::StillSurface(const RealRig& real, const Scene& scene, const RenderOptions& options, int threads)
    : imaging_(real.rig.imaging),
      camera_(real.camera),
      projector_(real.projector),
      surface_(real, scene, options.falloff, options.world),
      heights_(surface_.all_heights(0, 0)),
      grid_(real.rig.camera, lens_margin(options.camera_blur ? imaging_.camera_blur_px : 0)),
      blocks_(grid_.blocks()),
      nodes_(grid_.nodes()),
      centres_(real.rig.camera.pixels()) {
  const RigCamera& camera = real.rig.camera;
  parallel_for(grid_.nodes_down(), threads, [&](int down) {
    for (int across = 0; across < grid_.nodes_across(); ++across) {
      nodes_[grid_.node(down, across)] = trace(grid_.node_pixel(down, across), heights_);
    }
  });
  parallel_for(camera.rows, threads, [&](int row) {
    for (int column = 0; column < camera.columns; ++column) {
      centres_[static_cast<std::size_t>(row * camera.columns + column)] = trace({row + 0.0, column + 0.0}, heights_);
    }
  });
  std::vector<std::vector<LightSpot>> samples(static_cast<std::size_t>(grid_.down()));
  parallel_for(grid_.down(), threads, [&](int down) {
    for (int across = 0; across < grid_.across(); ++across) {
      trace_block(down, across, blocks_[grid_.block(down, across)], samples[static_cast<std::size_t>(down)]);
    }
  });
  for (int down = 0; down < grid_.down(); ++down) {
    const auto before = static_cast<std::int64_t>(samples_.size());
    for (int across = 0; across < grid_.across(); ++across) {
      Block& block = blocks_[grid_.block(down, across)];
      block.samples += block.samples < 0 ? 0 : before;
    }
    std::vector<LightSpot>& row = samples[static_cast<std::size_t>(down)];
    samples_.insert(samples_.end(), row.begin(), row.end());
    row = {};
  }
  for (const Block& block : blocks_) {
    bounds_.push_back(bounds_of(block));
  }
}

SpotBounds StillSurface::bounds_of(const Block& block) const {
  SpotBounds bounds;
  const LightSpot* const samples = samples_.data() + std::max<std::int64_t>(0, block.samples);
  const std::span<const LightSpot> spots = block.samples < 0
                                               ? std::span<const LightSpot>(block.corners)
                                               : std::span<const LightSpot>(samples, std::size_t{kBlockSamples});
  for (const LightSpot& spot : spots) {
    bounds.add(spot);
  }
  return bounds;
}

LightSpot StillSurface::spot_of(Point3 point, double share, double albedo, double reflectance) const {
  LightSpot spot;
  spot.z = static_cast<float>(point.z);
  spot.ambient = static_cast<float>(imaging_.dark + albedo * (imaging_.ambient - imaging_.dark));
  if (projector_.depth(point) > 0) {
    const PixelPoint p = projector_.project(point);
    spot.line = static_cast<float>(p.row);
    spot.column = static_cast<float>(p.column);
    spot.light = static_cast<float>(reflectance * share * (imaging_.white - imaging_.ambient));
  }
  return spot;
}

LightSpot StillSurface::trace(PixelPoint pixel, HeightRange heights) const {
  const LitSurface::Hit hit = surface_.hit(pixel, 0, heights);
  return spot_of(hit.point, surface_.lit_share(hit, 0, heights_.high), surface_.albedo(hit.point, 0),
                 surface_.reflectance(hit, 0));
}

// Whether the spots of a block are linear between its nodes, well within the tolerances. This is so if the surface
// hardly bends over the block, is lit all over, has one albedo and throws no shadow on itself.
bool StillSurface::is_smooth(int down, int across, HeightRange heights, const Block& block) const {
  const Box box = surface_.footprint(grid_.node_pixel(2 * down, 2 * across),
                                     grid_.node_pixel(2 * down + 2, 2 * across + 2), heights);
  const Smoothness smooth = surface_.smoothness(box);
  const double size = std::hypot(box.x1 - box.x0, box.y1 - box.y0);
  const double off = smooth.curvature * size * size / 4;  // mm of z, from linear
  if (!(off <= static_cast<double>(kDepthTolerance) / 2)) {
    return false;
  }
  float light = 0;
  for (const LightSpot& corner : block.corners) {
    if (!(corner.light > 0)) {
      return false;
    }
    light = std::max(light, corner.light);
  }
  const Point3 middle{(box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2, static_cast<double>(block.corners[0].z)};
  const PixelPoint here = projector_.project(middle);
  const PixelPoint below = projector_.project(middle + Point3{0, 0, 1});
  const double lines_a_mm = 2 * std::max(std::abs(below.row - here.row), std::abs(below.column - here.column));
  const double tilted = size * size * (smooth.change + smooth.curvature * smooth.curvature);  // from linear
  return off * lines_a_mm <= static_cast<double>(kPlaceTolerance) / 2 &&
         4 * static_cast<double>(light) * tilted <= static_cast<double>(kGreyTolerance) / 2 &&
         surface_.is_above_all(middle);
}

// If the surface is level or smooth, the nodes suffice. Otherwise all sub-pixels are traced, and dropped again if the
// corners can stand for them.
void StillSurface::trace_block(int down, int across, Block& block, std::vector<LightSpot>& samples) const {
  const auto node_of_block = [&](int d, int a) -> const LightSpot& {
    return nodes_[grid_.node(2 * down + d, 2 * across + a)];
  };
  block.corners = {node_of_block(0, 0), node_of_block(0, 2), node_of_block(2, 0), node_of_block(2, 2)};
  const HeightRange heights = surface_.heights_between(grid_.node_pixel(2 * down, 2 * across),
                                                       grid_.node_pixel(2 * down + 2, 2 * across + 2), 0, 0, heights_);
  constexpr LightSpot kLinear{kDepthTolerance, kPlaceTolerance, kPlaceTolerance, kGreyTolerance, kGreyTolerance};
  constexpr LightSpot kHalf{kDepthTolerance / 2, kPlaceTolerance / 2, kPlaceTolerance / 2, kGreyTolerance / 2,
                            kGreyTolerance / 2};
  bool linear = true;
  bool surely = true;
  for (int d = 0; d <= 2; ++d) {
    for (int a = 0; a <= 2; ++a) {
      const LightSpot straight = between(block.corners, static_cast<float>(d) / 2, static_cast<float>(a) / 2);
      linear = linear && alike(node_of_block(d, a), straight, kLinear);
      surely = surely && alike(node_of_block(d, a), straight, kHalf);
    }
  }
  if (linear && heights.high - heights.low <= kHeightTolerance && surface_.even_albedo()) {
    return;
  }
  if (surely && is_smooth(down, across, heights, block)) {
    return;
  }
  const std::size_t first = samples.size();
  for (int i = 0; i < kBlockSide; ++i) {
    for (int j = 0; j < kBlockSide; ++j) {
      samples.push_back(trace(grid_.sample_pixel(down, across, i, j), heights));
      linear = linear && alike(samples.back(), sample(block, i, j), kLinear);
    }
  }
  if (linear) {
    samples.resize(first);
  } else {
    block.samples = static_cast<std::int64_t>(first);
  }
}

void StillSurface::values(std::size_t index, const ProjectedLight& pattern, Shade shade, BlockValues& values) const {
  const Block& block = blocks_[index];
  const bool dark = shade == Shade::dark;
  float* to = values.data();
  if (block.samples >= 0) {
    const LightSpot* from = samples_.data() + block.samples;
    std::transform(from, from + kBlockSamples, to,
                   [&](const LightSpot& spot) { return dark ? spot.ambient : spot.grey(pattern); });
    return;
  }
  const MinMaxPyramid::Range range = dark ? MinMaxPyramid::Range{0, 0} : bounds_[index].light_of(pattern);
  const bool same = range.high - range.low <= kSameLight;
  for (int i = 0; i < kBlockSide; ++i, to += kBlockSide) {
    const float down = (static_cast<float>(i) + 0.5F) / kBlockSide;
    const LightSpot left = mix(block.corners[0], block.corners[2], down);
    const LightSpot right = mix(block.corners[1], block.corners[3], down);
    std::array<float, kBlockSide> light;
    light.fill(range.high);
    for (int j = 0; j < kBlockSide && !same; ++j) {
      const float across = (static_cast<float>(j) + 0.5F) / kBlockSide;
      light[static_cast<std::size_t>(j)] = pattern.quick_at(
          mix(left.line, right.line, across), mix(left.column, right.column, across), mix(left.z, right.z, across));
    }
    for (int j = 0; j < kBlockSide; ++j) {
      const float across = (static_cast<float>(j) + 0.5F) / kBlockSide;
      to[j] = mix(left.ambient, right.ambient, across) +
              light[static_cast<std::size_t>(j)] * mix(left.light, right.light, across);
    }
  }
}

}  // namespace selfproj
