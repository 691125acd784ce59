#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numbers>
#include <vector>

#include "sim/scene/scene.h"
#include "sim/scene/scenes.h"

namespace selfproj::sim {
namespace {

double distance_to_segment(double x, double y, double x0, double y0, double x1, double y1) {
  const double dx = x1 - x0;
  const double dy = y1 - y0;
  const double t = std::clamp(((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy), 0.0, 1.0);
  return std::hypot(x - x0 - t * dx, y - y0 - t * dy);
}

// How one rectangle lies relative to another.
enum class Overlap { none, some, inside };
Overlap overlap(const Box& box, const Box& with) {
  if (box.x1 < with.x0 || box.x0 > with.x1 || box.y1 < with.y0 || box.y0 > with.y1) {
    return Overlap::none;
  }
  return box.x0 >= with.x0 && box.x1 <= with.x1 && box.y0 >= with.y0 && box.y1 <= with.y1 ? Overlap::inside
                                                                                          : Overlap::some;
}
bool contains(const Box& box, double x, double y) { return overlap({x, x, y, y}, box) != Overlap::none; }

enum class CuboidSurface : std::uint8_t { good, marked };

class CuboidScene : public Scene {
 public:
  explicit CuboidScene(CuboidSurface surface) : marked_(surface == CuboidSurface::marked) {}

  [[nodiscard]] int frames() const override { return 16; }
  [[nodiscard]] double speed() const override { return 0; }

  [[nodiscard]] double height(double x, double y, double /*t*/) const override {
    if (contains(Cuboids::kLowPart.box, x, y)) {
      const bool carved = marked_ && Cuboids::distance_from_letter(x, y) <= Cuboids::kLetterStroke / 2;
      return Cuboids::kLow - (carved ? Cuboids::kLetterDepth : 0);
    }
    if (!contains(Cuboids::kHighPart.box, x, y)) {
      return 0;
    }
    for (std::size_t i = 0; marked_ && i < Cuboids::kBlocks.size(); ++i) {
      if (contains(Cuboids::kBlocks[i], x, y)) {
        return Cuboids::kHigh + Cuboids::kBlockHeights[i];
      }
    }
    return Cuboids::kHigh;
  }

  [[nodiscard]] HeightRange range(const Box& box, double /*t0*/, double /*t1*/) const override {
    const Overlap low = overlap(box, Cuboids::kLowPart.box);
    const Overlap high = overlap(box, Cuboids::kHighPart.box);
    HeightRange range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    if (low != Overlap::inside && high != Overlap::inside) {
      range.join(0);
    }
    if (low != Overlap::none) {
      const double radius = 0.5 * std::hypot(box.x1 - box.x0, box.y1 - box.y0);
      const double away =
          Cuboids::distance_from_letter(0.5 * (box.x0 + box.x1), 0.5 * (box.y0 + box.y1)) - Cuboids::kLetterStroke / 2;
      if (!marked_ || away > -radius) {
        range.join(Cuboids::kLow);
      }
      if (marked_ && away <= radius) {
        range.join(Cuboids::kLow - Cuboids::kLetterDepth);
      }
    }
    if (high != Overlap::none) {
      bool on_one = false;
      for (std::size_t i = 0; marked_ && i < Cuboids::kBlocks.size(); ++i) {
        const Overlap block = overlap(box, Cuboids::kBlocks[i]);
        on_one = on_one || block == Overlap::inside;
        if (block != Overlap::none) {
          range.join(Cuboids::kHigh + Cuboids::kBlockHeights[i]);
        }
      }
      if (!on_one) {
        range.join(Cuboids::kHigh);
      }
    }
    return range;
  }

 private:
  bool marked_;
};

// A block on the plane, and things that move in front of it.
class BlockScene : public Scene {
 public:
  BlockScene(const rig::Rig& rig, const Box& box, double height)
      : plane_z_(rig.plane_z_mm), box_(box), height_(height) {}
  [[nodiscard]] double speed() const override { return 0; }
  [[nodiscard]] double height(double x, double y, double /*t*/) const override {
    return contains(box_, x, y) ? height_ : 0;
  }
  [[nodiscard]] HeightRange range(const Box& box, double /*t0*/, double /*t1*/) const override {
    const Overlap o = overlap(box, box_);
    return {o == Overlap::inside ? height_ : 0, o == Overlap::none ? 0 : height_};
  }
  [[nodiscard]] int frames() const override { return 16; }

 protected:
  // The z of a height over the plane.
  [[nodiscard]] double z(double height) const { return plane_z_ - height; }

 private:
  double plane_z_;
  Box box_;
  double height_;
};

class MouseScene final : public BlockScene {
 public:
  explicit MouseScene(const rig::Rig& rig) : BlockScene(rig, MouseRun::kSlider, MouseRun::kSliderHeight) {}
  [[nodiscard]] int frames() const override { return 600; }
  [[nodiscard]] double body_speed() const override { return MouseRun::kSpeed; }
  [[nodiscard]] Bodies bodies(double t) const override {
    const double y = MouseRun::kStart + MouseRun::kSpeed * t;
    constexpr double kX = MouseRun::kX;
    const double top = z(MouseRun::kPlateHeight);
    Bodies bodies;
    bodies.push_back(
        std::make_unique<Block>(Cuboid{{kX - 28, y - 45, top}, {kX + 28, y + 45, z(MouseRun::kSliderHeight)}}));
    // Its lower half is inside plate and slider.
    bodies.push_back(
        std::make_unique<Ellipsoid>(Point3{kX, y, top}, std::array<Point3, 3>{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
                                    Point3{MouseRun::kWidth / 2, MouseRun::kLength / 2, MouseRun::kHeight}));
    return bodies;
  }
};

class HandsScene final : public BlockScene {
 public:
  explicit HandsScene(const rig::Rig& rig) : BlockScene(rig, TwoHands::kBlock, TwoHands::kBlockHeight) {}
  [[nodiscard]] int frames() const override { return 334; }  // one period
  [[nodiscard]] double body_speed() const override { return 2 * std::numbers::pi * TwoHands::kFrequency * 25; }
  [[nodiscard]] Bodies bodies(double t) const override {
    Bodies bodies;
    const double phase = 2 * std::numbers::pi * TwoHands::kFrequency * t;
    add_hand(bodies, 52 + 8 * std::cos(phase), -85 + 20 * std::sin(phase),
             z(TwoHands::kBlockHeight + 13 + 2 * std::sin(phase)));
    add_hand(bodies, 8 * std::cos(phase), 80 - 20 * std::sin(phase), z(30 + 8 * std::sin(phase)));
    return bodies;
  }

 private:
  // A flat palm and four fingers, which point to smaller x. z is that of the middle.
  static void add_hand(Bodies& bodies, double x, double y, double z) {
    bodies.push_back(std::make_unique<Ellipsoid>(
        Point3{x + 12, y, z}, std::array<Point3, 3>{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, Point3{30, 26, 11}, 0.7));
    for (int i = 0; i < 4; ++i) {
      const double side = 13 * (i - 1.5);
      bodies.push_back(
          std::make_unique<Capsule>(Point3{x - 5, y + side, z}, Point3{x - 45, y + 1.2 * side, z}, 5.5, 0.7));
    }
  }
};

}  // namespace

double Cuboids::distance_from_letter(double x, double y) {
  // Upright if image rows run along x, downwards: the apex is at the least x.
  return std::min({distance_to_segment(x, y, 18, -80, 76, -105), distance_to_segment(x, y, 18, -80, 76, -55),
                   distance_to_segment(x, y, 56, -96, 56, -64)});
}

const std::vector<SceneInfo>& self_projected_scenes() {
  static const std::vector<SceneInfo> all{
      {.name = "cuboids",
       .description = "B4: cuboids 25 and 109 mm high",
       .method = SceneMethod::self_projected,
       .cells_below = 8,
       .make = [](const rig::Rig& /*rig*/) -> std::unique_ptr<Scene> {
         return std::make_unique<CuboidScene>(CuboidSurface::good);
       }},
      {.name = "cuboids-marked",
       .description = "B4: the same with a letter A carved 2 mm deep and blocks of 3, 6, 9 mm",
       .method = SceneMethod::self_projected,
       .reference = "cuboids",
       .cells_below = 8,
       .make = [](const rig::Rig& /*rig*/) -> std::unique_ptr<Scene> {
         return std::make_unique<CuboidScene>(CuboidSurface::marked);
       }},
      {.name = "slider",
       .description = "B7: a slider 100 mm high",
       .method = SceneMethod::self_projected,
       .make = [](const rig::Rig& rig) -> std::unique_ptr<Scene> {
         return std::make_unique<BlockScene>(rig, MouseRun::kSlider, MouseRun::kSliderHeight);
       }},
      {.name = "mouse",
       .description = "B7: on it a mouse on a plate, 300 mm/s along y",
       .method = SceneMethod::self_projected,
       .reference = "slider",
       .make = [](const rig::Rig& rig) -> std::unique_ptr<Scene> { return std::make_unique<MouseScene>(rig); }},
      {.name = "block",
       .description = "B8: a block 109 mm high",
       .method = SceneMethod::self_projected,
       .make = [](const rig::Rig& rig) -> std::unique_ptr<Scene> {
         return std::make_unique<BlockScene>(rig, TwoHands::kBlock, TwoHands::kBlockHeight);
       }},
      {.name = "hands",
       .description = "B8: two hands, one over the block, one over the plane, 3 Hz",
       .method = SceneMethod::self_projected,
       .reference = "block",
       .make = [](const rig::Rig& rig) -> std::unique_ptr<Scene> { return std::make_unique<HandsScene>(rig); }},
  };
  return all;
}

}  // namespace selfproj::sim
