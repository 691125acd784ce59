// LitePCIe as a program sees it: the requests of its kernel driver, and the places of registers in its core.
//
// These are facts of the package litepcie 2024.12 on PyPI (its folder litepcie/software/kernel), and of the core that
// constraints/acorn/litepcie.yml describes. litepcie_core.py there compares the places with what LitePCIe's generator
// writes.
#ifndef SELFPROJ_HOST_DRIVER_LITEPCIE_INTERFACE_H
#define SELFPROJ_HOST_DRIVER_LITEPCIE_INTERFACE_H

#include <linux/ioctl.h>

#include <cstddef>
#include <cstdint>

namespace selfproj::driver::litepcie {

// One access of 32 bits to BAR 0.
struct Access {
  std::uint32_t address = 0;
  std::uint32_t value = 0;
  std::uint8_t write = 0;
};

// Starts or stops the DMA that writes into the host's memory. The counts are those of the last interrupt.
struct DmaWriter {
  std::uint8_t enable = 0;
  std::int64_t hw_count = 0;
  std::int64_t sw_count = 0;
};

// Takes the DMA for one process, or gives it back. The driver gives it back whenever the file is closed.
struct Lock {
  std::uint8_t reader_request = 0;
  std::uint8_t writer_request = 0;
  std::uint8_t reader_release = 0;
  std::uint8_t writer_release = 0;
  std::uint8_t reader_status = 0;
  std::uint8_t writer_status = 0;  // 0: another process has it
};

// Where mmap(2) finds the buffers. LitePCIe names them from the FPGA's side: the board writes into those called rx.
struct Buffers {
  std::uint64_t tx_offset = 0;
  std::uint64_t tx_bytes = 0;
  std::uint64_t tx_count = 0;
  std::uint64_t rx_offset = 0;
  std::uint64_t rx_bytes = 0;  // of one buffer
  std::uint64_t rx_count = 0;
};

// How many buffers the program has read, for poll(2).
struct Read {
  std::int64_t sw_count = 0;
};

static_assert(sizeof(Access) == 12 && sizeof(DmaWriter) == 24 && sizeof(Lock) == 6 && sizeof(Buffers) == 48 &&
              sizeof(Read) == 8);

inline constexpr unsigned long kAccess = _IOWR('S', 0, Access);
inline constexpr unsigned long kDmaWriter = _IOWR('S', 21, DmaWriter);
inline constexpr unsigned long kBuffers = _IOR('S', 24, Buffers);
inline constexpr unsigned long kLock = _IOWR('S', 25, Lock);
inline constexpr unsigned long kRead = _IOW('S', 26, Read);

// BAR 0: where the board's registers begin (mmap_base), and the register that says how far the DMA is: in its upper 16
// bits how often it has come round all buffers, in its lower 16 bits the number of the newest buffer that it has
// finished. Before the first buffer is finished, and after it, the register is 0.
inline constexpr std::uint32_t kBoardRegisters = 0x10000;
inline constexpr std::uint32_t kLoopStatus = 0x4014;

}  // namespace selfproj::driver::litepcie

#endif  // SELFPROJ_HOST_DRIVER_LITEPCIE_INTERFACE_H
