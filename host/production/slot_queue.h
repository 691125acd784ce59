// Profiles or depth images from the thread that takes packets to the thread that makes parts of them.
#ifndef SELFPROJ_HOST_PRODUCTION_SLOT_QUEUE_H
#define SELFPROJ_HOST_PRODUCTION_SLOT_QUEUE_H

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "model/packet.h"

namespace selfproj {

// A bounded queue for one writer and one reader, without locks and, after the start, without allocation. The writer
// computes a thing in its place. Nothing is dropped: a writer that finds the queue full has to wait.
template <class Thing>
class SlotQueue {
 public:
  struct Slot {
    PacketHeader header;
    std::int64_t arrival_ns = 0;
    Thing thing;
  };

  // `slots` is a power of two; `prepare` gives each thing its size.
  template <class Prepare>
  SlotQueue(std::size_t slots, const Prepare& prepare) : slots_(slots) {
    for (Slot& slot : slots_) {
      prepare(slot.thing);
    }
  }

  // The writer's side: the place of the next thing, or null while the queue is full; the same until publish().
  Slot* claim() {
    const std::uint64_t written = written_.load(std::memory_order_relaxed);
    if (written - read_seen_ >= slots_.size()) {
      read_seen_ = read_.load(std::memory_order_acquire);
      if (written - read_seen_ >= slots_.size()) {
        return nullptr;
      }
    }
    return &slots_[written & (slots_.size() - 1)];
  }
  void publish() { written_.store(written_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }

  // The reader's side: the oldest thing, or null if there is none; it stays until release().
  Slot* front() {
    const std::uint64_t read = read_.load(std::memory_order_relaxed);
    return read == written_.load(std::memory_order_acquire) ? nullptr : &slots_[read & (slots_.size() - 1)];
  }
  void release() { read_.store(read_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }

 private:
  std::vector<Slot> slots_;
  alignas(64) std::atomic<std::uint64_t> written_{0};
  std::uint64_t read_seen_ = 0;  // the writer's last look at read_
  alignas(64) std::atomic<std::uint64_t> read_{0};
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_PRODUCTION_SLOT_QUEUE_H
