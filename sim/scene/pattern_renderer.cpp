#include "sim/scene/pattern_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/io/float_image.h"
#include "sim/scene/parallel.h"
#include "sim/scene/ray.h"

namespace selfproj {
namespace {

// How far what lies in a block may be from linear, so that its corners stand for it.
constexpr float kPlaceTolerance = 0.02F;  // lines, columns of the projector
constexpr float kGreyTolerance = 0.2F;
constexpr float kDepthTolerance = 0.05F;  // mm

constexpr float kSameLight = 1e-4F;  // over a block: one value stands for all

float mix(float a, float b, float share) { return a + share * (b - a); }

}  // namespace

ProjectedLight project_image(const Rig& rig, const Image& image, bool blur, const std::string& source) {
  constexpr float kFull = 255;
  FloatImage light(image.rows, image.columns);
  std::transform(image.pixels.begin(), image.pixels.end(), light.values.begin(),
                 [](std::uint8_t value) { return static_cast<float>(value) / kFull; });
  check_pattern(light, rig.projector, source);
  return {light, blur ? rig.imaging.projector_blur_px : 0};
}

PatternSet::PatternSet(const Rig& rig, std::span<const Image> images, bool blur) {
  if (images.empty()) {
    throw std::invalid_argument("a set of no patterns");
  }
  light_.reserve(images.size());
  for (const Image& image : images) {
    light_.push_back(project_image(rig, image, blur));
  }
}

// g_2i = floor(2^i Y/H + 1/2) mod 2, in whole numbers.
std::vector<Image> gray_patterns(const RigProjector& projector, int bits) {
  constexpr int kMostBits = 12;
  if (bits < 1 || bits > kMostBits) {
    throw std::invalid_argument("Gray patterns of other than 1..12 bits");
  }
  constexpr std::uint8_t kFull = 255;
  const std::int64_t lines = projector.lines;
  std::vector<Image> patterns;
  for (int i = 0; i < bits; ++i) {
    for (const bool positive : {true, false}) {
      Image image{projector.lines, projector.columns, {}};
      image.pixels.reserve(static_cast<std::size_t>(lines) * static_cast<std::size_t>(projector.columns));
      for (std::int64_t line = 0; line < lines; ++line) {
        const bool lit = ((2 * (line << i) + lines) / (2 * lines)) % 2 == 1;
        image.pixels.insert(image.pixels.end(), static_cast<std::size_t>(projector.columns),
                            lit == positive ? kFull : std::uint8_t{0});
      }
      patterns.push_back(std::move(image));
    }
  }
  return patterns;
}

// The bodies at one time.
struct PatternRenderer::Moment {
  double t;
  Bodies bodies;
};

// The bodies during an exposure.
struct PatternRenderer::Motion {
  int passes = 1;                // each sub-pixel is looked at so often, at other instants
  std::array<Moment, 3> ends;    // begin, middle and end of the exposure
  std::vector<Moment> instants;  // kSub passes
  // Of each block, the bodies that may be seen in it, and those whose shadows may fall on what is seen in it.
  std::vector<std::uint32_t> seen;
  std::vector<std::uint32_t> shaded;
};

// What a ray meets when there are bodies.
struct PatternRenderer::Look {
  Spot spot;
  int body = -1;      // the surface
  bool dark = false;  // in the shadow of a body; a body's own: of anything
};

PatternRenderer::PatternRenderer(const Rig& rig, const Scene& scene, RenderOptions options, int threads)
    : rig_(rig),
      scene_(scene),
      options_(options),
      camera_(Pinhole::of_camera(rig.camera)),
      projector_(Pinhole::of_projector(rig.projector)),
      surface_(rig, scene, options.falloff),
      heights_(surface_.all_heights(0, 0)),
      margin_(lens_margin(options.camera_blur ? rig.imaging.camera_blur_px : 0)),
      kernel_(lens_kernel(options.camera_blur ? rig.imaging.camera_blur_px : 0)),
      blocks_down_((rig.camera.rows + 2 * margin_ + kBlock - 1) / kBlock),
      blocks_across_((rig.camera.columns + 2 * margin_ + kBlock - 1) / kBlock) {
  if (scene.speed() != 0) {
    throw std::invalid_argument("a surface that moves is not for patterns: its bodies may");
  }
  if (scene.bodies(0).size() > Scene::kMostBodies) {
    throw std::invalid_argument("a scene of too many bodies");
  }
  const int nodes_down = 2 * blocks_down_ + 1;
  const int nodes_across = 2 * blocks_across_ + 1;
  nodes_.resize(static_cast<std::size_t>(nodes_down) * static_cast<std::size_t>(nodes_across));
  parallel_for(nodes_down, threads, [&](int down) {
    for (int across = 0; across < nodes_across; ++across) {
      nodes_[static_cast<std::size_t>(down * nodes_across + across)] = still_spot(node_pixel(down, across), heights_);
    }
  });
  centres_.resize(static_cast<std::size_t>(rig.camera.rows) * static_cast<std::size_t>(rig.camera.columns));
  parallel_for(rig.camera.rows, threads, [&](int row) {
    for (int column = 0; column < rig.camera.columns; ++column) {
      centres_[static_cast<std::size_t>(row * rig.camera.columns + column)] =
          still_spot({row + 0.0, column + 0.0}, heights_);
    }
  });
  blocks_.resize(static_cast<std::size_t>(blocks_down_) * static_cast<std::size_t>(blocks_across_));
  std::vector<std::vector<Spot>> samples(static_cast<std::size_t>(blocks_down_));
  parallel_for(blocks_down_, threads, [&](int down) {
    for (int across = 0; across < blocks_across_; ++across) {
      trace_block(down, across, heights_, blocks_[static_cast<std::size_t>(down * blocks_across_ + across)],
                  samples[static_cast<std::size_t>(down)]);
    }
  });
  for (int down = 0; down < blocks_down_; ++down) {
    const auto before = static_cast<std::int64_t>(samples_.size());
    for (int across = 0; across < blocks_across_; ++across) {
      Block& block = blocks_[static_cast<std::size_t>(down * blocks_across_ + across)];
      block.samples += block.samples < 0 ? 0 : before;
    }
    std::vector<Spot>& row = samples[static_cast<std::size_t>(down)];
    samples_.insert(samples_.end(), row.begin(), row.end());
    row = {};
  }
}

PixelPoint PatternRenderer::node_pixel(int down, int across) const {
  constexpr double kStep = kBlock / 2.0;
  return {down * kStep - margin_ - 0.5, across * kStep - margin_ - 0.5};
}

PixelPoint PatternRenderer::sample_pixel(int down, int across, int i, int j) const {
  return {down * kBlock - margin_ - 0.5 + (i + 0.5) / kSub, across * kBlock - margin_ - 0.5 + (j + 0.5) / kSub};
}

// `share`: of the projector's full light, as LitSurface::lit_share.
PatternRenderer::Spot PatternRenderer::spot_of(Point3 point, double share, double albedo) const {
  const RigImaging& imaging = rig_.imaging;
  Spot spot;
  spot.z = static_cast<float>(point.z);
  spot.ambient = static_cast<float>(imaging.dark + albedo * (imaging.ambient - imaging.dark));
  if (projector_.depth(point) > 0) {
    const PixelPoint p = projector_.project(point);
    spot.line = static_cast<float>(p.row);
    spot.column = static_cast<float>(p.column);
    spot.light = static_cast<float>(albedo * share * (imaging.white - imaging.ambient));
  }
  return spot;
}

PatternRenderer::Spot PatternRenderer::still_spot(PixelPoint pixel, HeightRange heights) const {
  const LitSurface::Hit hit = surface_.hit(pixel, 0, heights);
  return spot_of(hit.point, surface_.lit_share(hit, 0, heights_.high), scene_.albedo(hit.point.x, hit.point.y, 0));
}

namespace {

template <class Spot>
Spot mix(const Spot& a, const Spot& b, float share) {
  return {mix(a.z, b.z, share), mix(a.line, b.line, share), mix(a.column, b.column, share),
          mix(a.light, b.light, share), mix(a.ambient, b.ambient, share)};
}

template <class Spot>
Spot between(const std::array<Spot, 4>& corners, float down, float across) {
  return mix(mix(corners[0], corners[2], down), mix(corners[1], corners[3], down), across);
}

template <class Spot>
bool alike(const Spot& a, const Spot& b, const Spot& tolerance) {
  return std::abs(a.z - b.z) <= tolerance.z && std::abs(a.line - b.line) <= tolerance.line &&
         std::abs(a.column - b.column) <= tolerance.column && std::abs(a.light - b.light) <= tolerance.light &&
         std::abs(a.ambient - b.ambient) <= tolerance.ambient;
}

// Bounds of lines and columns.
struct Places {
  float line_0 = std::numeric_limits<float>::max();
  float line_1 = std::numeric_limits<float>::lowest();
  float column_0 = std::numeric_limits<float>::max();
  float column_1 = std::numeric_limits<float>::lowest();

