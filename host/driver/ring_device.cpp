#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <utility>

#include "host/driver/clock.h"
#include "host/driver/device_kinds.h"
#include "host/driver/ring_memory.h"
#include "host/files/file_descriptor.h"
#include "selfproj/driver/counters.h"
#include "selfproj/driver/device.h"
#include "selfproj/driver/packet_reader.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/packet.h"

namespace selfproj::driver {
namespace {

using Found = ring::Memory::Found;

// More packets than a ring can lose.
constexpr std::uint64_t kMaxLost = std::uint64_t{1} << 48U;

// How often a reader without packets checks that ring and board still exist.
constexpr std::int64_t kLookNs = 50'000'000;

// How long a board may take to notice that its ring was removed.
constexpr std::int64_t kRenewalNs = 3'000'000'000;

class RingDevice final : public TalliedDevice {
 public:
  RingDevice(const std::string& name, const DeviceOptions& options)
      : TalliedDevice("ring:" + name, options), shared_(ring::shared_name(name)) {
    const Found found = memory_.attach(shared_.c_str());
    switch (found) {
      case Found::ring:
        break;
      case Found::being_made:
        return;  // next() waits for the ring
      case Found::none:
      case Found::unready:
        if (!options.wait_for_board) {
          throw UserError(uri_, "there is no such ring; a board or `selfproj-sim board` makes it");
        }
        return;
      case Found::other:
        throw UserError(uri_, "is a ring of another version or specification");
      case Found::no_access:
        no_access(errno);
    }
    if (!memory_.lock(ring::kReaderLock)) {
      throw UserError(uri_, "another reader has it open");
    }
    start_reading(options_.discard_backlog);
  }
  RingDevice(const RingDevice&) = delete;
  RingDevice& operator=(const RingDevice&) = delete;
  ~RingDevice() override {
    if (memory_.attached()) {
      release();
      leave();
    }
  }

  Next next(model::PacketView& packet, std::chrono::nanoseconds timeout) override {
    release();
    if (next_in_ring(packet)) {
      return Next::packet;
    }
    const std::int64_t started = now_ns();
    for (;;) {
      const std::int64_t now = now_ns();
      if (now >= next_look_) {
        next_look_ = now + kLookNs;
        const bool gone = !look();
        if (next_in_ring(packet)) {  // written before the board went
          return Next::packet;
        }
        if (gone && !options_.wait_for_board) {
          counters_.read_errors += std::exchange(patient_until_, 0) != 0 ? 1 : 0;  // it was not renewed in time
          return Next::end;
        }
      }
      const std::int64_t waited = now - started;
      if (waited >= timeout.count()) {
        return Next::timeout;
      }
      if (options_.polls(waited)) {
        relax();
      } else {
        sleep(std::min(timeout.count() - waited, next_look_ - now));
      }
      if (next_in_ring(packet)) {
        return Next::packet;
      }
    }
  }

  void release() override {
    if (held_) {
      held_ = false;
      step();
    }
  }

  [[nodiscard]] Counters counters() const override {
    Counters counters = counters_;
    if (memory_.attached()) {
      const std::uint64_t lost = memory_.header().lost.load(std::memory_order_acquire);
      if (lost - lost_before_ <= kMaxLost) {
        counters.lost_ring += lost - lost_before_;
        lost_reported_ = lost;
      } else {
        ++counters.bad;  // an impossible count
      }
    }
    return counters;
  }

 private:
  [[noreturn]] void no_access(int error) const {
    throw UserError(uri_,
                    files::error_text(error) +
                        (error == EACCES ? "; a reader needs the right to write, too, as it writes its counts into "
                                           "the ring: with umask 007 the board gives it to its group"
                                         : ""));
  }

  // The ring is mapped, and its lock is taken.
  void start_reading(bool discard) {
    ring::Header& header = memory_.header();
    if (header.reader_open.exchange(1) != 0) {
      header.reader_crashes.fetch_add(1);
    }
    header.readers.fetch_add(1);
    header.reader_pid.store(static_cast<std::uint32_t>(getpid()));
    header.sleeping.store(0);
    const std::uint64_t written = header.written.load(std::memory_order_acquire);
    read_ = header.read.load();
    if (written - read_ > memory_.slots()) {  // impossible counts: the number of packets between them is not known
      ++counters_.bad;
      skipping_ = true;
    }
    if (discard || written - read_ > memory_.slots()) {
      read_ = written;
      header.read.store(read_, std::memory_order_release);
    }
    generation_ = read_ != written ? memory_.slot(read_).generation : header.generation.load();
    lost_before_ = discard ? header.lost.load(std::memory_order_acquire) : header.lost_reported.load();
    lost_reported_ = lost_before_;
    next_look_ = 0;
    counters_.reattached += was_attached_ ? 1 : 0;
    was_attached_ = true;
  }

