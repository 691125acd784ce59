// Measures the speed of the host's column moments, beside the speed at which this machine reads memory, and the speed
// of reading packets.
//
//     bench_model [--frames=N] [--benchmark_...]
//
// Frames of 96 x 512 pixels lie one after another in a buffer far larger than the caches (N of them, 8000 by default:
// 393 MB). One thread computes the moments of all frames in each mode. It also reads all frames as fast as it can, in
// two ways; the faster one is the ceiling. The measurements are repeated 7 times in random order, and their medians are
// compared. Before the first measurement the results are compared with the model; a difference ends the program with
// exit status 1.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

#include "host/light_section/fast_moments.h"
#include "model/column_moments.h"
#include "model/packet.h"
#include "tests/bench/collector.h"
#include "tests/bench/read_ceiling.h"

namespace selfproj {
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
  ImageView frame(int i) const {
    return {bytes_.data() + static_cast<std::size_t>(i) * kFrameBytes, kRows, kColumns, kColumns};
  }
  std::span<const std::uint8_t> bytes() const { return {bytes_.data(), bytes_.size()}; }

 private:
  int frames_;
  bench::RandomBuffer bytes_;
};

bool results_are_right(const FrameBuffer& buffer) {
  Moments moments;
  Moments right;
  moments.resize(kColumns);
  right.resize(kColumns);
  for (int i = 0; i < std::min(buffer.frames(), 16); ++i) {
    for (const Mode mode : {Mode::binary, Mode::grey, Mode::grey_over}) {
      column_moments(buffer.frame(i), mode, kThreshold, right.view());
      fast_column_moments(buffer.frame(i), mode, kThreshold, moments.view());
      if (moments != right) {
        return false;
      }
    }
  }
  return true;
}

void set_counters(benchmark::State& state, std::int64_t items, std::size_t bytes_of_one) {
  state.SetItemsProcessed(state.iterations() * items);
  state.SetBytesProcessed(state.iterations() * items * static_cast<std::int64_t>(bytes_of_one));
}

void take_moments(benchmark::State& state, const FrameBuffer& buffer, Mode mode, int frames) {
  Moments moments;
  moments.resize(kColumns);
  const MomentsView out = moments.view();
  for (auto _ : state) {
    for (int i = 0; i < frames; ++i) {
      fast_column_moments(buffer.frame(i), mode, kThreshold, out);
      benchmark::ClobberMemory();
    }
  }
  set_counters(state, frames, kFrameBytes);
}

// A good packet of moments of kColumns columns.
std::vector<std::uint8_t> packet_of(Mode mode, const ImageView& image) {
  Moments moments;
  moments.resize(kColumns);
  column_moments(image, mode, kThreshold, moments.view());
  std::vector<std::uint8_t> payload(moments_payload_bytes(mode, kColumns));
  pack_moments(mode, kColumns, moments.view(), payload.data());
  PacketHeader header;
  header.kind = spec::kKindMoments;
  header.columns = kColumns;
  header.rows = kRows;
  header.mode = static_cast<std::uint8_t>(mode);
  std::vector<std::uint8_t> packet;
  append_packet(header, payload, 0, packet);
  return packet;
}

void parse(benchmark::State& state, const std::vector<std::uint8_t>& packet) {
  PacketView view;
  for (auto _ : state) {
    if (parse_packet(packet, view) != PacketError::none) {
      state.SkipWithError("the packet is bad");
      break;
    }
    benchmark::DoNotOptimize(view);
  }
  set_counters(state, 1, packet.size());
}

void parse_and_unpack(benchmark::State& state, const std::vector<std::uint8_t>& packet) {
  PacketView view;
  Moments moments;
  moments.resize(kColumns);
  for (auto _ : state) {
    if (parse_packet(packet, view) != PacketError::none) {
      state.SkipWithError("the packet is bad");
      break;
    }
    unpack_moments(static_cast<Mode>(view.header.mode), kColumns, view.payload.data(), moments.view());
    benchmark::ClobberMemory();
  }
  set_counters(state, 1, packet.size());
}

nlohmann::ordered_json print_ratios(const Collector& collector) {
  nlohmann::ordered_json results;
  const double ceiling = bench::read_ceiling(collector);
  results["read_ceiling_gb_per_s"] = ceiling * 1e-9;
  for (const char* mode : {"binary", "grey", "grey_over"}) {
    const double memory = collector.median(std::string("moments/memory/") + mode);
    const double cache = collector.median(std::string("moments/cache/") + mode);
    if (ceiling > 0 && memory > 0 && cache > 0) {
      std::printf("moments %-9s: %7.0f frames/s from memory, %5.1f %% of the read ceiling; %7.0f frames/s in cache\n",
                  mode, memory / kFrameBytes, 100 * memory / ceiling, cache / kFrameBytes);
      results[mode] = {{"memory_per_s", memory / kFrameBytes},
                       {"share_of_read_ceiling", memory / ceiling},
                       {"cache_per_s", cache / kFrameBytes}};
    }
  }
  return results;
}

int run(int argc, char** argv) {
  int frames = 8000;
  std::vector<std::string> words;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const std::string option = "--frames=";
    if (word.starts_with(option)) {
      char* end = nullptr;
      const long value = std::strtol(word.c_str() + option.size(), &end, 10);
      if (*end != '\0' || value < kFramesInCache || value > 1000000) {
        std::fprintf(stderr, "bench_model: %s: not a number in %d..1000000\n", word.c_str(), kFramesInCache);
        return 2;
      }
      frames = static_cast<int>(value);
    } else {
      words.push_back(word);
    }
  }
  if (!bench::initialize(argv[0], words)) {
    return 2;
  }

  const FrameBuffer buffer(frames);
  if (!results_are_right(buffer)) {
    std::fprintf(stderr, "bench_model: the moments are wrong\n");
    return 1;
  }
  const std::vector<std::uint8_t> binary = packet_of(Mode::binary, buffer.frame(0));
  const std::vector<std::uint8_t> grey = packet_of(Mode::grey, buffer.frame(0));

  bench::add_read_ceiling(buffer.bytes());
  for (const auto& [name, mode] :
       {std::pair{"binary", Mode::binary}, {"grey", Mode::grey}, {"grey_over", Mode::grey_over}}) {
    for (const auto& [place, some] : {std::pair{"memory", frames}, {"cache", kFramesInCache}}) {
      benchmark::RegisterBenchmark(
          (std::string("moments/") + place + "/" + name).c_str(),
          [&buffer, mode = mode, some = some](benchmark::State& state) { take_moments(state, buffer, mode, some); });
    }
  }
  benchmark::RegisterBenchmark("packet/parse/binary", [&](benchmark::State& state) { parse(state, binary); });
  benchmark::RegisterBenchmark("packet/parse_and_unpack/binary",
                               [&](benchmark::State& state) { parse_and_unpack(state, binary); });
  benchmark::RegisterBenchmark("packet/parse_and_unpack/grey",
                               [&](benchmark::State& state) { parse_and_unpack(state, grey); });

  return bench::run_registered(
      {"bench_model", "Column moments on the host, frames of 96 x 512, one core", "bytes_per_second"}, print_ratios);
}

}  // namespace
}  // namespace selfproj

int main(int argc, char** argv) { return selfproj::bench::main_of("bench_model", argc, argv, selfproj::run); }
