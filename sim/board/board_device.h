// The Verilated board with a world at its ports: a camera that is never stalled, a bus that may be, a host at the
// registers, an encoder, two unrelated clocks, and waveforms of a window of time.
//
//     BoardDevice<Vboard> board({.bus_period_ps = 8000});
//     board.on_packet([](std::span<const std::uint8_t> bytes) { ... });
//     board.write(spec::kRegControl, 1);
//     board.send(image);            // queues the frame's beats
//     board.drain();                // runs until all beats are in and no packet is under way
//
// Everything random depends on the seed in the options.
#ifndef SELFPROJ_SIM_BOARD_BOARD_DEVICE_H
#define SELFPROJ_SIM_BOARD_BOARD_DEVICE_H

#include <verilated.h>
#include <verilated_fst_c.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "model/register_file.h"
#include "selfproj/model/board.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/model/packet.h"
#include "selfproj/model/pixel_clock.h"
#include "selfproj/model/verdict.h"
#include "sim/board/clocks.h"
#include "sim/board/verilated_model.h"

namespace selfproj::sim {

struct BoardDeviceOptions {
  std::uint64_t seed = 1;
  std::uint64_t video_period_ps = model::pixel_clock_period_ps(model::kDefaultPixelClockHz);
  std::uint64_t bus_period_ps = 8000;  // 125 MHz
  std::uint64_t bus_phase_ps = 1234;
  int pixel_bits = spec::kPixelBits;  // of the build
  int lanes = spec::kPixelsPerBeat;   // likewise: pixels in a beat
  int bus_stall_percent = 0;          // share of bus clocks in which the sink is not ready
  int video_gap_percent = 0;          // share of video clocks without a beat while beats are waiting
  std::string trace_file = {};        // FST file; only if the model was built with TRACE
};

template <class Model>
class BoardDevice {
 public:
  using PacketSink = std::function<void(std::span<const std::uint8_t>)>;
  // Called before each video clock with its number; may set the encoder's lines.
  using ClockHook = std::function<void(std::uint64_t clock)>;
  // Called with every beat that the board takes, and the number of its clock.
  using BeatHook = std::function<void(std::uint64_t clock, const model::VideoBeat& beat)>;

  explicit BoardDevice(BoardDeviceOptions options = {})
      : options_(std::move(options)),
        simulation_([] { return std::make_unique<Simulation>(); }),
        model_(&simulation_->model),
        random_(options_.seed),
        clocks_(options_.video_period_ps, options_.bus_period_ps, options_.bus_phase_ps) {
    choose_mutant(*model_);
    model_->clk_i = 0;
    model_->bus_clk_i = 0;
    set_encoder(false, false);
    model_->eval();
    reset();
  }

  BoardDevice(const BoardDevice&) = delete;
  BoardDevice& operator=(const BoardDevice&) = delete;
  ~BoardDevice() { stop_trace(); }

  // Applies both resets for eight clocks each, drops all queued beats, and counts clocks from zero again.
  void reset() {
    beats_.clear();
    packet_.clear();
    settings_ = model::BoardSettings{};
    model_->rst_i = 1;
    model_->bus_rst_i = 1;
    model_->s_axil_awvalid = 0;
    model_->s_axil_wvalid = 0;
    model_->s_axil_arvalid = 0;
    model_->s_axil_bready = 0;
    model_->s_axil_rready = 0;
    in_reset_ = true;
    const std::uint64_t video = video_clocks_ + 8;
    const std::uint64_t bus = bus_clocks_ + 8;
    while (video_clocks_ < video || bus_clocks_ < bus) {
      step();
    }
    model_->bus_rst_i = 0;
    model_->rst_i = 0;
    in_reset_ = false;
    reset_clock_ = video_clocks_;
  }

