// Starts the matching block's count of late words near its end, where it carries through every bit and wraps. (Not for
// netlists, because their registers have other names.)
#include <gtest/gtest.h>

#include <cstdint>

#include "Vsp_gray_match_small_ports.h"
#include "tests/rtl/blocks/gray_match_bench.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

TEST(GrayMatchSmall, LateWordsAreCountedIn32Bits) {
  constexpr GrayMatchBuild kBuild = {6, 2, 5};
  for (int bit = 8; bit <= 32; ++bit) {
    Random random(static_cast<std::uint64_t>(bit));
    GrayMatchBench<Vsp_gray_match_small> bench(random, kBuild);
    bench.lates_before = static_cast<std::uint32_t>((std::uint64_t{1} << bit) - 2);
    bench.dut().late_o = bench.lates_before;  // the port is the register
    bench.late_permille = 300;
    play_match_frames(bench, kBuild, 20, random);
    EXPECT_GT(bench.lates(), 2U);
    ASSERT_FALSE(HasFailure());
  }
}

}  // namespace
}  // namespace selfproj::test
