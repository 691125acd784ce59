#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "sim/scene/ring_wave.h"
#include "sim/scene/scene.h"
#include "sim/scene/scenes.h"

namespace selfproj::sim {
namespace {

constexpr double kBlackSleeve = 0.02;  // albedo too dark for the threshold, so that an arm is not measured
constexpr double kSkin = 0.8;

// ------------------------------------------------------------------ Things that stand still on a table

// A part of a surface that stands still: its heights over the plane, and their bounds over a rectangle; 0 outside.
class TablePart {
 public:
  TablePart() = default;
  TablePart(const TablePart&) = delete;
  TablePart& operator=(const TablePart&) = delete;
  virtual ~TablePart() = default;
  [[nodiscard]] virtual double height(double x, double y) const = 0;
  [[nodiscard]] virtual HeightRange range(const Box& box) const = 0;
};

class TableSlab final : public TablePart {
 public:
  TableSlab(const Box& box, double top) : box_(box), top_(top) {}
  [[nodiscard]] double height(double x, double y) const override {
    return x >= box_.x0 && x <= box_.x1 && y >= box_.y0 && y <= box_.y1 ? top_ : 0;
  }
  [[nodiscard]] HeightRange range(const Box& b) const override {
    const bool touches = b.x1 >= box_.x0 && b.x0 <= box_.x1 && b.y1 >= box_.y0 && b.y0 <= box_.y1;
    const bool inside = b.x0 >= box_.x0 && b.x1 <= box_.x1 && b.y0 >= box_.y0 && b.y1 <= box_.y1;
    return {inside ? top_ : 0, touches ? top_ : 0};
  }

 private:
  Box box_;
  double top_;
};

// Half an ellipsoid on a cylinder.
class TableDome final : public TablePart {
 public:
  struct Size {
    double rx, ry, base, rise;
  };
  TableDome(double x, double y, const Size& size) : x_(x), y_(y), size_(size) {}
  [[nodiscard]] double height(double x, double y) const override {
    const double u = (x - x_) / size_.rx;
    const double v = (y - y_) / size_.ry;
    return at(u * u + v * v);
  }
  [[nodiscard]] HeightRange range(const Box& b) const override {
    if (b.x1 < x_ - size_.rx || b.x0 > x_ + size_.rx || b.y1 < y_ - size_.ry || b.y0 > y_ + size_.ry) {
      return {0, 0};
    }
    const auto near = [](double low, double high) { return std::clamp(0.0, low, high); };
    const auto far = [](double low, double high) { return std::max(-low, high); };
    const double x0 = b.x0 - x_;
    const double x1 = b.x1 - x_;
    const double y0 = b.y0 - y_;
    const double y1 = b.y1 - y_;
    return {height(x_ + far(x0, x1), y_ + far(y0, y1)), height(x_ + near(x0, x1), y_ + near(y0, y1))};
  }

 private:
  [[nodiscard]] double at(double distance_2) const {
    return distance_2 <= 1 ? size_.base + size_.rise * std::sqrt(1 - distance_2) : 0;
  }
  double x_, y_;
  Size size_;
};

// A surface whose height is that of its highest part.
class Table : public Scene {
 public:
  explicit Table(int frames) : frames_(frames) {}
  template <class P, class... Arguments>
  void add(Arguments&&... arguments) {
    parts_.push_back(std::make_unique<P>(std::forward<Arguments>(arguments)...));
  }
  [[nodiscard]] int frames() const override { return frames_; }
  [[nodiscard]] double height(double x, double y, double /*t*/) const override {
    double height = 0;
    for (const auto& part : parts_) {
      height = std::max(height, part->height(x, y));
    }
    return height;
  }
  [[nodiscard]] HeightRange range(const Box& box, double /*t0*/, double /*t1*/) const override {
    HeightRange all{0, 0};
    for (const auto& part : parts_) {
      const HeightRange range = part->range(box);
      all = {std::max(all.low, range.low), std::max(all.high, range.high)};
    }
    return all;
  }
  [[nodiscard]] double speed() const override { return 0; }

