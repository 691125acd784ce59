#include "host/driver/litepcie.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/driver/clock.h"
#include "host/driver/device_kinds.h"
#include "host/driver/device_port.h"
#include "host/driver/litepcie_interface.h"
#include "host/driver/register_port.h"
#include "host/files/file_descriptor.h"
#include "model/spec/generated/register_table.h"
#include "selfproj/driver/counters.h"
#include "selfproj/driver/device.h"
#include "selfproj/driver/packet_reader.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/packet.h"

namespace selfproj::driver {
namespace {

// The driver's interrupt comes after 32 buffers, which is late. So a sleeping reader looks this often by itself.
constexpr std::int64_t kDmaLookNs = 200'000;
// Fewer than a register that reads as ones would mean
constexpr std::uint64_t kMaxDmaBuffers = 1U << 15U;

class LitePcieDevice final : public TalliedDevice {
 public:
  LitePcieDevice(std::unique_ptr<DevicePort> port, std::string uri, const DeviceOptions& options)
      : TalliedDevice(std::move(uri), options),
        port_(std::move(port)),
        reader_(counters_, options.buffer_bytes, spec::kPacketBeatBytes) {
    litepcie::Buffers buffers;
    const int error = port_->control(litepcie::kBuffers, &buffers);
    if (error != 0) {
      fail("is no device of LitePCIe's driver", error);
    }
    bytes_ = static_cast<std::size_t>(buffers.rx_bytes);
    count_ = buffers.rx_count;
    // The reader has room for at least one more of the largest packets.
    if (bytes_ == 0 || bytes_ % spec::kPacketBeatBytes != 0 || bytes_ > model::kLargestPacketBytes || count_ < 4 ||
        count_ > kMaxDmaBuffers) {
      throw UserError(uri_, "its driver has " + std::to_string(count_) + " buffers of " + std::to_string(bytes_) +
                                " bytes, with which this program cannot work");
    }
    ring_ = port_->map(bytes_ * count_, static_cast<std::int64_t>(buffers.rx_offset));
    if (ring_ == nullptr) {
      fail("its buffers cannot be mapped", errno);
    }
    litepcie::Lock lock{.writer_request = 1};
    check(port_->control(litepcie::kLock, &lock), "its DMA cannot be taken");
    if (lock.writer_status == 0) {
      throw UserError(uri_, "already has a reader");
    }
    locked_ = true;
    start();
  }
  LitePcieDevice(const LitePcieDevice&) = delete;
  LitePcieDevice& operator=(const LitePcieDevice&) = delete;
  // A board that has gone cannot be stopped, and the driver frees what is left when the file is closed.
  ~LitePcieDevice() override {
    if (locked_) {
      static_cast<void>(enable(false));
      litepcie::Lock lock{.writer_release = 1};
      static_cast<void>(port_->control(litepcie::kLock, &lock));
    }
  }

  Next next(model::PacketView& packet, std::chrono::nanoseconds timeout) override {
    const std::int64_t started = now_ns();
    for (;;) {
      while (reader_.next(packet)) {
        if (tally_.deliver(packet)) {
          return Next::packet;
        }
      }
      const std::int64_t waited = now_ns() - started;
      if (copy_buffers()) {
        continue;
      }
      if (waited >= timeout.count()) {
        return Next::timeout;
      }
      wait(waited, timeout.count());
    }
  }

 private:
  [[noreturn]] void fail(const std::string& what, int error) const {
    throw UserError(uri_, what + ": " + files::error_text(error));
  }

  void check(int error, const std::string& what) const {
    if (error != 0) {
      fail(error == ENODEV || error == EIO ? "the board has gone" : what, error);
    }
  }

  [[nodiscard]] int enable(bool on) {
    litepcie::DmaWriter writer{.enable = static_cast<std::uint8_t>(on ? 1 : 0)};
    return port_->control(litepcie::kDmaWriter, &writer);
  }

  // The DMA starts at buffer 0, whatever it has done before.
  void start() {
    check(enable(false), "its DMA cannot be stopped");
    check(enable(true), "its DMA cannot be started");
    done_ = 0;
    read_ = 0;
    status_ = 0;
  }

  // Brings done_ up to date. Returns false if the board has begun anew, because of which the DMA was started again.
  bool look() {
    litepcie::Access access{.address = litepcie::kLoopStatus};
    check(port_->control(litepcie::kAccess, &access), "its DMA does not answer");
    const std::uint64_t buffer = access.value & 0xFFFFU;
    if (buffer >= count_) {  // a board that is not there reads as ones
      throw UserError(uri_, "the board has gone: its registers read as ones");
    }
    // The register wraps after 65536 rounds.
    const std::uint64_t period = count_ << 16U;
    const std::uint64_t status = (access.value >> 16U) * count_ + buffer;
    const std::uint64_t more = (status + period - status_) % period;
    if (more > period / 2) {
      ++counters_.reattached;
      reader_.restart();
      tally_.begin_anew();
      start();
      return false;
    }
    status_ = status;
    done_ += more;
    return true;
  }

