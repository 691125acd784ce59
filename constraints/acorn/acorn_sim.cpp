// The FPGA of an Acorn in simulation, LitePCIe's core included, and the host's device for LitePCIe behind it.
//
//     acorn_sim [--frames N] [--images] [--ready PERCENT] [--seed N]
//
// The circuits are those of constraints/acorn/acorn.sv with LitePCIe's core, which Verilator has compiled. In the place
// of the vendor's block for PCI Express there is pcie_s7.svh: packets of the transaction layer go to and from this
// program, which plays the host and LitePCIe's kernel driver. In PERCENT of all clocks the host takes what comes.
//
// First the board's selftest runs through BAR 0. Then the board sends N frames (40), with raw images if wanted. Each
// packet must be that of the models, and none may be missing. Prints the figures as NAME=VALUE; exit status 1 if
// anything is wrong.
#include <svdpi.h>
#include <verilated.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "Vacorn.h"
#include "constraints/acorn/acorn_driver.h"
#include "constraints/acorn/pcie_host.h"
#include "constraints/common/scoreboard.h"
#include "host/driver/boards.h"
#include "host/driver/control.h"
#include "host/driver/litepcie.h"
#include "selfproj/driver/counters.h"
#include "selfproj/driver/device.h"

namespace selfproj::sim {
namespace {

constexpr const char* kUri = "litepcie:simulated";
constexpr int kColumns = 512;  // of the test camera
constexpr int kRows = 96;
constexpr std::uint64_t kFrameClocks = 12'500;

struct Options {
  std::uint64_t frames = 40;
  bool images = false;
  int ready = 90;
  std::uint64_t seed = 1;
};

Options read_options(const std::vector<std::string>& words) {
  Options options;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == "--images") {
      options.images = true;
      continue;
    }
    char* end = nullptr;
    const std::uint64_t number = i + 1 < words.size() ? std::strtoull(words[i + 1].c_str(), &end, 10) : 0;
    if (number == 0 || *end != '\0') {
      throw std::runtime_error(words[i] + ": unknown, or without a number");
    }
    if (words[i] == "--frames") {
      options.frames = number;
    } else if (words[i] == "--ready" && number <= 100) {
      options.ready = static_cast<int>(number);
    } else if (words[i] == "--seed") {
      options.seed = number;
    } else {
      throw std::runtime_error(words[i] + ": unknown, or not in its range");
    }
    ++i;
  }
  return options;
}

PcieHost* g_host = nullptr;  // of the one simulation, for the function that the circuits call

class Fpga {
 public:
  explicit Fpga(PcieHost& host) : model_(std::make_unique<Vacorn>(&context_)) {
    g_host = &host;
    model_->clk200_n_i = 1;
    model_->pcie_rst_n_i = 0;
    for (int i = 0; i < 100; ++i) {
      step();
    }
    model_->pcie_rst_n_i = 1;
    for (int i = 0; i < 2000; ++i) {  // much longer than the resets last
      step();
    }
  }
  Fpga(const Fpga&) = delete;
  Fpga& operator=(const Fpga&) = delete;
  ~Fpga() {
    model_->final();
    g_host = nullptr;
  }

  // One clock of PCI Express. The pixel clock has a phase and a period of its own.
  void step() {
    next_pcie_ += kPciePs;
    while (next_pixel_ <= next_pcie_) {
      next_pixel_ += kPixelPs;
      model_->clk200_p_i = 0;
      model_->eval();
      model_->clk200_p_i = 1;
      model_->eval();
    }
    model_->pcie_clk_p_i = 0;
    model_->eval();
    model_->pcie_clk_p_i = 1;
    model_->eval();
    ++clocks_;
  }

  [[nodiscard]] std::uint64_t clocks() const { return clocks_; }

 private:
  static constexpr std::uint64_t kPciePs = 8000;
  static constexpr std::uint64_t kPixelPs = 7990;

  VerilatedContext context_;
  std::unique_ptr<Vacorn> model_;
  std::uint64_t next_pcie_ = 0;
  std::uint64_t next_pixel_ = 1234;
  std::uint64_t clocks_ = 0;
};

// Runs the board's selftest. Returns how many checks have failed.
std::uint64_t selftest(driver::Control& control) {
  std::uint64_t failed = 0;
  for (const driver::BoardTestResult& result : driver::test_board(control)) {
    if (!result.fault.empty()) {
      std::fprintf(stderr, "acorn_sim: %s: %s\n", result.what.c_str(), result.fault.c_str());
      ++failed;
    }
  }
  return failed;
}

