// Measures the clocks per second of the Verilated circuits: the moments core alone with one clock, and the board with
// two unrelated clocks. Frames have 96 x 512 pixels, every pixel clock carries a beat, and the mode is binary.
//
//     bench_rtl [GOOGLE_BENCHMARK_OPTION...]
//
// The program first compares both with the model. It ends with the rates, and with the board's rate as a share of the
// core's: for the clocks of both domains, and for the video clocks alone. The peer of the core is the model, the
// definition in C++, which sums the same frame. Core, board and model take turns, a frame each, and each share is the
// median over the turns: on a shared machine rates change by half from second to second, but little from one
// millisecond to the next. The fastest tenth of the frames shows the rates on an idle processor core:
// if its sibling thread is busy, the board loses more than the moments core, because it has more code and state.
// items_per_second counts the video clocks of the three frames of a turn.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "Vboard.h"
#include "Vboard_original.h"
#include "Vcore.h"
#include "Vcore_original.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/model/packet.h"
#include "selfproj/model/pixel_clock.h"
#include "sim/board/board_device.h"
#include "sim/board/clocks.h"
#include "tests/bench/collector.h"

namespace selfproj::test {
namespace {

using bench::Collector;

constexpr int kRows = 96;
constexpr int kColumns = 512;
constexpr int kGroups = kColumns / 4;
constexpr int kThreshold = 128;
constexpr int kFrameClocks = kRows * kGroups;
constexpr std::uint64_t kVideoPeriodPs = model::pixel_clock_period_ps(model::kDefaultPixelClockHz);
constexpr std::uint64_t kBusPeriodPs = 16000;  // 62.5 MHz: 16 bytes each, 1 GB/s

// One frame of noise, as the beats' words.
std::vector<std::uint32_t> noise() {
  std::mt19937 random(1);
  std::vector<std::uint32_t> beats(kFrameClocks);
  for (auto& beat : beats) {
    beat = static_cast<std::uint32_t>(random());
  }
  return beats;
}

// The moments core, one frame after another.
template <class Model>
class Core {
 public:
  Core() : model_(std::make_unique<Model>(&context_)) {
    model_->eval();
    model_->rst_i = 1;
    for (int i = 0; i < 8; ++i) {
      clock();
    }
    model_->rst_i = 0;
    model_->mode_i = 0;
    model_->threshold_i = kThreshold;
    model_->one_group_i = 0;
    model_->two_groups_i = 0;
    model_->break_i = 0;
    model_->accept_i = 1;
  }
  ~Core() { model_->final(); }
  Core(const Core&) = delete;
  Core& operator=(const Core&) = delete;

  // Clocks one frame in, and passes the output on.
  template <class Out>
  void frame(const std::vector<std::uint32_t>& beats, Out out) {
    const std::uint32_t* beat = beats.data();
    for (int row = 1; row <= kRows; ++row) {
      model_->beat_row_i = static_cast<std::remove_reference_t<decltype(model_->beat_row_i)>>(row);
      model_->beat_first_row_i = row == 1;
      model_->beat_last_row_i = row == kRows;
      for (int group = 0; group < kGroups; ++group) {
        model_->beat_valid_i = 1;
        model_->beat_pixels_i = *beat++;
        model_->beat_group_i = static_cast<std::remove_reference_t<decltype(model_->beat_group_i)>>(group);
        model_->beat_line_end_i = group == kGroups - 1;
        clock();
        if (model_->moments_valid_o != 0) {
          out(model_->moments_data_o);
        }
      }
    }
  }

 private:
  void clock() {
    model_->clk_i = 1;
    sim::rise(*model_);
  }

  VerilatedContext context_;
  std::unique_ptr<Model> model_;
};

// The board, settings as after reset (512 x 96, threshold 128, binary), pixel clock 151.2 MHz, bus clock 62.5 MHz.
template <class Model>
class Board {
 public:
  Board() { device_.write(model::BoardSettings{.columns = kColumns, .rows = kRows, .threshold = kThreshold}); }

  // The tight loop clocks the board's model without the queues of the device.
  template <class Out>
  void frame(const std::vector<std::uint32_t>& beats, Out out) {
    Model& m = device_.model();
    m.m_axis_tready = 1;
    const std::uint32_t* beat = beats.data();
    for (int row = 0; row < kRows; ++row) {
      for (int group = 0; group < kGroups;) {
        const sim::BoardClocks::Edge edge = clocks_.next();
        if (edge.video) {
          m.s_axis_tvalid = 1;
          m.s_axis_tdata = *beat++;
          m.s_axis_tuser = row == 0 && group == 0;
          m.s_axis_tlast = group == kGroups - 1;
          ++group;
        }
        if (edge.bus && m.m_axis_tvalid != 0) {
          out(m.m_axis_tdata);
        }
        clocks_.raise(m, edge);
      }
    }
  }

