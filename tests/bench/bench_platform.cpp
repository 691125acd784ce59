// Measures the clocks per second of the platform in SystemC, beside those of the same Verilated board in a plain loop
// that does nothing else. Frames of 96 x 512 at 10,000 a second: 15,120 pixel clocks a frame, of which 12,288 carry
// beats; mode grey-over, encoder turning, bus of 125 MHz.
//
//     bench_platform [GOOGLE_BENCHMARK_OPTION...]
//
// The program first compares the packets of both. It ends with the platform's rate as a share of the plain loop's in
// the same run, and as a share of real time.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "Vboard.h"
#include "selfproj/model/board.h"
#include "selfproj/model/packet.h"
#include "selfproj/model/pixel_clock.h"
#include "sim/board/board_device.h"
#include "sim/board/clocks.h"
#include "sim/board/packet_scoreboard.h"
#include "sim/platform/platform.h"
#include "tests/bench/collector.h"

namespace selfproj::test {
namespace {

using bench::Collector;

constexpr int kRows = 96;
constexpr int kColumns = 512;
constexpr int kFrames = 8;  // of one run of the platform
constexpr double kBeltStepsPerS = 100000;

const model::BoardSettings kSettings{.mode = model::Mode::grey_over, .threshold = 20};

// A light line on a dark, noisy image.
std::vector<std::uint8_t> line_image() {
  std::mt19937 random(1);
  std::vector<std::uint8_t> pixels(std::size_t{kRows} * kColumns);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const std::size_t row = i / kColumns;
    pixels[i] = static_cast<std::uint8_t>((row >= 46 && row < 52 ? 120 : 5) + random() % 10);
  }
  return pixels;
}

// The board in a plain loop, with beats in the same clocks.
class Plain {
 public:
  Plain() { device_.write(kSettings); }

  template <class Out>
  void frame(const std::vector<std::uint8_t>& pixels, const sim::CameraTiming& timing, Out out) {
    Vboard& m = device_.model();
    m.m_axis_tready = 1;
    std::uint64_t in_line = 0;
    int row = 0;
    for (std::uint64_t clock = 0; clock < timing.frame_clocks;) {
      const sim::BoardClocks::Edge edge = clocks_.next();
      if (edge.video) {
        m.s_axis_tvalid = row < kRows && in_line < timing.beats_a_line();
        if (m.s_axis_tvalid != 0) {
          const std::size_t at = static_cast<std::size_t>(row) * kColumns + 4 * static_cast<std::size_t>(in_line);
          std::uint32_t word = 0;
          std::memcpy(&word, pixels.data() + at, sizeof word);
          m.s_axis_tdata = word;
          m.s_axis_tuser = at == 0;
          m.s_axis_tlast = in_line + 1 == timing.beats_a_line();
        }
        ++clock;
        if (++in_line == timing.line_clocks) {
          in_line = 0;
          ++row;
        }
      }
      if (edge.bus && m.m_axis_tvalid != 0) {
        out(m.m_axis_tdata);
      }
      clocks_.raise(m, edge);
    }
  }

