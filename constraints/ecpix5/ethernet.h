// Ethernet frames between a simulated board and this machine: on the pins of RGMII, over a network with faults, and on
// a network interface.
#ifndef SELFPROJ_CONSTRAINTS_ECPIX5_ETHERNET_H
#define SELFPROJ_CONSTRAINTS_ECPIX5_ETHERNET_H

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace selfproj::sim {

using EthernetFrame = std::vector<std::uint8_t>;  // from the address of the receiver on, without the check

// The check at the end of a frame, CRC-32.
std::uint32_t ethernet_check(std::span<const std::uint8_t> bytes);

// The way to the board by RGMII, at a gigabit per second: a byte in each clock of 8 ns, its low half at the rising edge
// and its high half at the falling one. Gives the pins at each half of a clock.
class RgmiiSender {
 public:
  struct Pins {
    bool control = false;
    std::uint8_t data = 0;
  };

  // Frames wait for each other. Short ones are filled up. `damaged`: a byte arrives wrong.
  void send(const EthernetFrame& frame, bool damaged = false);
  [[nodiscard]] std::size_t waiting() const { return frames_.size(); }

  Pins rising();   // before the rising edge
  Pins falling();  // before the falling one

 private:
  std::deque<EthernetFrame> frames_;  // with all that is on the wire
  std::size_t at_ = 0;                // bytes of the first of them that are sent
  int gap_ = 0;                       // clocks until the next may begin
  Pins high_;
};

// The way from the board by RGMII.
class RgmiiReceiver {
 public:
  // The pins after each half of a clock. The second returns a frame that has ended with a good check.
  void rising(bool control, std::uint8_t data);
  std::optional<EthernetFrame> falling(std::uint8_t data);

  [[nodiscard]] std::uint64_t damaged() const { return damaged_; }
  [[nodiscard]] bool idle() const { return bytes_.empty(); }

 private:
  EthernetFrame bytes_;
  bool control_ = false;
  std::uint8_t low_ = 0;
  std::uint64_t damaged_ = 0;
};

// The source port of a frame of UDP over IPv4; 0 if it is none.
inline unsigned udp_source_port(const EthernetFrame& frame) {
  constexpr std::size_t kEthernet = 14;
  const bool udp = frame.size() >= kEthernet + 28 && frame[12] == 8 && frame[13] == 0 && frame[kEthernet] == 0x45 &&
                   frame[kEthernet + 9] == 17;
  return udp ? static_cast<unsigned>(frame[kEthernet + 20] << 8 | frame[kEthernet + 21]) : 0;
}

// Drops, doubles and reorders datagrams of one UDP port between board and host.
class FaultyNetwork {
 public:
  struct Faults {
    double dropped = 0;  // percent of datagrams
    double doubled = 0;
    double reordered = 0;
  };
  struct Counts {
    std::uint64_t datagrams = 0;  // that came
    std::uint64_t dropped = 0;
    std::uint64_t doubled = 0;
    std::uint64_t reordered = 0;
  };

  FaultyNetwork(unsigned port, const Faults& faults, std::uint64_t seed)
      : port_(port), faults_(faults), random_(seed) {}

  // What arrives when this frame comes.
  std::vector<EthernetFrame> pass(EthernetFrame frame) {
    std::vector<EthernetFrame> out;
    if (udp_source_port(frame) != port_) {
      out.push_back(std::move(frame));
      return out;
    }
    ++counts_.datagrams;
    if (chance(faults_.dropped)) {
      ++counts_.dropped;
    } else if (!held_ && chance(faults_.reordered)) {
      ++counts_.reordered;
      held_ = std::move(frame);
      return out;
    } else {
      if (chance(faults_.doubled)) {
        ++counts_.doubled;
        out.push_back(frame);
      }
      out.push_back(std::move(frame));
    }
    if (held_) {
      out.push_back(*std::exchange(held_, std::nullopt));
    }
    return out;
  }

  // What was to come after the next one, where none comes for now.
  std::optional<EthernetFrame> flush() { return std::exchange(held_, std::nullopt); }

  [[nodiscard]] const Counts& counts() const { return counts_; }

 private:
  bool chance(double percent) { return std::uniform_real_distribution<>(0, 100)(random_) < percent; }

  unsigned port_;
  Faults faults_;
  std::mt19937_64 random_;
  std::optional<EthernetFrame> held_;
  Counts counts_;
};

// A network interface of this machine that is a file: what the kernel sends on it can be read, and what is written to
// it comes to the kernel.
class Tap {
 public:
  // Throws std::runtime_error with the interface's name and the reason.
  explicit Tap(const std::string& name);
  Tap(const Tap&) = delete;
  Tap& operator=(const Tap&) = delete;
  ~Tap();

  std::optional<EthernetFrame> receive();  // nothing if none waits
  bool send(const EthernetFrame& frame);   // false if the kernel has no room or the interface is down

 private:
  int file_ = -1;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_CONSTRAINTS_ECPIX5_ETHERNET_H
