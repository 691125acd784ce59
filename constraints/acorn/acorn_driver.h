// LitePCIe's kernel driver on a simulated FPGA: it makes the accesses that the driver makes, in its order.
#ifndef SELFPROJ_CONSTRAINTS_ACORN_ACORN_DRIVER_H
#define SELFPROJ_CONSTRAINTS_ACORN_ACORN_DRIVER_H

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <stdexcept>

#include "constraints/acorn/pcie_host.h"
#include "host/driver/device_port.h"
#include "host/driver/litepcie_interface.h"
#include "litepcie.h"  // of LitePCIe's driver, with the places of registers in this core

namespace selfproj::sim {

// What this project says of the driver is what the driver says of itself.
static_assert(driver::litepcie::kAccess == LITEPCIE_IOCTL_REG &&
              driver::litepcie::kDmaWriter == LITEPCIE_IOCTL_DMA_WRITER &&
              driver::litepcie::kBuffers == LITEPCIE_IOCTL_MMAP_DMA_INFO &&
              driver::litepcie::kLock == LITEPCIE_IOCTL_LOCK &&
              driver::litepcie::kRead == LITEPCIE_IOCTL_MMAP_DMA_WRITER_UPDATE);
static_assert(
    offsetof(driver::litepcie::Access, write) == offsetof(litepcie_ioctl_reg, is_write) &&
    offsetof(driver::litepcie::DmaWriter, sw_count) == offsetof(litepcie_ioctl_dma_writer, sw_count) &&
    offsetof(driver::litepcie::Lock, writer_request) == offsetof(litepcie_ioctl_lock, dma_writer_request) &&
    offsetof(driver::litepcie::Lock, writer_release) == offsetof(litepcie_ioctl_lock, dma_writer_release) &&
    offsetof(driver::litepcie::Lock, writer_status) == offsetof(litepcie_ioctl_lock, dma_writer_status) &&
    offsetof(driver::litepcie::Buffers, rx_offset) == offsetof(litepcie_ioctl_mmap_dma_info, dma_rx_buf_offset) &&
    offsetof(driver::litepcie::Buffers, rx_bytes) == offsetof(litepcie_ioctl_mmap_dma_info, dma_rx_buf_size) &&
    offsetof(driver::litepcie::Buffers, rx_count) == offsetof(litepcie_ioctl_mmap_dma_info, dma_rx_buf_count));
static_assert(driver::litepcie::kLoopStatus == CSR_PCIE_DMA0_BASE + PCIE_DMA_WRITER_TABLE_LOOP_STATUS_OFFSET);

// Any number of ports may have the one driver.
class AcornDriver {
 public:
  static constexpr std::uint32_t kBuffers = DMA_BUFFER_COUNT;
  static constexpr std::uint32_t kBytes = DMA_BUFFER_SIZE;

  // `step` runs the simulation by a clock of PCI Express.
  AcornDriver(PcieHost& host, std::function<void()> step) : host_(host), step_(std::move(step)) {}

  std::uint32_t read(std::uint32_t address) {
    host_.read(address);
    for (int clocks = 0; clocks < 100'000; ++clocks) {
      step_();
      if (const std::optional<std::uint32_t> answer = host_.pop_answer()) {
        return *answer;
      }
    }
    throw std::runtime_error("a read of BAR 0 is not answered");
  }

  void write(std::uint32_t address, std::uint32_t value) {
    host_.write(address, value);
    while (host_.busy()) {
      step_();
    }
  }

