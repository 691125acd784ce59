// The FPGA of an ECPIX-5 in simulation. Its Ethernet is connected to a network interface of this machine.
//
//     ecpix5_sim INTERFACE [--drop PERCENT] [--double PERCENT] [--reorder PERCENT] [--damage PERCENT] [--seed N]
//                [--fast] [--counts FILE] [--paused FILE]
//
// The circuits are those of constraints/ecpix5/ecpix5_system.sv, LiteEth included, which Verilator has compiled; PLL
// and pins are not. INTERFACE becomes a TAP interface. The first three faults hit datagrams with packets, and those of
// replay. --damage hits any frame to the board, so that its check fails. --fast: pixels at 133.3 MHz and the bus at
// 53.3 MHz, not 125 and 50, as with parameter Fast of ecpix5.sv. Runs until SIGTERM or SIGINT, then writes what was
// sent as JSON, and how fast: packet_clocks are the clocks of RGMII, of 8 ns, from the end of the first datagram that
// begins a packet to the end of the last one.
//
// A simulated second takes minutes, but the host's clock is real. Ethernet frames with packets therefore wait here, as
// in a switch, until the board has sent nothing for 10 us. So the host sees no pauses within a burst of packets. If a
// burst does not end, whole packets are handed over before they are more than the kernel's buffer holds. The process
// whose number stands in the FILE of --paused, if there is one, is stopped while packets are handed over, because in
// simulated time this takes no time at all.
#include <sys/types.h>
#include <verilated.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "Vecpix5_system.h"
#include "constraints/ecpix5/ethernet.h"
#include "model/spec/generated/datagram_format.h"

