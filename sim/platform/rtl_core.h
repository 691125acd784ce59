// A Verilated board as a core of the platform.
#ifndef SELFPROJ_SIM_PLATFORM_RTL_CORE_H
#define SELFPROJ_SIM_PLATFORM_RTL_CORE_H

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <utility>

#include "selfproj/model/pixel_clock.h"
#include "sim/board/board_device.h"
#include "sim/platform/board_core.h"

namespace selfproj::sim {

// `Model` is the class that Verilator made of sp_board with some parameters (sim/board/CMakeLists.txt).
template <class Model>
class RtlCore : public BoardCore {
 public:
  explicit RtlCore(const BoardCoreOptions& options)
      : device_({.seed = options.seed,
                 .video_period_ps = model::pixel_clock_period_ps(options.pixel_clock_hz),
                 .bus_period_ps = options.bus.period_ps,
                 .bus_phase_ps = options.bus.phase_ps,
                 .pixel_bits = options.pixel_bits,
                 .bus_stall_percent = options.bus.stall_percent,
                 .trace_file = options.trace_file}),
        codes_(options.codes),
        patterns_(options.patterns),
        trace_from_(options.trace_file.empty() ? kNever : options.trace_from_clock) {
    device_.run(1);
    origin_ps_ = device_.time_ps();
    queue_end_ = device_.clock();
  }

  void on_packet(PacketSink sink) override {
    device_.on_packet([this, sink = std::move(sink)](std::span<const std::uint8_t> bytes) {
      sink(bytes, device_.time_ps() - origin_ps_);
    });
  }

  void write(const model::BoardSettings& settings, std::span<const model::SectionLimits> limits) override {
    if (!limits.empty()) {
      device_.write_limits(settings.verdict_settings.bank, limits);
    }
    if (patterns_ > 1) {
      device_.write(spec::kRegTriggerControl,
                    1U << spec::kRegTriggerControlOnFrameLsb | static_cast<std::uint32_t>(patterns_ - 1)
                                                                   << spec::kRegTriggerControlLastPatternLsb);
    }
    device_.write(settings);
    queue_end_ = device_.clock();
  }

  [[nodiscard]] std::uint64_t clock() const override { return device_.clock(); }

  void line(std::uint64_t clock, std::span<const std::uint16_t> pixels, bool frame_start) override {
    wait_until(clock);
    model::VideoBeat beat;
    beat.start = frame_start;
    for (std::size_t at = 0; at < pixels.size(); at += spec::kPixelsPerBeat) {
      std::copy_n(pixels.data() + at, spec::kPixelsPerBeat, beat.pixels.begin());
      beat.line_end = at + spec::kPixelsPerBeat == pixels.size();
      device_.send(beat);
      beat.start = false;
    }
    queue_end_ = clock + pixels.size() / spec::kPixelsPerBeat;
  }

  void encoder(std::uint64_t clock, bool a, bool b) override {
    run_to(clock);
    device_.set_encoder(a, b);
  }

  void stall(std::uint64_t clock, int percent) override {
    run_to(clock);
    device_.set_bus_stall_percent(percent);
  }

  void run_to(std::uint64_t clock) override {
    if (trace_from_ < clock) {
      run_device_to(trace_from_);
      device_.start_trace();
      trace_from_ = kNever;
    }
    run_device_to(clock);
  }

  void drain() override { device_.drain(); }

  [[nodiscard]] BoardCounters counters() override {
    return {.frames = device_.read(spec::kRegFrames),
            .broken = device_.read(spec::kRegBroken),
            .stray = device_.read(spec::kRegStray),
            .lost_moments = device_.read(spec::kRegLostMoments),
            .lost_image = device_.read(spec::kRegLostImage),
            .lost_codes = codes_ ? device_.read(spec::kRegLostCodes) : 0,
            .abandoned = codes_ ? device_.read(spec::kRegAbandoned) : 0};
  }

 private:
  static constexpr std::uint64_t kNever = ~std::uint64_t{0};

  void run_device_to(std::uint64_t clock) {
    if (device_.clock() < clock) {
      device_.run(clock - device_.clock());
    }
  }

  // Queues clocks without a beat, from the end of the queue up to this clock.
  void wait_until(std::uint64_t clock) {
    const std::uint64_t from = std::max(queue_end_, device_.clock());
    if (clock < from) {
      throw std::logic_error("a line begins before the last one ends, or in the past");
    }
    device_.gap(static_cast<std::uint32_t>(clock - from));
  }

  BoardDevice<Model> device_;
  bool codes_;
  int patterns_;
  std::uint64_t trace_from_;
  std::uint64_t origin_ps_ = 0;
  std::uint64_t queue_end_ = 0;  // clock at which everything queued has been sent
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_PLATFORM_RTL_CORE_H