  void on_packet(PacketSink sink) { sink_ = std::move(sink); }
  void on_clock(ClockHook hook) { clock_hook_ = std::move(hook); }
  void on_beat(BeatHook hook) { beat_hook_ = std::move(hook); }
  void set_encoder(bool a, bool b) {
    model_->encoder_a_i = a;
    model_->encoder_b_i = b;
  }
  void set_bus_stall_percent(int percent) { options_.bus_stall_percent = percent; }
  void set_video_gap_percent(int percent) { options_.video_gap_percent = percent; }
  [[nodiscard]] bool takes_beats() const { return model_->s_axis_tready != 0; }
  [[nodiscard]] bool projector_trigger() const { return model_->projector_trigger_o != 0; }
  [[nodiscard]] bool camera_trigger() const { return model_->camera_trigger_o != 0; }
  [[nodiscard]] bool ejector() const { return model_->ejector_o != 0; }

  // Queues one beat, or clocks without a beat.
  void send(const model::VideoBeat& beat) { beats_.push_back({beat, 0}); }
  void gap(std::uint32_t clocks) {
    if (clocks != 0) {
      beats_.push_back({{}, clocks});
    }
  }

  // Queues a whole frame; columns must be a multiple of the build's lanes.
  void send(const model::ImageView& image) {
    for (int row = 0; row < image.rows; ++row) {
      const std::uint8_t* line = image.pixels + row * image.stride;
      for (int column = 0; column < image.columns; column += options_.lanes) {
        model::VideoBeat beat;
        std::copy_n(line + column, options_.lanes, beat.pixels.begin());
        beat.start = row == 0 && column == 0;
        beat.line_end = column + options_.lanes == image.columns;
        send(beat);
      }
    }
  }

  // The number of beats and gaps in the queue.
  [[nodiscard]] std::size_t queued() const { return beats_.size(); }

  // Runs for this many video clocks.
  void run(std::uint64_t clocks) {
    const std::uint64_t end = video_clocks_ + clocks;
    while (video_clocks_ < end) {
      step();
    }
  }

  // Runs until all beats are in, and no packet beat has come out for `quiet` video clocks although the bus was ready.
  void drain(std::uint64_t quiet = 400) {
    while (!beats_.empty()) {
      step();
    }
    idle_since_ = video_clocks_;
    while (video_clocks_ < idle_since_ + quiet) {
      step();
    }
  }

  // Accesses a register while the board continues to run. A write that is refused throws std::runtime_error, unless the
  // caller asks for the error.
  model::RegisterAnswer access(bool write, std::uint32_t address, std::uint32_t data, unsigned strobe = 0xF) {
    auto& m = *model_;
    if (write) {
      m.s_axil_awvalid = 1;
      m.s_axil_awaddr = static_cast<std::uint8_t>(address);
      m.s_axil_wvalid = 1;
      m.s_axil_wdata = data;
      m.s_axil_wstrb = static_cast<std::uint8_t>(strobe);
      m.s_axil_bready = 1;
    } else {
      m.s_axil_arvalid = 1;
      m.s_axil_araddr = static_cast<std::uint8_t>(address);
      m.s_axil_rready = 1;
    }
    access_done_ = false;
    while (!access_done_) {
      step();
    }
    m.s_axil_bready = 0;
    m.s_axil_rready = 0;
    return answer_;
  }
  void write(std::uint32_t address, std::uint32_t data) {
    if (access(true, address, data).error) {
      throw std::runtime_error("register write refused: address " + std::to_string(address) + ", value " +
                               std::to_string(data));
    }
  }
  std::uint32_t read(std::uint32_t address) {
    const model::RegisterAnswer answer = access(false, address, 0);
    if (answer.error) {
      throw std::runtime_error("register read refused: address " + std::to_string(address));
    }
    return answer.data;
  }

  // Writes all settings. They count from the next frame start on. `hold` keeps them together, and stays if they say so.
  void write(const model::BoardSettings& settings) {
    if (!decodes_) {
      decodes_ = (read(spec::kRegCapability) >> spec::kRegCapabilityCodesLsb & 1U) != 0;
    }
    if (settings.codes && !*decodes_) {
      throw std::runtime_error("this board has no decoder");
    }
    for (const auto& [address, data] : model::setting_writes(settings, settings_, *decodes_)) {
      write(address, data);
    }
    settings_ = settings;
  }