  template <class Spot>
  void add(const Spot& spot) {
    line_0 = std::min(line_0, spot.line);
    line_1 = std::max(line_1, spot.line);
    column_0 = std::min(column_0, spot.column);
    column_1 = std::max(column_1, spot.column);
  }
};

}  // namespace

// Where the surface is level its nodes are enough to tell; else all sub-pixels are looked at, and forgotten again where
// the corners stand for them.
void PatternRenderer::trace_block(int down, int across, HeightRange all, Block& block,
                                  std::vector<Spot>& samples) const {
  const int nodes_across = 2 * blocks_across_ + 1;
  const auto node = [&](int d, int a) -> const Spot& {
    return nodes_[static_cast<std::size_t>((2 * down + d) * nodes_across + 2 * across + a)];
  };
  block.corners = {node(0, 0), node(0, 2), node(2, 0), node(2, 2)};
  const HeightRange heights =
      surface_.heights_between(node_pixel(2 * down, 2 * across), node_pixel(2 * down + 2, 2 * across + 2), 0, 0, all);
  constexpr Spot kLinear{kDepthTolerance, kPlaceTolerance, kPlaceTolerance, kGreyTolerance, kGreyTolerance};
  bool linear = true;
  for (int d = 0; d <= 2; ++d) {
    for (int a = 0; a <= 2; ++a) {
      linear = linear &&
               alike(node(d, a), between(block.corners, static_cast<float>(d) / 2, static_cast<float>(a) / 2), kLinear);
    }
  }
  if (linear && heights.high - heights.low <= kHeightTolerance && scene_.even_albedo()) {
    return;
  }
  const std::size_t first = samples.size();
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      samples.push_back(still_spot(sample_pixel(down, across, i, j), heights));
      linear = linear && alike(samples.back(), still_sample(block, i, j), kLinear);
    }
  }
  if (linear) {
    samples.resize(first);
  } else {
    block.samples = static_cast<std::int64_t>(first);
  }
}