 private:
  int frames_;
  std::vector<std::unique_ptr<TablePart>> parts_;
};

// ------------------------------------------------------------------ B1

// A mouse, two books on top of each other, three balls.
class Desk : public Table {
 public:
  explicit Desk(int frames) : Table(frames) {
    add<TableDome>(60.0, -130.0, TableDome::Size{55, 32, 12, 26});  // the mouse
    add<TableSlab>(Box{-190, -40, -120, 40}, 24);
    add<TableSlab>(Box{-170, -60, -100, 20}, 45);
    add<TableDome>(-135.0, 130.0, TableDome::Size{33, 33, 33, 33});  // balls: upper halves on cylinders of their radius
    add<TableDome>(-5.0, -60.0, TableDome::Size{20, 20, 20, 20});
    add<TableDome>(-60.0, 60.0, TableDome::Size{20, 20, 20, 20});
  }
};

// A fist at the end of a black sleeve. It moves on a circle so slanted that it rises and falls by 50 mm.
class Fist final : public Desk {
 public:
  Fist(const rig::Rig& rig, const FistPath& path)
      : Desk(static_cast<int>(std::lround(2 * rig.camera.frame_rate_hz))), plane_z_(rig.plane_z_mm), path_(path) {}

  [[nodiscard]] Bodies bodies(double t) const override {
    const double phase = 2 * std::numbers::pi * path_.frequency * t + path_.phase;
    const double up = std::sqrt(path_.radius * path_.radius - path_.rise * path_.rise) * std::sin(phase);
    const double level = path_.radius * std::cos(phase);
    const Point3 c{path_.x + up * std::cos(path_.towards) - level * std::sin(path_.towards),
                   path_.y + up * std::sin(path_.towards) + level * std::cos(path_.towards),
                   plane_z_ - path_.height - path_.rise * std::sin(phase)};
    Bodies bodies;
    bodies.push_back(std::make_unique<Ellipsoid>(c, std::array<Point3, 3>{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
                                                 Point3{38, 34, 26}, kSkin));
    for (int knuckle = 0; knuckle < 4; ++knuckle) {
      const double x = -24 + 16.0 * knuckle;
      bodies.push_back(std::make_unique<Capsule>(c + Point3{x, -20, -14}, c + Point3{x, 14, -18}, 9, kSkin));
    }
    bodies.push_back(
        std::make_unique<Capsule>(c + Point3{10, 40, 8}, Point3{60, 420, plane_z_ - 40}, 28, kBlackSleeve));
    return bodies;
  }
  [[nodiscard]] double body_speed() const override { return 2 * std::numbers::pi * path_.frequency * path_.radius; }

 private:
  double plane_z_;
  FistPath path_;
};

// ------------------------------------------------------------------ B2

// The water's surface in the pool: the wave and its reflections at the four walls, which are those of its mirror
// images.
class Water final : public Body {
 public:
  // At rest.
  explicit Water(double z) : z_(z) {}

  // With the wave at `t` after the impact at (x, y).
  Water(double z, const RingWave& wave, double t, double impact_x, double impact_y)
      : z_(z), most_(t < 0 ? 0 : 2 * wave.most()), profile_(wave.profile(t)) {
    const double reach = profile_.reach();
    for (const double x : images(impact_x, kX0, kX1)) {
      for (const double y : images(impact_y, kY0, kY1)) {
        const double dx = std::max({kX0 - x, 0.0, x - kX1});
        const double dy = std::max({kY0 - y, 0.0, y - kY1});
        if (std::hypot(dx, dy) < reach) {
          sources_.push_back({x, y});
        }
      }
    }
  }

