// The board's side of a ring.
#ifndef SELFPROJ_HOST_DRIVER_RING_WRITER_H
#define SELFPROJ_HOST_DRIVER_RING_WRITER_H

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "host/driver/ring_memory.h"

namespace selfproj {

// Puts packets into the ring `name`, which it makes where there is none, and otherwise continues: a board that was
// restarted. It never waits, and where the ring is full the packet is lost and counted in the ring.
class RingWriter {
 public:
  static constexpr std::uint32_t kDefaultSlots = 2048;  // 0.2 s at 10,000 packets a second; 34 MB
  static constexpr std::uint32_t kDeepSlots = 16384;    // 1.6 s; 272 MB

  // As many as the ring of this name has, if there is one of kDefaultSlots or more. Else kDeepSlots, so that a reader
  // that is not scheduled for a second loses nothing; half of that, and so on down to kDefaultSlots, where such a ring
  // would take more than half of what is free in /dev/shm. Throws UserError where the name is none.
  static std::uint32_t deep_slots(const std::string& name);

  // `slots`: a power of two up to 65536. A ring with another number is replaced. Throws UserError where another writer
  // has the ring, there is no room, or the name or the number is none.
  explicit RingWriter(const std::string& name, std::uint32_t slots = kDefaultSlots);
  RingWriter(const RingWriter&) = delete;
  RingWriter& operator=(const RingWriter&) = delete;

  // The ring stays, for its reader and the next writer; remove_ring takes it away.
  ~RingWriter();

  // A copy of the packet goes into the ring; its bytes are not judged. False where it was lost.
  // Throws std::invalid_argument where it is larger than kLargestPacketBytes.
  bool write(std::span<const std::uint8_t> packet);

  // Without a copy: kLargestPacketBytes to be filled, or nothing where the ring is full, which is then counted as a
  // loss.
  [[nodiscard]] std::span<std::uint8_t> claim();
  // The first `bytes` of what was claimed last are a packet.
  void publish(std::size_t bytes);

  // Packets that were lost since this writer began: that found the ring full, or whose ring was made shorter.
  [[nodiscard]] std::uint64_t lost() const { return own_lost_; }
  // Packets in the ring that were not released yet.
  [[nodiscard]] std::uint64_t unread() const;
  // Whether there is a reader now. Asks the kernel.
  [[nodiscard]] bool has_reader() const;

  // Makes the ring again where its name was removed (remove_ring) or its file made shorter, and says whether it did; a
  // packet that was claimed is gone. To be called now and then: otherwise a removed ring is written for nobody. Throws
  // as the constructor.
  bool renew_if_removed();

 private:
  void start();

  std::string name_;
  std::uint32_t slots_;
  ring::Memory memory_;
  std::uint64_t written_ = 0;
  std::uint64_t lost_ = 0;  // Header::lost
  std::uint64_t own_lost_ = 0;
  std::uint64_t read_ = 0;  // as last seen: the reader's line is looked at only where the ring seems full
  std::uint32_t generation_ = 0;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_RING_WRITER_H
