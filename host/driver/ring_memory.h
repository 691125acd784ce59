// Opens, checks, locks and maps the shared memory of a ring.
#ifndef SELFPROJ_HOST_DRIVER_RING_MEMORY_H
#define SELFPROJ_HOST_DRIVER_RING_MEMORY_H

#include <cstddef>
#include <cstdint>
#include <string>

#include "host/driver/ring_layout.h"

namespace selfproj::ring {

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

}  // namespace selfproj::ring

#endif  // SELFPROJ_HOST_DRIVER_RING_MEMORY_H