  void enable(bool on) {
    if (on == enabled_) {
      return;
    }
    enabled_ = on;
    if (on) {
      write(CSR_PCIE_DMA0_WRITER_ENABLE_ADDR, 0);
      write(CSR_PCIE_DMA0_WRITER_TABLE_RESET_ADDR, 1);
      write(CSR_PCIE_DMA0_WRITER_TABLE_LOOP_PROG_N_ADDR, 0);
      for (std::uint32_t i = 0; i < kBuffers; ++i) {
        write(CSR_PCIE_DMA0_WRITER_TABLE_VALUE_ADDR,
              DMA_LAST_DISABLE | (i % DMA_BUFFER_PER_IRQ == 0 ? 0U : DMA_IRQ_DISABLE) | kBytes);
        write(CSR_PCIE_DMA0_WRITER_TABLE_VALUE_ADDR + 4, PcieHost::kMemory + i * kBytes);
        write(CSR_PCIE_DMA0_WRITER_TABLE_WE_ADDR, 0);
      }
      write(CSR_PCIE_DMA0_WRITER_TABLE_LOOP_PROG_N_ADDR, 1);
      write(CSR_PCIE_DMA0_WRITER_ENABLE_ADDR, 1);
      write(CSR_PCIE_MSI_ENABLE_ADDR, read(CSR_PCIE_MSI_ENABLE_ADDR) | 1U << PCIE_DMA0_WRITER_INTERRUPT);
    } else {
      write(CSR_PCIE_MSI_ENABLE_ADDR, read(CSR_PCIE_MSI_ENABLE_ADDR) & ~(1U << PCIE_DMA0_WRITER_INTERRUPT));
      write(CSR_PCIE_DMA0_WRITER_TABLE_LOOP_PROG_N_ADDR, 0);
      write(CSR_PCIE_DMA0_WRITER_TABLE_RESET_ADDR, 1);
      wait(100'000);  // the driver waits for 1 ms
      write(CSR_PCIE_DMA0_WRITER_ENABLE_ADDR, 0);
      write(CSR_PCIE_DMA0_WRITER_TABLE_RESET_ADDR, 1);
    }
  }

  void wait(int clocks) {
    for (int i = 0; i < clocks; ++i) {
      step_();
    }
  }

  // What the driver does in an interrupt. Returns how many there were.
  std::uint64_t serve_interrupts() {
    while (served_ < host_.interrupts()) {
      ++served_;
      const std::uint32_t vector = read(CSR_PCIE_MSI_VECTOR_ADDR) & read(CSR_PCIE_MSI_ENABLE_ADDR);
      write(CSR_PCIE_MSI_CLEAR_ADDR, vector);
    }
    return served_;
  }

  [[nodiscard]] PcieHost& host() { return host_; }

 private:
  PcieHost& host_;
  std::function<void()> step_;
  bool enabled_ = false;
  std::uint64_t served_ = 0;
};

class AcornPort final : public driver::DevicePort {
 public:
  explicit AcornPort(AcornDriver& driver) : driver_(driver) {}

  int control(unsigned long request, void* argument) override {
    driver_.serve_interrupts();
    switch (request) {
      case driver::litepcie::kBuffers:
        *static_cast<driver::litepcie::Buffers*>(argument) = {.rx_offset = AcornDriver::kBuffers * AcornDriver::kBytes,
                                                              .rx_bytes = AcornDriver::kBytes,
                                                              .rx_count = AcornDriver::kBuffers};
        return 0;
      case driver::litepcie::kLock:
        static_cast<driver::litepcie::Lock*>(argument)->writer_status = 1;
        return 0;
      case driver::litepcie::kDmaWriter:
        driver_.enable(static_cast<driver::litepcie::DmaWriter*>(argument)->enable != 0);
        return 0;
      case driver::litepcie::kAccess: {
        auto& access = *static_cast<driver::litepcie::Access*>(argument);
        if (access.write != 0) {
          driver_.write(access.address, access.value);
        } else {
          access.value = driver_.read(access.address);
        }
        return 0;
      }
      case driver::litepcie::kRead:
        return 0;
      default:
        return ENOTTY;
    }
  }

  const std::uint8_t* map(std::size_t bytes, std::int64_t /*offset*/) override {
    errno = EINVAL;
    return bytes == driver_.host().memory().size() ? driver_.host().memory().data() : nullptr;
  }

  bool wait(std::chrono::nanoseconds timeout) override {
    constexpr std::int64_t kPeriodNs = 8;
    driver_.wait(static_cast<int>(std::clamp<std::int64_t>(timeout.count() / kPeriodNs, 1, 10'000)));
    return false;
  }

 private:
  AcornDriver& driver_;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_CONSTRAINTS_ACORN_ACORN_DRIVER_H
