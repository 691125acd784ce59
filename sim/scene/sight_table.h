// The sights of a camera's sub-pixels. A lens that distorts is inverted step by step for each, and every frame and
// every scene asks for the same ones.
#ifndef SELFPROJ_SIM_SCENE_SIGHT_TABLE_H
#define SELFPROJ_SIM_SCENE_SIGHT_TABLE_H

#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "host/rig/rig.h"
#include "sim/scene/lens_kernel.h"
#include "sim/scene/pinhole.h"

namespace selfproj {

class SightTable {
 public:
  // The table of a camera, which is shared with whoever asked for the same one before; null if its lens does not
  // distort, or if the table would be larger than 64 MiB. Several threads may call it at once.
  static std::shared_ptr<const SightTable> of(const Pinhole& camera, const RigCamera& size);

  // What camera.sight(pixel) gives, to the last digit. It is looked up for the middles of sub-pixels in the image and
  // in a margin of 8 pixels around it.
  [[nodiscard]] Point3 sight(PixelPoint pixel) const {
    const double r = (pixel.row + kMargin + 0.5) * kSubPixels - 0.5;
    const double c = (pixel.column + kMargin + 0.5) * kSubPixels - 0.5;
    if (r >= 0 && c >= 0 && r < static_cast<double>(rows_) && c < static_cast<double>(columns_)) {
      const auto row = static_cast<std::size_t>(r);
      const auto column = static_cast<std::size_t>(c);
      if (static_cast<double>(row) == r && static_cast<double>(column) == c) {
        return sights_of(row)[column];
      }
    }
    return camera_.sight(pixel);
  }

 private:
  static constexpr int kMargin = 8;  // pixels

  SightTable(const Pinhole& camera, const RigCamera& size);
  [[nodiscard]] bool is_of(const Pinhole& camera, const RigCamera& size) const;
  const Point3* sights_of(std::size_t row) const {
    const Point3* const filled = ready_[row].load(std::memory_order_acquire);
    return filled != nullptr ? filled : fill(row);
  }
  const Point3* fill(std::size_t row) const;

  Pinhole camera_;
  std::size_t rows_, columns_;  // of sub-pixels
  mutable std::vector<std::vector<Point3>> sights_;
  mutable std::vector<std::atomic<const Point3*>> ready_;  // the rows that are filled; null before
  std::unique_ptr<std::once_flag[]> filled_;  // NOLINT(modernize-avoid-c-arrays): once_flag cannot be moved
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_SIGHT_TABLE_H