  [[nodiscard]] bool meets(const Ray& ray, double most, Meeting& meeting) const override {
    if (!(ray.along.z > 0)) {
      return false;
    }
    double s = (z_ - ray.from.z) / ray.along.z;
    double rise = 0;
    double gx = 0;
    double gy = 0;
    if (!sources_.empty()) {
      // The wave is so flat that each step reduces the error to less than a tenth.
      constexpr int kSteps = 8;
      constexpr double kExact = 1e-5;
      for (int i = 0; i < kSteps; ++i) {
        const Point3 p = ray.from + s * ray.along;
        const double before = rise;
        rise = gx = gy = 0;
        for (const Source& source : sources_) {
          const double dx = p.x - source.x;
          const double dy = p.y - source.y;
          const double r = std::sqrt(dx * dx + dy * dy);
          const RingWave::Profile::Value value = profile_.at(r);
          rise += value.rise;
          if (r > 0) {
            gx += value.slope * dx / r;
            gy += value.slope * dy / r;
          }
        }
        s = (z_ - rise - ray.from.z) / ray.along.z;
        if (std::abs(rise - before) < kExact) {
          break;
        }
      }
    }
    const Point3 p = ray.from + s * ray.along;
    if (!(s > 0 && s < most) || p.x < kX0 || p.x > kX1 || p.y < kY0 || p.y > kY1) {
      return false;
    }
    meeting = {s, 1 / std::sqrt(gx * gx + gy * gy + 1) * Point3{-gx, -gy, -1}};
    return true;
  }
  // Waves this flat throw no shadows.
  [[nodiscard]] bool blocks(const Ray& /*ray*/, double /*most*/) const override { return false; }
  [[nodiscard]] bool is_near(const Ray& /*line*/, double /*slack*/) const override { return true; }
  [[nodiscard]] Cuboid bounds() const override { return {{kX0, kY0, z_ - most_}, {kX1, kY1, z_ + most_}}; }

 private:
  struct Source {
    double x, y;
  };
  static constexpr double kX0 = PoolWave::kCentreX - PoolWave::kWidth / 2;
  static constexpr double kX1 = PoolWave::kCentreX + PoolWave::kWidth / 2;
  static constexpr double kY0 = -PoolWave::kLength / 2;
  static constexpr double kY1 = PoolWave::kLength / 2;
  static std::array<double, 5> images(double place, double low, double high) {
    const double way = 2 * (high - low);
    return {place, 2 * low - place, 2 * high - place, place - way, place + way};
  }

  double z_;
  double most_ = 0;
  RingWave::Profile profile_;
  std::vector<Source> sources_;
};

// The pool and its wall, which is as high as the water.
class Pool : public Table {
 public:
  Pool(const rig::Rig& rig, int frames, double depth) : Table(frames), level_(rig.plane_z_mm - depth) {
    constexpr double kWall = 6;
    constexpr double kX = PoolWave::kWidth / 2;
    constexpr double kY = PoolWave::kLength / 2;
    constexpr double kMiddle = PoolWave::kCentreX;
    add<TableSlab>(Box{kMiddle - kX - kWall, kMiddle - kX, -kY - kWall, kY + kWall}, depth);
    add<TableSlab>(Box{kMiddle + kX, kMiddle + kX + kWall, -kY - kWall, kY + kWall}, depth);
    add<TableSlab>(Box{kMiddle - kX, kMiddle + kX, -kY - kWall, -kY}, depth);
    add<TableSlab>(Box{kMiddle - kX, kMiddle + kX, kY, kY + kWall}, depth);
  }
  [[nodiscard]] Bodies bodies(double /*t*/) const override {
    Bodies bodies;
    bodies.push_back(std::make_unique<Water>(level_));
    return bodies;
  }

 protected:
  [[nodiscard]] double level() const { return level_; }  // z of the water at rest

 private:
  double level_;
};

class Waves final : public Pool {
 public:
  Waves(const rig::Rig& rig, const PoolDrop& drop)
      : Pool(rig, static_cast<int>(std::lround((PoolWave::kImpact + drop.after) * rig.camera.frame_rate_hz)),
             drop.depth),
        drop_(drop),
        wave_(drop.depth, drop.crater, drop.size, drop.after + 0.05) {}

  // The body falls from rest, and disappears in the white water.
  [[nodiscard]] Bodies bodies(double t) const override {
    constexpr double kAcceleration = 9800;  // mm/s²
    const double left = PoolWave::kImpact - t;
    const double fall = std::min(kFall, left > 0 ? kAcceleration / 2 * left * left : kSink * left);
    const double bottom = level() - fall;  // z of its lower side
    Bodies bodies;
    bodies.push_back(std::make_unique<Water>(level(), wave_, -left, drop_.x, drop_.y));
    bodies.push_back(std::make_unique<Block>(
        Cuboid{{drop_.x - 13.5, drop_.y - 11.5, bottom - 11}, {drop_.x + 13.5, drop_.y + 11.5, bottom}}));
    return bodies;
  }
  [[nodiscard]] double body_speed() const override { return 1500; }  // the greatest speed of the fall

