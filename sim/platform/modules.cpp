#include "sim/platform/modules.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "selfproj/model/column_moments.h"

// Must come after <systemc>, which it needs and does not include.
#include <tlm_utils/tlm_quantumkeeper.h>

namespace selfproj::sim {
namespace {

// Threads that call foreign code (image files, the Verilated board) need more than SystemC's own stack. Memory is only
// taken as far as it is used.
constexpr std::size_t kStackBytes = std::size_t{8} << 20U;

std::uint64_t clock_of_time(const sc_core::sc_time& time, const sc_core::sc_time& period) {
  return (time.value() + period.value() - 1) / period.value();
}

}  // namespace

void InputMerge::line(const VideoLine& line) {
  std::vector<std::uint16_t> pixels;
  if (!spare_.empty()) {
    pixels = std::move(spare_.back());
    spare_.pop_back();
  }
  pixels.assign(line.pixels.begin(), line.pixels.end());
  lines_.push_back({line.clock, line.frame_start, std::move(pixels)});
}

Camera::Camera(const sc_core::sc_module_name& name, const CameraTiming& timing, std::uint64_t first_clock,
               const sc_core::sc_time& period, Source source)
    : GuardedModule(name), timing_(timing), first_clock_(first_clock), period_(period), source_(std::move(source)) {
  SC_HAS_PROCESS(Camera);
  SC_THREAD(expose);
  set_stack_size(kStackBytes);
}

void Camera::expose() {
  guard([this] {
    const auto promise = [this](std::uint64_t clock) {
      for (int i = 0; i < video.size(); ++i) {
        video[i]->promise_video(clock);
      }
    };
    // Local time is that of the next line.
    tlm_utils::tlm_quantumkeeper local;
    local.reset();
    promise(first_clock_);
    local.inc(time_of_clock(first_clock_, period_));
    local.sync();
    const sc_core::sc_time line_time = time_of_clock(timing_.line_clocks, period_);
    const sc_core::sc_time blank =
        time_of_clock(timing_.frame_clocks - static_cast<std::uint64_t>(timing_.rows) * timing_.line_clocks, period_);
    std::vector<std::uint16_t> pixels(static_cast<std::size_t>(timing_.columns));
    for (std::uint64_t start = first_clock_;; start += timing_.frame_clocks) {
      const std::optional<model::SensorView> image = source_();
      if (!image) {
        break;
      }
      for (int row = 0; row < timing_.rows; ++row) {
        const std::uint64_t clock = start + static_cast<std::uint64_t>(row) * timing_.line_clocks;
        std::visit(
            [&](const auto& view) { std::copy_n(view.pixels + row * view.stride, timing_.columns, pixels.begin()); },
            *image);
        const VideoLine line{.clock = clock, .pixels = pixels, .frame_start = row == 0};
        for (int i = 0; i < video.size(); ++i) {
          video[i]->line(line);
        }
        const bool last = row == timing_.rows - 1;
        promise(last ? start + timing_.frame_clocks : clock + timing_.line_clocks);
        local.inc(last ? line_time + blank : line_time);
        if (local.need_sync()) {
          local.sync();
        }
      }
      ++frames_;
    }
    local.sync();
    finished.write(true);
    promise(kForever);
  });
}

Conveyor::Conveyor(const sc_core::sc_module_name& name, double clocks_a_step, std::uint64_t first_clock,
                   const sc_core::sc_time& period)
    : GuardedModule(name), clocks_a_step_(clocks_a_step), first_clock_(first_clock), period_(period) {
  SC_HAS_PROCESS(Conveyor);
  SC_THREAD(turn);
}

void Conveyor::turn() {
  guard([this] {
    const auto promise = [this](std::uint64_t clock) {
      for (int i = 0; i < encoder.size(); ++i) {
        encoder[i]->promise_encoder(clock);
      }
    };
    if (clocks_a_step_ > 0) {
      tlm_utils::tlm_quantumkeeper local;
      local.reset();
      std::uint64_t now = 0;
      for (std::uint64_t step = 1; !finished.read(); ++step) {
        const std::uint64_t clock =
            first_clock_ + static_cast<std::uint64_t>(std::llround(static_cast<double>(step) * clocks_a_step_));
        promise(clock);
        local.inc(time_of_clock(clock - now, period_));
        now = clock;
        if (local.need_sync()) {
          local.sync();
        }
        const EncoderLevels levels = levels_of_step(step);
        for (int i = 0; i < encoder.size(); ++i) {
          encoder[i]->encoder(clock, levels.a, levels.b);
        }
      }
    }
    promise(kForever);
  });
}

Board::Board(const sc_core::sc_module_name& name, std::unique_ptr<BoardCore> core)
    : GuardedModule(name), core_(std::move(core)) {
  SC_HAS_PROCESS(Board);
  SC_THREAD(run);
  set_stack_size(kStackBytes);
  video.bind(*this);
  encoder_pins.bind(*this);
  bus_ready.bind(*this);
  core_->on_packet([this](std::span<const std::uint8_t> bytes, std::uint64_t time_ps) {
    bus->packet(bytes, sc_core::sc_time(static_cast<double>(time_ps), sc_core::SC_PS));
  });
}

void Board::run() {
  guard([this] {
    for (;;) {
      const std::uint64_t known = std::min({video_until_, encoder_until_, stall_until_});
      inputs_.take(known, *core_);
      if (known == kForever) {
        break;
      }
      core_->run_to(known);
      // A core with modules of its own lets others run meanwhile. Do not wait again for their promises.
      if (std::min({video_until_, encoder_until_, stall_until_}) == known) {
        wait(promised_);
      }
    }
    core_->drain();
  });
}

BusSink::BusSink(const sc_core::sc_module_name& name, const BusOptions& options, std::uint64_t seed,
                 const sc_core::sc_time& pixel_period, Receiver receiver)
    : GuardedModule(name),
      options_(options),
      pixel_period_(pixel_period),
      random_(seed),
      receiver_(std::move(receiver)) {
  SC_HAS_PROCESS(BusSink);
  SC_THREAD(deliver);
  set_stack_size(kStackBytes);
  SC_THREAD(hold_up);
  bus.bind(*this);
}

void BusSink::packet(std::span<const std::uint8_t> bytes, const sc_core::sc_time& time) {
  waiting_.push_back({time, {bytes.begin(), bytes.end()}});
  arrived_.notify(sc_core::SC_ZERO_TIME);
}

void BusSink::deliver() {
  guard([this] {
    for (;;) {
      while (waiting_.empty()) {
        wait(arrived_);
      }
      const Packet packet = std::move(waiting_.front());
      waiting_.pop_front();
      if (packet.time > sc_core::sc_time_stamp()) {
        wait(packet.time - sc_core::sc_time_stamp());
      }
      ++packets_;
      receiver_(packet.bytes, packet.time.value());
    }
  });
}

// Sometimes nothing is taken for a while, as with an interrupt or another master on the bus.
void BusSink::hold_up() {
  guard([this] {
    const auto clocks = [&](double seconds) {
      return sc_core::sc_time::from_value(
          std::max<std::uint64_t>(
              1, static_cast<std::uint64_t>(seconds * 1e12 / static_cast<double>(options_.period_ps))) *
          options_.period_ps);
    };
    // Announces the state from a time on, and sleeps until then.
    sc_core::sc_time then = sc_core::SC_ZERO_TIME;
    const auto pass = [&](double seconds) {
      then += clocks(seconds);
      ready->promise_stall(clock_of_time(then, pixel_period_));
      wait(then - sc_core::sc_time_stamp());
    };
    if (options_.hold_ups_a_second > 0) {
      std::exponential_distribution<double> pause(options_.hold_ups_a_second);
      std::uniform_real_distribution<double> duration(0, options_.hold_up_s);
      while (!finished.read()) {
        pass(pause(random_));
        ready->stall(clock_of_time(then, pixel_period_), 100);
        pass(duration(random_));
        ready->stall(clock_of_time(then, pixel_period_), options_.stall_percent);
        ++hold_ups_;
      }
    }
    ready->promise_stall(kForever);
  });
}

ReferenceModel::ReferenceModel(const sc_core::sc_module_name& name, const model::BoardSettings& settings,
                               std::span<const model::SectionLimits> limits, int patterns, int pixel_bits,
                               model::BoardModel::Sink sink)
    : sc_module(name), feed_(std::move(sink), patterns, pixel_bits) {
  feed_.write(settings, limits);
  video.bind(*this);
  encoder_pins.bind(*this);
}

void ReferenceModel::promise_video(std::uint64_t clock) {
  video_until_ = clock;
  feed();
}

void ReferenceModel::promise_encoder(std::uint64_t clock) {
  encoder_until_ = clock;
  feed();
}

void ReferenceModel::feed() {
  struct To {
    ModelFeed& feed;
    void line(std::uint64_t clock, std::span<const std::uint16_t> pixels, bool frame_start) const {
      feed.line(clock, pixels, frame_start);
    }
    void encoder(std::uint64_t /*clock*/, bool a, bool b) const { feed.encoder(a, b); }
    static void stall(std::uint64_t /*clock*/, int /*percent*/) {}
  };
  inputs_.take(std::min(video_until_, encoder_until_), To{feed_});
}

}  // namespace selfproj::sim
