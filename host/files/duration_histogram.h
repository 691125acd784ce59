// Statistics of many durations: percentiles without keeping the numbers.
#ifndef SELFPROJ_HOST_FILES_DURATION_HISTOGRAM_H
#define SELFPROJ_HOST_FILES_DURATION_HISTOGRAM_H

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace selfproj {

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
    std::uint64_t seen = 0;
    for (std::size_t bin = 0; bin < kBins; ++bin) {
      seen += bins_[bin];
      if (seen > 0 && seen >= wanted) {
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

}  // namespace selfproj

#endif  // SELFPROJ_HOST_FILES_DURATION_HISTOGRAM_H