namespace selfproj::sim {
namespace {

std::atomic<bool> g_stop = false;

constexpr unsigned kPacketPort = 1235;
constexpr std::uint64_t kHalfEthernetPs = 4000;
constexpr std::uint64_t kEthernetPs = 2 * kHalfEthernetPs;
constexpr std::uint64_t kBurstPs = 10'000'000;
constexpr std::size_t kBurstBytes = 80'000;       // with the kernel's overhead less than net.core.rmem_max usually is
constexpr std::chrono::milliseconds kHeldUp(10);  // half of what a host takes for silence
constexpr std::uint64_t kLookPs = 1'000'000;      // time between two looks at the interface

struct Options {
  std::string interface;
  FaultyNetwork::Faults faults;
  double damaged = 0;  // percent of the frames to the board
  std::uint64_t seed = 1;
  bool fast = false;
  std::string counts;
  std::string paused;
};

double percent(const std::string& option, const std::string& value) {
  char* end = nullptr;
  const double number = std::strtod(value.c_str(), &end);
  if (value.empty() || *end != '\0' || !(number >= 0 && number <= 100)) {
    throw std::runtime_error(option + ": '" + value + "' is not a percentage");
  }
  return number;
}

Options read_options(const std::vector<std::string>& words) {
  Options options;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (!word.starts_with("--")) {
      options.interface = word;
      continue;
    }
    if (word == "--fast") {
      options.fast = true;
      continue;
    }
    if (i + 1 == words.size()) {
      throw std::runtime_error(word + ": the value is missing");
    }
    const std::string& value = words[++i];
    if (word == "--drop") {
      options.faults.dropped = percent(word, value);
    } else if (word == "--double") {
      options.faults.doubled = percent(word, value);
    } else if (word == "--reorder") {
      options.faults.reordered = percent(word, value);
    } else if (word == "--damage") {
      options.damaged = percent(word, value);
    } else if (word == "--seed") {
      options.seed = std::strtoull(value.c_str(), nullptr, 10);
    } else if (word == "--counts") {
      options.counts = value;
    } else if (word == "--paused") {
      options.paused = value;
    } else {
      throw std::runtime_error(word + ": unknown");
    }
  }
  if (options.interface.empty()) {
    throw std::runtime_error("the name of the interface is missing");
  }
  return options;
}

// Whether a frame with a datagram of packets holds the first piece of one.
bool begins_packet(const EthernetFrame& frame) {
  constexpr std::size_t kHeader = 14 + 20 + 8;  // behind the headers of Ethernet, IP and UDP
  const auto is_0 = [&](std::size_t field) { return frame[kHeader + field] == 0 && frame[kHeader + field + 1] == 0; };
  return frame.size() >= kHeader + spec::kDatagramHeaderBytes && is_0(spec::kDatagramOffset) &&
         !is_0(spec::kDatagramLength);
}

class Simulation {
 public:
  explicit Simulation(const Options& options)
      : model_(std::make_unique<Vecpix5_system>(&context_)),
        tap_(options.interface),
        network_(kPacketPort, options.faults, options.seed),
        to_board_(spec::kReplayPort, options.faults, options.seed + 1),
        paused_(options.paused),
        half_pixel_(options.fast ? 3750 : 4000),
        half_bus_(options.fast ? 9375 : 10'000),
        damaged_(options.damaged / 100),
        random_(options.seed) {
    model_->rst_i = 1;
    model_->bus_rst_i = 1;
  }
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;
  ~Simulation() { model_->final(); }

  // One half of an Ethernet clock, and the edges of the other clocks in it.
  void step() {
    now_ += kHalfEthernetPs;
    while (std::min(next_pixel_, next_bus_) <= now_) {
      if (next_bus_ <= next_pixel_) {
        model_->bus_clk_i = model_->bus_clk_i == 0;
        next_bus_ += half_bus_;
      } else {
        model_->clk_i = model_->clk_i == 0;
        next_pixel_ += half_pixel_;
      }
      model_->eval();
    }
    ethernet();
    if (now_ == kResetPs) {
      model_->rst_i = 0;
      model_->bus_rst_i = 0;
    }
    if (now_ % kLookPs == 0) {
      exchange_frames();
    }
  }

  void write_counts(const std::string& path) const {
    const FaultyNetwork::Counts& counts = network_.counts();
    const FaultyNetwork::Counts& replayed = to_board_.counts();
    std::ofstream file(path);
    file << "{\"simulated_us\": " << now_ / 1'000'000 << ", \"datagrams\": " << counts.datagrams
         << ", \"dropped\": " << counts.dropped << ", \"doubled\": " << counts.doubled
         << ", \"reordered\": " << counts.reordered << ", \"refused_by_kernel\": " << refused_
         << ", \"held_up\": " << held_up_ << ", \"replay_datagrams\": " << replayed.datagrams
         << ", \"replay_dropped\": " << replayed.dropped << ", \"replay_doubled\": " << replayed.doubled
         << ", \"replay_reordered\": " << replayed.reordered << ", \"to_board_damaged\": " << to_board_damaged_
         << ", \"from_board_damaged\": " << receiver_.damaged() << ", \"packets_on_cable\": " << packets_
         << ", \"packet_clocks\": " << (last_packet_ - first_packet_) / kEthernetPs << "}\n";
    if (!file.flush()) {
      throw std::runtime_error(path + ": cannot be written");
    }
  }

 private:
  static constexpr std::uint64_t kResetPs = 400'000;

  void ethernet() {
    const bool rising = model_->eth_rx_clk_i == 0;
    const RgmiiSender::Pins pins = rising ? sender_.rising() : sender_.falling();
    model_->eth_rx_ctl_i = pins.control;
    model_->eth_rx_data_i = pins.data;
    model_->eth_rx_clk_i = rising;
    model_->eval();
    if (rising) {
      receiver_.rising(model_->eth_tx_ctl_o != 0, model_->eth_tx_data_o);
    } else if (std::optional<EthernetFrame> frame = receiver_.falling(model_->eth_tx_data_o)) {
      if (udp_source_port(*frame) != kPacketPort) {
        refused_ += tap_.send(*frame) ? 0 : 1;
      } else {
        if (begins_packet(*frame)) {
          first_packet_ = packets_ == 0 ? now_ : first_packet_;
          last_packet_ = now_;
          ++packets_;
          if (burst_bytes_ >= kBurstBytes) {
            hand_over();
          }
        }
        for (EthernetFrame& one : network_.pass(*std::move(frame))) {
          burst_bytes_ += one.size();
          burst_.push_back(std::move(one));
        }
      }
    }
    last_busy_ = receiver_.idle() ? last_busy_ : now_;
  }

  void exchange_frames() {
    if (now_ - last_busy_ >= kBurstPs) {
      if (std::optional<EthernetFrame> frame = network_.flush()) {
        burst_.push_back(*std::move(frame));
      }
      if (!burst_.empty()) {
        hand_over();
      }
    }
    while (std::optional<EthernetFrame> frame = tap_.receive()) {
      // One that is held back, and to which nothing follows, is lost.
      for (const EthernetFrame& one : to_board_.pass(*std::move(frame))) {
        const bool damage = damaged_(random_);
        to_board_damaged_ += damage ? 1 : 0;
        sender_.send(one, damage);
      }
    }
  }

  void hand_over() {
    std::ifstream file(paused_);
    pid_t process = 0;
    const bool stops = file >> process && process > 1 && kill(process, SIGSTOP) == 0;
    auto last = std::chrono::steady_clock::now();
    for (const EthernetFrame& frame : burst_) {
      refused_ += tap_.send(frame) ? 0 : 1;
      const auto now = std::chrono::steady_clock::now();
      held_up_ += !stops && now - last > kHeldUp ? 1 : 0;
      last = now;
    }
    burst_.clear();
    burst_bytes_ = 0;
    if (stops) {
      kill(process, SIGCONT);
    }
  }

  VerilatedContext context_;
  std::unique_ptr<Vecpix5_system> model_;
  Tap tap_;
  FaultyNetwork network_;
  FaultyNetwork to_board_;
  std::string paused_;
  std::uint64_t half_pixel_;  // of a clock, in ps
  std::uint64_t half_bus_;
  std::bernoulli_distribution damaged_;  // whether a frame to the board is
  std::mt19937_64 random_;
  RgmiiSender sender_;
  RgmiiReceiver receiver_;
  std::vector<EthernetFrame> burst_;
  std::size_t burst_bytes_ = 0;
  std::uint64_t now_ = 0;
  std::uint64_t next_pixel_ = half_pixel_;
  std::uint64_t next_bus_ = half_bus_;
  std::uint64_t packets_ = 0;  // that have begun on the cable, and when the first and the last one did
  std::uint64_t first_packet_ = 0;
  std::uint64_t last_packet_ = 0;
  std::uint64_t last_busy_ = 0;
  std::uint64_t refused_ = 0;
  std::uint64_t held_up_ = 0;  // pauses within a burst, because this process had to wait for a processor
  std::uint64_t to_board_damaged_ = 0;
};

int run(const std::vector<std::string>& words) {
  const Options options = read_options(words);
  Simulation simulation(options);
  std::signal(SIGTERM, [](int) { g_stop = true; });
  std::signal(SIGINT, [](int) { g_stop = true; });
  std::printf("ready\n");
  std::fflush(stdout);
  while (!g_stop) {
    simulation.step();
  }
  if (!options.counts.empty()) {
    simulation.write_counts(options.counts);
  }
  return 0;
}

}  // namespace
}  // namespace selfproj::sim

int main(int argc, char** argv) {
  try {
    return selfproj::sim::run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ecpix5_sim: %s\n", error.what());
    return 2;
  }
}
