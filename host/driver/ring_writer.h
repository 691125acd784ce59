// The board's side of a ring.
#ifndef SELFPROJ_HOST_DRIVER_RING_WRITER_H
#define SELFPROJ_HOST_DRIVER_RING_WRITER_H

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "host/driver/ring_memory.h"

namespace selfproj::driver {

// Puts packets into the ring `name`. It makes the ring if it does not exist, and otherwise continues it like a
// restarted board. It never waits: if the ring is full, the packet is lost and counted in the ring.
class RingWriter {
 public:
  static constexpr std::uint32_t kDefaultSlots = 1024;  // 0.1 s at 10,000 packets a second; 34 MB
  static constexpr std::uint32_t kDeepSlots = 16384;    // 1.6 s; 540 MB

  // The number of slots of the existing ring, if it has kDefaultSlots or more. Otherwise kDeepSlots, so that a reader
  // that is not scheduled for a second loses nothing. This number is halved, down to kDefaultSlots, until the ring
  // takes at most half of the free space in /dev/shm. Throws UserError if the name is not valid.
  static std::uint32_t deep_slots(const std::string& name);

  // `slots`: a power of two up to 65536. A ring with another number is replaced. Throws UserError if another writer has
  // the ring, there is no room, or the name or the number is not valid.
  explicit RingWriter(const std::string& name, std::uint32_t slots = kDefaultSlots);
  RingWriter(const RingWriter&) = delete;
  RingWriter& operator=(const RingWriter&) = delete;

  // The ring stays for its reader and the next writer; remove_ring removes it.
  ~RingWriter();

  // Copies the packet into the ring without judging its bytes. Returns false if it was lost. Throws
  // std::invalid_argument if it is larger than kLargestPacketBytes.
  bool write(std::span<const std::uint8_t> packet);

  // The same without a copy: returns kLargestPacketBytes to fill, or nothing if the ring is full, which counts as a
  // loss.
  [[nodiscard]] std::span<std::uint8_t> claim();
  // Publishes the first `bytes` of the last claim as a packet.
  void publish(std::size_t bytes);

  // Packets lost since this writer began, because the ring was full or its file was shortened.
  [[nodiscard]] std::uint64_t lost() const { return own_lost_; }
  // Packets in the ring that are not released yet.
  [[nodiscard]] std::uint64_t unread() const;
  // Whether a reader exists now. Asks the kernel.
  [[nodiscard]] bool has_reader() const;

  // Renews the ring if its name was removed (remove_ring) or its file was shortened, and returns whether it did. A
  // claimed packet is then gone. Call this from time to time; otherwise the writer would go on with a removed ring that
  // nobody reads. Throws like the constructor.
  bool renew_if_removed();

 private:
  void start();

  std::string name_;
  std::uint32_t slots_;
  ring::Memory memory_;
  std::uint64_t written_ = 0;
  std::uint64_t lost_ = 0;  // Header::lost
  std::uint64_t own_lost_ = 0;
  std::uint64_t read_ = 0;  // last known value; the reader's cache line is read only when the ring seems full
  std::uint32_t generation_ = 0;
};

}  // namespace selfproj::driver

#endif  // SELFPROJ_HOST_DRIVER_RING_WRITER_H
