// Measures the read ceiling, the speed at which one thread reads memory, in two ways. The faster one counts.
#ifndef SELFPROJ_TESTS_BENCH_READ_CEILING_H
#define SELFPROJ_TESTS_BENCH_READ_CEILING_H

#include <benchmark/benchmark.h>

#if defined(__linux__)
#include <sys/mman.h>
#endif

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <random>
#include <span>
#include <utility>

#include "model/cpu_clones.h"
#include "tests/bench/collector.h"

namespace selfproj::bench {

// Random bytes, in huge pages if the system has them. The size is a multiple of 8.
class RandomBuffer {
 public:
  explicit RandomBuffer(std::size_t size) : size_(size) {
    constexpr std::size_t kHugePage = std::size_t{2} << 20;
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

  [[nodiscard]] std::uint8_t* data() { return bytes_.get(); }
  [[nodiscard]] const std::uint8_t* data() const { return bytes_.get(); }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  struct Free {
    void operator()(std::uint8_t* bytes) const { std::free(bytes); }
  };

  std::size_t size_;
  std::unique_ptr<std::uint8_t, Free> bytes_;
};

// The exclusive-or of all 8-byte words, from one end to the other.
SELFPROJ_CLONES inline std::uint64_t read_one_stream(const std::uint8_t* bytes, std::size_t size) {
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

// The same, reading four neighbouring pages of 4 KiB in parallel, which keeps more of the processor's prefetchers busy.
SELFPROJ_CLONES inline std::uint64_t read_four_streams(const std::uint8_t* bytes, std::size_t size) {
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

// Adds the two ways of reading `bytes`, which should be far larger than the caches, to the benchmarks.
inline void add_read_ceiling(std::span<const std::uint8_t> bytes) {
  using Read = std::uint64_t (*)(const std::uint8_t*, std::size_t);
  const std::pair<const char*, Read> reads[] = {{"read/one_stream", read_one_stream},
                                                {"read/four_streams", read_four_streams}};
  for (const auto& [name, read] : reads) {
    add(name, [bytes, read = read](benchmark::State& state) {
      for (auto _ : state) {
        benchmark::DoNotOptimize(read(bytes.data(), bytes.size()));
      }
      set_counters(state, 1, bytes.size());
    });
  }
}

// Prints and returns the bytes per second from a collector of "bytes_per_second".
inline double read_ceiling(const Collector& collector) {
  const double one = collector.median("read/one_stream");
  const double four = collector.median("read/four_streams");
  const double ceiling = std::max(one, four);
  std::printf("\nread ceiling: %.2f GB/s (one thread, from memory; medians; one stream %.2f, four %.2f)\n",
              ceiling * 1e-9, one * 1e-9, four * 1e-9);
  return ceiling;
}

}  // namespace selfproj::bench

#endif  // SELFPROJ_TESTS_BENCH_READ_CEILING_H