  // The first buffer that the DMA cannot have begun to write over. Buffer done_ + 1 is under way, in the place of
  // buffer done_ + 1 - count_.
  [[nodiscard]] std::uint64_t oldest() const { return done_ + 2 > count_ ? done_ + 2 - count_ : 0; }

  // Copies finished buffers into the reader. Returns whether there were any, or anything else that changed.
  bool copy_buffers() {
    if (!follow()) {
      return true;
    }
    arrival_ns_ = now_ns();
    if (read_ == done_) {
      return false;
    }
    const std::span<std::uint8_t> room = reader_.room();
    const std::uint64_t buffers = std::min<std::uint64_t>(done_ - read_, room.size() / bytes_);
    for (std::uint64_t i = 0; i < buffers; ++i) {
      std::memcpy(room.data() + i * bytes_, ring_ + (read_ + i) % count_ * bytes_, bytes_);
    }
    if (!follow()) {  // what was copied may be torn
      return true;
    }
    reader_.added(buffers * bytes_);
    read_ += buffers;
    return true;
  }

  // Brings done_ up to date. Returns false if the next buffer to read is lost: the board has begun anew, or the DMA has
  // come round. In the second case half of the ring is given up, so that the reader does not lose the next buffer as
  // well.
  bool follow() {
    if (!look()) {
      return false;
    }
    if (read_ >= oldest()) {
      return true;
    }
    const std::uint64_t to = std::max(oldest(), done_ - std::min(done_, count_ / 2));
    ++counters_.read_errors;
    counters_.bytes_discarded += (to - read_) * bytes_;
    reader_.restart();
    read_ = to;
    return false;
  }

  // Waits according to the policy.
  void wait(std::int64_t waited, std::int64_t timeout) {
    if (options_.polls(waited)) {
      relax();
      return;
    }
    litepcie::Read read{.sw_count = static_cast<std::int64_t>(read_)};
    check(port_->control(litepcie::kRead, &read), "its DMA does not answer");
    static_cast<void>(port_->wait(std::chrono::nanoseconds(std::min(kDmaLookNs, timeout - waited))));
  }

  std::unique_ptr<DevicePort> port_;
  PacketStreamReader reader_;
  const std::uint8_t* ring_ = nullptr;
  std::size_t bytes_ = 0;     // of a buffer
  std::uint64_t count_ = 0;   // buffers of the ring
  std::uint64_t status_ = 0;  // the register of the loop, as a number of buffers
  std::uint64_t done_ = 0;    // buffers before this one are finished
  std::uint64_t read_ = 0;    // buffers before this one were read or given up
  bool locked_ = false;
};

class LitePciePort final : public RegisterPort {
 public:
  LitePciePort(std::unique_ptr<DevicePort> port, std::string uri) : port_(std::move(port)), uri_(std::move(uri)) {}

  std::vector<std::uint32_t> read(std::span<const std::uint32_t> addresses) override {
    std::vector<std::uint32_t> words;
    words.reserve(addresses.size());
    for (const std::uint32_t address : addresses) {
      words.push_back(access({.address = place(address), .value = 0, .write = 0}));
    }
    return words;
  }

  Written write(std::uint32_t address, std::uint32_t value) override {
    access({.address = place(address), .value = value, .write = 1});
    return Written::unknown;
  }

  [[nodiscard]] const std::string& uri() const override { return uri_; }

 private:
  // The driver does not check addresses: those beyond the board's registers would be LitePCIe's own.
  [[nodiscard]] std::uint32_t place(std::uint32_t address) const {
    if (address % 4 != 0 || address > spec::kRegisters.back().address) {
      throw UserError(uri_, "has no register at " + std::to_string(address));
    }
    return litepcie::kBoardRegisters + address;
  }

  std::uint32_t access(litepcie::Access one) {
    const int error = port_->control(litepcie::kAccess, &one);
    if (error != 0) {
      throw UserError(uri_, "the board's registers cannot be reached: " + files::error_text(error));
    }
    return one.value;
  }

  std::unique_ptr<DevicePort> port_;
  std::string uri_;
};

}  // namespace

std::unique_ptr<Device> make_litepcie_device(const std::string& path, const DeviceOptions& options) {
  const std::string uri = "litepcie:" + path;
  return make_litepcie_device(open_device_port(path, uri), uri, options);
}

std::unique_ptr<Device> make_litepcie_device(std::unique_ptr<DevicePort> port, const std::string& uri,
                                             const DeviceOptions& options) {
  return std::make_unique<LitePcieDevice>(std::move(port), uri, options);
}

std::unique_ptr<RegisterPort> make_litepcie_port(const std::string& path) {
  const std::string uri = "litepcie:" + path;
  return make_litepcie_port(open_device_port(path, uri), uri);
}

std::unique_ptr<RegisterPort> make_litepcie_port(std::unique_ptr<DevicePort> port, const std::string& uri) {
  return std::make_unique<LitePciePort>(std::move(port), uri);
}

}  // namespace selfproj::driver
