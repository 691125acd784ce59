// The clock that all processes of a machine share, and statistics of durations.
#ifndef SELFPROJ_HOST_DRIVER_CLOCK_H
#define SELFPROJ_HOST_DRIVER_CLOCK_H

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace selfproj::driver {

// Nanoseconds of std::chrono::steady_clock (CLOCK_MONOTONIC).
inline std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

// Tells the processor that this is a waiting loop.
inline void relax() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

// Counts of nanoseconds in bins: one for each number below 64, then 32 for each octave, so that a percentile is at most
// 1/32 above the exact one. Allocates nothing.
class DurationHistogram {
 public:
  // Negative durations count as 0.
  void add(std::int64_t ns) {
    ns = std::max<std::int64_t>(ns, 0);
    ++bins_[bin_of(static_cast<std::uint64_t>(ns))];
    ++count_;
    longest_ = std::max(longest_, ns);
  }

  [[nodiscard]] std::uint64_t count() const { return count_; }

  // The longest duration, exactly; 0 if there is none.
  [[nodiscard]] std::int64_t longest_ns() const { return longest_; }

  // The duration that `share` (0..1) of them do not exceed: the upper end of its bin, or the longest duration. 0 if
  // there is none.
  [[nodiscard]] std::int64_t percentile_ns(double share) const {
    const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count_)));
    std::uint64_t passed = 0;
    for (std::size_t bin = 0; bin < kBins; ++bin) {
      passed += bins_[bin];
      if (passed > 0 && passed >= wanted) {
        return std::min(longest_, last_of(bin));
      }
    }
    return longest_;
  }

 private:
  static constexpr unsigned kSubBits = 5;  // 32 bins an octave
  static constexpr std::size_t kBins = (64 - kSubBits + 1) << kSubBits;

  static std::size_t bin_of(std::uint64_t ns) {
    const auto shift =
        static_cast<unsigned>(std::max(0, static_cast<int>(std::bit_width(ns)) - static_cast<int>(kSubBits) - 1));
    return (std::size_t{shift} << kSubBits) + static_cast<std::size_t>(ns >> shift);
  }
  // The largest number of a bin.
  static std::int64_t last_of(std::size_t bin) {
    if (bin < (std::size_t{2} << kSubBits)) {
      return static_cast<std::int64_t>(bin);
    }
    const std::size_t shift = (bin >> kSubBits) - 1;
    const std::uint64_t top = (bin & ((std::size_t{1} << kSubBits) - 1)) + (std::uint64_t{1} << kSubBits);
    return static_cast<std::int64_t>(((top + 1) << shift) - 1);
  }

  std::array<std::uint64_t, kBins> bins_{};
  std::uint64_t count_ = 0;
  std::int64_t longest_ = 0;
};

}  // namespace selfproj::driver

#endif  // SELFPROJ_HOST_DRIVER_CLOCK_H
