// The platform: a camera with real line and frame timing, a conveyor with its encoder, the board, and a bus, in
// SystemC.
//
//     Platform platform(options, frames, packets, expected);  // source of frames, sinks of both kinds of packets
//     platform.run();
//
// Users of this header see nothing of SystemC.
#ifndef SELFPROJ_SIM_PLATFORM_PLATFORM_H
#define SELFPROJ_SIM_PLATFORM_PLATFORM_H

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "selfproj/model/board.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/model/pixel_clock.h"
#include "sim/platform/board_core.h"
#include "sim/platform/camera_timing.h"

namespace selfproj::sim {

enum class PlatformEngine : std::uint8_t { rtl, hls, model };

struct PlatformOptions {
  PlatformEngine engine = PlatformEngine::rtl;
  model::BoardSettings settings = {};  // columns and rows are those of the frames
  int pixel_bits = spec::kPixelBits;   // engine rtl: 8, 10 or 12; the latter without codes and waveforms; hls: 8
  std::vector<model::SectionLimits> limits = {};  // of a verdict, for 15 sections at most; empty: nothing is judged
  double frame_rate_hz = 10000;
  double pixel_clock_hz = model::kDefaultPixelClockHz;
  int patterns = 1;                // 1..256: frame k carries the pattern index k mod patterns (sequencer on_frame)
  double encoder_steps_per_s = 0;  // at most a quarter of the pixel clock; 0: no encoder
  BusOptions bus = {};
  std::uint64_t seed = 1;           // seed of the bus's stalls
  std::uint64_t quantum_lines = 1;  // how far threads run ahead of simulated time; changes nothing but the speed
  std::string trace_file = {};      // FST file; empty: none; engine rtl only
  std::uint64_t trace_from = 1;     // first frame with waveforms, from 1
};

// Whether a Verilated board takes pixels of so many bits.
constexpr bool has_rtl_of(int pixel_bits) { return pixel_bits == 8 || pixel_bits == 10 || pixel_bits == 12; }

// The outcome of a run.
struct PlatformReport {
  std::uint64_t frames = 0;   // frames from the camera
  std::uint64_t packets = 0;  // packets taken by the bus
  std::uint64_t clocks = 0;   // pixel clocks the board ran
  double seconds = 0;         // their duration
  std::uint64_t hold_ups = 0;
  BoardCounters board;
};

// Only one may exist in a process at a time.
class Platform {
 public:
  // The next frame, of the size in the settings and of pixel_bits, valid until the next call; nothing if there are no
  // more.
  using NextFrame = std::function<std::optional<model::SensorView>()>;
  // Receives a packet and the time (in ps) at which its last beat was taken from the bus.
  using PacketSink = std::function<void(std::span<const std::uint8_t> bytes, std::uint64_t time_ps)>;

  // Clock of the first frame's first beat. Before it the host sets the registers, for which it takes longer with limits
  // of a verdict.
  static constexpr std::uint64_t kFirstClock = 4096;

  // `expected`, if given, gets the packets of the model of the board, each before the board's own, with `lost` 0.
  // Throws std::invalid_argument for options without sense, and UserError if the engine is not in this build.
  Platform(const PlatformOptions& options, NextFrame frames, PacketSink packets, model::BoardModel::Sink expected = {});
  Platform(const Platform&) = delete;
  Platform& operator=(const Platform&) = delete;
  ~Platform();

  // Runs until the source has no more frames and every packet is out. May be called only once. Rethrows exceptions of
  // callbacks.
  void run();

  [[nodiscard]] const CameraTiming& timing() const;
  // Available after run().
  [[nodiscard]] PlatformReport report() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_PLATFORM_PLATFORM_H
