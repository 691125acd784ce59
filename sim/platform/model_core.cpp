// The model of the board with nearly the RTL's timing: packets come out a fixed latency after the last beat, and then
// on average with one beat in every bus clock in which the sink is ready.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "selfproj/model/board.h"
#include "selfproj/model/packet.h"
#include "selfproj/model/pixel_clock.h"
#include "sim/platform/board_core.h"

namespace selfproj::sim {
namespace {

class ModelCore final : public BoardCore {
 public:
  explicit ModelCore(const BoardCoreOptions& options)
      : clock_ps_(model::pixel_clock_period_ps(options.pixel_clock_hz)),
        bus_period_(static_cast<double>(options.bus.period_ps)),
        stall_percent_(options.bus.stall_percent),
        feed_([this](model::BoardPacket&& packet) { take(packet); }, options.patterns, options.pixel_bits) {}

  void on_packet(PacketSink sink) override { sink_ = std::move(sink); }

  void write(const model::BoardSettings& settings, std::span<const model::SectionLimits> limits) override {
    clock_ += kWriteClocks;
    feed_.write(settings, limits);
  }

  [[nodiscard]] std::uint64_t clock() const override { return clock_; }

  void line(std::uint64_t clock, std::span<const std::uint16_t> pixels, bool frame_start) override {
    feed_.line(clock, pixels, frame_start);
  }
  void encoder(std::uint64_t /*clock*/, bool a, bool b) override { feed_.encoder(a, b); }
  void stall(std::uint64_t clock, int percent) override {
    run_bus(time_ps(clock));
    stall_percent_ = percent;
  }

  void run_to(std::uint64_t clock) override {
    clock_ = std::max(clock_, clock);
    run_bus(time_ps(clock_));
  }

  void drain() override {
    while (!waiting_.empty()) {
      run_to(clock_ + kWriteClocks);
    }
  }

  [[nodiscard]] BoardCounters counters() override {
    const model::BoardModel& model = feed_.model();
    return {.frames = model.frames(), .broken = model.broken(), .stray = model.stray(), .abandoned = model.abandoned()};
  }

 private:
  struct Waiting {
    std::vector<std::uint8_t> bytes;
    double ready_ps;  // when its first beat can be on the bus
    double beats;     // beats still to be taken
  };

  static constexpr std::uint64_t kWriteClocks = 200;

  [[nodiscard]] double time_ps(std::uint64_t clock) const { return static_cast<double>(clock * clock_ps_); }

  // Clocks from the last beat of a frame until the whole packet is in its FIFO and visible to the bus.
  static double latency(const model::PacketHeader& header) {
    constexpr double kBinary = 20;
    const double groups = header.columns / 4.0;
    return static_cast<model::Mode>(header.mode) == model::Mode::binary ? kBinary : kBinary + groups + 5;
  }

  void take(const model::BoardPacket& packet) {
    Waiting next;
    model::append_packet(packet.header, packet.payload, packet.status, next.bytes);
    next.ready_ps = time_ps(feed_.clock()) + latency(packet.header) * static_cast<double>(clock_ps_);
    next.beats = static_cast<double>(next.bytes.size()) / static_cast<double>(spec::kPacketBeatBytes);
    waiting_.push_back(std::move(next));
  }

  // Lets the bus take packets up to a time.
  void run_bus(double end) {
    while (!waiting_.empty() && stall_percent_ < 100) {
      Waiting& next = waiting_.front();
      const double start = std::max(bus_ps_, next.ready_ps);
      const double beat = bus_period_ * 100 / (100 - stall_percent_);
      if (start >= end) {
        break;
      }
      const double done = start + next.beats * beat;
      if (done > end) {
        next.beats -= (end - start) / beat;
        next.ready_ps = end;
        break;
      }
      bus_ps_ = done;
      // The callback must find the queue, like the model, in a consistent state.
      const Waiting out = std::move(next);
      waiting_.pop_front();
      if (sink_) {
        sink_(out.bytes, static_cast<std::uint64_t>(std::llround(done)));
      }
    }
    bus_ps_ = std::max(bus_ps_, end);
  }

  std::uint64_t clock_ps_;
  double bus_period_;
  int stall_percent_;
  ModelFeed feed_;
  PacketSink sink_;
  std::deque<Waiting> waiting_;
  std::uint64_t clock_ = 0;
  double bus_ps_ = 0;  // time up to which the bus has run
};

}  // namespace

std::unique_ptr<BoardCore> make_model_core(const BoardCoreOptions& options) {
  return std::make_unique<ModelCore>(options);
}

}  // namespace selfproj::sim
