// The layout of the ring in shared memory. docs/driver.md has the table and the life cycle.
//
// The writer (the board's side) counts packets written, the reader packets read, both from 0 and never back; slot
// `count % slots` holds packet `count`. Each count is written by one side only and lies in a cache line of its own. A
// slot belongs to the writer while written - read < slots. It belongs to the reader from the moment that `written`
// passes it until `read` passes it. The writer never waits: if all slots are full, it drops the whole packet and counts
// it.
//
// Locks on the file's first two bytes (open file description locks) say whether a writer and a reader exist. The kernel
// releases them whenever a process ends.
#ifndef SELFPROJ_HOST_DRIVER_RING_LAYOUT_H
#define SELFPROJ_HOST_DRIVER_RING_LAYOUT_H

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "model/packet.h"

namespace selfproj::ring {

inline constexpr std::uint64_t kMagic = 0x474E495250464C53;  // "SLFPRING"
inline constexpr std::uint32_t kVersion = 2;
inline constexpr std::size_t kLine = 64;  // bytes of a cache line

using Count = std::atomic<std::uint64_t>;
using Word = std::atomic<std::uint32_t>;
static_assert(Count::is_always_lock_free && Word::is_always_lock_free);

// At the beginning of the shared memory.
struct Header {
  Count magic;  // written last, when the rest is complete
  std::uint32_t version;
  std::uint32_t spec_hash;
  std::uint32_t slots;       // a power of two
  std::uint32_t slot_bytes;  // distance from one slot to the next

  // Written by the writer.
  alignas(kLine) Count written;  // packets put into the ring
  Count lost;                    // packets that found it full
  Word generation;               // number of writers so far
  Word writer_open;              // 1 from a writer's start to its proper end
  Word writer_crashes;           // writers that ended without closing the ring
  Word writer_pid;               // for information

  // Written by the reader.
  alignas(kLine) Count read;  // packets released
  Count lost_told;            // the part of Header::lost that earlier readers have reported
  Word readers;               // number of readers so far
  Word reader_open;           // 1 from a reader's start to its proper end
  Word reader_crashes;        // readers that ended without closing the ring
  Word reader_pid;            // for information

  // Where a reader sleeps: it sets `sleeping` and waits (futex) for `wake` to change.
  alignas(kLine) Word sleeping;
  Word wake;
};

// At the beginning of each slot; the packet follows.
struct alignas(kLine) Slot {
  std::uint64_t number;      // the packet's count; a slot with another count was overwritten
  std::uint64_t lost;        // Header::lost when it was written
  std::int64_t arrival_ns;   // std::chrono::steady_clock when it was written
  std::uint32_t bytes;       // of the packet
  std::uint32_t generation;  // of its writer
};

static_assert(sizeof(Header) == 4 * kLine && sizeof(Slot) == kLine);

inline constexpr std::size_t kSlotBytes = sizeof(Slot) + (kLargestPacketBytes + kLine - 1) / kLine * kLine;

inline constexpr std::uint32_t kMaxSlots = std::uint32_t{1} << 16U;

// Bytes of the whole ring.
constexpr std::size_t ring_bytes(std::uint32_t slots) { return sizeof(Header) + std::size_t{slots} * kSlotBytes; }

// Bytes of the file that the writer and the reader lock.
inline constexpr long kWriterLock = 0;
inline constexpr long kReaderLock = 1;

}  // namespace selfproj::ring

#endif  // SELFPROJ_HOST_DRIVER_RING_LAYOUT_H
