// LitePCIe's kernel driver and its DMA without a board, behind the seam of the driver.
#ifndef SELFPROJ_TESTS_SUPPORT_LITEPCIE_PLAYER_H
#define SELFPROJ_TESTS_SUPPORT_LITEPCIE_PLAYER_H

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <mutex>
#include <span>
#include <vector>

#include "host/driver/device_port.h"
#include "host/driver/litepcie_interface.h"

namespace selfproj::test {

// What the board's DMA does to the host's memory: it writes into the ring and never waits. For several threads.
class LitePciePlayer {
 public:
  LitePciePlayer(std::size_t buffers, std::size_t bytes) : buffers_(buffers), bytes_(bytes), ring_(buffers * bytes) {}

  // Writes these bytes where the last ones ended. Returns false if the DMA is off; they are then lost.
  bool write(std::span<const std::uint8_t> stream) {
    const std::lock_guard lock(mutex_);
    if (!enabled_) {
      return false;
    }
    while (!stream.empty()) {
      const std::size_t count = std::min(stream.size(), bytes_ - place_);
      std::memcpy(ring_.data() + finished_ % buffers_ * bytes_ + place_, stream.data(), count);
      stream = stream.subspan(count);
      place_ += count;
      if (place_ == bytes_) {
        place_ = 0;
        ++finished_;
      }
    }
    return true;
  }

  // As the FPGA does after a burst: zeros to the end of the buffer, and another buffer of them.
  void fill() {
    std::size_t rest = 0;
    {
      const std::lock_guard lock(mutex_);
      rest = bytes_ - place_ + (place_ == 0 ? 0 : bytes_);
    }
    write(std::vector<std::uint8_t>(rest));
  }

  // The board is reset: the DMA is off, and its counts begin anew.
  void reset() {
    const std::lock_guard lock(mutex_);
    set_enabled(false);
  }

  [[nodiscard]] std::size_t ring_bytes() const { return ring_.size(); }
  [[nodiscard]] std::uint64_t finished() const {
    const std::lock_guard lock(mutex_);
    return finished_;
  }
  [[nodiscard]] bool enabled() const {
    const std::lock_guard lock(mutex_);
    return enabled_;
  }

  // What a test may change
  bool foreign = false;                                  // the file is no device of LitePCIe's driver
  bool taken = false;                                    // another process has the DMA
  int error = 0;                                         // of every request
  bool ones = false;                                     // registers read as ones
  std::function<void()> on_access;                       // before a register is read
  std::function<void(driver::litepcie::Access&)> board;  // an access to the board's registers, its address from 0 on
  std::uint32_t waits = 0;                               // calls of wait()

 private:
  friend class LitePciePlayerPort;

  void set_enabled(bool on) {
    enabled_ = on;
    finished_ = 0;
    place_ = 0;
  }

  // The register that the driver reads: the newest finished buffer and its round.
  std::uint32_t loop_status() const {
    const std::lock_guard lock(mutex_);
    const std::uint64_t newest = finished_ == 0 ? 0 : finished_ - 1;
    return static_cast<std::uint32_t>(newest / buffers_ << 16U | newest % buffers_);
  }

  std::size_t buffers_;
  std::size_t bytes_;
  std::vector<std::uint8_t> ring_;
  mutable std::mutex mutex_;
  bool enabled_ = false;
  std::uint64_t finished_ = 0;  // buffers
  std::size_t place_ = 0;       // in the buffer under way
};

class LitePciePlayerPort final : public driver::DevicePort {
 public:
  explicit LitePciePlayerPort(LitePciePlayer& player) : player_(player) {}
  ~LitePciePlayerPort() override {
    player_.taken = player_.taken && !mine_;  // the kernel's driver gives it back
  }

  int control(unsigned long request, void* argument) override {
    if (player_.foreign) {
      return ENOTTY;
    }
    if (player_.error != 0) {
      return player_.error;
    }
    switch (request) {
      case driver::litepcie::kBuffers:
        *static_cast<driver::litepcie::Buffers*>(argument) = {
            .rx_offset = player_.ring_bytes(), .rx_bytes = player_.bytes_, .rx_count = player_.buffers_};
        return 0;
      case driver::litepcie::kLock:
        return take(*static_cast<driver::litepcie::Lock*>(argument));
      case driver::litepcie::kDmaWriter: {
        const std::lock_guard lock(player_.mutex_);
        player_.set_enabled(static_cast<driver::litepcie::DmaWriter*>(argument)->enable != 0);
        return 0;
      }
      case driver::litepcie::kAccess:
        return access(*static_cast<driver::litepcie::Access*>(argument));
      case driver::litepcie::kRead:
        return 0;
      default:
        return ENOTTY;
    }
  }

  const std::uint8_t* map(std::size_t bytes, std::int64_t offset) override {
    const bool right = bytes == player_.ring_bytes() && static_cast<std::size_t>(offset) == player_.ring_bytes();
    errno = EINVAL;
    return right ? player_.ring_.data() : nullptr;
  }

  // As if a signal came at once.
  bool wait(std::chrono::nanoseconds /*timeout*/) override {
    ++player_.waits;
    return false;
  }

 private:
  int take(driver::litepcie::Lock& lock) {
    lock.writer_status = 1;
    if (lock.writer_request != 0) {
      lock.writer_status = player_.taken ? 0 : 1;
      mine_ = mine_ || !player_.taken;
      player_.taken = true;
    }
    if (lock.writer_release != 0) {
      mine_ = false;
      player_.taken = false;
    }
    return 0;
  }

  int access(driver::litepcie::Access& access) {
    if (player_.on_access) {
      player_.on_access();
    }
    if (access.address >= driver::litepcie::kBoardRegisters && player_.board) {
      driver::litepcie::Access inner = access;
      inner.address -= driver::litepcie::kBoardRegisters;
      player_.board(inner);
      access.value = inner.value;
      return 0;
    }
    if (access.write != 0 || access.address != driver::litepcie::kLoopStatus) {
      return EINVAL;
    }
    access.value = player_.ones ? 0xFFFF'FFFFU : player_.loop_status();
    return 0;
  }

  LitePciePlayer& player_;
  bool mine_ = false;
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_SUPPORT_LITEPCIE_PLAYER_H