 private:
  static constexpr double kFall = 100;  // mm
  static constexpr double kSink = 700;  // mm/s

  PoolDrop drop_;
  RingWave wave_;
};

// ------------------------------------------------------------------ B3

// Keys of 16 mm on a pitch of 18 mm, with staggered rows.
class Keyboard : public Table {
 public:
  Keyboard(const rig::Rig& rig, int frames) : Table(frames), plane_z_(rig.plane_z_mm) {
    const double scale = rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
    const auto seen = [&](KeyTaps::Pixel pixel) {  // at a nail's height
      const double z = plane_z_ - kNail;
      return Point3{z * scale * (pixel.row - (rig.camera.rows - 1) / 2.0),
                    z * scale * (pixel.column - (rig.camera.columns - 1) / 2.0), z};
    };
    tips_ = {seen(KeyTaps::kFirst.of(rig.camera)), seen(KeyTaps::kSecond.of(rig.camera))};
    const Point3 middle = 0.5 * (tips_[0] + tips_[1]);
    keys_ = {Point3{middle.x - kPitch / 2, middle.y + kPitch / 2, 0},
             Point3{middle.x + kPitch / 2, middle.y - kPitch / 2, 0}};
    // All keys except the two that move, in five rows of twelve. The two lie diagonally next to each other.
    constexpr int kRows = 5;
    constexpr int kColumns = 12;
    for (int row = 0; row < kRows; ++row) {
      for (int column = 0; column < kColumns; ++column) {
        const double x = keys_[0].x + kPitch * (row - 2);
        const double y = keys_[0].y + kPitch * (column - 6);
        if ((row == 2 && column == 6) || (row == 3 && column == 5)) {
          continue;
        }
        add<TableSlab>(Box{x - kKey / 2, x + kKey / 2, y - kKey / 2, y + kKey / 2}, kTop);
      }
    }
    add<TableSlab>(
        Box{keys_[0].x - 2.7 * kPitch, keys_[0].x + 2.7 * kPitch, keys_[0].y - 6.7 * kPitch, keys_[0].y + 5.7 * kPitch},
        kTop - 8);
  }
  [[nodiscard]] Bodies bodies(double /*t*/) const override {
    Bodies bodies;
    for (const Point3& key : keys_) {
      bodies.push_back(cap(key, kTop));
    }
    return bodies;
  }

 protected:
  static constexpr double kPitch = 18;  // mm
  static constexpr double kKey = 16;
  static constexpr double kTop = 30;                             // height of a key at rest
  static constexpr double kTravel = 3.5;                         // travel of a key
  static constexpr double kFinger = 7.5;                         // radius of a finger
  static constexpr double kNail = kTop - kTravel + 2 * kFinger;  // height of a fingertip that has pressed a key

  [[nodiscard]] std::unique_ptr<Body> cap(const Point3& key, double top) const {
    return std::make_unique<Block>(Cuboid{{key.x - kKey / 2, key.y - kKey / 2, plane_z_ - top},
                                          {key.x + kKey / 2, key.y + kKey / 2, plane_z_ - top + 6}});
  }
  [[nodiscard]] const Point3& key(std::size_t i) const { return keys_[i]; }
  [[nodiscard]] const Point3& tip(std::size_t i) const { return tips_[i]; }
  [[nodiscard]] double plane_z() const { return plane_z_; }

 private:
  double plane_z_;
  std::array<Point3, 2> keys_{};
  std::array<Point3, 2> tips_{};  // what the two pixels see when the fingers are down
};

// Two fingers of a hand that tap in turn.
class Keys final : public Keyboard {
 public:
  Keys(const rig::Rig& rig, const Taps& taps)
      : Keyboard(rig, static_cast<int>(std::lround(3 * rig.camera.frame_rate_hz))), taps_(taps) {}