struct Received {
  std::uint64_t packets = 0;
  std::uint64_t equal = 0;
};

// Reads until nothing comes for 1 ms of simulated time, or until so many frames have begun.
void read(driver::Device& device, CameraScoreboard& scoreboard, Received& received, AcornDriver& driver,
          std::uint64_t frames) {
  model::PacketView packet;
  for (int idle = 0; idle < 100; ++idle) {
    while (device.next(packet, std::chrono::nanoseconds(0)) == driver::Next::packet) {
      ++received.packets;
      received.equal += scoreboard.matches(packet) ? 1 : 0;
      idle = 0;
      if (packet.header.sequence + 1 >= frames) {
        return;
      }
    }
    driver.wait(1250);
  }
}

int run(const std::vector<std::string>& words) {
  const Options options = read_options(words);
  PcieHost host(std::size_t{AcornDriver::kBuffers} * AcornDriver::kBytes, options.ready, options.seed);
  Fpga fpga(host);
  AcornDriver driver(host, [&fpga] { fpga.step(); });
  driver::Control control(driver::make_litepcie_port(std::make_unique<AcornPort>(driver), kUri));
  const std::uint64_t failed = selftest(control);
  const std::unique_ptr<driver::Device> device =
      driver::make_litepcie_device(std::make_unique<AcornPort>(driver), kUri, {});
  control.write_together({{driver::register_part("size.columns"), kColumns},
                          {driver::register_part("size.rows"), kRows},
                          {driver::register_part("measure.mode"), 2},
                          {driver::register_part("measure.threshold"), 100},
                          {driver::register_part("control.image"), options.images ? 1 : 0}});
  control.write("control.run", 1);
  CameraScoreboard scoreboard(kColumns, kRows, kFrameClocks);
  Received received;
  read(*device, scoreboard, received, driver, options.frames);
  control.write("control.run", 0);
  read(*device, scoreboard, received, driver, UINT64_MAX);
  const std::uint64_t frames = control.read("frames");
  const std::uint64_t lost = control.read("lost_moments") + control.read("lost_image");
  const std::uint64_t sent = frames * (options.images ? 1 + kRows : 1) - lost;
  const driver::Counters counters = device->counters();
  const std::uint64_t wrong =
      counters.bad + counters.bytes_discarded + counters.read_errors + host.strangers() + failed;
  std::printf(
      "frames=%llu\npackets_sent=%llu\nread=%llu\nequal=%llu\nlost_board=%llu\nwrong=%llu\ninterrupts=%llu\n"
      "memory_writes=%llu\nclocks=%llu\n",
      static_cast<unsigned long long>(frames), static_cast<unsigned long long>(sent),
      static_cast<unsigned long long>(received.packets), static_cast<unsigned long long>(received.equal),
      static_cast<unsigned long long>(lost), static_cast<unsigned long long>(wrong),
      static_cast<unsigned long long>(driver.serve_interrupts()), static_cast<unsigned long long>(host.writes()),
      static_cast<unsigned long long>(fpga.clocks()));
  return frames >= options.frames && received.packets == sent && received.equal == sent && wrong == 0 ? 0 : 1;
}

}  // namespace
}  // namespace selfproj::sim

// Called by pcie_s7.svh in every clock.
extern "C" void pcie_host_clock(svBit taken, svBit last, const svBitVecVal* keep, const svBitVecVal* sent, svBit given,
                                svBit interrupt, svBit* ready, svBit* valid, svBit* is_read, svBitVecVal* offered) {
  const selfproj::sim::PcieHost::To to = selfproj::sim::g_host->clock({.taken = taken != 0,
                                                                       .last = last != 0,
                                                                       .keep = static_cast<std::uint16_t>(*keep),
                                                                       .beat = {sent[0], sent[1], sent[2], sent[3]},
                                                                       .given = given != 0,
                                                                       .interrupt = interrupt != 0});
  *ready = to.ready ? 1 : 0;
  *valid = to.valid ? 1 : 0;
  *is_read = to.read ? 1 : 0;
  for (std::size_t i = 0; i < to.beat.size(); ++i) {
    offered[i] = to.beat[i];
  }
}

int main(int argc, char** argv) {
  try {
    return selfproj::sim::run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "acorn_sim: %s\n", error.what());
    return 2;
  }
}