  // Writes limits of a verdict, and a pulse of one count for the ejector, at once.
  void write_limits(int bank, std::span<const model::SectionLimits> sections) {
    write(spec::kRegEjectorDelay, 0);
    write(spec::kRegEjectorLength, 1);
    const int room = static_cast<int>(sections.size()) + 1;  // the build has one more
    for (const auto& [address, data] : model::limits_writes(bank, sections, spec::kMaxColumns, room)) {
      write(address, data);
    }
  }

  // Video clocks since the last reset.
  [[nodiscard]] std::uint64_t clock() const { return video_clocks_ - reset_clock_; }
  [[nodiscard]] std::uint64_t time_ps() const { return now_; }
  [[nodiscard]] Model& model() { return *model_; }

  // Starts and stops waveforms. Throws unless the model was built with TRACE.
  void start_trace() {
    if constexpr (kHasWaveforms) {
      if (!options_.trace_file.empty() && trace_ == nullptr) {
        if (!std::ofstream(options_.trace_file)) {  // some versions of Verilator do not tell
          throw std::runtime_error(options_.trace_file + ": cannot write the waveform");
        }
        trace_ = std::make_unique<VerilatedFstC>();
        model_->trace(trace_.get(), 99, 0);
        trace_->open(options_.trace_file.c_str());
      }
    } else {
      throw std::logic_error("this model was built without waveforms");
    }
  }
  void stop_trace() {
    if (trace_ != nullptr) {
      trace_->close();
      trace_.reset();
    }
  }

 private:
  // Newer versions of Verilator give every model a trace(), and this constant.
  static constexpr bool kHasWaveforms = [] {
    if constexpr (requires { Model::traceCapable; }) {
      return Model::traceCapable;
    } else {
      return requires(Model & m, VerilatedFstC * f) { m.trace(f, 1, 0); };
    }
  }();

  struct QueuedBeat {
    model::VideoBeat beat;
    std::uint32_t gap;  // clocks without a beat; 0 stands for the beat itself
  };

  [[nodiscard]] bool chance(int percent) { return percent != 0 && static_cast<int>(random_() % 100U) < percent; }

  // Advances to the next rising edge of a clock, or of both.
  void step() {
    auto& m = *model_;
    const BoardClocks::Edge edge = clocks_.next();
    now_ = edge.time_ps;
    if (trace_ != nullptr) {  // shows the falling edge, too
      m.clk_i = 0;
      m.bus_clk_i = 0;
      m.eval();
      dump(now_ - 1);
    }
    if (edge.video) {
      drive_video();
    }
    if (edge.bus) {
      drive_bus();
    }
    BoardClocks::raise(m, edge);
    dump(now_);
    video_clocks_ += edge.video ? 1 : 0;
    bus_clocks_ += edge.bus ? 1 : 0;
  }

  // The pixels of a beat, leftmost lowest.
  template <typename Port>
  void set_pixels(Port& port, const model::VideoBeat& beat) const {
    if constexpr (std::is_integral_v<Port>) {
      std::uint64_t pixels = 0;
      for (int i = options_.lanes - 1; i >= 0; --i) {
        pixels = pixels << options_.pixel_bits | beat.pixels[static_cast<std::size_t>(i)];
      }
      port = static_cast<Port>(pixels);
    } else {                   // words of 32 bits
      std::uint64_t bits = 0;  // that are not in a word yet
      int held = 0;
      int word = 0;
      for (int i = 0; i < options_.lanes; ++i) {
        bits |= std::uint64_t{beat.pixels[static_cast<std::size_t>(i)]} << held;
        held += options_.pixel_bits;
        if (held >= 32) {
          port[word++] = static_cast<std::uint32_t>(bits);
          bits >>= 32;
          held -= 32;
        }
      }
      if (held > 0) {
        port[word] = static_cast<std::uint32_t>(bits);
      }
    }
  }

