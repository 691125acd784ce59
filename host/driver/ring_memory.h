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
#ifndef SELFPROJ_HOST_DRIVER_RING_MEMORY_H
#define SELFPROJ_HOST_DRIVER_RING_MEMORY_H

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "selfproj/model/packet.h"

namespace selfproj::driver::ring {

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
  Count lost_reported;        // the part of Header::lost that earlier readers have reported
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

inline constexpr std::size_t kSlotBytes = sizeof(Slot) + (model::kLargestPacketBytes + kLine - 1) / kLine * kLine;

inline constexpr std::uint32_t kMaxSlots = std::uint32_t{1} << 16U;

// Bytes of the whole ring.
constexpr std::size_t ring_bytes(std::uint32_t slots) { return sizeof(Header) + std::size_t{slots} * kSlotBytes; }

// Bytes of the file that the writer and the reader lock.
inline constexpr long kWriterLock = 0;
inline constexpr long kReaderLock = 1;

// Whether a ring can have this name: 1 to 64 letters, digits, '_', '-' or '.'.
bool is_name(const std::string& name);

// The name of the shared memory of ring `name`, as shm_open takes it. Throws UserError if the name is not valid.
std::string shared_name(const std::string& name);

// A mapped ring, or none. Only `create` allocates or throws.
class Memory {
 public:
  // The result of `attach`.
  enum class Found : std::uint8_t {
    ring,        // a ring of this layout and specification
    none,        // nothing of this name
    being_made,  // a writer is making one
    unready,     // a ring whose creation was interrupted
    other,       // something of another layout or specification
    no_access    // errno has the reason
  };

  Memory() = default;
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;
  ~Memory() { detach(); }

  // Readers write their counts, too. A process that only looks needs no permission to write.
  enum class Access : std::uint8_t { use, look };

  // Maps the ring of this shared name. Maps nothing if it is not a ring of this project.
  Found attach(const char* shared, Access access = Access::use);

  // Opens or creates the shared memory of this name for a writer: takes the writer's lock, and makes an empty ring of
  // `slots` slots unless the memory holds one of this layout, specification and size. A ring that does not fit is
  // replaced by a new one of the same name. The old one is detached only when the new one is complete, so that a reader
  // always sees a board. Throws UserError, naming `name`, if another writer has the ring, if there is no room or no
  // permission to replace it, or if it cannot be mapped (it then stays unchanged).
  void create(const std::string& name, std::uint32_t slots);

  void detach();

  [[nodiscard]] bool attached() const { return header_ != nullptr; }
  // Only if a ring is attached (clang-tidy cannot see that create and attach set it).
  [[nodiscard]] Header& header() const { return *header_; }     // NOLINT(clang-analyzer-core.uninitialized.UndefReturn)
  [[nodiscard]] std::uint32_t slots() const { return slots_; }  // checked when it was mapped

  // The slot of packet `count`, and its packet's first byte.
  [[nodiscard]] Slot& slot(std::uint64_t count) const;
  [[nodiscard]] std::uint8_t* packet(std::uint64_t count) const;

  // Takes the lock (kWriterLock, kReaderLock) until the ring is detached. Returns false if another process has it.
  [[nodiscard]] bool lock(long which) const;

  // Whether another process has the lock.
  [[nodiscard]] bool locked(long which) const;

  // Whether the name of this ring was removed, so that no other process can find it.
  [[nodiscard]] bool removed() const;

  // Whether another process has shortened its file. Reads behind the end then give zeros, and writes there are lost.
  [[nodiscard]] bool shortened() const;

 private:
  Found map(Access access = Access::use);
  void unmap();
  bool open_for_writer(const std::string& uri, const std::string& shared, std::uint32_t slots, Memory& replaced);
  void fill(const std::string& uri, const std::string& shared, std::uint32_t slots);
  void swap(Memory& other) noexcept;

  int descriptor_ = -1;
  Header* header_ = nullptr;
  std::size_t bytes_ = 0;
  std::uint32_t slots_ = 0;
};

}  // namespace selfproj::driver::ring

namespace selfproj::driver {

// The present state of a ring.
struct RingInfo {
  std::string name;
  std::string problem;          // why the ring cannot be used; the rest is then 0
  bool board = false;           // a board is writing into it
  bool reader = false;          // a reader is reading from it
  std::uint32_t board_pid = 0;  // process IDs of the last board and reader
  std::uint32_t reader_pid = 0;
  std::uint32_t slots = 0;
  std::uint64_t written = 0;  // packets put into it
  std::uint64_t read = 0;     // packets released
  std::uint64_t lost = 0;     // packets for which it had no room
  std::uint32_t boards = 0;   // boards started so far
  std::uint32_t readers = 0;
  std::uint32_t board_crashes = 0;  // of these, boards that ended without saying so
  std::uint32_t reader_crashes = 0;
};

// All rings in the order of their names. Does not disturb their users.
std::vector<RingInfo> list_rings();

// Removes the name of a ring. Its reader reads the remaining packets, and then waits for a new ring. Its writer
// continues, but nobody reads. Returns false if the ring does not exist. Throws UserError if removal is not allowed or
// the name is invalid.
bool remove_ring(const std::string& name);

}  // namespace selfproj::driver

#endif  // SELFPROJ_HOST_DRIVER_RING_MEMORY_H