PatternRenderer::Spot PatternRenderer::still_sample(const Block& block, int i, int j) const {
  if (block.samples >= 0) {
    return samples_[static_cast<std::size_t>(block.samples + i * kSide + j)];
  }
  return between(block.corners, (static_cast<float>(i) + 0.5F) / kSide, (static_cast<float>(j) + 0.5F) / kSide);
}

// Grey values of a block where no body is seen. `dark`: in the shadow of one.
void PatternRenderer::still_values(const Block& block, const ProjectedLight& pattern, bool dark, Values& values) const {
  float* to = values.data();
  if (block.samples >= 0) {
    const Spot* from = samples_.data() + block.samples;
    std::transform(from, from + kSamples, to, [&](const Spot& spot) {
      return dark || spot.light == 0 ? spot.ambient
                                     : spot.ambient + spot.light * pattern.quick_at(spot.line, spot.column);
    });
    return;
  }
  Places places;
  for (const Spot& corner : block.corners) {
    places.add(corner);
  }
  const MinMaxPyramid::Range range =
      dark ? MinMaxPyramid::Range{0, 0}
           : pattern.range(static_cast<double>(places.line_0), static_cast<double>(places.line_1),
                           static_cast<double>(places.column_0), static_cast<double>(places.column_1));
  const bool same = range.high - range.low <= kSameLight;
  for (int i = 0; i < kSide; ++i) {
    const float down = (static_cast<float>(i) + 0.5F) / kSide;
    const Spot left = mix(block.corners[0], block.corners[2], down);
    const Spot right = mix(block.corners[1], block.corners[3], down);
    for (int j = 0; j < kSide; ++j) {
      const float across = (static_cast<float>(j) + 0.5F) / kSide;
      const float light =
          same ? range.high
               : pattern.quick_at(mix(left.line, right.line, across), mix(left.column, right.column, across));
      *to++ = mix(left.ambient, right.ambient, across) + light * mix(left.light, right.light, across);
    }
  }
}

