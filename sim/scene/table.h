// A table with things on it that stand still.
#ifndef SELFPROJ_SIM_SCENE_TABLE_H
#define SELFPROJ_SIM_SCENE_TABLE_H

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "sim/scene/scene.h"

namespace selfproj {

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

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_TABLE_H
