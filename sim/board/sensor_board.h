// A board whose camera sends what the board's registers say, of recorded images of its whole sensor.
#ifndef SELFPROJ_SIM_BOARD_SENSOR_BOARD_H
#define SELFPROJ_SIM_BOARD_SENSOR_BOARD_H

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "selfproj/model/board.h"
#include "selfproj/model/column_runs.h"
#include "sim/board/packet_recording.h"

namespace selfproj::sim {

// The camera sends the part of each image that begins where the register `region` says, of the register `size`; where
// `region` says nothing it stays where it was, at first in the corner. The columns are measured as the registers say.
// Raw images are not sent. Without `run`, and with a part that the sensor has not, nothing is sent.
class SensorBoard {
 public:
  // `pixels`: images of rows x columns, image by image. The encoder counts so much from image to image. The registers
  // must live as long.
  SensorBoard(std::vector<std::uint8_t> pixels, int rows, int columns, double counts_per_frame,
              PlayedRegisters& registers)
      : pixels_(std::move(pixels)),
        rows_(rows),
        columns_(columns),
        counts_per_frame_(counts_per_frame),
        registers_(registers) {}

  [[nodiscard]] std::size_t frames() const {
    return pixels_.size() / (static_cast<std::size_t>(rows_) * static_cast<std::size_t>(columns_));
  }

  // As PacketRecording::play.
  template <typename Emit>
  void play(std::uint64_t frame, double clocks_per_frame, const Emit& emit) {
    if (const std::span<const std::uint8_t> packet = packet_of(frame, clocks_per_frame); !packet.empty()) {
      emit(packet.size(), [&](std::uint8_t* room) { std::copy(packet.begin(), packet.end(), room); });
    }
  }

 private:
  std::span<const std::uint8_t> packet_of(std::uint64_t frame, double clocks_per_frame);

  std::vector<std::uint8_t> pixels_;
  int rows_, columns_;
  double counts_per_frame_;
  PlayedRegisters& registers_;
  model::BoardSettings taken_;  // in force
  int row_ = 0, column_ = 0;    // where the camera begins
  model::Runs runs_;
  std::vector<std::uint8_t> payload_, packet_;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_BOARD_SENSOR_BOARD_H
