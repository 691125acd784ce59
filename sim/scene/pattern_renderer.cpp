#include "sim/scene/pattern_renderer.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <vector>

#include "sim/scene/blocks.h"
#include "sim/scene/lit_surface.h"
#include "sim/scene/optics.h"
#include "sim/scene/scene.h"
#include "sim/scene/still_surface.h"

namespace selfproj::sim {
namespace {

const Scene& checked(const Scene& scene) {
  if (scene.speed() != 0) {
    throw std::invalid_argument("a surface that moves is not for patterns: its bodies may");
  }
  if (scene.bodies(0).size() > Scene::kMaxBodies) {
    throw std::invalid_argument("a scene of too many bodies");
  }
  return scene;
}

// The point that a ray meets if the scene has bodies.
struct Look {
  LightSpot spot;
  int body = -1;      // -1: the surface
  bool dark = false;  // in the shadow of a body; for a body, in any shadow
};
using Nodes = std::array<Look, 9>;  // of a block, row by row: corners, middles of the sides, middle

// `still` is what the ray meets on the surface. `seen` and `shaded` are the bodies that may matter.
Look look(const StillSurface& surface, PixelPoint pixel, const LightSpot& still, const Bodies& bodies,
          std::uint32_t seen, std::uint32_t shaded) {
  const Point3 centre = surface.camera().centre();
  const Point3 sight = surface.camera().sight(pixel);  // s is the way along z
  Look result;
  Meeting nearest;
  nearest.s = static_cast<double>(still.z) - centre.z;
  for (std::uint32_t rest = seen; rest != 0; rest &= rest - 1) {
    const int body = __builtin_ctz(rest);
    if (bodies[static_cast<std::size_t>(body)]->meets({centre, sight}, nearest.s, nearest)) {
      result.body = body;
    }
  }
  const Point3 point = centre + nearest.s * sight;
  const auto shaded_from = [&](Point3 from) {
    const Ray light{from, surface.projector().centre() - from};
    for (std::uint32_t rest = shaded; rest != 0; rest &= rest - 1) {
      if (bodies[static_cast<std::size_t>(__builtin_ctz(rest))]->blocks(light, 1)) {
        return true;
      }
    }
    return false;
  };
  if (result.body < 0) {
    result.spot = still;
    result.dark = still.light > 0 && shaded_from(point);
    result.spot.light = result.dark ? 0 : still.light;
    return result;
  }
  double share = surface.surface().incidence(point, nearest.normal);
  if (share > 0 && (surface.surface().in_shadow(point, nearest.normal, 0, surface.heights().high) ||
                    shaded_from(point + kShadowLift * nearest.normal))) {
    share = 0;
  }
  result.dark = share <= 0;
  const double albedo = bodies[static_cast<std::size_t>(result.body)]->albedo();
  result.spot = surface.spot_of(point, share, albedo, surface.surface().reflectance(point, nearest.normal, albedo));
  return result;
}

// The parabola through three nodes, at the sub-pixel row or column i.
struct Parabola {
  explicit Parabola(int i) {
    const float u = (static_cast<float>(i) + 0.5F) / kBlockSide;
    weights = {(2 * u - 1) * (u - 1), 4 * u * (1 - u), u * (2 * u - 1)};
  }
  [[nodiscard]] LightSpot through(const LightSpot& a, const LightSpot& b, const LightSpot& c) const {
    const auto sum = [&](float p, float q, float r) { return weights[0] * p + weights[1] * q + weights[2] * r; };
    return {sum(a.z, b.z, c.z), sum(a.line, b.line, c.line), sum(a.column, b.column, c.column),
            sum(a.light, b.light, c.light), sum(a.ambient, b.ambient, c.ambient)};
  }
  std::array<float, 3> weights{};
};

// Whether a body's spots are nearly parabolas over the block, and linear in time. A parabola leaves a much smaller
// error than its own deviation from a straight line.
bool is_smooth(const std::array<Nodes, 3>& looks) {
  constexpr LightSpot kBend{0.5F, 0.25F, 0.25F, 3, 3};
  constexpr LightSpot kInTime{kDepthTolerance, 0.05F, 0.05F, kGreyTolerance, kGreyTolerance};
  for (std::size_t n = 0; n < looks[0].size(); ++n) {
    const std::size_t row = n / 3;
    const std::size_t column = n % 3;
    for (const Nodes& nodes : looks) {
      const SpotCorners corners{nodes[0].spot, nodes[2].spot, nodes[6].spot, nodes[8].spot};
      if (!alike(nodes[n].spot, between(corners, static_cast<float>(row) / 2, static_cast<float>(column) / 2), kBend)) {
        return false;
      }
    }
    if (!alike(looks[1][n].spot, mix(looks[0][n].spot, looks[2][n].spot, 0.5F), kInTime)) {
      return false;
    }
  }
  return true;
}

// Grey values of a block that one body fills: parabolas through the nodes, and a straight line in time between the
// beginning and the end of the exposure.
void swept_values(const Nodes& begin, const Nodes& end, int passes, const ProjectedLight& pattern,
                  BlockValues& values) {
  SpotBounds bounds;
  for (std::size_t n = 0; n < begin.size(); ++n) {
    bounds.add(begin[n].spot);
    bounds.add(end[n].spot);
  }
  const MinMaxPyramid::Range range = begin[0].dark ? MinMaxPyramid::Range{0, 0} : bounds.light_of(pattern);
  const bool same = range.high - range.low <= kSameLight;
  const float instant = 1 / static_cast<float>(kSubPixels * passes);  // share of the exposure
  for (int i = 0; i < kBlockSide; ++i) {
    const Parabola down(i);
    std::array<LightSpot, 3> first;  // along the sub-pixel row, at the columns of the nodes
    std::array<LightSpot, 3> last;
    for (std::size_t n = 0; n < first.size(); ++n) {
      first[n] = down.through(begin[n].spot, begin[n + 3].spot, begin[n + 6].spot);
      last[n] = down.through(end[n].spot, end[n + 3].spot, end[n + 6].spot);
    }
    for (int j = 0; j < kBlockSide; ++j) {
      const Parabola across(j);
      const LightSpot from = across.through(first[0], first[1], first[2]);
      const LightSpot to = across.through(last[0], last[1], last[2]);
      float light = range.high;
      if (!same) {
        light = 0;
        for (int pass = 0; pass < passes; ++pass) {
          const float s = (static_cast<float>((i + j) % kSubPixels * passes + pass) + 0.5F) * instant;
          light += pattern.quick_at(mix(from.line, to.line, s), mix(from.column, to.column, s), mix(from.z, to.z, s));
        }
        light /= static_cast<float>(passes);
      }
      values[static_cast<std::size_t>(i * kBlockSide + j)] =
          mix(from.ambient, to.ambient, 0.5F) + light * mix(from.light, to.light, 0.5F);
    }
  }
}

}  // namespace

PatternRenderer::PatternRenderer(const PerturbedRig& actual, const Scene& scene, const RenderOptions& options,
                                 int threads)
    : Renderer(actual, checked(scene), options),
      still_(actual, scene, options, threads),
      dark_(actual.rig.camera.pixels()) {
  disturb(actual, scene, still_.surface());
  const ProjectedLight none(images::FloatImage(1, 1), 0);
  const std::vector<IndexSpan> all(static_cast<std::size_t>(grid().down()), {0, grid().across() - 1});
  fold().fold(
      fold().pixels_of(all),
      [&](int down, int across, BlockValues& values) {
        still_.values(grid().block(down, across), none, Shade::dark, values);
      },
      dark_);
}

BodyMotion PatternRenderer::motion_of(int frame) const {
  return body_motion(rig(), scene(), still_, time_of_shot(frame), exposure());
}

// Grey values of a block in which bodies may be. Its nine nodes at three times show whether one smooth thing fills it,
// all lit or all dark. Otherwise every sub-pixel is traced at its instants, which are dealt out as in LineRenderer.
void PatternRenderer::moving_values(const BodyMotion& motion, int down, int across, const ProjectedLight& pattern,
                                    BlockValues& values) const {
  const std::size_t index = grid().block(down, across);
  const StillSurface::Block& block = still_.block(index);
  const std::uint32_t seen = motion.seen[index];
  const std::uint32_t shaded = motion.shaded[index];

  std::array<Nodes, 3> looks;
  bool one = true;
  for (std::size_t end = 0; end < looks.size() && one; ++end) {
    for (int n = 0; n < 9 && one; ++n) {
      const int d = 2 * down + n / 3;
      const int a = 2 * across + n % 3;
      Look& now = looks[end][static_cast<std::size_t>(n)];
      now = look(still_, grid().node_pixel(d, a), still_.node(grid().node(d, a)), motion.ends[end], seen, shaded);
      one = now.body == looks[0][0].body && now.dark == looks[0][0].dark;
    }
  }
  if (one && looks[0][0].body < 0) {
    still_.values(index, pattern, looks[0][0].dark ? Shade::dark : Shade::lit, values);
    return;
  }
  if (one && is_smooth(looks)) {
    swept_values(looks.front(), looks.back(), motion.passes, pattern, values);
    return;
  }
  for (int i = 0; i < kBlockSide; ++i) {
    for (int j = 0; j < kBlockSide; ++j) {
      const PixelPoint pixel = grid().sample_pixel(down, across, i, j);
      const LightSpot still = still_.sample(block, i, j);
      float sum = 0;
      for (int pass = 0; pass < motion.passes; ++pass) {
        const auto now = static_cast<std::size_t>((i + j) % kSubPixels * motion.passes + pass);
        sum += look(still_, pixel, still, motion.instants[now], seen, shaded).spot.grey(pattern);
      }
      values[static_cast<std::size_t>(i * kBlockSide + j)] = sum / static_cast<float>(motion.passes);
    }
  }
}

// The image without noise. Where no light falls on any block that contributes to a pixel, it is that of a dark pattern.
void PatternRenderer::expose(int frame, const ProjectedLight& pattern, std::span<float> pixels) const {
  const BodyMotion motion = motion_of(frame);
  std::vector<IndexSpan> lit(static_cast<std::size_t>(grid().down()));
  for (int down = 0; down < grid().down(); ++down) {
    for (int across = 0; across < grid().across(); ++across) {
      const std::size_t index = grid().block(down, across);
      if (motion.touches(index) || !still_.is_dark(index, pattern)) {
        lit[static_cast<std::size_t>(down)].join({across, across});
      }
    }
  }
  std::copy(dark_.begin(), dark_.end(), pixels.begin());
  fold().fold(
      fold().pixels_of(lit),
      [&](int down, int across, BlockValues& values) {
        const std::size_t index = grid().block(down, across);
        if (motion.touches(index)) {
          moving_values(motion, down, across, pattern, values);
        } else {
          still_.values(index, pattern, Shade::lit, values);
        }
      },
      pixels);
}

void PatternRenderer::lit_depth(int frame, std::span<float> z, float min_light) const {
  const BodyMotion motion = motion_of(frame);
  for (int row = 0; row < rig().camera.rows; ++row) {
    for (int column = 0; column < rig().camera.columns; ++column) {
      const auto i = static_cast<std::size_t>(row * rig().camera.columns + column);
      const std::size_t block = grid().block_of_pixel(row, column);
      LightSpot spot = still_.centre(i);
      if (motion.touches(block)) {
        spot = look(still_, {row + 0.0, column + 0.0}, spot, motion.ends[1], motion.seen[block], motion.shaded[block])
                   .spot;
      }
      z[i] = spot.light <= min_light ? std::numeric_limits<float>::quiet_NaN() : spot.z;
    }
  }
}

}  // namespace selfproj::sim
