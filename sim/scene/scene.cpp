#include "sim/scene/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/io/float_image.h"
#include "host/io/user_error.h"
#include "host/rig/rig.h"
#include "sim/scene/height_map.h"
#include "sim/scene/marks.h"
#include "sim/scene/scanner_scenes.h"
#include "sim/scene/self_scenes.h"

namespace selfproj {
namespace {

constexpr double kPartLength = 130;  // mm, of the parts of rig A: 1400 frames of 0.1 mm with the lead on both sides

HeightRange join(HeightRange a, HeightRange b) { return {std::min(a.low, b.low), std::max(a.high, b.high)}; }

class Plane : public ConveyedScene {
 public:
  explicit Plane(const Rig& rig) : ConveyedScene(rig, 0) {}
  [[nodiscard]] double part_height(double /*x*/, double /*y*/) const override { return 0; }
  [[nodiscard]] HeightRange part_range(const Box& /*box*/) const override { return {0, 0}; }
};

// A prism along x: one profile over y, cut off at both ends.
class Prism : public ConveyedScene {
 public:
  Prism(const Rig& rig, double width) : ConveyedScene(rig, kPartLength), half_width_(width / 2) {}

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
    const HeightRange on_top = top_range(inner);
    const bool inside = inner.x0 == box.x0 && inner.x1 == box.x1 && inner.y0 == box.y0 && inner.y1 == box.y1;
    return inside ? on_top : join(on_top, {0, 0});
  }

 protected:
  // As height and range, of points on the part only.
  [[nodiscard]] virtual double top(double x, double y) const = 0;
  [[nodiscard]] virtual HeightRange top_range(const Box& box) const = 0;

 private:
  double half_width_;
};

// Experiment A1: a smooth ridge, H (1 − (2 y/W)²)²: level on top and where it meets the plane, steepest slope 0.73.
class Mountain : public Prism {
 public:
  explicit Mountain(const Rig& rig) : Prism(rig, kWidth) {}

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

// Experiment A2: three treads side by side across y, with vertical faces, and on request a mark carved into each.
class Stairs : public Prism {
 public:
  Stairs(const Rig& rig, bool marked) : Prism(rig, kTreadWidth * std::size(kTreads)), marked_(marked) {}

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
      result = join(result, {height, height});
      if (!marked_ || !near_mark(i, box)) {
        continue;
      }
      // the distance from the mark changes over the rectangle by at most half its diagonal
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
  // Whether the rectangle touches the square that the tread's mark lies in.
  static bool near_mark(int i, const Box& box) {
    constexpr double kHalf = kMarkSize / 2;
    return box.x0 <= kHalf && box.x1 >= -kHalf && box.y0 - middle(i) <= kHalf && box.y1 - middle(i) >= -kHalf;
  }
  // Read as the measured heights lie: later frames, which are smaller x, are down.
  static double distance(int i, double x, double y) {
    return distance_from_mark(kTreads[static_cast<std::size_t>(i)].mark, y - middle(i), -x);
  }

  bool marked_;
};

int frames_of(const Rig& rig, double length) {
  const double step = rig.conveyor.speed_mm_per_s / rig.camera.frame_rate_hz;
  constexpr double kMost = 1e6;
  return step > 0 ? static_cast<int>(std::clamp(std::round((length + 2 * ConveyedScene::kLead) / step), 1.0, kMost))
                  : 1;
}

}  // namespace

ConveyedScene::ConveyedScene(const Rig& rig, double length)
    : speed_(rig.conveyor.speed_mm_per_s),
      start_(speed_ > 0 ? -(length / 2 + kLead) : 0),
      frames_(frames_of(rig, length)) {}

const std::vector<SceneInfo>& scenes() {
  static const std::vector<SceneInfo> all = [] {
    std::vector<SceneInfo> list{
        {"plane", "the bare plane", "light-section", "", 0},
        {"mountain", "A1: smooth ridge along x, 23.6 mm high, 100 mm wide", "light-section", "", 0},
        {"stairs", "A2: treads 30, 39, 21 mm high, 35 mm wide each, side by side", "light-section", "", 0},
        {"stairs-marked", "A2: the same with a circle, a cross and a triangle carved 1 mm deep", "light-section",
         "stairs", 0},
    };
    list.insert(list.end(), scanner_scenes().begin(), scanner_scenes().end());
    list.insert(list.end(), self_scenes().begin(), self_scenes().end());
    for (SceneInfo& info : list) {
      info.frames = make_scene(info.name, load_rig(info.rig))->frames();
    }
    return list;
  }();
  return all;
}

std::unique_ptr<Scene> make_scene(const std::string& name, const Rig& rig) {
  if (name == "plane") {
    return std::make_unique<Plane>(rig);
  }
  if (name == "mountain") {
    return std::make_unique<Mountain>(rig);
  }
  if (name == "stairs" || name == "stairs-marked") {
    return std::make_unique<Stairs>(rig, name == "stairs-marked");
  }
  for (const auto& [of_scanner, make] :
       {std::pair{&scanner_scenes(), &make_scanner_scene}, {&self_scenes(), &make_self_scene}}) {
    if (std::any_of(of_scanner->begin(), of_scanner->end(), [&](const SceneInfo& info) { return info.name == name; })) {
      if (rig.kind != RigKind::scanner) {
        throw UserError(name, fmt::format("is a scene for a rig of kind scanner; {} is none", rig.name));
      }
      return make(name, rig);
    }
  }
  std::string names;
  for (const SceneInfo& info : scenes()) {
    names += (names.empty() ? "" : ", ") + info.name;
  }
  throw UserError(name, fmt::format("is no scene (there are {})", names));
}

std::unique_ptr<Scene> height_map_scene(const FloatImage& height_mm, double mm_per_pixel, const Rig& rig,
                                        const std::string& source) {
  if (height_mm.values.empty()) {
    throw UserError(source, "has no pixels");
  }
  if (!(mm_per_pixel > 0) || !std::isfinite(mm_per_pixel)) {
    throw UserError(source, fmt::format("has a scale of {} mm a pixel; it must be greater than 0", mm_per_pixel));
  }
  return std::make_unique<HeightMap>(height_mm, mm_per_pixel, rig, source);
}

}  // namespace selfproj
