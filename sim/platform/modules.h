// The interfaces between the modules of the platform.
//
// Time is decoupled. A module that drives an input of the board announces events ahead of simulated time, each with the
// number of its pixel clock, and promises up to which clock it has announced everything. The board runs up to the
// smallest promise and no further, so that no input ever comes too late. The result is the same, clock for clock,
// whatever the quantum is and in whatever order the kernel wakes the threads. A module sleeps at most until the time it
// has promised, so no promise is ever behind simulated time.
#ifndef SELFPROJ_SIM_PLATFORM_MODULES_H
#define SELFPROJ_SIM_PLATFORM_MODULES_H

#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <systemc>
#include <utility>
#include <vector>

#include "selfproj/model/board.h"
#include "selfproj/model/column_moments.h"
#include "sim/platform/board_core.h"
#include "sim/platform/camera_timing.h"

namespace selfproj::sim {

// A promise beyond any clock: nothing more will come.
inline constexpr std::uint64_t kForever = std::numeric_limits<std::uint64_t>::max();

// One line of the camera: a beat of four pixels each clock, from `clock` on.
struct VideoLine {
  std::uint64_t clock = 0;
  std::span<const std::uint16_t> pixels;  // a multiple of 4 pixels; valid during the call
  bool frame_start = false;               // tuser with the first beat
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

// The modules of the platform. platform.h puts them together.

// Merges the inputs of several modules, each in the order of its clocks, into the order of all clocks.
class InputMerge {
 public:
  void line(const VideoLine& line);
  void encoder(std::uint64_t clock, bool a, bool b) { encoder_.push_back({clock, a, b}); }
  void stall(std::uint64_t clock, int percent) { stalls_.push_back({clock, percent}); }

  // Passes everything before `end` to `to` (line, encoder, stall as in BoardCore). At equal clocks lines come last.
  template <class To>
  void take(std::uint64_t end, To&& to) {
    for (;;) {
      const std::uint64_t stall = stalls_.empty() ? kForever : stalls_.front().clock;
      const std::uint64_t encoder = encoder_.empty() ? kForever : encoder_.front().clock;
      const std::uint64_t line = lines_.empty() ? kForever : lines_.front().clock;
      if (stall < end && stall <= encoder && stall <= line) {
        to.stall(stall, stalls_.front().percent);
        stalls_.pop_front();
      } else if (encoder < end && encoder <= line) {
        to.encoder(encoder, encoder_.front().a, encoder_.front().b);
        encoder_.pop_front();
      } else if (line < end) {
        to.line(line, lines_.front().pixels, lines_.front().frame_start);
        spare_.push_back(std::move(lines_.front().pixels));
        lines_.pop_front();
      } else {
        return;
      }
    }
  }

 private:
  struct Line {
    std::uint64_t clock;
    bool frame_start;
    std::vector<std::uint16_t> pixels;
  };
  struct Encoder {
    std::uint64_t clock;
    bool a, b;
  };
  struct Stall {
    std::uint64_t clock;
    int percent;
  };

  std::deque<Line> lines_;
  std::vector<std::vector<std::uint16_t>> spare_;  // kept for reuse
  std::deque<Encoder> encoder_;
  std::deque<Stall> stalls_;
};

// A module whose threads call code that may throw. SystemC would turn an exception into a message of its own. Here the
// first exception is kept, the simulation stops, and Platform::run rethrows it.
class GuardedModule : public sc_core::sc_module {
 public:
  using sc_core::sc_module::sc_module;
  [[nodiscard]] const std::exception_ptr& failure() const { return failure_; }

 protected:
  template <class Body>
  void guard(Body body) {
    try {
      body();
    } catch (const sc_core::sc_unwind_exception&) {
      throw;  // the kernel ends the thread
    } catch (...) {
      failure_ = std::current_exception();
      sc_core::sc_stop();
    }
  }

 private:
  std::exception_ptr failure_;
};

// Sends the frames of a source, line by line, each at its time.
class Camera : public GuardedModule {
 public:
  // The next frame, valid until the next call; nothing if there are no more.
  using Source = std::function<std::optional<model::SensorView>()>;

  sc_core::sc_port<VideoInterface, 2> video{"video"};
  sc_core::sc_out<bool> finished{"finished"};  // after the last frame

  // The first frame's first beat is at `first_clock`.
  Camera(const sc_core::sc_module_name& name, const CameraTiming& timing, std::uint64_t first_clock,
         const sc_core::sc_time& period, Source source);

  [[nodiscard]] std::uint64_t frames() const { return frames_; }

 private:
  void expose();

