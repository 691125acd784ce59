#include "sim/platform/platform.h"

#include <memory>
#include <stdexcept>
#include <systemc>
#include <tlm>
#include <utility>

#include "selfproj/files/user_error.h"
#include "selfproj/model/pixel_clock.h"
#include "sim/platform/modules.h"

// SystemC's library has a main function that calls this one. The programs have their own main.
int sc_main(int /*argc*/, char** /*argv*/) { return 0; }

namespace selfproj::sim {

namespace {

// SystemC elaborates a kernel only once, so every platform replaces the default kernel with a new one.
class Kernel {
 public:
  // SystemC 2.3.4 frees the data of a port's reset_signal_is() at elaboration, and again with the kernel. A kernel
  // whose modules have clocked threads with a reset is therefore never freed, which costs some kilobytes. Nor is any
  // kernel of SystemC 3.0.1, which frees its threads after what they need.
  explicit Kernel(bool has_resets) : kept_(has_resets || SC_VERSION_MAJOR >= 3) {
    if (std::exchange(alive, true)) {
      throw std::logic_error("two platforms at once");
    }
    use(kernel_.get());
    sc_core::sc_report_handler::set_actions("/OSCI/SystemC", sc_core::SC_INFO, sc_core::SC_DO_NOTHING);
  }
  Kernel(const Kernel&) = delete;
  Kernel& operator=(const Kernel&) = delete;
  ~Kernel() {
    if (kept_) {
      static_cast<void>(kernel_.release());
    }
    kernel_.reset();
    use(default_);
    alive = false;
  }

 private:
  static void use(sc_core::sc_simcontext* kernel) {
    sc_core::sc_curr_simcontext = kernel;
    sc_core::sc_default_global_context = kernel;
  }

