#include "sim/scene/still_surface.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
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

// If the surface is level, the nodes suffice. Otherwise all sub-pixels are traced, and dropped again if the corners can
// stand for them.
void StillSurface::trace_block(int down, int across, Block& block, std::vector<LightSpot>& samples) const {
  const auto node_of_block = [&](int d, int a) -> const LightSpot& {
    return nodes_[grid_.node(2 * down + d, 2 * across + a)];
  };
  block.corners = {node_of_block(0, 0), node_of_block(0, 2), node_of_block(2, 0), node_of_block(2, 2)};
  const HeightRange heights = surface_.heights_between(grid_.node_pixel(2 * down, 2 * across),
                                                       grid_.node_pixel(2 * down + 2, 2 * across + 2), 0, 0, heights_);
  constexpr LightSpot kLinear{kDepthTolerance, kPlaceTolerance, kPlaceTolerance, kGreyTolerance, kGreyTolerance};
  bool linear = true;
  for (int d = 0; d <= 2; ++d) {
    for (int a = 0; a <= 2; ++a) {
      linear = linear && alike(node_of_block(d, a),
                               between(block.corners, static_cast<float>(d) / 2, static_cast<float>(a) / 2), kLinear);
    }
  }
  if (linear && heights.high - heights.low <= kHeightTolerance && surface_.even_albedo()) {
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

void StillSurface::values(const Block& block, const ProjectedLight& pattern, Shade shade, BlockValues& values) const {
  const bool dark = shade == Shade::dark;
  float* to = values.data();
  if (block.samples >= 0) {
    const LightSpot* from = samples_.data() + block.samples;
    std::transform(from, from + kBlockSamples, to,
                   [&](const LightSpot& spot) { return dark ? spot.ambient : spot.grey(pattern); });
    return;
  }
  SpotBounds bounds;
  for (const LightSpot& corner : block.corners) {
    bounds.add(corner);
  }
  const MinMaxPyramid::Range range = dark ? MinMaxPyramid::Range{0, 0} : bounds.light_of(pattern);
  const bool same = range.high - range.low <= kSameLight;
  for (int i = 0; i < kBlockSide; ++i) {
    const float down = (static_cast<float>(i) + 0.5F) / kBlockSide;
    const LightSpot left = mix(block.corners[0], block.corners[2], down);
    const LightSpot right = mix(block.corners[1], block.corners[3], down);
    for (int j = 0; j < kBlockSide; ++j) {
      const float across = (static_cast<float>(j) + 0.5F) / kBlockSide;
      const float light = same ? range.high
                               : pattern.quick_at(mix(left.line, right.line, across),
                                                  mix(left.column, right.column, across), mix(left.z, right.z, across));
      *to++ = mix(left.ambient, right.ambient, across) + light * mix(left.light, right.light, across);
    }
  }
}

}  // namespace selfproj