  void stop_reading() {
    if (memory_.attached()) {
      counters_ = counters();
      release();
      leave();
    }
  }

  // The next reader counts losses that this one has not reported.
  void leave() {
    memory_.header().lost_reported.store(lost_reported_);
    memory_.header().reader_open.store(0);
    memory_.detach();
  }

  // Releases the slot at read_.
  void step() { memory_.header().read.store(++read_, std::memory_order_release); }

  // Returns the next good packet in the ring.
  bool next_in_ring(model::PacketView& packet) {
    if (!memory_.attached()) {
      return false;
    }
    for (;;) {
      const std::uint64_t written = memory_.header().written.load(std::memory_order_acquire);
      if (written == read_) {
        return false;
      }
      if (written - read_ > memory_.slots()) {  // an impossible count: start again at the writer's position
        ++counters_.bad;
        skipping_ = true;
        read_ = written - 1;
        step();
        continue;
      }
      if (look_at_slot(packet)) {
        held_ = true;
        return true;
      }
      step();
    }
  }

  // Whether the slot at read_ has a good packet that must be given out.
  bool look_at_slot(model::PacketView& packet) {
    const ring::Slot& slot = memory_.slot(read_);
    const std::span<const std::uint8_t> bytes(memory_.packet(read_),
                                              std::min<std::size_t>(slot.bytes, model::kLargestPacketBytes));
    const model::PacketError error = model::parse_packet(bytes, packet);
    if (error != model::PacketError::none || packet.size != slot.bytes || slot.number != read_) {
      ++counters_.bad;
      counters_.other_spec += error == model::PacketError::hash || error == model::PacketError::version ? 1 : 0;
      counters_.bytes_discarded += bytes.size();
      skipping_ = true;
      return false;
    }
    counters_.resynchronized += skipping_ ? 1 : 0;
    skipping_ = false;
    if (slot.generation != generation_) {
      generation_ = slot.generation;
      ++counters_.reattached;
      tally_.begin_anew();
    }
    if (!tally_.deliver(packet)) {
      return false;
    }
    arrival_ns_ = slot.arrival_ns;
    return true;
  }

  // Checks a ring without packets: is there a board that may write into it? Attaches to a ring of this name if none is
  // attached.
  bool look() {
    if (memory_.attached()) {
      if (memory_.shortened()) {
        ++counters_.bad;
        stop_reading();
      } else if (memory_.locked(ring::kWriterLock)) {
        return true;  // even if the name was removed: nothing is lost before the writer leaves
      } else if (!memory_.removed() || memory_.header().written.load(std::memory_order_acquire) != read_) {
        return now_ns() < patient_until_;
      } else {
        // A writer that is still running renews the ring as soon as it notices that the name is gone.
        patient_until_ = memory_.header().writer_open.load() != 0 ? now_ns() + kRenewalNs : 0;
        stop_reading();
      }
    }
    if (!memory_.attached()) {
      const Found found = memory_.attach(shared_.c_str());
      if (found == Found::being_made) {
        return true;  // the board exists and is allocating the ring
      }
      if (found != Found::ring || !memory_.lock(ring::kReaderLock)) {
        memory_.detach();
        return now_ns() < patient_until_;
      }
      start_reading(false);  // what came since the device was opened is no backlog
    }
    if (memory_.locked(ring::kWriterLock)) {
      patient_until_ = 0;
      return true;
    }
    return now_ns() < patient_until_;
  }

  // Sleeps until the writer wakes it, at most for this time.
  void sleep(std::int64_t ns) {
    if (!memory_.attached()) {
      std::this_thread::sleep_for(std::chrono::nanoseconds(ns));
      return;
    }
    ring::Header& header = memory_.header();
    const std::uint32_t wake = header.wake.load(std::memory_order_acquire);
    header.sleeping.store(1, std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_seq_cst);  // see RingWriter::publish
    if (header.written.load(std::memory_order_acquire) == read_) {
      const timespec limit = files::timespec_of(ns);
      syscall(SYS_futex, &header.wake, FUTEX_WAIT, wake, &limit, nullptr, 0);
    }
    header.sleeping.store(0, std::memory_order_relaxed);
  }

  std::string shared_;
  ring::Memory memory_;
  std::uint64_t read_ = 0;
  std::uint64_t lost_before_ = 0;            // the part of Header::lost that earlier readers have reported
  mutable std::uint64_t lost_reported_ = 0;  // and the part that this one has
  std::uint32_t generation_ = 0;
  bool held_ = false;
  bool skipping_ = false;
  bool was_attached_ = false;
  std::int64_t next_look_ = 0;
  std::int64_t patient_until_ = 0;  // before this time a missing ring does not count as the end
};

}  // namespace

std::unique_ptr<Device> make_ring_device(const std::string& name, const DeviceOptions& options) {
  return std::make_unique<RingDevice>(name, options);
}

}  // namespace selfproj::driver
