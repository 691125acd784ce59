// Measures the speed of the host's column moments, beside the speed at which this machine reads memory, and the speed
// of reading packets.
//
//     bench_model [--frames=N] [--benchmark_...]
//
// Frames of 96 x 512 pixels lie one after another in a buffer far larger than the caches (N of them, 8000 by default:
// 393 MB). One thread computes the moments of all frames in each mode. It also reads all frames as fast as it can, in
// two ways: in one stream and in four; the faster one is the ceiling. A second buffer of N frames has a line in each:
// one run in every column. There the strongest runs, with gap 0 and 3, are compared with the moments of all lit pixels;
// and once more with a second run in every 16th column. The measurements are repeated 7 times in random order, and
// their medians are compared. Before the first measurement the results are compared with the model; a difference ends
// the program with exit status 1.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "selfproj/light_section/fast_moments.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/packet.h"
#include "tests/bench/collector.h"
#include "tests/bench/read_ceiling.h"

namespace selfproj::test {
namespace {

using bench::Collector;

constexpr int kRows = 96;
constexpr int kColumns = 512;
constexpr int kThreshold = 128;
constexpr std::size_t kFrameBytes = static_cast<std::size_t>(kRows) * kColumns;
constexpr int kFramesInCache = 4;

// Frames that lie one after another in memory.
class FrameBuffer {
 public:
  explicit FrameBuffer(int frames) : frames_(frames), bytes_(static_cast<std::size_t>(frames) * kFrameBytes) {}

  int frames() const { return frames_; }
  model::ImageView frame(int i) const {
    return {bytes_.data() + static_cast<std::size_t>(i) * kFrameBytes, kRows, kColumns, kColumns};
  }
  std::span<const std::uint8_t> bytes() const { return {bytes_.data(), bytes_.size()}; }

  // Draws a line into every frame, 3 to 9 rows wide, and darkness elsewhere; every `second`th column has a second run.
  void draw_lines(int second) {
    std::mt19937 engine(1);
    const auto below = [&](unsigned limit) { return static_cast<std::size_t>(engine() % limit); };
    for (std::size_t at = 0; at < bytes_.size(); ++at) {  // the random pixels, none of them lit
      bytes_.data()[at] %= kThreshold + 1;
    }
    for (int i = 0; i < frames_; ++i) {
      std::uint8_t* frame = bytes_.data() + static_cast<std::size_t>(i) * kFrameBytes;
      std::size_t top = 40;
      for (std::size_t column = 0; column < kColumns; ++column) {
        const auto light = [&](std::size_t first, std::size_t rows) {
          for (std::size_t row = first; row < first + rows; ++row) {
            frame[row * kColumns + column] = static_cast<std::uint8_t>(kThreshold + 1 + below(255 - kThreshold));
          }
        };
        top = std::clamp<std::size_t>(top + below(3), 11, 81) - 1;
        light(top, 3 + below(7));
        if (second != 0 && column % static_cast<std::size_t>(second) == 0) {
          light(0, 2);
        }
      }
    }
  }

