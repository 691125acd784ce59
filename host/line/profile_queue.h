// Profiles from the thread that takes packets to the thread that makes parts of them.
#ifndef SELFPROJ_HOST_LINE_PROFILE_QUEUE_H
#define SELFPROJ_HOST_LINE_PROFILE_QUEUE_H

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/light_section/profile.h"
#include "model/packet.h"

namespace selfproj {

// A bounded queue for one writer and one reader, without locks and, after the start, without allocation. The writer
// computes a profile in its place. Nothing is dropped: a writer that finds the queue full has to wait.
class ProfileQueue {
 public:
  struct Slot {
    PacketHeader header;
    std::int64_t arrival_ns = 0;
    Profile profile;
  };

  // `slots` is a power of two.
  ProfileQueue(int columns, std::size_t slots) : slots_(slots) {
    for (Slot& slot : slots_) {
      slot.profile.resize(columns);
    }
  }

  // The writer's side: the place of the next profile, or null while the queue is full; the same until publish().
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

  // The reader's side: the oldest profile, or null if there is none; it stays until release().
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

#endif  // SELFPROJ_HOST_LINE_PROFILE_QUEUE_H
