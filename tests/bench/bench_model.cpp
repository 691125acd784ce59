// How fast the models are, beside how fast this machine reads memory.
//
//     bench_model [--frames=N] [--benchmark_...]
//
// Frames of 96 x 512 pixels lie one after another in a buffer far larger than the caches (N of them, 8000 by default:
// 393 MB). One thread takes the moments of all of them, in each mode; and reads all of them as fast as it can, in two
// ways, the faster of which is the ceiling. The measurements are repeated (7 times) in random order; what is compared
// are medians. Before anything is timed the results are compared with the definition; a difference ends the program
// with exit status 1.
#include <benchmark/benchmark.h>

#if defined(__linux__)
#include <sys/mman.h>
#endif

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <map>
#include <memory>
#include <new>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "model/column_moments.h"
#include "model/packet.h"
#include "tests/bench/collector.h"
#include "tests/support/reference_moments.h"

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && __GNUC__ >= 12
#define SELFPROJ_BENCH_CLONES __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define SELFPROJ_BENCH_CLONES
#endif

namespace selfproj {
namespace {

using bench::Collector;

constexpr int kRows = 96;
constexpr int kColumns = 512;
constexpr int kThreshold = 128;
constexpr std::size_t kFrameBytes = static_cast<std::size_t>(kRows) * kColumns;
constexpr int kFramesInCache = 4;

// Memory for frames, in huge pages where the system has them.
class FrameBuffer {
 public:
  explicit FrameBuffer(int frames) : frames_(frames) {
    constexpr std::size_t kHugePage = std::size_t{2} << 20;
    const std::size_t size = static_cast<std::size_t>(frames) * kFrameBytes;
    bytes_.reset(
        static_cast<std::uint8_t*>(std::aligned_alloc(kHugePage, (size + kHugePage - 1) / kHugePage * kHugePage)));
    if (bytes_ == nullptr) {
      throw std::bad_alloc();
    }
#if defined(__linux__)
    madvise(bytes_.get(), size, MADV_HUGEPAGE);
#endif
    std::mt19937_64 random(1);
    for (std::size_t i = 0; i < size; i += sizeof(std::uint64_t)) {
      const std::uint64_t pixels = random();
      std::memcpy(bytes_.get() + i, &pixels, sizeof pixels);
    }
  }

  int frames() const { return frames_; }
  ImageView frame(int i) const {
    return {bytes_.get() + static_cast<std::size_t>(i) * kFrameBytes, kRows, kColumns, kColumns};
  }
  std::span<const std::uint8_t> bytes() const {
    return {bytes_.get(), static_cast<std::size_t>(frames_) * kFrameBytes};
  }

 private:
  struct Free {
    void operator()(std::uint8_t* bytes) const { std::free(bytes); }
  };

  int frames_;
  std::unique_ptr<std::uint8_t, Free> bytes_;
};

// The exclusive-or of all 8-byte words, from one end to the other.
SELFPROJ_BENCH_CLONES std::uint64_t read_one_stream(const std::uint8_t* bytes, std::size_t size) {
  constexpr std::size_t kLanes = 64;  // words a round: 8 cache lines
  std::uint64_t lanes[kLanes] = {};
  for (std::size_t at = 0; at + sizeof lanes <= size; at += sizeof lanes) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      std::uint64_t word;
      std::memcpy(&word, bytes + at + k * sizeof word, sizeof word);
      lanes[k] ^= word;
    }
  }
  std::uint64_t all = 0;
  for (const std::uint64_t lane : lanes) {
    all ^= lane;
  }
  return all;
}

// The same of four neighbouring pages of 4 KiB at once, which keeps more of the processor's prefetchers busy.
SELFPROJ_BENCH_CLONES std::uint64_t read_four_streams(const std::uint8_t* bytes, std::size_t size) {
  constexpr std::size_t kPage = 4096;
  constexpr std::size_t kLanes = 16;  // words a round and page: 2 cache lines
  std::uint64_t lanes[4][kLanes] = {};
  for (std::size_t group = 0; group + 4 * kPage <= size; group += 4 * kPage) {
    for (std::size_t at = group; at < group + kPage; at += kLanes * sizeof(std::uint64_t)) {
      for (std::size_t page = 0; page < 4; ++page) {
        for (std::size_t k = 0; k < kLanes; ++k) {
          std::uint64_t word;
          std::memcpy(&word, bytes + at + page * kPage + k * sizeof word, sizeof word);
          lanes[page][k] ^= word;
        }
      }
    }
  }
  std::uint64_t all = 0;
  for (const auto& page : lanes) {
    for (const std::uint64_t lane : page) {
      all ^= lane;
    }
  }
  return all;
}

bool results_are_right(const FrameBuffer& buffer) {
  Moments moments;
  moments.resize(kColumns);
  for (int i = 0; i < std::min(buffer.frames(), 16); ++i) {
    for (const Mode mode : {Mode::binary, Mode::grey, Mode::grey_over}) {
      column_moments(buffer.frame(i), mode, kThreshold, moments.view());
      if (test::wrong_columns(buffer.frame(i), mode, kThreshold, moments) != 0) {
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

using Read = std::uint64_t (*)(const std::uint8_t*, std::size_t);

void read_memory(benchmark::State& state, const FrameBuffer& buffer, Read read) {
  for (auto _ : state) {
    benchmark::DoNotOptimize(read(buffer.bytes().data(), buffer.bytes().size()));
  }
  set_counters(state, buffer.frames(), kFrameBytes);
}

void take_moments(benchmark::State& state, const FrameBuffer& buffer, Mode mode, int frames) {
  Moments moments;
  moments.resize(kColumns);
  const MomentsView out = moments.view();
  for (auto _ : state) {
    for (int i = 0; i < frames; ++i) {
      column_moments(buffer.frame(i), mode, kThreshold, out);
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

void print_ratios(const Collector& collector) {
  const double ceiling = std::max(collector.median("read/one_stream"), collector.median("read/four_streams"));
  std::printf("\nread ceiling: %.2f GB/s (one thread, from memory; medians)\n", ceiling * 1e-9);
  for (const char* mode : {"binary", "grey", "grey_over"}) {
    const double memory = collector.median(std::string("moments/memory/") + mode);
    const double cache = collector.median(std::string("moments/cache/") + mode);
    if (ceiling > 0 && memory > 0 && cache > 0) {
      std::printf("moments %-9s: %7.0f frames/s from memory, %5.1f %% of the read ceiling; %7.0f frames/s in cache\n",
                  mode, memory / kFrameBytes, 100 * memory / ceiling, cache / kFrameBytes);
    }
  }
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

  const auto add_read = [&](const char* name, Read read) {
    benchmark::RegisterBenchmark(name, [&buffer, read](benchmark::State& state) { read_memory(state, buffer, read); });
  };
  add_read("read/one_stream", read_one_stream);
  add_read("read/four_streams", read_four_streams);
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

  Collector collector("bytes_per_second");
  benchmark::RunSpecifiedBenchmarks(&collector);
  if (!collector.failed()) {
    print_ratios(collector);
  }
  benchmark::Shutdown();
  return collector.failed() ? 1 : 0;
}

}  // namespace
}  // namespace selfproj

int main(int argc, char** argv) {
  try {
    return selfproj::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_model: %s\n", error.what());
    return 1;
  }
}