// Marks the blocks in which a body of these bounds may be seen, and those on whose points its shadow may fall: what
// lies behind it as the projector sees it, down to the deepest surface.
void PatternRenderer::mark(std::size_t body, const Cuboid& bounds, std::vector<std::uint32_t>& seen,
                           std::vector<std::uint32_t>& shaded) const {
  struct Rectangle {
    double row_0 = std::numeric_limits<double>::max();
    double row_1 = std::numeric_limits<double>::lowest();
    double column_0 = std::numeric_limits<double>::max();
    double column_1 = std::numeric_limits<double>::lowest();
  };
  constexpr double kNear = 1;  // mm before a pinhole: what is nearer may be anywhere
  const auto add = [&](Rectangle& rectangle, Point3 p) {
    if (p.z < kNear) {
      constexpr double kFar = 1e6;
      rectangle = {-kFar, kFar, -kFar, kFar};
      return;
    }
    const PixelPoint pixel = camera_.project(p);
    rectangle.row_0 = std::min(rectangle.row_0, pixel.row);
    rectangle.row_1 = std::max(rectangle.row_1, pixel.row);
    rectangle.column_0 = std::min(rectangle.column_0, pixel.column);
    rectangle.column_1 = std::max(rectangle.column_1, pixel.column);
  };
  const auto fill = [&](const Rectangle& rectangle, std::vector<std::uint32_t>& masks) {
    const auto block_of = [&](double pixel, int most) {
      return static_cast<int>(std::clamp((pixel + 0.5 + margin_) / kBlock, 0.0, most - 1.0));
    };
    if (rectangle.row_1 < -margin_ - 0.5 || rectangle.column_1 < -margin_ - 0.5 ||
        rectangle.row_0 > rig_.camera.rows + margin_ || rectangle.column_0 > rig_.camera.columns + margin_) {
      return;
    }
    for (int down = block_of(rectangle.row_0, blocks_down_); down <= block_of(rectangle.row_1, blocks_down_); ++down) {
      for (int across = block_of(rectangle.column_0, blocks_across_);
           across <= block_of(rectangle.column_1, blocks_across_); ++across) {
        masks[static_cast<std::size_t>(down * blocks_across_ + across)] |= std::uint32_t{1} << body;
      }
    }
  };
  const Point3 centre = projector_.centre();
  const double deepest = rig_.plane_z_mm - heights_.low;
  Rectangle body_rectangle;
  Rectangle shadow;
  for (const double x : {bounds.low.x, bounds.high.x}) {
    for (const double y : {bounds.low.y, bounds.high.y}) {
      for (const double z : {bounds.low.z, bounds.high.z}) {
        const Point3 corner{x, y, z};
        add(body_rectangle, corner);
        add(shadow, corner);
        if (z >= deepest) {
          continue;
        }
        const double below = z - centre.z;  // the projector
        add(shadow, below > kNear ? centre + (deepest - centre.z) / below * (corner - centre) : Point3{});
      }
    }
  }
  fill(body_rectangle, seen);
  fill(shadow, shaded);
}

