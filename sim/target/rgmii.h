// Ethernet frames on the pins of RGMII, at a gigabit per second: a byte in each clock of 8 ns, its low half at the
// rising edge and its high half at the falling one.
#ifndef SELFPROJ_SIM_TARGET_RGMII_H
#define SELFPROJ_SIM_TARGET_RGMII_H

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

namespace selfproj {

using EthernetFrame = std::vector<std::uint8_t>;  // from the address of the receiver on, without the check

// The check at the end of a frame, CRC-32.
std::uint32_t ethernet_check(std::span<const std::uint8_t> bytes);

// The way to the board: gives the pins at each half of a clock.
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

// The way from the board.
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

}  // namespace selfproj

#endif  // SELFPROJ_SIM_TARGET_RGMII_H
