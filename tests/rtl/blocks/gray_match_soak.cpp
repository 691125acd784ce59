// Soak of the matching block: random look-ups, every one compared with the model.
//
//     gray_match_soak [LOOKUPS] [FIRST_SEED]      10,000,000 look-ups from seed 1 on by default
//
// The last line says what was compared. The first mismatch ends the program with exit status 1.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "Vsp_gray_match_ports.h"
#include "host/files/results_file.h"
#include "tests/rtl/blocks/gray_match_bench.h"

namespace {

std::uint64_t g_lookups = 10'000'000;
std::uint64_t g_seed = 1;

}  // namespace

namespace selfproj::test {
namespace {

TEST(Soak, EveryLookUpEqualsTheModel) {
  constexpr GrayMatchBuild kBuild{1024, 4, 2};
  std::uint64_t pixels = 0;
  std::uint64_t lates = 0;
  for (std::uint64_t seed = g_seed; pixels < g_lookups; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed << "; repeat with: gray_match_soak 1 " << seed);
    Random random(seed);
    GrayMatchBench<Vsp_gray_match> bench(random, kBuild);
    bench.late_permille = random.chance(80) ? 0 : 1;
    play_match_frames(bench, kBuild, 200, random);
    ASSERT_FALSE(HasFailure());
    pixels += bench.pixels();
    lates += bench.lates();
  }
  std::printf("matched %llu look-ups, 0 mismatches; %llu frames were abandoned for a late word\n",
              static_cast<unsigned long long>(pixels), static_cast<unsigned long long>(lates));
  write_results("gray_match_soak", "The matching block's RTL against the model, random look-ups",
                {{"lookups", pixels}, {"mismatches", 0}, {"frames_abandoned", lates}});
}

}  // namespace
}  // namespace selfproj::test

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  if (argc > 1) {
    g_lookups = std::strtoull(argv[1], nullptr, 10);
  }
  if (argc > 2) {
    g_seed = std::strtoull(argv[2], nullptr, 10);
  }
  return RUN_ALL_TESTS();
}
