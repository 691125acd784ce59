// The interfaces between the modules of the platform.
//
// Time is decoupled. A module that drives an input of the board announces events ahead of simulated time, each with the
// number of its pixel clock, and promises up to which clock it has announced everything. The board runs up to the
// smallest promise and no further, so that no input ever comes too late. The result is the same, clock for clock,
// whatever the quantum is and in whatever order the kernel wakes the threads. A module sleeps at most until the time it
// has promised, so no promise is ever behind simulated time.
#ifndef SELFPROJ_SIM_PLATFORM_INTERFACES_H
#define SELFPROJ_SIM_PLATFORM_INTERFACES_H

#include <cstdint>
#include <limits>
#include <span>
#include <systemc>

namespace selfproj {

// A promise beyond any clock: nothing more will come.
inline constexpr std::uint64_t kForever = std::numeric_limits<std::uint64_t>::max();

// One line of the camera: a beat of four pixels each clock, from `clock` on.
struct VideoLine {
  std::uint64_t clock = 0;
  std::span<const std::uint8_t> pixels;  // a multiple of 4 pixels; valid during the call
  bool frame_start = false;              // tuser with the first beat
};

// The board's AXI4-Stream video input. It cannot refuse, because the camera is never stalled.
class VideoInterface : public virtual sc_core::sc_interface {
 public:
  // A line that begins after the last one has ended.
  virtual void line(const VideoLine& line) = 0;
  // Promises that every line that begins before this clock has been announced.
  virtual void promise_video(std::uint64_t clock) = 0;
};

// The board's encoder pins.
class EncoderInterface : public virtual sc_core::sc_interface {
 public:
  // New levels at the pins from this clock's edge on; at least four clocks after the last ones.
  virtual void encoder(std::uint64_t clock, bool a, bool b) = 0;
  virtual void promise_encoder(std::uint64_t clock) = 0;
};

// How often the bus is ready: m_axis_tready.
class BusReadyInterface : public virtual sc_core::sc_interface {
 public:
  // From this pixel clock on the sink is not ready in `percent` percent of its clocks, 0..100.
  virtual void stall(std::uint64_t clock, int percent) = 0;
  virtual void promise_stall(std::uint64_t clock) = 0;
};

// The receiving end of the bus.
class PacketInterface : public virtual sc_core::sc_interface {
 public:
  // A whole packet whose last beat is taken at `time`, now or later. Packets come in the order of their times.
  virtual void packet(std::span<const std::uint8_t> bytes, const sc_core::sc_time& time) = 0;
};

// The one place that relates clocks to time: clock n is at n periods.
inline sc_core::sc_time time_of_clock(std::uint64_t clock, const sc_core::sc_time& period) {
  return sc_core::sc_time::from_value(clock * period.value());
}

}  // namespace selfproj

#endif  // SELFPROJ_SIM_PLATFORM_INTERFACES_H