 private:
  sim::BoardDevice<Vboard> device_;
  sim::BoardClocks clocks_{model::pixel_clock_period_ps(model::kDefaultPixelClockHz), 8000, 1234};
};

// Runs the platform over some frames.
template <class Packet>
std::uint64_t run_platform(sim::PlatformEngine engine, const std::vector<std::uint8_t>& pixels, bool compare,
                           Packet packet) {
  sim::PlatformOptions options;
  options.engine = engine;
  options.settings = kSettings;
  options.encoder_steps_per_s = kBeltStepsPerS;
  int left = kFrames;
  const model::ImageView view{.pixels = pixels.data(), .rows = kRows, .columns = kColumns, .stride = kColumns};
  sim::PacketScoreboard scoreboard;
  sim::Platform platform(
      options, [&]() -> std::optional<model::ImageView> { return left-- > 0 ? std::optional(view) : std::nullopt; },
      [&](std::span<const std::uint8_t> bytes, std::uint64_t) {
        packet(bytes);
        if (compare) {
          scoreboard.compare(bytes);
        }
      },
      compare ? model::BoardModel::Sink([&](model::BoardPacket&& made) { scoreboard.expect(std::move(made)); })
              : model::BoardModel::Sink());
  platform.run();
  if (scoreboard.mismatches() != 0) {
    throw std::runtime_error(scoreboard.first_mismatch());
  }
  return platform.report().clocks;
}

// The payload of a frame's packet, from the plain loop and from the platform.
bool are_equal(const std::vector<std::uint8_t>& pixels, const sim::CameraTiming& timing) {
  std::vector<std::uint8_t> plain;
  Plain board;
  for (int i = 0; i < 2; ++i) {
    board.frame(pixels, timing, [&](const auto& data) {
      const std::size_t at = plain.size();
      plain.resize(at + 16);
      std::memcpy(plain.data() + at, data.data(), 16);
    });
  }
  std::vector<std::uint8_t> platform;
  run_platform(sim::PlatformEngine::rtl, pixels, true,
               [&](std::span<const std::uint8_t> bytes) { platform.assign(bytes.begin(), bytes.end()); });
  if (platform.empty() || plain.size() < platform.size()) {
    return false;
  }
  const auto a = model::payload_of(std::span(plain).first(platform.size()));
  const auto b = model::payload_of(platform);
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

int run() {
  const std::vector<std::uint8_t> pixels = line_image();
  const sim::CameraTiming timing = sim::camera_timing(kRows, kColumns, 10000);
  bench::require(are_equal(pixels, timing), "the platform's packets are not those of the plain loop");

  bench::add("plain/rtl", [&](benchmark::State& state) {
    Plain board;
    std::uint64_t words = 0;
    for (auto _ : state) {
      board.frame(pixels, timing, [&](const auto&) { ++words; });
    }
    benchmark::DoNotOptimize(words);
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(timing.frame_clocks));
  });
  const auto platform = [&](const char* name, sim::PlatformEngine engine, bool compare) {
    bench::add(name, [&, engine, compare](benchmark::State& state) {
      std::uint64_t clocks = 0;
      std::uint64_t bytes = 0;
      for (auto _ : state) {
        clocks += run_platform(engine, pixels, compare, [&](const auto& packet) { bytes += packet.size(); });
      }
      benchmark::DoNotOptimize(bytes);
      state.SetItemsProcessed(static_cast<std::int64_t>(clocks));
    });
  };
  platform("platform/rtl", sim::PlatformEngine::rtl, false);
  platform("compared/rtl", sim::PlatformEngine::rtl, true);
  platform("platform/model", sim::PlatformEngine::model, false);

  const bench::About about{"bench_platform", "The platform in SystemC beside the same board in a plain loop",
                           "items_per_second"};
  return bench::run_registered(about, [](const Collector& collector) {
    nlohmann::ordered_json results;
    const double plain = collector.median("plain/rtl");
    if (plain <= 0) {
      return results;
    }
    const auto print = [&](const char* name, const char* key, const char* what) {
      if (const double rate = collector.median(name); rate > 0) {
        std::printf("%-36s %6.2f M clocks/s: %4.0f %% of the plain loop's, 1/%.0f of real time\n", what, rate * 1e-6,
                    100 * rate / plain, model::kDefaultPixelClockHz / rate);
        results[key] = {{"clocks_per_s", rate},
                        {"share_of_plain_loop", rate / plain},
                        {"slower_than_real_time", model::kDefaultPixelClockHz / rate}};
      }
    };
    std::printf("\n");
    print("plain/rtl", "plain", "board in a plain loop");
    print("platform/rtl", "platform", "platform, engine rtl");
    print("compared/rtl", "compared", "... and compared with the model");
    print("platform/model", "model", "platform, engine model");
    return results;
  });
}

}  // namespace
}  // namespace selfproj::test

int main(int argc, char** argv) {
  return selfproj::bench::main_of("bench_platform", {argv + 1, argv + argc}, selfproj::test::run);
}
