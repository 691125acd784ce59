#include "sim/scene/still_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include "sim/scene/blocks.h"
#include "sim/scene/lit_surface.h"
#include "sim/scene/optics.h"
#include "sim/scene/parallel.h"

namespace selfproj::sim {

StillSurface::StillSurface(const PerturbedRig& actual, const Scene& scene, const RenderOptions& options, int threads)
    : imaging_(actual.rig.imaging),
      camera_(actual.camera),
      projector_(actual.projector),
      surface_(actual, scene, options.falloff, options.world),
      heights_(surface_.all_heights(0, 0)),
      grid_(actual.rig.camera, lens_margin(options.camera_blur ? imaging_.camera_blur_px : 0)),
      blocks_(grid_.blocks()),
      nodes_(grid_.nodes()),
      centres_(actual.rig.camera.pixels()) {
  const rig::RigCamera& camera = actual.rig.camera;
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

namespace {

// The part of the image that holds all points between some (their convex hull).
class ImageBounds {
 public:
  void add(Point3 p) { points_.push_back(p); }

  // Sets the bit of a body in the masks of the blocks there. That is the whole image if a point is nearer than 1 mm in
  // front of the pinhole, because it may then be seen anywhere.
  void mark(const StillSurface& still, const rig::RigCamera& camera, std::size_t body,
            std::vector<std::uint32_t>& masks) const {
    const BlockGrid& grid = still.grid();
    const int margin = grid.margin();
    constexpr double kFar = 1e6;
    PixelBounds b{-kFar, kFar, -kFar, kFar};
    if (std::all_of(points_.begin(), points_.end(), [&](Point3 p) { return still.camera().depth(p) >= kNear; })) {
      b = still.camera().bounds(points_).value_or(b);
    }
    if (b.row_1 < -margin - 0.5 || b.column_1 < -margin - 0.5 || b.row_0 > camera.rows + margin ||
        b.column_0 > camera.columns + margin) {
      return;
    }
    const auto block_of = [&](double pixel, int most) {
      return static_cast<int>(std::clamp((pixel + 0.5 + margin) / kBlockPixels, 0.0, most - 1.0));
    };
    for (int down = block_of(b.row_0, grid.down()); down <= block_of(b.row_1, grid.down()); ++down) {
      for (int across = block_of(b.column_0, grid.across()); across <= block_of(b.column_1, grid.across()); ++across) {
        masks[grid.block(down, across)] |= std::uint32_t{1} << body;
      }
    }
  }

  static constexpr double kNear = 1;  // mm

 private:
  std::vector<Point3> points_;
};

// Marks the blocks in which a body with these bounds may be seen, and those on whose points its shadow may fall, that
// is, all that lies behind it as the projector sees it, down to the deepest surface.
void mark(const rig::Rig& rig, const StillSurface& still, std::size_t body, const Cuboid& bounds, BodyMotion& motion) {
  const Point3 centre = still.projector().centre();
  const double deepest = rig.plane_z_mm - still.heights().low;
  ImageBounds seen;
  ImageBounds shadow;
  for (const double x : {bounds.low.x, bounds.high.x}) {
    for (const double y : {bounds.low.y, bounds.high.y}) {
      for (const double z : {bounds.low.z, bounds.high.z}) {
        const Point3 corner{x, y, z};
        seen.add(corner);
        shadow.add(corner);
        if (z >= deepest) {
          continue;
        }
        const double below = z - centre.z;  // below the projector
        shadow.add(below > ImageBounds::kNear ? centre + (deepest - centre.z) / below * (corner - centre)
                                              : still.camera().centre());
      }
    }
  }
  seen.mark(still, rig.camera, body, motion.seen);
  shadow.mark(still, rig.camera, body, motion.shaded);
}

// The bodies of a mask that come within `slack` of the line at one of the three times.
std::uint32_t near_ones(const BodyMotion& motion, std::uint32_t mask, const Ray& line, double slack) {
  std::uint32_t result = mask;
  for (std::uint32_t rest = mask; rest != 0; rest &= rest - 1) {
    const auto body = static_cast<std::size_t>(__builtin_ctz(rest));
    if (std::none_of(motion.ends.begin(), motion.ends.end(),
                     [&](const Bodies& bodies) { return bodies[body]->is_near(line, slack); })) {
      result ^= std::uint32_t{1} << body;
    }
  }
  return result;
}

// Removes from the masks of the blocks the bodies that are too far from the block's rays, and from the rays of light to
// the surface in it. `way` is how far a body moves between two of the three times.
void narrow(const rig::Rig& rig, const StillSurface& still, double way, BodyMotion& motion) {
  const BlockGrid& grid = still.grid();
  const Point3 camera = still.camera().centre();
  const double deepest = rig.plane_z_mm - still.heights().low;
  constexpr double kHalfDiagonal = kBlockPixels * std::numbers::sqrt2 / 2;
  const double slack = deepest * kHalfDiagonal * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
  for (int down = 0; down < grid.down(); ++down) {
    for (int across = 0; across < grid.across(); ++across) {
      const std::size_t index = grid.block(down, across);
      const StillSurface::Block& block = still.block(index);
      const Point3 sight = still.camera().sight(grid.node_pixel(2 * down + 1, 2 * across + 1));
      motion.seen[index] = near_ones(motion, motion.seen[index], {camera, sight}, slack + way);
      if (motion.seen[index] != 0 || motion.shaded[index] == 0 || block.samples >= 0) {
        continue;  // what is seen may be anywhere
      }
      const double z = static_cast<double>(still.node(grid.node(2 * down + 1, 2 * across + 1)).z);
      const Point3 middle = camera + (z - camera.z) * sight;
      double furthest = 0;
      for (const int corner : {0, 1, 2, 3}) {
        const PixelPoint pixel = grid.node_pixel(2 * (down + corner / 2), 2 * (across + corner % 2));
        const Point3 d =
            still.camera().point_at(pixel, static_cast<double>(block.corners[static_cast<std::size_t>(corner)].z)) -
            middle;
        furthest = std::max(furthest, std::sqrt(dot(d, d)));
      }
      motion.shaded[index] =
          near_ones(motion, motion.shaded[index], {middle, still.projector().centre() - middle}, furthest + way);
    }
  }
}

// The bounds of a body over all sampled times.
Cuboid bounds_of(const BodyMotion& motion, std::size_t body) {
  Cuboid all = motion.ends[0].at(body)->bounds();
  const auto join = [&](const Bodies& bodies) {
    const Cuboid now = bodies.at(body)->bounds();
    all = {{std::min(all.low.x, now.low.x), std::min(all.low.y, now.low.y), std::min(all.low.z, now.low.z)},
           {std::max(all.high.x, now.high.x), std::max(all.high.y, now.high.y), std::max(all.high.z, now.high.z)}};
  };
  std::for_each(motion.ends.begin(), motion.ends.end(), join);
  std::for_each(motion.instants.begin(), motion.instants.end(), join);
  return all;
}

}  // namespace

BodyMotion body_motion(const rig::Rig& rig, const Scene& scene, const StillSurface& still, double middle,
                       double exposure) {
  BodyMotion motion;
  motion.ends[1] = scene.bodies(middle);
  const std::size_t count = motion.ends[1].size();
  if (count == 0) {
    return motion;
  }
  motion.ends[0] = scene.bodies(middle - exposure / 2);
  motion.ends[2] = scene.bodies(middle + exposure / 2);
  double nearest = rig.plane_z_mm;
  for (const auto& body : motion.ends[1]) {
    nearest = std::min(nearest, body->bounds().low.z);
  }
  const double way_px =
      scene.body_speed() * exposure * rig.camera.focal_length_mm / rig.camera.pixel_pitch_mm / std::max(nearest, 1.0);
  constexpr double kWayPx = 0.75;  // from one instant to the next
  constexpr int kMaxPasses = 64;
  motion.passes = std::clamp(static_cast<int>(std::ceil(way_px / (kWayPx * kSubPixels))), 1, kMaxPasses);
  const int instants = kSubPixels * motion.passes;
  for (int i = 0; i < instants; ++i) {
    motion.instants.push_back(scene.bodies(middle + exposure * ((i + 0.5) / instants - 0.5)));
  }
  motion.seen.resize(still.grid().blocks());
  motion.shaded.resize(still.grid().blocks());
  for (std::size_t body = 0; body < count; ++body) {
    mark(rig, still, body, bounds_of(motion, body), motion);
  }
  narrow(rig, still, scene.body_speed() * exposure / 4, motion);
  return motion;
}

}  // namespace selfproj::sim
