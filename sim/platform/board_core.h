// The implementation inside the platform's board: the Verilated RTL, or the model with plausible timing.
//
// The caller gives a core its inputs in the order of their clocks, ahead of the core's own time, and then runs it up to
// a clock. This interface does not use SystemC.
#ifndef SELFPROJ_SIM_PLATFORM_BOARD_CORE_H
#define SELFPROJ_SIM_PLATFORM_BOARD_CORE_H

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "selfproj/model/board.h"
#include "selfproj/model/pixel_clock.h"
#include "selfproj/model/verdict.h"

namespace selfproj::sim {

// A bus with its own clock.
struct BusOptions {
  std::uint64_t period_ps = 8000;  // 125 MHz
  std::uint64_t phase_ps = 1234;
  int stall_percent = 0;         // share of bus clocks in which the sink is not ready, 0..95
  double hold_ups_a_second = 0;  // how often the sink takes nothing at all ...
  double hold_up_s = 0;          // ... for up to this long
};

struct BoardCoreOptions {
  double pixel_clock_hz = model::kDefaultPixelClockHz;
  BusOptions bus = {};
  std::uint64_t seed = 1;  // seed of the stalls
  int patterns = 1;        // the sequencer counts frames modulo this
  bool codes = false;      // build with the Gray-code decoder, for images up to 512 x 512; binary moments only
  // build with the strongest runs, compact columns and verdicts; not with codes, a trace file or SystemC shells
  bool runs = false;
  // more than 8: a build with runs; the RTL has 10 and 12
  int pixel_bits = spec::kPixelBits;
  std::string trace_file;  // FST file; empty: none; engine rtl only
  std::uint64_t trace_from_clock = 0;
};

// The board's own counters, read from its registers at the end.
struct BoardCounters {
  std::uint64_t frames = 0;        // frame starts accepted
  std::uint64_t broken = 0;        // frames that broke
  std::uint64_t stray = 0;         // beats outside any frame
  std::uint64_t lost_moments = 0;  // packets lost in full FIFOs
  std::uint64_t lost_image = 0;
  std::uint64_t lost_codes = 0;
  std::uint64_t abandoned = 0;  // good frames after which the decoder waits for plane 0
};

class BoardCore {
 public:
  // Receives a packet and the time at which its last beat was taken, in picoseconds since the edge of clock 0.
  using PacketSink = std::function<void(std::span<const std::uint8_t> bytes, std::uint64_t time_ps)>;

  BoardCore() = default;
  BoardCore(const BoardCore&) = delete;
  BoardCore& operator=(const BoardCore&) = delete;
  virtual ~BoardCore() = default;

  virtual void on_packet(PacketSink sink) = 0;

  // Sets the registers as the host does; takes some hundred clocks, with limits of a verdict for each of them some
  // dozens. Throws std::runtime_error if the board refuses.
  virtual void write(const model::BoardSettings& settings, std::span<const model::SectionLimits> limits) = 0;

  // The number of the next clock edge.
  [[nodiscard]] virtual std::uint64_t clock() const = 0;

  // Inputs. None may be before clock(), and each must be at the clock of the last one or later. The clock of a line is
  // that of its first beat.
  virtual void line(std::uint64_t clock, std::span<const std::uint16_t> pixels, bool frame_start) = 0;
  virtual void encoder(std::uint64_t clock, bool a, bool b) = 0;
  virtual void stall(std::uint64_t clock, int percent) = 0;

  // Runs up to this clock, not including it. A clock in the past is not an error.
  virtual void run_to(std::uint64_t clock) = 0;

  // Runs until no packet is on its way. The sink must not stall forever.
  virtual void drain() = 0;

  [[nodiscard]] virtual BoardCounters counters() = 0;
};

// The model of the board. Its packets are the RTL's, byte for byte, as long as the RTL loses none. They come within
// some clocks of the RTL's times, from FIFOs that are never full.
std::unique_ptr<BoardCore> make_model_core(const BoardCoreOptions& options);

// The two below are defined only if SELFPROJ_HAS_RTL_PLATFORM is. A program gets them from the object library
// selfproj_sim_rtl_cores, or from selfproj_sim_demo_core, which has only the board with default parameters and throws
// UserError for the others.

// The Verilated board. A trace file selects the build with waveforms, which is slower from the first clock on.
std::unique_ptr<BoardCore> make_rtl_core(const BoardCoreOptions& options);

// The same board with SystemC shells (hls/shells) in place of blocks: decoder and median with codes, else the column
// moments. Their kernel must be running when beats come.
std::unique_ptr<BoardCore> make_hls_core(const BoardCoreOptions& options);

// The model of the board behind the platform's inputs, which are lines and encoder levels, not beats.
class ModelFeed {
 public:
  // Frame k has the pattern index k mod patterns.
  explicit ModelFeed(model::BoardModel::Sink sink, int patterns = 1, int pixel_bits = spec::kPixelBits)
      : model_(std::move(sink), true, pixel_bits), patterns_(static_cast<std::uint64_t>(patterns)) {}

  void write(const model::BoardSettings& settings, std::span<const model::SectionLimits> limits) {
    if (!limits.empty()) {
      constexpr int kSections = 64;
      verdict_ = std::make_unique<model::Verdict>(spec::kMaxColumns, kSections);
      verdict_->write(settings.verdict_settings.bank, limits);
      model_.judge_with(*verdict_);
    }
    model_.write(settings);
  }

  // A line of beats from `clock` on. Packets that it completes go to the sink.
  void line(std::uint64_t clock, std::span<const std::uint16_t> pixels, bool frame_start) {
    model::VideoBeat beat;
    beat.start = frame_start;
    for (std::size_t at = 0; at < pixels.size(); at += spec::kPixelsPerBeat) {
      std::copy_n(pixels.data() + at, spec::kPixelsPerBeat, beat.pixels.begin());
      beat.line_end = at + spec::kPixelsPerBeat == pixels.size();
      clock_ = clock++;
      const auto pattern = static_cast<std::uint16_t>(model_.frames() % patterns_);
      model_.beat({.clock = clock_, .encoder = count_, .pattern = pattern}, beat);
      beat.start = false;
    }
  }

  // New levels of the encoder: one step forward if A leads, back if B does.
  void encoder(bool a, bool b) {
    constexpr std::array<unsigned, 4> kPhase{0, 1, 3, 2};  // phase of the levels b a
    const unsigned phase = kPhase[(a ? 1U : 0U) | (b ? 2U : 0U)];
    const unsigned step = (phase - phase_) & 3U;
    count_ += step == 1 ? 1U : step == 3 ? ~0U : 0U;
    phase_ = phase;
  }

  // The clock of the last beat.
  [[nodiscard]] std::uint64_t clock() const { return clock_; }
  [[nodiscard]] const model::BoardModel& model() const { return model_; }

 private:
  std::unique_ptr<model::Verdict> verdict_;
  model::BoardModel model_;
  std::uint64_t patterns_;
  std::uint64_t clock_ = 0;
  unsigned phase_ = 0;
  std::uint32_t count_ = 0;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_PLATFORM_BOARD_CORE_H
