// The host's side of PCI Express in simulation: accesses to BAR 0, and memory that the FPGA writes. Packets of the
// transaction layer as the vendor's block of 7-series FPGAs has them, 128 bits a clock.
#ifndef SELFPROJ_CONSTRAINTS_ACORN_PCIE_HOST_H
#define SELFPROJ_CONSTRAINTS_ACORN_PCIE_HOST_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <random>
#include <span>
#include <vector>

namespace selfproj::sim {

class PcieHost {
 public:
  using Beat = std::array<std::uint32_t, 4>;

  // `bytes` of memory at address kMemory. In `ready` of 100 clocks the host takes what the FPGA sends.
  PcieHost(std::size_t bytes, int ready, std::uint64_t seed) : memory_(bytes), ready_(ready / 100.0), random_(seed) {}

  static constexpr std::uint32_t kMemory = 0x8000'0000;

  // Queues an access to BAR 0. A read is answered when pop_answer() returns a value.
  void write(std::uint32_t address, std::uint32_t value);
  void read(std::uint32_t address);
  // Whether the FPGA has not taken all accesses yet.
  [[nodiscard]] bool busy() const { return !accesses_.empty(); }
  std::optional<std::uint32_t> pop_answer();

  // What the FPGA does with the host
  [[nodiscard]] std::span<const std::uint8_t> memory() const { return memory_; }
  [[nodiscard]] std::uint64_t interrupts() const { return interrupts_; }
  [[nodiscard]] std::uint64_t writes() const { return writes_; }        // packets that write memory
  [[nodiscard]] std::uint64_t strangers() const { return strangers_; }  // packets that cannot be right

  // One clock of the block: what it took from the FPGA and gave to it, and what it does next.
  struct From {
    bool taken = false;
    bool last = false;
    std::uint16_t keep = 0;
    Beat beat{};
    bool given = false;
    bool interrupt = false;
  };
  struct To {
    bool ready = false;
    bool valid = false;
    bool read = false;
    Beat beat{};
  };
  To clock(const From& from);

 private:
  struct Access {
    bool read = false;
    std::uint32_t address = 0;
    std::uint32_t value = 0;
  };

  void receive(const std::vector<std::uint32_t>& words);
  void store(const std::vector<std::uint32_t>& words);

  std::vector<std::uint8_t> memory_;
  std::bernoulli_distribution ready_;
  std::mt19937_64 random_;
  std::deque<Access> accesses_;
  std::vector<std::uint32_t> words_;  // of the packet that comes from the FPGA
  std::optional<std::uint32_t> answer_;
  std::uint64_t interrupts_ = 0;
  std::uint64_t writes_ = 0;
  std::uint64_t strangers_ = 0;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_CONSTRAINTS_ACORN_PCIE_HOST_H
