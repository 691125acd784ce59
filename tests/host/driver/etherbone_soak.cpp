// Soak of the registers over Etherbone: random accesses through a network that loses, repeats and delays datagrams.
//
//     etherbone_soak [ACCESSES] [SEED]      100,000 accesses by default
//
// The first wrong access ends the program with exit status 1.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "host/files/results_file.h"
#include "tests/host/driver/etherbone_accesses.h"

namespace {

int g_accesses = 100'000;
std::uint64_t g_seed = 1;

}  // namespace

namespace selfproj::test {
namespace {

TEST(Soak, EveryWriteOnceOrRefused) {
  constexpr int kPercent = 3;
  const AccessCounts counts = random_accesses(g_accesses, kPercent, g_seed);
  ASSERT_FALSE(HasFailure());
  std::printf("%d accesses, %llu writes, each performed once or refused, 0 wrong\n", g_accesses,
              static_cast<unsigned long long>(counts.writes));
  write_results("etherbone_soak", "Random accesses to the registers of a board through a network with faults",
                {{"accesses", g_accesses},
                 {"reads", counts.reads},
                 {"writes", counts.writes},
                 {"writes_refused", counts.refused},
                 {"wrong", 0},
                 {"datagrams_lost", counts.lost},
                 {"datagrams_repeated", counts.repeated},
                 {"datagrams_late", counts.late}});
}

}  // namespace
}  // namespace selfproj::test

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  if (argc > 1) {
    g_accesses = std::atoi(argv[1]);
  }
  if (argc > 2) {
    g_seed = std::strtoull(argv[2], nullptr, 10);
  }
  return RUN_ALL_TESTS();
}
