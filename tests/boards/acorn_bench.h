// What is in the FPGA of an Acorn beside LitePCIe, Verilated, with a stand-in for LitePCIe at its ports: the host's
// program has its registers and its DMA through the seam of the driver.
#ifndef SELFPROJ_TESTS_BOARDS_ACORN_BENCH_H
#define SELFPROJ_TESTS_BOARDS_ACORN_BENCH_H

#include <verilated.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <stdexcept>

#include "Vacorn_system.h"
#include "host/driver/litepcie_interface.h"
#include "tests/support/litepcie_player.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

class AcornBench {
 public:
  // The parameters of the model (constraints/CMakeLists.txt)
  static constexpr int kColumns = 64;
  static constexpr int kRows = 16;
  static constexpr std::uint64_t kFrameClocks = 400;

  explicit AcornBench(std::uint64_t seed) : random_(seed), dut_(&context_), player_(256, 8192) {
    player_.board = [this](litepcie::Access& access) { reach(access); };
    dut_.rst_i = 1;
    dut_.bus_rst_i = 1;
    dut_.s_axil_bready = 1;
    dut_.s_axil_rready = 1;
    dut_.s_axil_wstrb = 0xF;
    run(16);
    dut_.rst_i = 0;
    dut_.bus_rst_i = 0;
  }
  AcornBench(const AcornBench&) = delete;
  AcornBench& operator=(const AcornBench&) = delete;
  ~AcornBench() { dut_.final(); }

  LitePciePlayer& player() { return player_; }

  // In how many of 100 clocks LitePCIe takes a beat
  void set_ready(int percent) { ready_percent_ = percent; }

  // Runs so many clocks of the bus.
  void run(std::uint64_t clocks) {
    for (const std::uint64_t end = clocks_ + clocks; clocks_ < end;) {
      step();
    }
  }

 private:
  // The next rising edge: the bus's period is 8.000 ns, the camera's 7.9.
  void step() {
    const bool pixel = next_pixel_ <= next_bus_;
    if (pixel) {
      next_pixel_ += kPixelPs;
      dut_.clk_i = 0;
      dut_.eval();
      dut_.clk_i = 1;
      dut_.eval();
      return;
    }
    next_bus_ += kBusPs;
    ++clocks_;
    dut_.bus_clk_i = 0;
    const bool on = player_.enabled();
    dut_.dma_enable_i = on ? 1 : 0;
    dut_.dma_ready_i = on && random_.chance(ready_percent_) ? 1 : 0;  // as LitePCIe's core has it
    dut_.eval();
    if (dut_.dma_valid_o != 0 && dut_.dma_ready_i != 0) {
      std::array<std::uint8_t, 16> beat{};
      for (std::size_t byte = 0; byte < beat.size(); ++byte) {  // the lowest byte goes to the lowest address
        beat[byte] = static_cast<std::uint8_t>(dut_.dma_data_o[byte / 4] >> (8 * (byte % 4)));
      }
      player_.write(beat);
    }
    if (dut_.s_axil_awready != 0) {
      aw_taken_ = aw_taken_ || dut_.s_axil_awvalid != 0;
    }
    w_taken_ = w_taken_ || (dut_.s_axil_wready != 0 && dut_.s_axil_wvalid != 0);
    ar_taken_ = ar_taken_ || (dut_.s_axil_arready != 0 && dut_.s_axil_arvalid != 0);
    answered_ = dut_.s_axil_bvalid != 0 || dut_.s_axil_rvalid != 0;
    answer_ = dut_.s_axil_rdata;
    dut_.bus_clk_i = 1;
    dut_.eval();
    dut_.s_axil_awvalid = dut_.s_axil_awvalid != 0 && !aw_taken_;
    dut_.s_axil_wvalid = dut_.s_axil_wvalid != 0 && !w_taken_;
    dut_.s_axil_arvalid = dut_.s_axil_arvalid != 0 && !ar_taken_;
  }

  // An access by AXI4-Lite, as LitePCIe makes it: address and data together, the answer's code ignored by the driver.
  void reach(litepcie::Access& access) {
    aw_taken_ = w_taken_ = ar_taken_ = answered_ = false;
    dut_.s_axil_awvalid = access.write;
    dut_.s_axil_wvalid = access.write;
    dut_.s_axil_arvalid = access.write == 0 ? 1 : 0;
    dut_.s_axil_awaddr = static_cast<std::uint8_t>(access.address);
    dut_.s_axil_araddr = static_cast<std::uint8_t>(access.address);
    dut_.s_axil_wdata = access.value;
    for (const std::uint64_t end = clocks_ + 1000; !answered_;) {
      step();
      if (clocks_ > end) {
        throw std::runtime_error("the board's registers do not answer");
      }
    }
    access.value = access.write != 0 ? access.value : answer_;
    answered_ = false;
  }

  static constexpr std::uint64_t kBusPs = 8000;
  static constexpr std::uint64_t kPixelPs = 7900;

  Random random_;
  VerilatedContext context_;
  Vacorn_system dut_;
  LitePciePlayer player_;
  int ready_percent_ = 100;
  std::uint64_t clocks_ = 0;
  std::uint64_t next_bus_ = 0;
  std::uint64_t next_pixel_ = 1234;
  bool aw_taken_ = false;
  bool w_taken_ = false;
  bool ar_taken_ = false;
  bool answered_ = false;
  std::uint32_t answer_ = 0;
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_BOARDS_ACORN_BENCH_H
