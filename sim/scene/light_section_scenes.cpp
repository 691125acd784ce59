#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <memory>
#include <vector>

#include "selfproj/rig/rig.h"
#include "sim/scene/scene.h"
#include "sim/scene/scenes.h"

namespace selfproj::sim {
namespace {

constexpr double kPartLength = 130;  // length of the parts of rig A: 1400 frames of 0.1 mm with the lead on both sides

class Plane : public ConveyedScene {
 public:
  explicit Plane(const rig::Rig& rig) : ConveyedScene(rig, 0) {}
  [[nodiscard]] double part_height(double /*x*/, double /*y*/) const override { return 0; }
  [[nodiscard]] HeightRange part_range(const Box& /*box*/) const override { return {0, 0}; }
};

// A prism along x: one profile over y, cut off at both ends.
class Prism : public ConveyedScene {
 public:
  Prism(const rig::Rig& rig, double width) : ConveyedScene(rig, kPartLength), half_width_(width / 2) {}

  [[nodiscard]] double part_height(double x, double y) const final {
    return std::abs(x) <= kPartLength / 2 && std::abs(y) <= half_width_ ? top(x, y) : 0;
  }

  [[nodiscard]] HeightRange part_range(const Box& box) const final {
    constexpr double kEnd = kPartLength / 2;
    const Box inner{std::max(box.x0, -kEnd), std::min(box.x1, kEnd), std::max(box.y0, -half_width_),
                    std::min(box.y1, half_width_)};
    if (inner.x0 > inner.x1 || inner.y0 > inner.y1) {
      return {0, 0};
    }
    HeightRange range = top_range(inner);
    const bool inside = inner.x0 == box.x0 && inner.x1 == box.x1 && inner.y0 == box.y0 && inner.y1 == box.y1;
    if (!inside) {
      range.join(0);
    }
    return range;
  }

 protected:
  // Like height and range, but only for points on the part.
  [[nodiscard]] virtual double top(double x, double y) const = 0;
  [[nodiscard]] virtual HeightRange top_range(const Box& box) const = 0;

 private:
  double half_width_;
};

// Experiment A1: a smooth ridge, H (1 − (2 y/W)²)², level on top and where it meets the plane, steepest slope 0.73.
class Mountain : public Prism {
 public:
  explicit Mountain(const rig::Rig& rig) : Prism(rig, kWidth) {}

 protected:
  [[nodiscard]] double top(double /*x*/, double y) const override { return profile(y); }
  [[nodiscard]] HeightRange top_range(const Box& box) const override {
    const double a = profile(box.y0);
    const double b = profile(box.y1);
    return {std::min(a, b), box.y0 <= 0 && box.y1 >= 0 ? kHeight : std::max(a, b)};
  }

 private:
  static constexpr double kHeight = 23.6;
  static constexpr double kWidth = 100;

  static double profile(double y) {
    const double u = 2 * y / kWidth;
    const double v = 1 - u * u;
    return kHeight * v * v;
  }
};

enum class TreadSurface : std::uint8_t { good, marked };

// Experiment A2: three treads side by side across y, with vertical faces, and optionally a mark carved into each.
class Stairs : public Prism {
 public:
  Stairs(const rig::Rig& rig, TreadSurface surface)
      : Prism(rig, kTreadWidth * std::size(kTreads)), marked_(surface == TreadSurface::marked) {}

 protected:
  [[nodiscard]] double top(double x, double y) const override {
    const int i = tread(y);
    const bool carved = marked_ && near_mark(i, {x, x, y, y}) && distance(i, x, y) <= kMarkStroke / 2;
    return tread_height(i) - (carved ? kMarkDepth : 0);
  }

  [[nodiscard]] HeightRange top_range(const Box& box) const override {
    const int first = tread(box.y0);
    const int last = tread(box.y1);
    HeightRange result{std::numeric_limits<double>::max(), 0};
    for (int i = first; i <= last; ++i) {
      const double height = tread_height(i);
      result.join(height);
      if (!marked_ || !near_mark(i, box)) {
        continue;
      }
      // The distance from the mark changes over the rectangle by at most half its diagonal.
      const double dx = box.x1 - box.x0;
      const double dy = box.y1 - box.y0;
      const double half_diagonal = 0.5 * std::sqrt(dx * dx + dy * dy);
      const double d = distance(i, (box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2);
      if (d - half_diagonal <= kMarkStroke / 2) {
        result.low = std::min(result.low, height - kMarkDepth);
        if (first == last && d + half_diagonal <= kMarkStroke / 2) {
          result.high = height - kMarkDepth;
        }
      }
    }
    return result;
  }

 private:
  struct Tread {
    double height;
    Mark mark;
  };
  static constexpr double kTreadWidth = 35;
  static constexpr std::array<Tread, 3> kTreads{{{30, Mark::circle}, {39, Mark::cross}, {21, Mark::triangle_down}}};

  static int tread(double y) {
    constexpr int kLast = static_cast<int>(std::size(kTreads)) - 1;
    return std::clamp(static_cast<int>(std::floor(y / kTreadWidth + std::size(kTreads) / 2.0)), 0, kLast);
  }
  static double tread_height(int i) { return kTreads[static_cast<std::size_t>(i)].height; }
  static double middle(int i) { return kTreadWidth * (i - (std::size(kTreads) - 1) / 2.0); }
  // Whether the rectangle touches the square around the tread's mark.
  static bool near_mark(int i, const Box& box) {
    constexpr double kHalf = kMarkSize / 2;
    return box.x0 <= kHalf && box.x1 >= -kHalf && box.y0 - middle(i) <= kHalf && box.y1 - middle(i) >= -kHalf;
  }
  // Oriented like the measured heights: later frames, which have smaller x, are down.
  static double distance(int i, double x, double y) {
    return distance_from_mark(kTreads[static_cast<std::size_t>(i)].mark, y - middle(i), -x);
  }

  bool marked_;
};

}  // namespace

const std::vector<SceneInfo>& light_section_scenes() {
  static const std::vector<SceneInfo> all{
      {.name = "plane",
       .description = "the bare plane",
       .make = [](const rig::Rig& rig) -> std::unique_ptr<Scene> { return std::make_unique<Plane>(rig); }},
      {.name = "mountain",
       .description = "A1: smooth ridge along x, 23.6 mm high, 100 mm wide",
       .make = [](const rig::Rig& rig) -> std::unique_ptr<Scene> { return std::make_unique<Mountain>(rig); }},
      {.name = "stairs",
       .description = "A2: treads 30, 39, 21 mm high, 35 mm wide each, side by side",
       .make = [](const rig::Rig& rig) -> std::unique_ptr<Scene> {
         return std::make_unique<Stairs>(rig, TreadSurface::good);
       }},
      {.name = "stairs-marked",
       .description = "A2: the same with a circle, a cross and a triangle carved 1 mm deep",
       .reference = "stairs",
       .make = [](const rig::Rig& rig) -> std::unique_ptr<Scene> {
         return std::make_unique<Stairs>(rig, TreadSurface::marked);
       }},
  };
  return all;
}

}  // namespace selfproj::sim