  void drive_video() {
    auto& m = *model_;
    if (clock_hook_ && !in_reset_) {
      clock_hook_(clock());
    }
    m.s_axis_tvalid = 0;
    if (beats_.empty() || in_reset_) {
      return;
    }
    QueuedBeat& next = beats_.front();
    if (next.gap != 0) {
      if (--next.gap == 0) {
        beats_.pop_front();
      }
      return;
    }
    if (chance(options_.video_gap_percent)) {
      return;
    }
    m.s_axis_tvalid = 1;
    set_pixels(m.s_axis_tdata, next.beat);
    m.s_axis_tuser = next.beat.start;
    m.s_axis_tlast = next.beat.line_end;
    if (beat_hook_) {
      beat_hook_(clock(), next.beat);
    }
    beats_.pop_front();
  }

  void drive_bus() {
    auto& m = *model_;
    // The values before the edge decide what happens at it.
    m.m_axis_tready = !chance(options_.bus_stall_percent) && !in_reset_;
    if (in_reset_) {
      return;
    }
    if (m.m_axis_tvalid != 0 && m.m_axis_tready != 0) {
      for (int word = 0; word < 4; ++word) {
        for (int byte = 0; byte < 4; ++byte) {
          packet_.push_back(static_cast<std::uint8_t>(m.m_axis_tdata[word] >> (8 * byte)));
        }
      }
      if (m.m_axis_tlast != 0) {
        if (sink_) {
          sink_(packet_);
        }
        packet_.clear();
      }
    }
    if (m.m_axis_tvalid != 0) {
      idle_since_ = video_clocks_;
    }
    // What was taken at the previous edge is no longer offered at this one.
    if (std::exchange(drop_aw_, false)) {
      m.s_axil_awvalid = 0;
    }
    if (std::exchange(drop_w_, false)) {
      m.s_axil_wvalid = 0;
    }
    if (std::exchange(drop_ar_, false)) {
      m.s_axil_arvalid = 0;
    }
    drop_aw_ = m.s_axil_awvalid != 0 && m.s_axil_awready != 0;
    drop_w_ = m.s_axil_wvalid != 0 && m.s_axil_wready != 0;
    drop_ar_ = m.s_axil_arvalid != 0 && m.s_axil_arready != 0;
    if (m.s_axil_bvalid != 0 && m.s_axil_bready != 0) {
      answer_ = {.error = m.s_axil_bresp != 0, .data = 0};
      access_done_ = true;
    }
    if (m.s_axil_rvalid != 0 && m.s_axil_rready != 0) {
      answer_ = {.error = m.s_axil_rresp != 0, .data = m.s_axil_rdata};
      access_done_ = true;
    }
  }

  void dump(std::uint64_t time) {
    if (trace_ != nullptr) {
      trace_->dump(time);
    }
  }

  BoardDeviceOptions options_;
  struct Simulation {
    Simulation() { context.traceEverOn(true); }
    ~Simulation() {
      model.final();
      // A model whose names are known to VPI takes them from the thread's context, which may belong to a device that no
      // longer exists.
      Verilated::threadContextp(&context);
    }
    Simulation(const Simulation&) = delete;
    Simulation& operator=(const Simulation&) = delete;
    VerilatedContext context;
    Model model{with_initial_values(context)};
#ifdef SELFPROJ_COVERAGE
    CoverageFile coverage{context};  // declared after the model, so that it writes before the model is destroyed
#endif
  };
  Reusable<Simulation> simulation_;
  Model* model_;
  std::unique_ptr<VerilatedFstC> trace_;
  std::mt19937_64 random_;

  BoardClocks clocks_;
  std::uint64_t now_ = 0;
  std::uint64_t video_clocks_ = 0;
  std::uint64_t bus_clocks_ = 0;
  std::uint64_t reset_clock_ = 0;
  std::uint64_t idle_since_ = 0;
  bool in_reset_ = false;

  std::deque<QueuedBeat> beats_;
  std::vector<std::uint8_t> packet_;
  PacketSink sink_;
  ClockHook clock_hook_;
  BeatHook beat_hook_;

  model::BoardSettings settings_;  // written since the last reset
  std::optional<bool> decodes_;    // whether the build has the decoder; empty until asked
  model::RegisterAnswer answer_;
  bool access_done_ = true;
  bool drop_aw_ = false;
  bool drop_w_ = false;
  bool drop_ar_ = false;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_BOARD_BOARD_DEVICE_H
