// Tests what the FPGA of an Acorn has beside LitePCIe, together with the host's device and registers for LitePCIe:
// every packet against the models, and every loss counted.
#include <gtest/gtest.h>
#include <verilated.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <stdexcept>

#include "Vacorn_system.h"
#include "constraints/common/scoreboard.h"
#include "host/driver/control.h"
#include "host/driver/litepcie.h"
#include "selfproj/driver/counters.h"
#include "selfproj/driver/device.h"
#include "selfproj/model/packet.h"
#include "tests/support/litepcie_player.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

constexpr const char* kUri = "litepcie:bench";

// What is in the FPGA of an Acorn beside LitePCIe, Verilated, with a stand-in for LitePCIe at its ports: the host's
// program has its registers and its DMA through the seam of the driver.
class AcornBench {
 public:
  // The parameters of the model (constraints/CMakeLists.txt)
  static constexpr int kColumns = 64;
  static constexpr int kRows = 16;
  static constexpr std::uint64_t kFrameClocks = 400;

  explicit AcornBench(std::uint64_t seed) : random_(seed), dut_(&context_), player_(256, 8192) {
    player_.board = [this](driver::litepcie::Access& access) { reach(access); };
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
  void reach(driver::litepcie::Access& access) {
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

// The host of a board on the bench.
class Host {
 public:
  explicit Host(std::uint64_t seed)
      : bench_(seed),
        control_(driver::make_litepcie_port(std::make_unique<LitePciePlayerPort>(bench_.player()), kUri)) {
    control_.write_together({{driver::register_part("size.columns"), AcornBench::kColumns},
                             {driver::register_part("size.rows"), AcornBench::kRows},
                             {driver::register_part("measure.mode"), 2},
                             {driver::register_part("measure.threshold"), 100}});
  }

  AcornBench& bench() { return bench_; }
  driver::Counters counters() const { return device_->counters(); }
  std::uint64_t newest_frame() const { return newest_frame_; }
  int of_newest_frame() const { return of_newest_frame_; }  // packets
  std::uint64_t of(const char* name) { return control_.read(name); }
  // Packets that the board says it has made and not lost.
  std::uint64_t sent() { return packets_ + packets_of_run() - of("lost_moments") - of("lost_image"); }

  void open() {
    device_ = driver::make_litepcie_device(std::make_unique<LitePciePlayerPort>(bench_.player()), kUri, {});
    scoreboard_.emplace(AcornBench::kColumns, AcornBench::kRows, AcornBench::kFrameClocks);
  }
  void close() { device_.reset(); }

  void start(bool image) {
    packets_ += packets_of_run();
    frames_ = of("frames");
    image_ = image;
    scoreboard_.emplace(AcornBench::kColumns, AcornBench::kRows, AcornBench::kFrameClocks);
    control_.write("control.image", image ? 1 : 0);
    control_.write("control.run", 1);
  }
  // And waits for much longer than the FPGA takes to see that nothing follows.
  void stop() {
    control_.write("control.run", 0);
    run(10);
  }

  // Reads every 1000 clocks.
  void run(int times) {
    for (int i = 0; i < times; ++i) {
      bench_.run(1000);
      if (device_) {
        read();
      }
    }
  }

  // Each packet must be the models'.
  void read() {
    model::PacketView packet;
    while (device_->next(packet, std::chrono::nanoseconds(0)) == driver::Next::packet) {
      ASSERT_TRUE(scoreboard_->matches(packet))
          << "frame " << packet.header.sequence << ", kind " << int{packet.header.kind};
      of_newest_frame_ = packet.header.sequence == newest_frame_ ? of_newest_frame_ + 1 : 1;
      newest_frame_ = packet.header.sequence;
    }
  }

 private:
  std::uint64_t packets_of_run() { return (of("frames") - frames_) * (image_ ? 1 + AcornBench::kRows : 1); }

  AcornBench bench_;
  driver::Control control_;
  std::optional<sim::CameraScoreboard> scoreboard_;
  std::unique_ptr<driver::Device> device_;
  std::uint64_t newest_frame_ = 0;
  int of_newest_frame_ = 0;
  std::uint64_t packets_ = 0;  // of earlier runs
  std::uint64_t frames_ = 0;   // before this run
  bool image_ = false;
};

TEST(Acorn, EveryPacketAndNoneStaysBehind) {
  for (const std::uint64_t seed : seeds(3)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Host host(seed);
    host.open();
    for (const int frames : {1, 2, 300}) {
      for (const bool image : {false, true}) {
        host.bench().set_ready(image ? 60 : 100);
        host.start(image);
        host.run(frames * static_cast<int>(AcornBench::kFrameClocks) / 1000 + 1);
        host.stop();
        EXPECT_EQ(host.counters().delivered, host.sent());
      }
    }
    driver::Counters want;
    want.delivered = host.sent();
    EXPECT_EQ(host.counters(), want);
    EXPECT_GT(want.delivered, 5000U);
  }
}

TEST(Acorn, WhatTheBoardLosesIsCounted) {
  Host host(1);
  host.open();
  host.bench().set_ready(20);  // too seldom for raw images
  host.start(true);
  host.run(100);
  host.bench().set_ready(100);
  host.run(10);
  host.stop();
  const driver::Counters counters = host.counters();
  EXPECT_GT(counters.lost_board, 0U);
  EXPECT_EQ(counters.lost_board, host.of("lost_moments") + host.of("lost_image"));
  EXPECT_EQ(counters.delivered, host.sent());
  EXPECT_EQ(counters.bad + counters.bytes_discarded + counters.read_errors, 0U);
}

// Zeros only behind the last packet of a burst: the camera's frames follow each other within IdleClocks.
TEST(Acorn, NoZerosWhilePacketsFollow) {
  Host host(1);
  host.open();
  host.start(false);
  host.run(100);
  host.stop();
  const std::uint64_t bytes = host.counters().delivered * model::packet_bytes(8 * AcornBench::kColumns);
  EXPECT_GT(bytes, 10U * 8192);
  EXPECT_LE(host.bench().player().finished(), bytes / 8192 + 2);
}

// Whenever the DMA starts, its first byte is that of a packet, and none stays behind.
TEST(Acorn, TheDmaStartsAnewInTheMiddle) {
  Host host(1);
  Random random(1);
  host.start(true);
  for (int i = 0; i < 40; ++i) {
    host.open();
    host.run(random.between(4, 12));  // two buffers take less than 3000 clocks
    EXPECT_GT(host.counters().delivered, 0U);
    EXPECT_EQ(host.counters().bytes_discarded, 0U);
    EXPECT_EQ(host.counters().bad, 0U);
    if (i % 2 == 1) {
      host.stop();
      EXPECT_EQ(host.newest_frame() + 1, host.of("frames"));
      EXPECT_EQ(host.of_newest_frame(), 1 + AcornBench::kRows);
      host.start(true);
    }
    host.close();
    host.bench().run(static_cast<std::uint64_t>(random.between(1, 700)));
  }
}

TEST(Acorn, AHostThatIsTooSlow) {
  Host host(1);
  host.open();
  host.start(true);
  host.run(20);
  while (host.bench().player().finished() < 400) {  // once round, and more
    host.bench().run(1000);
  }
  host.run(20);
  host.stop();
  const driver::Counters counters = host.counters();
  EXPECT_EQ(counters.read_errors, 1U);
  EXPECT_EQ(counters.resynchronized, 1U);
  EXPECT_EQ(counters.lost_board, 0U);
  EXPECT_GT(counters.missing, 0U);
  EXPECT_LT(counters.delivered, host.sent());
}

}  // namespace
}  // namespace selfproj::test
