#include "host/capture/settle.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/driver/clock.h"
#include "selfproj/files/user_error.h"

namespace selfproj::capture {
namespace {

constexpr int kFlashes = 16;
constexpr double kMarginMs = 2;
constexpr double kJitterMs = 5;  // of the times themselves
constexpr std::int64_t kMillisecond = 1'000'000;
constexpr std::int64_t kFirstWait = 700 * kMillisecond;  // before anything is known
constexpr std::int64_t kKnownWait = 200 * kMillisecond;  // more than twice the known time
constexpr std::int64_t kMaxDelay = 3000 * kMillisecond;
constexpr double kMinContrast = 3;

double milliseconds(std::int64_t ns) { return static_cast<double>(ns) / static_cast<double>(kMillisecond); }

// The time from one image to the next, where nothing waits.
std::int64_t interval_of(Shots& shots) {
  constexpr int kImages = 4;
  shots.take_after(driver::now_ns());
  const std::int64_t first = shots.arrived_ns();
  for (int i = 0; i < kImages; ++i) {
    shots.take_after(shots.arrived_ns() + 1);
  }
  return (shots.arrived_ns() - first) / kImages;
}

}  // namespace

Settle settle_of(const std::vector<FlashTimes>& flashes) {
  if (flashes.empty()) {
    throw std::invalid_argument("settle: no flashes");
  }
  double latest_old = 0;
  double earliest_new = std::numeric_limits<double>::max();
  double latest_new = 0;
  for (const FlashTimes& flash : flashes) {
    latest_old = std::max(latest_old, flash.old_ms);
    earliest_new = std::min(earliest_new, flash.new_ms);
    latest_new = std::max(latest_new, flash.new_ms);
  }
  const double overlap = std::max(latest_old - earliest_new, 0.0);
  const bool one_delay = overlap <= kJitterMs;
  Settle settle{.min_ms = one_delay ? std::min(latest_old, earliest_new) : earliest_new,
                .max_ms = one_delay ? std::max(latest_old, earliest_new) : latest_new};
  const double more = one_delay ? 0.1 * settle.max_ms + overlap : settle.max_ms - settle.min_ms;
  settle.settle_ms = settle.max_ms + std::max(more, kMarginMs);
  return settle;
}

WhiteAndBlack take_white_and_black(Shots& shots, const std::string& camera, std::optional<double> settle_ms) {
  const std::int64_t wait = settle_ms ? static_cast<std::int64_t>(2e6 * *settle_ms) + kKnownWait : kFirstWait;
  WhiteAndBlack levels;
  levels.black = shots.take_after(shots.show(std::uint8_t{0}) + wait);
  levels.white = shots.take_after(shots.show(std::uint8_t{255}) + wait);
  const double black = mean_grey(levels.black);
  const double white = mean_grey(levels.white);
  if (white - black < kMinContrast) {
    throw UserError(camera,
                    fmt::format("sees no light from the projector: the mean grey is {:.1f} under black and {:.1f} "
                                "under white",
                                black, white));
  }
  return levels;
}

Settle measure_settle(Shots& shots, const WhiteAndBlack& levels, const std::string& camera) {
  std::vector<FlashTimes> flashes;
  const std::int64_t interval = interval_of(shots);
  int wanted = kFlashes;
  for (int i = 0; i < wanted; ++i) {
    const bool to_white = i % 2 == 1;  // white was shown last
    // Flash and trigger fall at another part of the interval each time, in orders that fill it evenly: some cameras
    // have a clock of their own, others begin with the trigger.
    shots.wait_until(driver::now_ns() + interval * (i * 5 % kFlashes) / kFlashes);
    const std::int64_t shown = shots.show(static_cast<std::uint8_t>(to_white ? 255 : 0));
    FlashTimes times;
    std::int64_t next = shown + interval * (i * 7 % kFlashes) / kFlashes;
    for (;;) {
      const images::Image& image = shots.take_after(next);
      const std::int64_t after = shots.arrived_ns() - shown;
      if (to_white ? all_white(image, levels) : all_black(image, levels)) {
        times.new_ms = milliseconds(after);
        break;
      }
      times.old_ms = milliseconds(after);
      if (after > kMaxDelay) {
        throw UserError(camera,
                        "sees no change of the projector's light within 3 s; does the projector show this display?");
      }
      next = shots.arrived_ns() + 1;
    }
    flashes.push_back(times);
    // Where an image takes more than half the delay, a single delay explains a few flashes even if delays spread.
    if (i + 1 == kFlashes && 2 * milliseconds(interval) > settle_of(flashes).max_ms) {
      wanted = 3 * kFlashes;
    }
  }
  return settle_of(flashes);
}

ExposureCheck check_exposure(const WhiteAndBlack& levels) {
  constexpr int kLitAbove = 10;
  constexpr double kMaxSaturated = 0.005;
  constexpr int kShort = 150;
  constexpr double kWanted = 220;
  std::array<std::size_t, 256> lit{};
  std::size_t lit_count = 0;
  std::size_t saturated = 0;
  const std::size_t pixels = levels.white.pixels.size();
  for (std::size_t i = 0; i < pixels; ++i) {
    const int white = levels.white.pixels[i];
    saturated += white == 255 ? 1 : 0;
    if (white - levels.black.pixels[i] >= kLitAbove) {
      ++lit[static_cast<std::size_t>(white)];
      ++lit_count;
    }
  }
  const auto share = [&](std::size_t count) { return static_cast<double>(count) / static_cast<double>(pixels); };
  ExposureCheck check{.saturated = share(saturated), .dark = share(pixels - lit_count)};
  std::size_t above = 0;
  int brightest = 255;  // 0.5 % of the lit pixels are above it
  for (; brightest > 0 && above + lit[static_cast<std::size_t>(brightest)] <= lit_count / 200; --brightest) {
    above += lit[static_cast<std::size_t>(brightest)];
  }
  if (check.saturated > kMaxSaturated) {
    check.factor = 0.5;
  } else if (lit_count > 0 && brightest < kShort) {
    check.factor = kWanted / brightest;
  }
  return check;
}

std::string exposure_text(const ExposureCheck& check) {
  return fmt::format("{:.1f} % of the pixels are saturated under white, {:.1f} % are dark{}", 100 * check.saturated,
                     100 * check.dark,
                     !check.factor ? "" : fmt::format("; try {:.2g} times the exposure", *check.factor));
}

}  // namespace selfproj::capture