PatternRenderer::Motion PatternRenderer::motion_of(int frame) const {
  const double middle = time_of(frame);
  const double exposure = options_.motion_blur ? rig_.camera.exposure_s : 0;
  Motion motion;
  motion.ends[1] = {middle, scene_.bodies(middle)};
  const std::size_t count = motion.ends[1].bodies.size();
  if (count == 0) {
    return motion;
  }
  motion.ends[0] = {middle - exposure / 2, scene_.bodies(middle - exposure / 2)};
  motion.ends[2] = {middle + exposure / 2, scene_.bodies(middle + exposure / 2)};
  double nearest = rig_.plane_z_mm;
  for (const auto& body : motion.ends[1].bodies) {
    nearest = std::min(nearest, body->bounds().low.z);
  }
  const double way_px = scene_.body_speed() * exposure * rig_.camera.focal_length_mm / rig_.camera.pixel_pitch_mm /
                        std::max(nearest, 1.0);
  constexpr double kWayPx = 0.75;  // from one instant to the next
  constexpr int kMostPasses = 64;
  motion.passes = std::clamp(static_cast<int>(std::ceil(way_px / (kWayPx * kSub))), 1, kMostPasses);
  const int instants = kSub * motion.passes;
  for (int i = 0; i < instants; ++i) {
    const double t = middle + exposure * ((i + 0.5) / instants - 0.5);
    motion.instants.push_back({t, scene_.bodies(t)});
  }
  motion.seen.resize(blocks_.size());
  motion.shaded.resize(blocks_.size());
  for (std::size_t body = 0; body < count; ++body) {
    Cuboid all = motion.ends[0].bodies.at(body)->bounds();
    const auto join = [&](const Moment& moment) {
      const Cuboid now = moment.bodies.at(body)->bounds();
      all = {{std::min(all.low.x, now.low.x), std::min(all.low.y, now.low.y), std::min(all.low.z, now.low.z)},
             {std::max(all.high.x, now.high.x), std::max(all.high.y, now.high.y), std::max(all.high.z, now.high.z)}};
    };
    std::for_each(motion.ends.begin(), motion.ends.end(), join);
    std::for_each(motion.instants.begin(), motion.instants.end(), join);
    mark(body, all, motion.seen, motion.shaded);
  }
  narrow(motion, scene_.body_speed() * exposure / 4);
  return motion;
}

// Takes out of the blocks' masks the bodies that are too far from the block's rays, and from those of the light on the
// surface in it. `way`: what a body moves between two of the three times that are looked at.
void PatternRenderer::narrow(Motion& motion, double way) const {
  const int nodes_across = 2 * blocks_across_ + 1;
  const auto far = [&](std::uint32_t mask, const Ray& line, double slack) {
    std::uint32_t result = mask;
    for (std::uint32_t rest = mask; rest != 0; rest &= rest - 1) {
      const auto body = static_cast<std::size_t>(__builtin_ctz(rest));
      if (std::none_of(motion.ends.begin(), motion.ends.end(),
                       [&](const Moment& moment) { return moment.bodies[body]->is_near(line, slack); })) {
        result ^= std::uint32_t{1} << body;
      }
    }
    return result;
  };
  const double deepest = rig_.plane_z_mm - heights_.low;
  constexpr double kHalfDiagonal = kBlock * std::numbers::sqrt2 / 2;
  const double slack = deepest * kHalfDiagonal * rig_.camera.pixel_pitch_mm / rig_.camera.focal_length_mm;
  for (int down = 0; down < blocks_down_; ++down) {
    for (int across = 0; across < blocks_across_; ++across) {
      const auto index = static_cast<std::size_t>(down * blocks_across_ + across);
      const Point3 along = camera_.ray(node_pixel(2 * down + 1, 2 * across + 1));
      motion.seen[index] = far(motion.seen[index], {{0, 0, 0}, along}, slack + way);
      if (motion.seen[index] != 0 || motion.shaded[index] == 0 || blocks_[index].samples >= 0) {
        continue;  // what is seen may be anywhere
      }
      const auto node = static_cast<std::size_t>((2 * down + 1) * nodes_across + 2 * across + 1);
      const Point3 middle = static_cast<double>(nodes_[node].z) * along;
      double furthest = 0;
      for (const int corner : {0, 1, 2, 3}) {
        const Point3 ray = camera_.ray(node_pixel(2 * (down + corner / 2), 2 * (across + corner % 2)));
        const Point3 d = static_cast<double>(blocks_[index].corners[static_cast<std::size_t>(corner)].z) * ray - middle;
        furthest = std::max(furthest, std::sqrt(dot(d, d)));
      }
      motion.shaded[index] = far(motion.shaded[index], {middle, projector_.centre() - middle}, furthest + way);
    }
  }
}

