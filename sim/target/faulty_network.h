// A network between board and host that drops, doubles and reorders datagrams of one UDP port.
#ifndef SELFPROJ_SIM_TARGET_FAULTY_NETWORK_H
#define SELFPROJ_SIM_TARGET_FAULTY_NETWORK_H

#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "sim/target/rgmii.h"

namespace selfproj {

// The source port of a frame of UDP over IPv4; 0 if it is none.
inline unsigned udp_source_port(const EthernetFrame& frame) {
  constexpr std::size_t kEthernet = 14;
  const bool udp = frame.size() >= kEthernet + 28 && frame[12] == 8 && frame[13] == 0 && frame[kEthernet] == 0x45 &&
                   frame[kEthernet + 9] == 17;
  return udp ? static_cast<unsigned>(frame[kEthernet + 20] << 8 | frame[kEthernet + 21]) : 0;
}

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

}  // namespace selfproj

#endif  // SELFPROJ_SIM_TARGET_FAULTY_NETWORK_H
