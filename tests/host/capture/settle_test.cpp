// Tests how settle times and exposures are judged.
#include "host/capture/settle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// Images every `interval` ms, which begin at random after each flash, and a delay of `least` to `most` ms.
std::vector<capture::FlashTimes> flashes_of(Random& random, int least, int most, int interval) {
  std::vector<capture::FlashTimes> flashes;
  for (int i = 0; i < 16; ++i) {
    const int delay = random.between(10 * least, 10 * most);  // 0.1 ms
    int at = random.between(0, 10 * interval);
    capture::FlashTimes times;
    for (; at < delay; at += 10 * interval) {
      times.old_ms = at / 10.0;
    }
    times.new_ms = at / 10.0;
    flashes.push_back(times);
  }
  return flashes;
}

TEST(Settle, OneDelayIsFoundWithinTenMilliseconds) {
  for (const std::uint64_t seed : seeds(200)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const int delay = random.between(0, 150);
    const capture::Settle settle = capture::settle_of(flashes_of(random, delay, delay, 30));
    ASSERT_LE(settle.min_ms, delay);
    ASSERT_GE(settle.max_ms, delay);
    ASSERT_GE(settle.settle_ms, delay + 2);
    ASSERT_LE(settle.max_ms, delay + 10) << "of 16 images at random times in 30 ms one comes within 10";
  }
}

TEST(Settle, SpreadDelaysAreWaitedFor) {
  int too_short = 0;
  for (const std::uint64_t seed : seeds(1000)) {
    Random random(seed);
    const capture::Settle settle = capture::settle_of(flashes_of(random, 0, 120, 5));
    too_short += settle.settle_ms < 120 ? 1 : 0;
    ASSERT_LT(settle.settle_ms, 250);
  }
  EXPECT_EQ(too_short, 0);
  EXPECT_THROW(capture::settle_of({}), std::invalid_argument);
}

TEST(ExposureCheck, SaysWhatIsTooBrightAndTooDark) {
  const auto check = [](std::uint8_t lit, int saturated, int dark) {
    std::vector<std::uint8_t> white(1000, lit);
    std::fill_n(white.begin(), saturated, std::uint8_t{255});
    std::fill_n(white.end() - dark, dark, std::uint8_t{9});
    return capture::check_exposure({{10, 100, white}, {10, 100, std::vector<std::uint8_t>(1000, 0)}});
  };
  EXPECT_FALSE(check(200, 4, 300).factor.has_value());
  EXPECT_DOUBLE_EQ(check(200, 4, 300).dark, 0.3);
  EXPECT_EQ(check(200, 6, 0).factor, 0.5);
  EXPECT_EQ(check(110, 0, 100).factor, 2);
  EXPECT_FALSE(check(9, 0, 0).factor.has_value()) << "no light at all: nothing can be proposed";
  EXPECT_EQ(capture::exposure_text(check(200, 20, 300)),
            "2.0 % of the pixels are saturated under white, 30.0 % are dark; try 0.5 times the exposure");
}

}  // namespace
}  // namespace selfproj::test
