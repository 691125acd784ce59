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
    ring,      // a ring of this layout and specification
    none,      // nothing of this name
    unready,   // one that is just being made, or whose making was interrupted
    other,     // something of another layout or specification
    no_access  // errno says why
  };

  Memory() = default;
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;
  ~Memory() { detach(); }

  // Maps the ring of this shared name; where it is none of ours, nothing is mapped.
  Found attach(const char* shared);

  // Opens the shared memory of this name, which is made where there is none, for a writer: takes the writer's lock and
  // makes an empty ring of `slots` slots unless there is one of this layout, specification and size. A ring that does
  // not fit is replaced by a new one of the same name. Throws UserError, naming `name`, where another writer has it, or
  // there is no room.
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

 private:
  Found map();

  int descriptor_ = -1;
  Header* header_ = nullptr;
  std::size_t bytes_ = 0;
  std::uint32_t slots_ = 0;
};

}  // namespace selfproj::ring

#endif  // SELFPROJ_HOST_DRIVER_RING_MEMORY_H