  inline static bool alive = false;
  bool kept_;
  sc_core::sc_simcontext* default_ = sc_core::sc_curr_simcontext;
  std::unique_ptr<sc_core::sc_simcontext> kernel_ = std::make_unique<sc_core::sc_simcontext>();
};

double clocks_a_step(double steps_per_s, double pixel_clock_hz) {
  if (steps_per_s == 0) {
    return 0;
  }
  constexpr double kFewest = 4;
  const double clocks = pixel_clock_hz / steps_per_s;
  if (!(clocks >= kFewest)) {
    throw std::invalid_argument("the encoder turns too fast for the board");
  }
  return clocks;
}

void check(const PlatformOptions& options) {
  if (!(options.pixel_clock_hz >= model::kMinPixelClockHz && options.pixel_clock_hz <= model::kMaxPixelClockHz)) {
    throw std::invalid_argument("no board has this pixel clock");
  }
  constexpr int kMaxStalls = 95;
  const BusOptions& bus = options.bus;
  if (bus.period_ps == 0 || bus.stall_percent < 0 || bus.stall_percent > kMaxStalls || bus.hold_ups_a_second < 0 ||
      bus.hold_up_s < 0) {
    throw std::invalid_argument("the options of the bus make no sense");
  }
  constexpr int kMaxPatterns = 256;
  constexpr int kMostBits = 12;
  if (options.patterns < 1 || options.patterns > kMaxPatterns) {
    throw std::invalid_argument("patterns are 1..256");
  }
  if (options.settings.codes && !options.trace_file.empty()) {
    throw std::invalid_argument("there is no build with both codes and waveforms");
  }
  if ((options.settings.select == model::Select::strongest || options.settings.compact || options.settings.verdict) &&
      (options.settings.codes || !options.trace_file.empty() || options.engine == PlatformEngine::hls)) {
    throw std::invalid_argument(
        "there is no build with the strongest runs, compact columns or verdicts and codes, waveforms or SystemC "
        "shells");
  }
  const bool wide = options.pixel_bits > spec::kPixelBits;
  if (options.pixel_bits < spec::kPixelBits || options.pixel_bits > kMostBits ||
      (wide && (options.settings.codes || !options.trace_file.empty() || options.engine == PlatformEngine::hls)) ||
      (options.engine == PlatformEngine::rtl && !has_rtl_of(options.pixel_bits))) {
    throw std::invalid_argument("there is no build with pixels of so many bits");
  }
  if (options.quantum_lines == 0 || options.trace_from == 0) {
    throw std::invalid_argument("the quantum and the first frame of a trace are at least 1");
  }
  if (options.engine != PlatformEngine::rtl && !options.trace_file.empty()) {
    throw std::invalid_argument("only the RTL has waveforms");
  }
}

std::uint64_t first_clock(const PlatformOptions& options) {
  constexpr std::uint64_t kClocksALimit = 128;  // two writes on a bus that is not slower than half the pixel clock
  std::uint64_t limits = 0;
  for (const model::SectionLimits& section : options.limits) {
    limits += section.limits.size() + model::kMaxShiftColumns + 2;
  }
  return Platform::kFirstClock + kClocksALimit * limits;
}

std::unique_ptr<BoardCore> make_core(const PlatformOptions& options, const CameraTiming& timing) {
  const BoardCoreOptions core{
      .pixel_clock_hz = options.pixel_clock_hz,
      .bus = options.bus,
      .seed = options.seed,
      .patterns = options.patterns,
      .codes = options.settings.codes,
      .runs =
          options.settings.select == model::Select::strongest || options.settings.compact || options.settings.verdict,
      .pixel_bits = options.pixel_bits,
      .trace_file = options.trace_file,
      .trace_from_clock = first_clock(options) + (options.trace_from - 1) * timing.frame_clocks};
  if (options.engine == PlatformEngine::model) {
    return make_model_core(core);
  }
#ifdef SELFPROJ_HAS_RTL_PLATFORM
  return options.engine == PlatformEngine::hls ? make_hls_core(core) : make_rtl_core(core);
#else
  throw UserError("--engine", "this engine is not part of this build");
#endif
}

}  // namespace

struct Platform::Parts {
  Parts(const PlatformOptions& options, Camera::Source frames, BusSink::Receiver packets,
        model::BoardModel::Sink expected)
      : kernel(options.engine == PlatformEngine::hls),
        pixel_clock_hz(options.pixel_clock_hz),
        timing(camera_timing(options.settings.rows, options.settings.columns, options.frame_rate_hz,
                             options.pixel_clock_hz)),
        period(sc_core::sc_time::from_value(model::pixel_clock_period_ps(options.pixel_clock_hz))),
        camera("camera", timing, first_clock(options), period, std::move(frames)),
        conveyor("conveyor", clocks_a_step(options.encoder_steps_per_s, options.pixel_clock_hz), first_clock(options),
                 period),
        board("board", make_core(options, timing)),
        sink("bus_sink", options.bus, options.seed, period, std::move(packets)) {
    tlm::tlm_global_quantum::instance().set(time_of_clock(options.quantum_lines * timing.line_clocks, period));
    camera.video(board.video);
    camera.finished(finished);
    conveyor.encoder(board.encoder_pins);
    conveyor.finished(finished);
    board.bus(sink.bus);
    sink.ready(board.bus_ready);
    sink.finished(finished);
    if (expected) {
      reference = std::make_unique<ReferenceModel>("reference", options.settings, options.limits, options.patterns,
                                                   options.pixel_bits, std::move(expected));
      camera.video(reference->video);
      conveyor.encoder(reference->encoder_pins);
    }
    board.core().write(options.settings, options.limits);
    if (board.core().clock() > first_clock(options)) {
      throw std::logic_error("the registers were not set in time");
    }
  }

  Kernel kernel;
  double pixel_clock_hz;
  CameraTiming timing;
  sc_core::sc_time period;
  sc_core::sc_signal<bool> finished{"camera_finished"};
  Camera camera;
  Conveyor conveyor;
  Board board;
  BusSink sink;
  std::unique_ptr<ReferenceModel> reference;
  PlatformReport report;
};

Platform::Platform(const PlatformOptions& options, NextFrame frames, PacketSink packets,
                   model::BoardModel::Sink expected) {
  check(options);
  parts_ = std::make_unique<Parts>(options, std::move(frames), std::move(packets), std::move(expected));
}

Platform::~Platform() = default;

void Platform::run() {
  Parts& parts = *parts_;
  sc_core::sc_start();
  for (const GuardedModule* module :
       std::initializer_list<const GuardedModule*>{&parts.camera, &parts.conveyor, &parts.board, &parts.sink}) {
    if (module->failure()) {
      std::rethrow_exception(module->failure());
    }
  }
  parts.report = {.frames = parts.camera.frames(),
                  .packets = parts.sink.packets(),
                  .clocks = parts.board.core().clock(),
                  .seconds = model::seconds_of_clocks(parts.board.core().clock(), parts.pixel_clock_hz),
                  .hold_ups = parts.sink.hold_ups(),
                  .board = parts.board.core().counters()};
}

const CameraTiming& Platform::timing() const { return parts_->timing; }

PlatformReport Platform::report() const { return parts_->report; }

}  // namespace selfproj::sim
