#include "sim/scene/body_motion.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "sim/scene/block_grid.h"
#include "sim/scene/pinhole.h"

namespace selfproj {
namespace {

// The part of the image that holds all points between some (their convex hull).
class ImageBounds {
 public:
  void add(Point3 p) { points_.push_back(p); }

  // Sets the bit of a body in the masks of the blocks there. That is the whole image if a point is nearer than 1 mm in
  // front of the pinhole, because it may then be seen anywhere.
  void mark(const StillSurface& still, const RigCamera& camera, std::size_t body,
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
void mark(const Rig& rig, const StillSurface& still, std::size_t body, const Cuboid& bounds, BodyMotion& motion) {
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
void narrow(const Rig& rig, const StillSurface& still, double way, BodyMotion& motion) {
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

BodyMotion body_motion(const Rig& rig, const Scene& scene, const StillSurface& still, double middle, double exposure) {
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
  constexpr int kMostPasses = 64;
  motion.passes = std::clamp(static_cast<int>(std::ceil(way_px / (kWayPx * kSubPixels))), 1, kMostPasses);
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

}  // namespace selfproj
