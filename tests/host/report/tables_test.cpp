#include "host/report/tables.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

std::string fixed(double value) {
  std::array<char, report::kMaxNumberText> text{};
  return {text.data(), report::append_tenth_micrometres(text.data(), value)};
}

std::string integer(std::uint64_t value) {
  std::array<char, report::kMaxNumberText> text{};
  return {text.data(), report::append_integer(text.data(), value)};
}

TEST(NumberText, Integers) {
  EXPECT_EQ(integer(0), "0");
  EXPECT_EQ(integer(716800), "716800");
  EXPECT_EQ(integer(std::numeric_limits<std::uint64_t>::max()), "18446744073709551615");
}

TEST(NumberText, TenthsOfAMicrometre) {
  EXPECT_EQ(fixed(0), "0.0000");
  EXPECT_EQ(fixed(-0.00004), "0.0000");
  EXPECT_EQ(fixed(0.00005), "0.0001");
  EXPECT_EQ(fixed(-0.00005), "-0.0001");
  EXPECT_EQ(fixed(1166.99996), "1167.0000");
  EXPECT_EQ(fixed(-12.3456789), "-12.3457");
  EXPECT_EQ(fixed(999999999999.5), "999999999999.5000");
}

// Whatever the number, the text is within half a unit of its last digit.
TEST(NumberText, TextIsTheNearest) {
  Random random(1);
  for (int i = 0; i < 20000; ++i) {
    const double value =
        std::ldexp(static_cast<double>(random.between(-1000000000, 1000000000)), -random.between(0, 45));
    const std::string text = fixed(value);
    EXPECT_LE(std::abs(std::strtod(text.c_str(), nullptr) - value), 0.5e-4 + 1e-15 * std::abs(value))
        << text << ' ' << value;
    EXPECT_EQ(text.size() - text.find('.'), 5U) << text;
  }
}

TEST(NumberText, RoundNumbers) {
  EXPECT_DOUBLE_EQ(report::round_up(1.0), 1.0);
  EXPECT_DOUBLE_EQ(report::round_up(1.02), 1.5);
  EXPECT_DOUBLE_EQ(report::round_up(0.071), 0.1);
  EXPECT_DOUBLE_EQ(report::round_up(31), 50);
  EXPECT_DOUBLE_EQ(report::round_down(29.9), 20);
  EXPECT_DOUBLE_EQ(report::round_down(0.5), 0.5);
  EXPECT_DOUBLE_EQ(report::round_down(1000), 1000);
  EXPECT_DOUBLE_EQ(report::round_down(0.0199), 0.01);
}

TEST(NumberText, Ticks) {
  EXPECT_EQ(report::ticks(-1.5, 1.5, 6), (std::vector<double>{-1.5, -1, -0.5, 0, 0.5, 1, 1.5}));
  EXPECT_EQ(report::ticks(-60.3, 58, 6), (std::vector<double>{-60, -40, -20, 0, 20, 40}));
  EXPECT_TRUE(report::ticks(1, 1, 5).empty());
  EXPECT_TRUE(report::ticks(2, 1, 5).empty());
  for (const double span : {0.013, 0.3, 1.0, 7.7, 29.0, 431.0}) {
    const std::vector<double> found = report::ticks(0, span, 5);
    EXPECT_GE(found.size(), 3U) << span;
    EXPECT_LE(found.size(), 6U) << span;
  }
  EXPECT_EQ(report::tick_text(0.5, 0.5), "0.5");
  EXPECT_EQ(report::tick_text(-20, 20), "-20");
  EXPECT_EQ(report::tick_text(-1e-9, 20), "0");
  EXPECT_EQ(report::tick_text(-1e-9, 0.01), "0.00");
  EXPECT_EQ(report::tick_text(0.02, 0.01), "0.02");
}

}  // namespace
}  // namespace selfproj::test
