// What the columns of a camera see, from edge to edge of their pixels: the same in every frame.
#ifndef SELFPROJ_SIM_SCENE_COLUMN_VIEWS_H
#define SELFPROJ_SIM_SCENE_COLUMN_VIEWS_H

#include <algorithm>
#include <cstddef>
#include <mutex>
#include <span>
#include <vector>

#include "host/rig/rig.h"
#include "sim/scene/lit_surface.h"
#include "sim/scene/pinhole.h"
#include "sim/scene/scene.h"

namespace selfproj {

// Several threads may call it at once. The sights are found when they are first needed.
class ColumnViews {
 public:
  ColumnViews(const Pinhole& camera, const RigCamera& size)
      : camera_(camera), rows_(size.rows), columns_(size.columns), parts_((size.rows + kPart - 1) / kPart) {}

  static constexpr int kPart = 16;  // rows of a part of a column; the last one may have fewer

  [[nodiscard]] int parts() const { return parts_; }
  [[nodiscard]] int first_row(int part) const { return part * kPart; }
  [[nodiscard]] int rows_of(int part) const { return std::min(kPart, rows_ - part * kPart); }

  // The camera's sights at the upper edge of each row of a part, and at the lower edge of the last one.
  [[nodiscard]] std::span<const Point3> edges(int column, int part) const {
    fill();
    return {edges_.data() + static_cast<std::ptrdiff_t>(column) * (rows_ + 1) + first_row(part),
            static_cast<std::size_t>(rows_of(part)) + 1};
  }

  // Bounds of x and y of these.
  [[nodiscard]] const Box& tangents(int column, int part) const {
    fill();
    return tangents_[static_cast<std::size_t>(column * parts_ + part)];
  }

 private:
  void fill() const {
    std::call_once(filled_, [&] {
      edges_.reserve(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_ + 1));
      for (int column = 0; column < columns_; ++column) {
        for (int row = 0; row <= rows_; ++row) {
          edges_.push_back(camera_.sight({row - 0.5, column + 0.0}));
        }
      }
      for (int column = 0; column < columns_; ++column) {
        for (int part = 0; part < parts_; ++part) {
          tangents_.push_back(
              tangents_of({edges_.data() + static_cast<std::ptrdiff_t>(column) * (rows_ + 1) + first_row(part),
                           static_cast<std::size_t>(rows_of(part)) + 1}));
        }
      }
    });
  }

  Pinhole camera_;
  int rows_, columns_, parts_;
  mutable std::once_flag filled_;
  mutable std::vector<Point3> edges_;  // column by column
  mutable std::vector<Box> tangents_;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_COLUMN_VIEWS_H