 private:
  sim::BoardDevice<Model> device_;
  sim::BoardClocks clocks_{kVideoPeriodPs, kBusPeriodPs, 1234};
};

// The output of a circuit for a frame.
enum class Gives : std::uint8_t { payloads, packets };

// The model of the moments, the definition in C++.
void sum_frame(const std::vector<std::uint32_t>& beats, model::Moments& moments) {
  model::column_moments({.pixels = reinterpret_cast<const std::uint8_t*>(beats.data()),
                         .rows = kRows,
                         .columns = kColumns,
                         .stride = kColumns},
                        model::Mode::binary, kThreshold, moments.view());
}

// Compares the circuit's payload of two frames with the model.
template <class Circuit>
bool is_right(const std::vector<std::uint32_t>& beats, Gives gives) {
  std::vector<std::uint8_t> got;
  const auto keep = [&](const auto& data) {
    const auto at = got.size();
    got.resize(at + 16);
    std::memcpy(got.data() + at, data.data(), 16);
  };
  Circuit circuit;
  for (int i = 0; i < 3; ++i) {
    circuit.frame(beats, keep);
  }
  model::Moments moments;
  moments.resize(kColumns);
  sum_frame(beats, moments);
  std::vector<std::uint8_t> want(model::moments_payload_bytes(model::Mode::binary, kColumns));
  model::pack_moments(model::Mode::binary, kColumns, moments.view(), want.data());
  const std::size_t size = gives == Gives::packets ? model::packet_bytes(want.size()) : want.size();
  if (got.size() < 2 * size) {
    return false;
  }
  for (std::size_t i = 0; i < 2; ++i) {
    std::span<const std::uint8_t> given = std::span(got).subspan(i * size, size);
    given = gives == Gives::packets ? model::payload_of(given) : given;
    if (!std::equal(want.begin(), want.end(), given.begin(), given.end())) {
      return false;
    }
  }
  return true;
}

// The seconds of each turn that the core, the board and the model took for their frame.
struct Turns {
  std::vector<double> core;
  std::vector<double> board;
  std::vector<double> model;
};

template <class Work>
double seconds_of(Work work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

template <class CoreModel, class BoardModel>
void take_turns(benchmark::State& state, const std::vector<std::uint32_t>& beats, Turns& turns) {
  Core<CoreModel> core;
  Board<BoardModel> board;
  model::Moments moments;
  moments.resize(kColumns);
  std::uint64_t words = 0;
  const auto count = [&](const auto&) { ++words; };
  for (auto _ : state) {
    turns.core.push_back(seconds_of([&] { core.frame(beats, count); }));
    turns.board.push_back(seconds_of([&] { board.frame(beats, count); }));
    turns.model.push_back(seconds_of([&] { sum_frame(beats, moments); }));
    benchmark::ClobberMemory();
  }
  benchmark::DoNotOptimize(words);
  state.SetItemsProcessed(3 * state.iterations() * kFrameClocks);
}

// The value below which `share` of the values lie.
double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

// The median over the turns of one time divided by another.
double median_ratio(const std::vector<double>& of, const std::vector<double>& to) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < of.size(); ++i) {
    ratios.push_back(of[i] / to[i]);
  }
  return quantile(ratios, 0.5);
}

nlohmann::ordered_json print_share(const Turns& turns, const char* build) {
  if (turns.core.empty()) {
    return {};  // left out by --benchmark_filter
  }
  const double both = 1 + static_cast<double>(kVideoPeriodPs) / static_cast<double>(kBusPeriodPs);
  const double video = median_ratio(turns.core, turns.board);
  const double beside_model = median_ratio(turns.model, turns.core);
  const auto rate = [](const std::vector<double>& seconds, double share) {
    return kFrameClocks / quantile(seconds, share) * 1e-6;
  };
  std::printf(
      "%-8s: core %.1f M clocks/s; board %.1f M in both domains: %.0f %% of the core's, video clocks alone %.0f %%\n",
      build, rate(turns.core, 0.5), both * rate(turns.board, 0.5), 100 * both * video, 100 * video);
  std::printf("          core beside the model: %.3f of its frames\n", beside_model);
  const double core = rate(turns.core, 0.1);
  const double board = rate(turns.board, 0.1);
  std::printf("          fastest tenth of the frames: core %.1f M; board %.1f M, %.0f %%, %.0f %%\n", core,
              both * board, 100 * both * board / core, 100 * board / core);
  return {{"core_clocks_per_s", 1e6 * rate(turns.core, 0.5)},
          {"core_share_of_model", beside_model},
          {"board_clocks_per_s", 1e6 * both * rate(turns.board, 0.5)},
          {"share", both * video},
          {"share_of_video_clocks", video},
          {"fastest_tenth",
           {{"core_clocks_per_s", 1e6 * core},
            {"board_clocks_per_s", 1e6 * both * board},
            {"share", both * board / core}}}};
}

int run() {
  const std::vector<std::uint32_t> beats = noise();
  bench::require(
      is_right<Core<Vcore>>(beats, Gives::payloads) && is_right<Core<Vcore_original>>(beats, Gives::payloads) &&
          is_right<Board<Vboard>>(beats, Gives::packets) && is_right<Board<Vboard_original>>(beats, Gives::packets),
      "a circuit does not equal the model");

  Turns original;
  Turns standard;
  bench::add("turns/original",
             [&](benchmark::State& s) { take_turns<Vcore_original, Vboard_original>(s, beats, original); });
  bench::add("turns/default", [&](benchmark::State& s) { take_turns<Vcore, Vboard>(s, beats, standard); });

  const bench::About about{"bench_rtl", "Verilated circuits: the moments core, and the board beside it",
                           "items_per_second"};
  return bench::run_registered(about, [&](const Collector& /*collector*/) {
    std::printf(
        "\noriginal: 512 columns, 127 rows, binary build; default: 2048 columns, 1023 rows, grey and raw images; "
        "both run mode binary\n");
    nlohmann::ordered_json results;
    for (const auto& [build, turns] : {std::pair{"original", &original}, {"default", &standard}}) {
      if (const nlohmann::ordered_json share = print_share(*turns, build); !share.empty()) {
        results[build] = share;
      }
    }
    return results;
  });
}

}  // namespace
}  // namespace selfproj::test

int main(int argc, char** argv) {
  return selfproj::bench::main_of("bench_rtl", {argv + 1, argv + argc}, selfproj::test::run);
}
