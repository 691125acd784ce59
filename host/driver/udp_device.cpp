#include <sys/socket.h>
#include <sys/types.h>
#include <sys/uio.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "host/driver/clock.h"
#include "host/driver/datagram_assembler.h"
#include "host/driver/device_kinds.h"
#include "host/driver/udp_socket.h"
#include "host/files/file_descriptor.h"
#include "model/datagram.h"
#include "selfproj/driver/counters.h"
#include "selfproj/driver/device.h"
#include "selfproj/driver/packet_reader.h"
#include "selfproj/files/user_error.h"

namespace selfproj::driver {
namespace {

constexpr std::size_t kBatch = 64;     // datagrams of one system call
constexpr std::size_t kRoom = 9216;    // bytes for each, more than a jumbo frame has
constexpr int kSocketBytes = 1 << 25;  // the kernel's buffer: 0.4 s of Gigabit Ethernet
constexpr std::int64_t kSilenceNs = 20'000'000;
constexpr std::chrono::milliseconds kErrorPause(1);

// The batches of a socket.
class DatagramBatch {
 public:
  DatagramBatch() : bytes_(kBatch * kRoom) {
    for (std::size_t i = 0; i < kBatch; ++i) {
      pieces_[i] = {bytes_.data() + i * kRoom, kRoom};
      messages_[i].msg_hdr.msg_iov = &pieces_[i];
      messages_[i].msg_hdr.msg_iovlen = 1;
    }
  }

  // Returns the number of datagrams that have come, or -1 with errno.
  int receive(int socket) {
    for (std::size_t i = 0; i < kBatch; ++i) {
      messages_[i].msg_hdr.msg_control = controls_[i].data();
      messages_[i].msg_hdr.msg_controllen = controls_[i].size();
    }
    return recvmmsg(socket, messages_.data(), kBatch, MSG_DONTWAIT, nullptr);
  }

  [[nodiscard]] std::span<const std::uint8_t> datagram(std::size_t i) const {
    return {bytes_.data() + i * kRoom, std::min<std::size_t>(messages_[i].msg_len, kRoom)};
  }

  // The kernel's count of datagrams without room, if datagram i reports it. It wraps.
  bool overflow(std::size_t i, std::uint32_t& count) {
    msghdr& header = messages_[i].msg_hdr;
    for (cmsghdr* part = CMSG_FIRSTHDR(&header); part != nullptr; part = CMSG_NXTHDR(&header, part)) {
      if (part->cmsg_level == SOL_SOCKET && part->cmsg_type == SO_RXQ_OVFL) {
        std::memcpy(&count, CMSG_DATA(part), sizeof count);
        return true;
      }
    }
    return false;
  }

 private:
  std::vector<std::uint8_t> bytes_;
  std::array<iovec, kBatch> pieces_{};
  std::array<mmsghdr, kBatch> messages_{};
  struct alignas(cmsghdr) Control : std::array<std::uint8_t, CMSG_SPACE(sizeof(std::uint32_t))> {};
  std::array<Control, kBatch> controls_{};
};

class UdpDevice final : public TalliedDevice {
 public:
  UdpDevice(const std::string& place, const DeviceOptions& options)
      : TalliedDevice("udp:" + place, options),
        socket_(open_udp_socket(uri_, udp_place(uri_, place, model::kDatagramPort), true)),
        assembler_(counters_) {
    // As much as the system allows: without the right to more, net.core.rmem_max is the limit.
    const int bytes = kSocketBytes;
    if (setsockopt(socket_.number(), SOL_SOCKET, SO_RCVBUFFORCE, &bytes, sizeof bytes) != 0) {
      static_cast<void>(setsockopt(socket_.number(), SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes));
    }
    const int on = 1;
    if (setsockopt(socket_.number(), SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on) != 0) {
      throw UserError(uri_, files::error_text(errno));
    }
    arrival_ns_ = now_ns();
  }

  Next next(model::PacketView& packet, std::chrono::nanoseconds timeout) override {
    const std::int64_t started = now_ns();
    for (;;) {
      while (take(packet)) {
        if (tally_.deliver(packet)) {
          return Next::packet;
        }
      }
      // The time before the look: what came while this process had to wait for its turn is no silence.
      const std::int64_t now = now_ns();
      if (receive()) {
        continue;
      }
      if (!quiet_ && now - arrival_ns_ >= kSilenceNs) {
        assembler_.flush();
        quiet_ = true;
        continue;
      }
      if (now - started >= timeout.count()) {
        return Next::timeout;
      }
      wait(now - started, timeout.count());
    }
  }

 private:
  // The next packet of the datagrams received.
  bool take(model::PacketView& packet) {
    for (;;) {
      if (assembler_.next(packet)) {
        return true;
      }
      if (used_ == held_) {
        return false;
      }
      used_ += assembler_.add(batch_.datagram(used_)) ? 1 : 0;
    }
  }

  // Receives what is there. Returns false if that is nothing.
  bool receive() {
    const int count = batch_.receive(socket_.number());
    if (count > 0) {
      arrival_ns_ = now_ns();
      quiet_ = false;
      used_ = 0;
      held_ = static_cast<std::size_t>(count);
      note_overflow();
      return true;
    }
    if (count < 0 && errno != EAGAIN && errno != EINTR && errno != ECONNREFUSED) {
      ++counters_.read_errors;
      std::this_thread::sleep_for(kErrorPause);
    }
    return false;
  }

  // Waits for datagrams according to the policy, no longer than until the silence counts.
  void wait(std::int64_t waited, std::int64_t timeout) {
    if (options_.polls(waited)) {
      relax();
      return;
    }
    std::int64_t rest = std::max<std::int64_t>(timeout - waited, 0);
    if (!quiet_) {
      rest = std::min(rest, kSilenceNs);
    }
    static_cast<void>(files::wait_readable(socket_.number(), rest));
  }

  void note_overflow() {
    for (std::size_t i = 0; i < held_; ++i) {
      std::uint32_t count = 0;
      if (batch_.overflow(i, count)) {
        counters_.datagrams_overflow += static_cast<std::uint32_t>(count - overflow_);
        overflow_ = count;
      }
    }
  }

  files::FileDescriptor socket_;
  DatagramBatch batch_;
  DatagramAssembler assembler_;
  std::size_t used_ = 0;  // datagrams of the batch that were added
  std::size_t held_ = 0;  // datagrams in the batch
  std::uint32_t overflow_ = 0;
  bool quiet_ = true;  // what was incomplete is given up
};

}  // namespace

std::unique_ptr<Device> make_udp_device(const std::string& place, const DeviceOptions& options) {
  return std::make_unique<UdpDevice>(place, options);
}

}  // namespace selfproj::driver