  CameraTiming timing_;
  std::uint64_t first_clock_;
  sc_core::sc_time period_;
  Source source_;
  std::uint64_t frames_ = 0;
};

// The belt. Its encoder turns one step every given number of clocks (at least 4; 0: it stands still).
class Conveyor : public GuardedModule {
 public:
  sc_core::sc_port<EncoderInterface, 2> encoder{"encoder"};
  sc_core::sc_in<bool> finished{"finished"};

  Conveyor(const sc_core::sc_module_name& name, double clocks_a_step, std::uint64_t first_clock,
           const sc_core::sc_time& period);

 private:
  void turn();

  double clocks_a_step_;
  std::uint64_t first_clock_;
  sc_core::sc_time period_;
};

// The board: runs its core as far as all inputs are known, and sends packets with their times.
class Board : public GuardedModule, public VideoInterface, public EncoderInterface, public BusReadyInterface {
 public:
  sc_core::sc_export<VideoInterface> video{"video"};
  sc_core::sc_export<EncoderInterface> encoder_pins{"encoder_pins"};
  sc_core::sc_export<BusReadyInterface> bus_ready{"bus_ready"};
  sc_core::sc_port<PacketInterface> bus{"bus"};

  // `core` has its registers set and has not reached the first input yet.
  Board(const sc_core::sc_module_name& name, std::unique_ptr<BoardCore> core);

  void line(const VideoLine& line) override { inputs_.line(line); }
  void promise_video(std::uint64_t clock) override { promise(video_until_, clock); }
  void encoder(std::uint64_t clock, bool a, bool b) override { inputs_.encoder(clock, a, b); }
  void promise_encoder(std::uint64_t clock) override { promise(encoder_until_, clock); }
  void stall(std::uint64_t clock, int percent) override { inputs_.stall(clock, percent); }
  void promise_stall(std::uint64_t clock) override { promise(stall_until_, clock); }

  [[nodiscard]] BoardCore& core() { return *core_; }

 private:
  void promise(std::uint64_t& until, std::uint64_t clock) {
    until = clock;
    promised_.notify(sc_core::SC_ZERO_TIME);
  }
  void run();

  std::unique_ptr<BoardCore> core_;
  InputMerge inputs_;
  std::uint64_t video_until_ = 0;
  std::uint64_t encoder_until_ = 0;
  std::uint64_t stall_until_ = 0;
  sc_core::sc_event promised_;
};

// The receiving end of the bus, with its own clock. Passes every packet on at the time of its last beat.
class BusSink : public GuardedModule, public PacketInterface {
 public:
  using Receiver = std::function<void(std::span<const std::uint8_t> bytes, std::uint64_t time_ps)>;

  sc_core::sc_export<PacketInterface> bus{"bus"};
  sc_core::sc_port<BusReadyInterface> ready{"ready"};
  sc_core::sc_in<bool> finished{"finished"};

  BusSink(const sc_core::sc_module_name& name, const BusOptions& options, std::uint64_t seed,
          const sc_core::sc_time& pixel_period, Receiver receiver);

  void packet(std::span<const std::uint8_t> bytes, const sc_core::sc_time& time) override;

  [[nodiscard]] std::uint64_t packets() const { return packets_; }
  [[nodiscard]] std::uint64_t hold_ups() const { return hold_ups_; }

 private:
  struct Packet {
    sc_core::sc_time time;
    std::vector<std::uint8_t> bytes;
  };

  void deliver();
  void hold_up();

  BusOptions options_;
  sc_core::sc_time pixel_period_;
  std::mt19937_64 random_;
  Receiver receiver_;
  std::deque<Packet> waiting_;
  sc_core::sc_event arrived_;
  std::uint64_t packets_ = 0;
  std::uint64_t hold_ups_ = 0;
};

// Feeds the model of the board with the board's inputs, and keeps the model's packets until the board's are compared
// with them.
class ReferenceModel : public sc_core::sc_module, public VideoInterface, public EncoderInterface {
 public:
  sc_core::sc_export<VideoInterface> video{"video"};
  sc_core::sc_export<EncoderInterface> encoder_pins{"encoder_pins"};

  ReferenceModel(const sc_core::sc_module_name& name, const model::BoardSettings& settings,
                 std::span<const model::SectionLimits> limits, int patterns, int pixel_bits,
                 model::BoardModel::Sink sink);

  void line(const VideoLine& line) override { inputs_.line(line); }
  void promise_video(std::uint64_t clock) override;
  void encoder(std::uint64_t clock, bool a, bool b) override { inputs_.encoder(clock, a, b); }
  void promise_encoder(std::uint64_t clock) override;

 private:
  void feed();

  ModelFeed feed_;
  InputMerge inputs_;
  std::uint64_t video_until_ = 0;
  std::uint64_t encoder_until_ = 0;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_PLATFORM_MODULES_H
