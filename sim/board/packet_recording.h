// Recorded packets, which can be played again and again as one long run of a board.
#ifndef SELFPROJ_SIM_BOARD_PACKET_RECORDING_H
#define SELFPROJ_SIM_BOARD_PACKET_RECORDING_H

#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "host/driver/clock.h"
#include "model/register_file.h"
#include "selfproj/driver/counters.h"
#include "selfproj/model/board.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/packet.h"

namespace selfproj::sim {

// The encoder's count at a frame, modulo 2^32.
inline std::uint32_t encoder_at(std::uint64_t frame, double counts_per_frame) {
  return static_cast<std::uint32_t>(std::llround(static_cast<double>(frame) * counts_per_frame));
}

// The packets of a run of frames, held in memory. A frame consists of the packets with one sequence number: its
// moments, and the lines of its image and code image if there are any.
//
// Playing numbers the frames without gaps from 0, loop after loop. Sequence, time stamp, encoder count and check word
// of each packet are written anew, `lost` is 0, and everything else stays as it was recorded.
class PacketRecording {
 public:
  // Adds a packet, which must be right.
  void add(const model::PacketHeader& header, std::span<const std::uint8_t> packet);

  // The encoder counts so much from frame to frame, instead of what was recorded.
  void count_encoder(double counts_per_frame) {
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      frames_[i].encoder = encoder_at(i, counts_per_frame);
    }
  }

  [[nodiscard]] std::size_t frames() const { return frames_.size(); }
  // A board that sends such columns
  [[nodiscard]] const model::BoardBuild& build() const { return build_; }
  [[nodiscard]] std::size_t packets() const { return packets_.size(); }
  [[nodiscard]] std::size_t bytes() const { return bytes_.size(); }

  // The packets of frame `frame` % frames(), where frame >= 0 counts over all loops. Calls emit(packet size in bytes,
  // stamp). emit calls stamp(room), with room for that many bytes, to have the packet written there.
  template <typename Emit>
  void play(std::uint64_t frame, double clocks_per_frame, const Emit& emit) const {
    const Frame& recorded = frames_[static_cast<std::size_t>(frame % frames_.size())];
    for (std::size_t i = recorded.first; i < recorded.first + recorded.packets; ++i) {
      emit(packets_[i].size, [&](std::uint8_t* room) { stamp(i, frame, clocks_per_frame, room); });
    }
  }

 private:
  struct Packet {
    std::size_t begin = 0;
    std::size_t size = 0;
  };
  struct Frame {
    std::uint64_t sequence = 0;  // sequence as recorded
    std::uint32_t encoder = 0;
    std::size_t first = 0;
    std::size_t packets = 0;
  };

  void stamp(std::size_t packet, std::uint64_t frame, double clocks_per_frame, std::uint8_t* room) const;

  std::vector<std::uint8_t> bytes_;
  std::vector<Packet> packets_;  // frame by frame
  std::vector<Frame> frames_;
  model::BoardBuild build_;
};

// Reads a recorded stream to its end. The driver's counts go to `counters`. Throws UserError if the file cannot be read
// or has no good packet.
PacketRecording read_recording(const std::string& file, driver::Counters& counters);

// A line of light that moves over the image, through the model of the board: `frames` images of rows x columns 8-bit
// pixels (peak 200, background 10, standard deviation two pixels, no noise), after which it is back where it began. The
// line's row in column η (from 0) of frame k is
//
//     (rows - 1)/2 + (rows/4) sin(2π (η/columns + k/frames))
//
// Every pixel and moment is thus known. Throws std::invalid_argument if a number is out of the circuit's range.
PacketRecording moving_line(int rows, int columns, int frames, const model::Measure& measure);

// The packets that the model of the board makes of `images` images, image i under pattern i % patterns. The settings
// say their size and what is sent besides the moments; pixels have `pixel_bits`. `image` is asked in order.
PacketRecording recording_of_images(const model::BoardSettings& settings, int pixel_bits, std::size_t images,
                                    int patterns, const std::function<model::SensorView(std::size_t)>& image);

// The registers of a board that plays: settings are taken or refused as a board of that build does; frames and time go
// on. One thread plays, another one accesses.
class PlayedRegisters {
 public:
  explicit PlayedRegisters(double pixel_clock_hz, const model::BoardBuild& build = {})
      : clocks_per_ns_(pixel_clock_hz / 1e9), start_ns_(driver::now_ns()), registers_(build) {}

  // The settings as they are written.
  [[nodiscard]] model::BoardSettings settings() {
    const std::lock_guard lock(mutex_);
    return registers_.settings();
  }

  void set_frames(std::uint64_t frames) { frames_ = static_cast<std::uint32_t>(frames); }

  model::RegisterAnswer access(bool write, std::uint32_t address, std::uint32_t data) {
    const std::lock_guard lock(mutex_);
    if (write) {
      return registers_.write(address, data);
    }
    const double clocks = static_cast<double>(driver::now_ns() - start_ns_) * clocks_per_ns_;
    return registers_.read(address, {.frames = frames_, .time = static_cast<std::uint64_t>(clocks)});
  }

 private:
  double clocks_per_ns_;
  std::int64_t start_ns_;
  std::atomic<std::uint32_t> frames_ = 0;
  std::mutex mutex_;  // of registers_
  model::RegisterFile registers_;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_BOARD_PACKET_RECORDING_H