  [[nodiscard]] Bodies bodies(double t) const override {
    Bodies bodies;
    std::array<double, 2> lift{};
    for (std::size_t i = 0; i < lift.size(); ++i) {
      const double phase = 2 * std::numbers::pi * taps_.frequency[i] * t + taps_.phase[i];
      lift[i] = taps_.stroke[i] * (1 - std::cos(phase)) / 2;
      bodies.push_back(cap(key(i), std::min(kTop, kTop - kTravel + lift[i])));
    }
    for (std::size_t i = 0; i < lift.size(); ++i) {
      const Point3 end = tip(i) + Point3{0, 0, kFinger - lift[i]};  // end of the finger's axis
      const Point3 joint = end + Point3{28, 3, -14};
      const Point3 knuckle{tip(0).x + 85, end.y + 8, plane_z() - 75};
      bodies.push_back(std::make_unique<Capsule>(end + Point3{-10, 0, 0}, joint, kFinger, kSkin));
      bodies.push_back(std::make_unique<Capsule>(joint, knuckle, 8.5, kSkin));
    }
    const Point3 palm{tip(0).x + 112, -2, plane_z() - 72};
    bodies.push_back(std::make_unique<Ellipsoid>(palm, std::array<Point3, 3>{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
                                                 Point3{42, 36, 15}, kSkin));
    bodies.push_back(std::make_unique<Capsule>(palm + Point3{50, 0, 0}, palm + Point3{250, 30, -10}, 24, kBlackSleeve));
    return bodies;
  }
  [[nodiscard]] double body_speed() const override {
    return std::numbers::pi * std::max(taps_.frequency[0] * taps_.stroke[0], taps_.frequency[1] * taps_.stroke[1]);
  }

 private:
  Taps taps_;
};

}  // namespace

std::unique_ptr<Scene> make_fist(const rig::Rig& rig, const FistPath& path) {
  return std::make_unique<Fist>(rig, path);
}

std::unique_ptr<Scene> make_pool(const rig::Rig& rig, double depth) { return std::make_unique<Pool>(rig, 1, depth); }

std::unique_ptr<Scene> make_waves(const rig::Rig& rig, const PoolDrop& drop) {
  return std::make_unique<Waves>(rig, drop);
}

std::unique_ptr<Scene> make_keys(const rig::Rig& rig, const Taps& taps) { return std::make_unique<Keys>(rig, taps); }

const std::vector<SceneInfo>& scanner_scenes() {
  static const std::vector<SceneInfo> all{
      {.name = "desk",
       .description = "mouse, books and balls, for the background of the fist",
       .method = SceneMethod::gray_codes,
       .make = [](const rig::Rig& /*rig*/) -> std::unique_ptr<Scene> { return std::make_unique<Desk>(1); }},
      {.name = "fist",
       .description = "B1: a fist on a slanted circle, 3.5 turns a second, over the desk",
       .method = SceneMethod::gray_codes,
       .reference = "desk",
       .make = [](const rig::Rig& rig) -> std::unique_ptr<Scene> { return make_fist(rig, {}); }},
      {.name = "pool",
       .description = "still water of 3 cm, 34 x 25 cm",
       .method = SceneMethod::gray_codes,
       .make = [](const rig::Rig& rig) { return make_pool(rig, PoolWave::kDepth); }},
      {.name = "waves",
       .description = "B2: a body falls into the pool at 1.36 s, and makes a wave",
       .method = SceneMethod::gray_codes,
       .reference = "pool",
       .analysis = SceneAnalysis::wave_front,
       .make = [](const rig::Rig& rig) { return make_waves(rig, {}); }},
      {.name = "keyboard",
       .description = "keys on a pitch of 18 mm",
       .method = SceneMethod::gray_codes,
       .make = [](const rig::Rig& rig) -> std::unique_ptr<Scene> { return std::make_unique<Keyboard>(rig, 1); }},
      {.name = "keys",
       .description = "B3: two fingers tap on keys, 5 times a second each, 10 mm",
       .method = SceneMethod::gray_codes,
       .reference = "keyboard",
       .analysis = SceneAnalysis::key_taps,
       .make = [](const rig::Rig& rig) -> std::unique_ptr<Scene> { return make_keys(rig, {}); }},
  };
  return all;
}

}  // namespace selfproj::sim
