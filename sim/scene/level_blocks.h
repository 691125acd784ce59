// Grey values of level blocks in the light, kept by their height: a part's top shows the same in every frame in which
// it lies under a block.
#ifndef SELFPROJ_SIM_SCENE_LEVEL_BLOCKS_H
#define SELFPROJ_SIM_SCENE_LEVEL_BLOCKS_H

#include <array>
#include <atomic>
#include <cstddef>
#include <deque>
#include <mutex>
#include <utility>
#include <vector>

#include "sim/scene/block_grid.h"

namespace selfproj {

// Several threads may call it at once.
class LevelBlocks {
 public:
  struct Kept {
    double height;
    std::vector<float> values;  // as many as BlockValues has; none if no light falls on the block at this height

    [[nodiscard]] bool dark() const { return values.empty(); }
  };

  explicit LevelBlocks(std::size_t blocks) : slots_(blocks) {}

  // What is kept of a block at this height; null if nothing is. Valid as long as this object.
  [[nodiscard]] const Kept* find(std::size_t block, double height) const {
    for (const std::atomic<const Kept*>& slot : slots_[block]) {
      const Kept* const kept = slot.load(std::memory_order_acquire);
      if (kept == nullptr || kept->height == height) {
        return kept;
      }
    }
    return nullptr;
  }

  // Keeps it, unless kHeights heights of the block are kept already.
  void keep(std::size_t block, Kept kept) {
    const std::lock_guard lock(mutex_);
    for (std::atomic<const Kept*>& slot : slots_[block]) {
      const Kept* const other = slot.load(std::memory_order_relaxed);
      if (other == nullptr) {
        slot.store(&all_.emplace_back(std::move(kept)), std::memory_order_release);
        return;
      }
      if (other->height == kept.height) {
        return;
      }
    }
  }

  static constexpr std::size_t kHeights = 4;

 private:
  std::vector<std::array<std::atomic<const Kept*>, kHeights>> slots_;  // of a block, the first ones filled
  std::deque<Kept> all_;
  std::mutex mutex_;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_LEVEL_BLOCKS_H
