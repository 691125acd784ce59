// The platform: a camera with real line and frame timing, a conveyor with its encoder, the board, and a bus, in
// SystemC.
//
//     Platform platform(options, frames, packets, expected);  // where frames come from, packets and the model's go
//     platform.run();
//
// SystemC itself does not show through this header.
#ifndef SELFPROJ_SIM_PLATFORM_PLATFORM_H
#define SELFPROJ_SIM_PLATFORM_PLATFORM_H

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "model/board.h"
#include "model/column_moments.h"
#include "model/pixel_clock.h"
#include "sim/platform/board_core.h"
#include "sim/platform/camera_timing.h"

namespace selfproj {

enum class PlatformEngine : std::uint8_t { rtl, hls, model };

struct PlatformOptions {
  PlatformEngine engine = PlatformEngine::rtl;
  BoardSettings settings = {};  // columns and rows are those of the frames
  double frame_rate_hz = 10000;
  double pixel_clock_hz = kDefaultPixelClockHz;
  int patterns = 1;                // 1..256: frame k carries the pattern index k mod patterns (sequencer on_frame)
  double encoder_steps_per_s = 0;  // at most a quarter of the pixel clock; 0: no encoder
  BusOptions bus = {};
  std::uint64_t seed = 1;           // of the bus's stalls
  std::uint64_t quantum_lines = 1;  // how far threads run ahead of simulated time; changes nothing but the speed
  std::string trace_file = {};      // FST; empty: none. Engine rtl only
  std::uint64_t trace_from = 1;     // frame, from 1
};

// What a run was.
struct PlatformReport {
  std::uint64_t frames = 0;   // that the camera gave
  std::uint64_t packets = 0;  // that the bus took
  std::uint64_t clocks = 0;   // pixel clocks the board ran
  double seconds = 0;         // what they last
  std::uint64_t hold_ups = 0;
  BoardCounters board;
};

// One at a time can live in a process.
class Platform {
 public:
  // The next frame, of the size in the settings, valid until the next call; nothing: there are no more.
  using NextFrame = std::function<std::optional<ImageView>()>;
  // A packet, at the time (in ps) its last beat was taken from the bus.
  using PacketSink = std::function<void(std::span<const std::uint8_t> bytes, std::uint64_t time_ps)>;

  // Clock of the first frame's first beat; until then the host sets the registers.
  static constexpr std::uint64_t kFirstClock = 4096;

  // `expected`, where given, gets the packets of the model of the board, each before the board's own, with `lost` 0.
  // Throws std::invalid_argument where the options make no sense, UserError where the engine is not in this build.
  Platform(const PlatformOptions& options, NextFrame frames, PacketSink packets, BoardModel::Sink expected = {});
  Platform(const Platform&) = delete;
  Platform& operator=(const Platform&) = delete;
  ~Platform();

  // Runs until the source has no more frames and every packet is out. Once only. What a callback throws comes out here.
  void run();

  [[nodiscard]] const CameraTiming& timing() const;
  // After run().
  [[nodiscard]] PlatformReport report() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_PLATFORM_PLATFORM_H
