#include "sim/scene/sight_table.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

namespace selfproj {
namespace {

// All that a camera's sights depend on.
std::array<double, 21> numbers_of(const Pinhole& camera) {
  const Point3 c = camera.centre();
  const auto& a = camera.axes();
  const Pinhole::Intrinsics& k = camera.intrinsics();
  const BrownLens::Coefficients& l = camera.lens().coefficients();
  return {c.x,     c.y,        c.z,    a[0].x, a[0].y, a[0].z,      a[1].x,
          a[1].y,  a[1].z,     a[2].x, a[2].y, a[2].z, k.row_scale, k.column_scale,
          k.row_0, k.column_0, l.k1,   l.k2,   l.p1,   l.p2,        l.k3};
}

}  // namespace

SightTable::SightTable(const Pinhole& camera, const RigCamera& size)
    : camera_(camera),
      rows_(static_cast<std::size_t>((size.rows + 2 * kMargin) * kSubPixels)),
      columns_(static_cast<std::size_t>((size.columns + 2 * kMargin) * kSubPixels)),
      sights_(rows_),
      ready_(rows_),
      filled_(std::make_unique<std::once_flag[]>(rows_)) {}  // NOLINT(modernize-avoid-c-arrays)

bool SightTable::is_of(const Pinhole& camera, const RigCamera& size) const {
  return numbers_of(camera) == numbers_of(camera_) &&
         rows_ == static_cast<std::size_t>((size.rows + 2 * kMargin) * kSubPixels) &&
         columns_ == static_cast<std::size_t>((size.columns + 2 * kMargin) * kSubPixels);
}

const Point3* SightTable::fill(std::size_t row) const {
  std::call_once(filled_[row], [&] {
    const auto middle = [](std::size_t i) { return (static_cast<double>(i) + 0.5) / kSubPixels - 0.5 - kMargin; };
    sights_[row].reserve(columns_);
    for (std::size_t column = 0; column < columns_; ++column) {
      sights_[row].push_back(camera_.sight({middle(row), middle(column)}));
    }
    ready_[row].store(sights_[row].data(), std::memory_order_release);
  });
  return sights_[row].data();
}

std::shared_ptr<const SightTable> SightTable::of(const Pinhole& camera, const RigCamera& size) {
  constexpr std::size_t kMost = std::size_t{64} << 20U;  // bytes
  constexpr std::size_t kSquare = std::size_t{kSubPixels} * kSubPixels;
  if (!camera.lens().distorts() || size.pixels() * kSquare * sizeof(Point3) > kMost) {
    return nullptr;
  }
  static std::mutex mutex;
  static std::array<std::shared_ptr<const SightTable>, 2> kept;  // the newest first
  const std::lock_guard lock(mutex);
  const auto found =
      std::find_if(kept.begin(), kept.end(), [&](const auto& table) { return table && table->is_of(camera, size); });
  if (found != kept.end()) {
    std::rotate(kept.begin(), found, found + 1);
  } else {
    kept[1] = kept[0];
    kept[0] = std::shared_ptr<const SightTable>(new SightTable(camera, size));
  }
  return kept[0];
}

}  // namespace selfproj