// `still`: what the ray meets of the surface. `seen`, `shaded`: the bodies that may matter.
PatternRenderer::Look PatternRenderer::look(PixelPoint pixel, const Spot& still, const Moment& moment,
                                            std::uint32_t seen, std::uint32_t shaded) const {
  const Point3 along = camera_.ray(pixel);  // of depth 1, so that s is z
  Look result;
  Meeting nearest;
  nearest.s = static_cast<double>(still.z);
  for (std::uint32_t rest = seen; rest != 0; rest &= rest - 1) {
    const int body = __builtin_ctz(rest);
    if (moment.bodies[static_cast<std::size_t>(body)]->meets({{0, 0, 0}, along}, nearest.s, nearest)) {
      result.body = body;
    }
  }
  const Point3 point = nearest.s * along;
  const auto shaded_from = [&](Point3 from) {
    const Ray light{from, projector_.centre() - from};
    for (std::uint32_t rest = shaded; rest != 0; rest &= rest - 1) {
      if (moment.bodies[static_cast<std::size_t>(__builtin_ctz(rest))]->blocks(light, 1)) {
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
  double share = surface_.incidence(point, nearest.normal);
  if (share > 0 && (surface_.in_shadow(point, nearest.normal, 0, heights_.high) ||
                    shaded_from(point + kShadowLift * nearest.normal))) {
    share = 0;
  }
  result.dark = share <= 0;
  result.spot = spot_of(point, share, moment.bodies[static_cast<std::size_t>(result.body)]->albedo());
  return result;
}

// The parabola through three nodes at the sub-pixel row or column i.
struct PatternRenderer::Parabola {
  explicit Parabola(int i) {
    const float u = (static_cast<float>(i) + 0.5F) / kSide;
    weights = {(2 * u - 1) * (u - 1), 4 * u * (1 - u), u * (2 * u - 1)};
  }
  [[nodiscard]] Spot through(const Spot& a, const Spot& b, const Spot& c) const {
    const auto sum = [&](float p, float q, float r) { return weights[0] * p + weights[1] * q + weights[2] * r; };
    return {sum(a.z, b.z, c.z), sum(a.line, b.line, c.line), sum(a.column, b.column, c.column),
            sum(a.light, b.light, c.light), sum(a.ambient, b.ambient, c.ambient)};
  }
  std::array<float, 3> weights{};
};

// Grey values of a block where bodies may be. Its nine nodes at three times tell whether one thing fills it, all lit or
// all dark, and smooth; else every sub-pixel is traced at its instants, which are dealt out as Renderer
// does.
void PatternRenderer::moving_values(const Motion& motion, int down, int across, const ProjectedLight& pattern,
                                    Values& values) const {
  const auto index = static_cast<std::size_t>(down * blocks_across_ + across);
  const Block& block = blocks_[index];
  const std::uint32_t seen = motion.seen[index];
  const std::uint32_t shaded = motion.shaded[index];
  const int nodes_across = 2 * blocks_across_ + 1;

  std::array<Nodes, 3> looks;
  bool one = true;
  for (std::size_t end = 0; end < looks.size() && one; ++end) {
    for (int n = 0; n < 9 && one; ++n) {
      const int d = 2 * down + n / 3;
      const int a = 2 * across + n % 3;
      Look& now = looks[end][static_cast<std::size_t>(n)];
      now = look(node_pixel(d, a), nodes_[static_cast<std::size_t>(d * nodes_across + a)], motion.ends[end], seen,
                 shaded);
      one = now.body == looks[0][0].body && now.dark == looks[0][0].dark;
    }
  }
  if (one && looks[0][0].body < 0) {
    still_values(block, pattern, looks[0][0].dark, values);
    return;
  }
  if (one && is_smooth(looks)) {
    swept_values(looks.front(), looks.back(), motion.passes, pattern, values);
    return;
  }
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const PixelPoint pixel = sample_pixel(down, across, i, j);
      const Spot still = still_sample(block, i, j);
      float sum = 0;
      for (int pass = 0; pass < motion.passes; ++pass) {
        const auto now = static_cast<std::size_t>((i + j) % kSub * motion.passes + pass);
        const Spot spot = look(pixel, still, motion.instants[now], seen, shaded).spot;
        sum += spot.ambient + (spot.light > 0 ? spot.light * pattern.quick_at(spot.line, spot.column) : 0);
      }
      values[static_cast<std::size_t>(i * kSide + j)] = sum / static_cast<float>(motion.passes);
    }
  }
}

// Whether a body's spots are as good as parabolas over the block, and linear in time. What a parabola leaves is far
// less than it differs from a straight line.
bool PatternRenderer::is_smooth(const std::array<Nodes, 3>& looks) {
  constexpr Spot kBend{0.5F, 0.25F, 0.25F, 3, 3};
  constexpr Spot kInTime{kDepthTolerance, 0.05F, 0.05F, kGreyTolerance, kGreyTolerance};
  for (std::size_t n = 0; n < looks[0].size(); ++n) {
    const std::size_t row = n / 3;
    const std::size_t column = n % 3;
    for (const Nodes& nodes : looks) {
      const Corners corners{nodes[0].spot, nodes[2].spot, nodes[6].spot, nodes[8].spot};
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

// Grey values of a block that one body fills: parabolas through the nodes, a straight line in time between begin and
// end of the exposure.
void PatternRenderer::swept_values(const Nodes& begin, const Nodes& end, int passes, const ProjectedLight& pattern,
                                   Values& values) {
  Places places;
  for (std::size_t n = 0; n < begin.size(); ++n) {
    places.add(begin[n].spot);
    places.add(end[n].spot);
  }
  const MinMaxPyramid::Range range =
      begin[0].dark ? MinMaxPyramid::Range{0, 0}
                    : pattern.range(static_cast<double>(places.line_0), static_cast<double>(places.line_1),
                                    static_cast<double>(places.column_0), static_cast<double>(places.column_1));
  const bool same = range.high - range.low <= kSameLight;
  const float instant = 1 / static_cast<float>(kSub * passes);  // its share of the exposure
  for (int i = 0; i < kSide; ++i) {
    const Parabola down(i);
    std::array<Spot, 3> first;  // of the sub-pixel row, at the nodes' columns
    std::array<Spot, 3> last;
    for (std::size_t n = 0; n < first.size(); ++n) {
      first[n] = down.through(begin[n].spot, begin[n + 3].spot, begin[n + 6].spot);
      last[n] = down.through(end[n].spot, end[n + 3].spot, end[n + 6].spot);
    }
    for (int j = 0; j < kSide; ++j) {
      const Parabola across(j);
      const Spot from = across.through(first[0], first[1], first[2]);
      const Spot to = across.through(last[0], last[1], last[2]);
      float light = range.high;
      if (!same) {
        light = 0;
        for (int pass = 0; pass < passes; ++pass) {
          const float s = (static_cast<float>((i + j) % kSub * passes + pass) + 0.5F) * instant;
          light += pattern.quick_at(mix(from.line, to.line, s), mix(from.column, to.column, s));
        }
        light /= static_cast<float>(passes);
      }
      values[static_cast<std::size_t>(i * kSide + j)] =
          mix(from.ambient, to.ambient, 0.5F) + light * mix(from.light, to.light, 0.5F);
    }
  }
}

// The image without noise: blocks of sub-pixels, row by row, each of whose sub-pixel rows gives, by the kernel, to the
// pixel rows around it; a pixel row that has got all is folded along its columns.
void PatternRenderer::expose(int frame, const ProjectedLight& pattern, std::span<float> pixels) const {
  const Motion motion = motion_of(frame);
  const int rows = rig_.camera.rows;
  const int columns = rig_.camera.columns;
  const int taps = static_cast<int>(kernel_.size());
  const std::ptrdiff_t stride = static_cast<std::ptrdiff_t>(blocks_across_) * kSide;
  std::vector<float> strip(static_cast<std::size_t>(stride) * kSide);
  const int open_rows = 2 * (margin_ + kBlock) + 1;  // pixel rows under way at the same time, at most
  std::vector<float> sums(static_cast<std::size_t>(stride) * static_cast<std::size_t>(open_rows), 0.0F);
  const auto sums_of = [&](int row) { return sums.data() + (row % open_rows) * stride; };
  std::vector<float> every(static_cast<std::size_t>(stride / kSub));
  Values values{};
  int done = 0;  // pixel rows
  for (int down = 0; down < blocks_down_; ++down) {
    for (int across = 0; across < blocks_across_; ++across) {
      const auto index = static_cast<std::size_t>(down * blocks_across_ + across);
      if (!motion.seen.empty() && (motion.seen[index] | motion.shaded[index]) != 0) {
        moving_values(motion, down, across, pattern, values);
      } else {
        still_values(blocks_[index], pattern, false, values);
      }
      for (int i = 0; i < kSide; ++i) {
        std::copy_n(values.data() + i * kSide, kSide, strip.data() + i * stride + across * kSide);
      }
    }
    for (int i = 0; i < kSide; ++i) {
      const float* from = strip.data() + i * stride;
      const int sub_row = down * kSide + i;  // from the margin's first
      const int first = std::max(0, (sub_row - taps + kSub) / kSub);
      const int last = std::min(rows - 1, sub_row / kSub);
      for (int row = first; row <= last; ++row) {
        const float weight = kernel_[static_cast<std::size_t>(sub_row - row * kSub)];
        float* to = sums_of(row);
        for (std::ptrdiff_t c = 0; c < stride; ++c) {
          to[c] += weight * from[c];
        }
      }
    }
    for (; done < rows && done * kSub + taps <= (down + 1) * kSide; ++done) {
      float* from = sums_of(done);
      float* to = pixels.data() + static_cast<std::ptrdiff_t>(done) * columns;
      std::fill_n(to, columns, 0.0F);
      for (int phase = 0; phase < kSub; ++phase) {  // every kSub-th sub-pixel side by side
        for (std::size_t c = 0; c < every.size(); ++c) {
          every[c] = from[static_cast<std::ptrdiff_t>(c) * kSub + phase];
        }
        for (int k = phase; k < taps; k += kSub) {
          const float weight = kernel_[static_cast<std::size_t>(k)];
          const float* shifted = every.data() + k / kSub;
          for (int c = 0; c < columns; ++c) {
            to[c] += weight * shifted[c];
          }
        }
      }
      std::fill_n(from, stride, 0.0F);
    }
  }
}

void PatternRenderer::render(int frame, const ProjectedLight& pattern, std::span<float> pixels) const {
  expose(frame, pattern, pixels);
  add_noise(rig_.imaging, options_, frame, pixels);
  if (options_.quantization) {
    quantize(pixels);
  }
}

void PatternRenderer::render(int frame, const ProjectedLight& pattern, std::span<std::uint8_t> pixels) const {
  std::vector<float> values(pixels.size());
  render(frame, pattern, values);
  quantize(values, pixels);
}

void PatternRenderer::lit_depth(int frame, std::span<float> z, float least_light) const {
  const Motion motion = motion_of(frame);
  for (int row = 0; row < rig_.camera.rows; ++row) {
    for (int column = 0; column < rig_.camera.columns; ++column) {
      const auto i = static_cast<std::size_t>(row * rig_.camera.columns + column);
      const auto block =
          static_cast<std::size_t>((row + margin_) / kBlock * blocks_across_ + (column + margin_) / kBlock);
      Spot spot = centres_[i];
      if (!motion.seen.empty() && (motion.seen[block] | motion.shaded[block]) != 0) {
        spot = look({row + 0.0, column + 0.0}, spot, motion.ends[1], motion.seen[block], motion.shaded[block]).spot;
      }
      z[i] = spot.light <= least_light ? std::numeric_limits<float>::quiet_NaN() : spot.z;
    }
  }
}

}  // namespace selfproj
