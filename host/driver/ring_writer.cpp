#include "host/driver/ring_writer.h"

#include <linux/futex.h>
#include <sys/statvfs.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>

#include "host/driver/clock.h"
#include "host/driver/ring_memory.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/packet.h"

namespace selfproj::driver {

RingWriter::RingWriter(const std::string& name, std::uint32_t slots) : name_(name), slots_(slots) {
  if (!std::has_single_bit(slots) || slots > ring::kMaxSlots) {
    throw UserError("ring:" + name,
                    std::to_string(slots) + " slots are not possible; a power of two up to 65536 is needed");
  }
  start();
}

std::uint32_t RingWriter::deep_slots(const std::string& name) {
  if (ring::Memory there;
      there.attach(ring::shared_name(name).c_str()) == ring::Memory::Found::ring && there.slots() >= kDefaultSlots) {
    return there.slots();
  }
  std::uint32_t slots = kDeepSlots;
  struct statvfs room {};
  if (statvfs("/dev/shm", &room) == 0) {
    const std::uint64_t free = std::uint64_t{room.f_bavail} * room.f_frsize;
    while (slots > kDefaultSlots && 2 * ring::ring_bytes(slots) > free) {
      slots /= 2;
    }
  }
  return slots;
}

void RingWriter::start() {
  memory_.create(name_, slots_);
  ring::Header& header = memory_.header();
  if (header.writer_open.exchange(1) != 0) {
    header.writer_crashes.fetch_add(1);
  }
  written_ = header.written.load();
  lost_ = header.lost.load();
  read_ = header.read.load();
  generation_ = header.generation.fetch_add(1) + 1;
  header.writer_pid.store(static_cast<std::uint32_t>(getpid()));
}

bool RingWriter::renew_if_removed() {
  const bool removed = memory_.removed();
  const bool shortened = memory_.shortened();
  if (!removed && !shortened) {
    return false;
  }
  // Packets that nobody can read any more are lost: all packets of a ring that was shortened (if its counts are gone,
  // at most this many), or that has no reader.
  const bool unseen = shortened || !memory_.locked(ring::kReaderLock);
  const std::uint64_t read = std::max(read_, std::min(memory_.header().read.load(), written_));
  const std::uint64_t unread = unseen ? std::min<std::uint64_t>(written_ - read, memory_.slots()) : 0;
  if (!removed) {
    remove_ring(name_);
  }
  start();
  lost_ += unread;
  own_lost_ += unread;
  memory_.header().lost.store(lost_, std::memory_order_release);
  return true;
}

RingWriter::~RingWriter() {
  if (memory_.attached()) {
    memory_.header().writer_open.store(0);
  }
}

std::span<std::uint8_t> RingWriter::claim() {
  ring::Header& header = memory_.header();
  if (written_ - read_ >= memory_.slots()) {
    read_ = header.read.load(std::memory_order_acquire);
    if (written_ - read_ >= memory_.slots()) {
      header.lost.store(++lost_, std::memory_order_release);
      ++own_lost_;
      return {};
    }
  }
  return {memory_.packet(written_), model::kLargestPacketBytes};
}

void RingWriter::publish(std::size_t bytes) {
  ring::Header& header = memory_.header();
  ring::Slot& slot = memory_.slot(written_);
  slot.number = written_;
  slot.lost = lost_;
  slot.arrival_ns = now_ns();
  slot.bytes = static_cast<std::uint32_t>(bytes);
  slot.generation = generation_;
  header.written.store(++written_, std::memory_order_release);
  // Either the reader sees the count just written before it sleeps, or this thread sees its `sleeping`.
  std::atomic_thread_fence(std::memory_order_seq_cst);
  if (header.sleeping.load(std::memory_order_relaxed) != 0) {
    header.wake.fetch_add(1, std::memory_order_release);
    syscall(SYS_futex, &header.wake, FUTEX_WAKE, 1, nullptr, nullptr, 0);
  }
}

bool RingWriter::write(std::span<const std::uint8_t> packet) {
  if (packet.size() > model::kLargestPacketBytes) {
    throw std::invalid_argument("ring: the packet is larger than a slot");
  }
  const std::span<std::uint8_t> place = claim();
  if (place.empty()) {
    return false;
  }
  std::copy(packet.begin(), packet.end(), place.begin());
  publish(packet.size());
  return true;
}

std::uint64_t RingWriter::unread() const { return written_ - memory_.header().read.load(std::memory_order_acquire); }

bool RingWriter::has_reader() const { return memory_.locked(ring::kReaderLock); }

}  // namespace selfproj::driver
