#ifndef SELFPROJ_SIM_BOARD_PLAYED_REGISTERS_H
#define SELFPROJ_SIM_BOARD_PLAYED_REGISTERS_H

#include <atomic>
#include <cstdint>

#include "host/driver/clock.h"
#include "model/register_file.h"

namespace selfproj {

// The registers of a board that plays recorded packets: settings are taken or refused as a board does, but change no
// packet; frames and time go on. One thread counts, another one accesses.
class PlayedRegisters {
 public:
  explicit PlayedRegisters(double pixel_clock_hz) : clocks_per_ns_(pixel_clock_hz / 1e9), start_ns_(now_ns()) {}

  void set_frames(std::uint64_t frames) { frames_ = static_cast<std::uint32_t>(frames); }

  RegisterAnswer access(bool write, std::uint32_t address, std::uint32_t data) {
    if (write) {
      return registers_.write(address, data);
    }
    const double clocks = static_cast<double>(now_ns() - start_ns_) * clocks_per_ns_;
    return registers_.read(address, {.frames = frames_, .time = static_cast<std::uint64_t>(clocks)});
  }

 private:
  double clocks_per_ns_;
  std::int64_t start_ns_;
  std::atomic<std::uint32_t> frames_ = 0;
  RegisterFile registers_;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_BOARD_PLAYED_REGISTERS_H
