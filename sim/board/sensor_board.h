// A board whose camera sends what the board's registers say, of recorded images of its whole sensor.
#ifndef SELFPROJ_SIM_BOARD_SENSOR_BOARD_H
#define SELFPROJ_SIM_BOARD_SENSOR_BOARD_H

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "host/images/image_files.h"
#include "selfproj/model/board.h"
#include "selfproj/model/column_runs.h"
#include "sim/board/packet_recording.h"

namespace selfproj::sim {

// The camera sends the part of each image that begins where the register `region` says, of the register `size`; where
// `region` says nothing it stays where it was, at first in the corner. The columns are measured as the registers say.
// Raw images are not sent. Without `run`, and with a part that the sensor has not, nothing is sent.
class SensorBoard {
 public:
  // Images of one size, whose pixels have so many bits. The encoder counts so much from image to image. The registers
  // must live as long.
  SensorBoard(std::vector<images::SensorImage> images, int pixel_bits, double counts_per_frame,
              PlayedRegisters& registers)
      : images_(std::move(images)),
        pixel_bits_(pixel_bits),
        counts_per_frame_(counts_per_frame),
        registers_(registers) {}

  [[nodiscard]] std::size_t frames() const { return images_.size(); }

  // As PacketRecording::play.
  template <typename Emit>
  void play(std::uint64_t frame, double clocks_per_frame, const Emit& emit) {
    if (const std::span<const std::uint8_t> packet = packet_of(frame, clocks_per_frame); !packet.empty()) {
      emit(packet.size(), [&](std::uint8_t* room) { std::copy(packet.begin(), packet.end(), room); });
    }
  }

 private:
  std::span<const std::uint8_t> packet_of(std::uint64_t frame, double clocks_per_frame);

  std::vector<images::SensorImage> images_;
  int pixel_bits_;
  double counts_per_frame_;
  PlayedRegisters& registers_;
  model::BoardSettings taken_;  // in force
  int row_ = 0, column_ = 0;    // where the camera begins
  model::Runs runs_;
  std::vector<std::uint8_t> payload_, packet_;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_BOARD_SENSOR_BOARD_H
