// The shared memory of a ring: opened, checked, locked, mapped.
#ifndef SELFPROJ_HOST_DRIVER_RING_MEMORY_H
#define SELFPROJ_HOST_DRIVER_RING_MEMORY_H

#include <cstddef>
#include <cstdint>
#include <string>

#include "host/driver/ring_layout.h"

namespace selfproj::ring {

// Whether a ring can have this name: 1 to 64 letters, digits, '_', '-' or '.'.
bool is_name(const std::string& name);

// The name of the shared memory of ring `name`, as shm_open takes it. Throws UserError where no ring can have that
// name.
std::string shared_name(const std::string& name);

// A ring that is mapped, or none. Nothing here allocates or throws, but for `create`.
class Memory {
 public:
  // What `attach` found.
  enum class Found : std::uint8_t {
    ring,        // a ring of this layout and specification
    none,        // nothing of this name
    being_made,  // a writer is making one
    unready,     // one whose making was interrupted
    other,       // something of another layout or specification
    no_access    // errno says why
  };

  Memory() = default;
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;
  ~Memory() { detach(); }

  // Readers write, too: their counts. Who only looks needs no right to.
  enum class Access : std::uint8_t { use, look };

  // Maps the ring of this shared name; where it is none of ours, nothing is mapped.
  Found attach(const char* shared, Access access = Access::use);

  // Opens the shared memory of this name, which is made where there is none, for a writer: takes the writer's lock and
  // makes an empty ring of `slots` slots unless there is one of this layout, specification and size. A ring that does
  // not fit is replaced by a new one of the same name; what is attached here goes only when the new one is whole, so
  // that a reader sees a board all the time. Throws UserError, naming `name`: another writer has it, there is no room
  // or no right to replace it, or it cannot be mapped (it is left as it is then).
  void create(const std::string& name, std::uint32_t slots);

  void detach();

  [[nodiscard]] bool attached() const { return header_ != nullptr; }
  // Only where a ring is attached (clang-tidy cannot see that create and attach set it).
  [[nodiscard]] Header& header() const { return *header_; }     // NOLINT(clang-analyzer-core.uninitialized.UndefReturn)
  [[nodiscard]] std::uint32_t slots() const { return slots_; }  // checked when it was mapped

  // The slot of packet `count`, and its packet's first byte.
  [[nodiscard]] Slot& slot(std::uint64_t count) const;
  [[nodiscard]] std::uint8_t* packet(std::uint64_t count) const;

  // Takes the lock (kWriterLock, kReaderLock) until the ring is detached; false where someone else has it.
  [[nodiscard]] bool lock(long which) const;

  // Whether someone else has the lock.
  [[nodiscard]] bool locked(long which) const;

  // Whether the name of this ring was removed: no one else will come to it.
  [[nodiscard]] bool removed() const;

  // Whether its file was made shorter by someone: what is read behind its end is zeros, and what is written there lost.
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

}  // namespace selfproj::ring

#endif  // SELFPROJ_HOST_DRIVER_RING_MEMORY_H