 private:
  int frames_;
  bench::RandomBuffer bytes_;
};

bool results_are_right(const FrameBuffer& buffer) {
  model::Moments moments;
  model::Moments right;
  moments.resize(kColumns);
  right.resize(kColumns);
  for (int i = 0; i < std::min(buffer.frames(), 16); ++i) {
    for (const model::Mode mode : {model::Mode::binary, model::Mode::grey, model::Mode::grey_over}) {
      model::column_moments(buffer.frame(i), mode, kThreshold, right.view());
      light_section::fast_column_moments(buffer.frame(i), mode, kThreshold, moments.view());
      if (moments != right) {
        return false;
      }
    }
  }
  return true;
}

// What is compared on frames with lines.
struct RunsCase {
  const char* name;
  model::Measure measure;
};

std::vector<RunsCase> runs_cases() {
  std::vector<RunsCase> cases;
  for (const auto& [mode, all, gap0, gap3] :
       {std::tuple{model::Mode::binary, "binary/all", "binary/gap_0", "binary/gap_3"},
        {model::Mode::grey, "grey/all", "grey/gap_0", "grey/gap_3"}}) {
    cases.push_back({all, {.mode = mode, .threshold = kThreshold, .select = model::Select::all}});
    cases.push_back({gap0, {.mode = mode, .threshold = kThreshold, .select = model::Select::strongest, .gap = 0}});
    cases.push_back({gap3, {.mode = mode, .threshold = kThreshold, .select = model::Select::strongest, .gap = 3}});
  }
  return cases;
}

bool runs_are_right(const FrameBuffer& buffer) {
  for (const auto& [name, measure] : runs_cases()) {
    model::Runs runs;
    model::Runs right;
    runs.resize(measure.select, kColumns);
    right.resize(measure.select, kColumns);
    for (int i = 0; i < std::min(buffer.frames(), 16); ++i) {
      model::measure_columns(buffer.frame(i), measure, right.view());
      light_section::fast_measure_columns(buffer.frame(i), measure, runs.view());
      if (!(runs == right)) {
        return false;
      }
    }
  }
  return true;
}

void take_moments(benchmark::State& state, const FrameBuffer& buffer, model::Mode mode, int frames) {
  model::Moments moments;
  moments.resize(kColumns);
  const model::MomentsView out = moments.view();
  for (auto _ : state) {
    for (int i = 0; i < frames; ++i) {
      light_section::fast_column_moments(buffer.frame(i), mode, kThreshold, out);
      benchmark::ClobberMemory();
    }
  }
  bench::set_counters(state, frames, kFrameBytes);
}

// The same grey values as pixels of 12 bits in words of 16, of half as many frames: as many bytes.
void take_wide_moments(benchmark::State& state, const std::vector<std::uint16_t>& pixels, model::Mode mode,
                       int frames) {
  model::Moments moments;
  moments.resize(kColumns);
  const model::MomentsView out = moments.view();
  for (auto _ : state) {
    for (int i = 0; i < frames; ++i) {
      const model::WideImageView frame{pixels.data() + static_cast<std::size_t>(i) * kFrameBytes, kRows, kColumns,
                                       kColumns};
      light_section::fast_column_moments(frame, model::kMaxPixelBits, mode, 16 * kThreshold, out);
      benchmark::ClobberMemory();
    }
  }
  bench::set_counters(state, frames, 2 * kFrameBytes);
}

void take_runs(benchmark::State& state, const FrameBuffer& buffer, const model::Measure& measure, int frames) {
  model::Runs runs;
  runs.resize(measure.select, kColumns);
  const model::RunsView out = runs.view();
  for (auto _ : state) {
    for (int i = 0; i < frames; ++i) {
      light_section::fast_measure_columns(buffer.frame(i), measure, out);
      benchmark::ClobberMemory();
    }
  }
  bench::set_counters(state, frames, kFrameBytes);
}

// A good packet of moments of kColumns columns.
std::vector<std::uint8_t> packet_of(model::Mode mode, const model::ImageView& image) {
  model::Moments moments;
  moments.resize(kColumns);
  model::column_moments(image, mode, kThreshold, moments.view());
  std::vector<std::uint8_t> payload(model::moments_payload_bytes(mode, kColumns));
  model::pack_moments(mode, kColumns, moments.view(), payload.data());
  model::PacketHeader header;
  header.kind = spec::kKindMoments;
  header.columns = kColumns;
  header.rows = kRows;
  header.mode = static_cast<std::uint8_t>(mode);
  std::vector<std::uint8_t> packet;
  model::append_packet(header, payload, 0, packet);
  return packet;
}

void parse(benchmark::State& state, const std::vector<std::uint8_t>& packet) {
  model::PacketView view;
  for (auto _ : state) {
    if (model::parse_packet(packet, view) != model::PacketError::none) {
      state.SkipWithError("the packet is bad");
      break;
    }
    benchmark::DoNotOptimize(view);
  }
  bench::set_counters(state, 1, packet.size());
}

void parse_and_unpack(benchmark::State& state, const std::vector<std::uint8_t>& packet) {
  model::PacketView view;
  model::Moments moments;
  moments.resize(kColumns);
  for (auto _ : state) {
    if (model::parse_packet(packet, view) != model::PacketError::none) {
      state.SkipWithError("the packet is bad");
      break;
    }
    model::unpack_moments(static_cast<model::Mode>(view.header.mode), kColumns, view.payload.data(), moments.view());
    benchmark::ClobberMemory();
  }
  bench::set_counters(state, 1, packet.size());
}

// The speed of the strongest runs beside that of all lit pixels of the same frames.
void print_runs(const Collector& collector, nlohmann::ordered_json& results) {
  for (const std::string lines : {"lines", "reflections"}) {
    for (const std::string mode : {"binary", "grey"}) {
      for (const std::string place : {"memory", "cache"}) {
        const std::string name = lines + "/" + place + "/" + mode;
        const double all = collector.median(name + "/all");
        for (const std::string gap : {"gap_0", "gap_3"}) {
          const double strongest = collector.median(name + "/" + gap);
          if (all > 0 && strongest > 0) {
            std::printf("strongest run, %-11s %-6s %-6s %s: %7.0f frames/s, %3.0f %% of all lit pixels\n",
                        lines.c_str(), mode.c_str(), place.c_str(), gap.c_str(), strongest / kFrameBytes,
                        100 * strongest / all);
            results["strongest_run"][lines][mode][place][gap] = {{"per_s", strongest / kFrameBytes},
                                                                 {"share_of_all", strongest / all}};
          }
        }
      }
    }
  }
}

nlohmann::ordered_json print_ratios(const Collector& collector) {
  nlohmann::ordered_json results;
  const double ceiling = bench::read_ceiling(collector);
  const double one_stream = collector.median("read/one_stream");
  results["read_ceiling_gb_per_s"] = ceiling * 1e-9;
  results["one_stream_gb_per_s"] = one_stream * 1e-9;
  for (const char* mode : {"binary", "grey", "grey_over"}) {
    const double memory = collector.median(std::string("moments/memory/") + mode);
    const double cache = collector.median(std::string("moments/cache/") + mode);
    if (one_stream > 0 && memory > 0 && cache > 0) {
      std::printf(
          "moments %-9s: %7.0f frames/s from memory, %3.0f %% of the read ceiling, %3.0f %% of one stream; "
          "%7.0f frames/s in cache\n",
          mode, memory / kFrameBytes, 100 * memory / ceiling, 100 * memory / one_stream, cache / kFrameBytes);
      results[mode] = {{"memory_per_s", memory / kFrameBytes},
                       {"share_of_read_ceiling", memory / ceiling},
                       {"share_of_one_stream", memory / one_stream},
                       {"cache_per_s", cache / kFrameBytes}};
    }
  }
  for (const std::string mode : {"binary", "grey"}) {
    const double memory = collector.median("moments/memory/twelve_bits/" + mode);
    const double cache = collector.median("moments/cache/twelve_bits/" + mode);
    if (one_stream > 0 && memory > 0 && cache > 0) {
      std::printf("moments %-6s, 12 bits in 16: %7.0f frames/s from memory, %3.0f %% of one stream; %7.0f in cache\n",
                  mode.c_str(), memory / (2 * kFrameBytes), 100 * memory / one_stream, cache / (2 * kFrameBytes));
      results["twelve_bits"][mode] = {{"memory_per_s", memory / (2 * kFrameBytes)},
                                      {"share_of_one_stream", memory / one_stream},
                                      {"cache_per_s", cache / (2 * kFrameBytes)}};
    }
  }
  print_runs(collector, results);
  return results;
}

void add_runs(const std::string& lines, const FrameBuffer& buffer) {
  for (const auto& [name, measure] : runs_cases()) {
    for (const auto& [place, some] : {std::pair{"memory", buffer.frames()}, {"cache", kFramesInCache}}) {
      bench::add(lines + "/" + place + "/" + name, [&buffer, measure = measure, some = some](benchmark::State& state) {
        take_runs(state, buffer, measure, some);
      });
    }
  }
}

int run(int frames) {
  const FrameBuffer buffer(frames);
  FrameBuffer lines(frames);
  FrameBuffer reflections(frames);
  lines.draw_lines(0);
  reflections.draw_lines(16);
  bench::require(results_are_right(buffer) && runs_are_right(lines) && runs_are_right(reflections),
                 "the moments are wrong");
  const std::vector<std::uint8_t> binary = packet_of(model::Mode::binary, buffer.frame(0));
  const std::vector<std::uint8_t> grey = packet_of(model::Mode::grey, buffer.frame(0));

  bench::add_read_ceiling(buffer.bytes());
  for (const auto& [name, mode] :
       {std::pair{"binary", model::Mode::binary}, {"grey", model::Mode::grey}, {"grey_over", model::Mode::grey_over}}) {
    for (const auto& [place, some] : {std::pair{"memory", frames}, {"cache", kFramesInCache}}) {
      bench::add(
          std::string("moments/") + place + "/" + name,
          [&buffer, mode = mode, some = some](benchmark::State& state) { take_moments(state, buffer, mode, some); });
    }
  }
  const int wide_frames = frames / 2;
  std::vector<std::uint16_t> wide(static_cast<std::size_t>(wide_frames) * kFrameBytes);
  for (std::size_t i = 0; i < wide.size(); ++i) {
    wide[i] = static_cast<std::uint16_t>(16 * buffer.bytes()[i % buffer.bytes().size()]);
  }
  for (const auto& [name, mode] : {std::pair{"binary", model::Mode::binary}, {"grey", model::Mode::grey}}) {
    for (const auto& [place, some] : {std::pair{"memory", wide_frames}, {"cache", kFramesInCache / 2}}) {
      bench::add(
          std::string("moments/") + place + "/twelve_bits/" + name,
          [&wide, mode = mode, some = some](benchmark::State& state) { take_wide_moments(state, wide, mode, some); });
    }
  }
  add_runs("lines", lines);
  add_runs("reflections", reflections);
  bench::add("packet/parse/binary", [&](benchmark::State& state) { parse(state, binary); });
  bench::add("packet/parse_and_unpack/binary", [&](benchmark::State& state) { parse_and_unpack(state, binary); });
  bench::add("packet/parse_and_unpack/grey", [&](benchmark::State& state) { parse_and_unpack(state, grey); });

  return bench::run_registered(
      {"bench_model", "Column moments on the host, frames of 96 x 512, one core", "bytes_per_second"}, print_ratios);
}

}  // namespace
}  // namespace selfproj::test

int main(int argc, char** argv) {
  int frames = 8000;
  std::vector<std::string> words;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const std::string option = "--frames=";
    if (!word.starts_with(option)) {
      words.push_back(word);
      continue;
    }
    char* end = nullptr;
    const long value = std::strtol(word.c_str() + option.size(), &end, 10);
    if (*end != '\0' || value < selfproj::test::kFramesInCache || value > 1000000) {
      std::fprintf(stderr, "bench_model: %s: not a number in %d..1000000\n", word.c_str(),
                   selfproj::test::kFramesInCache);
      return 2;
    }
    frames = static_cast<int>(value);
  }
  return selfproj::bench::main_of("bench_model", words, [&] { return selfproj::test::run(frames); });
}
