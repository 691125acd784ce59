// Soak of the registers over Etherbone: random accesses through a network that loses, repeats and delays datagrams.
//
//     etherbone_soak [ACCESSES] [SEED]      100,000 accesses by default
#include "tests/host/driver/etherbone_accesses.h"
#include "tests/support/soak.h"

namespace selfproj::test {
namespace {

TEST(Soak, EveryWriteOnceOrRefused) {
  constexpr int kPercent = 3;
  const auto accesses = static_cast<int>(soak_command.number(0, 100'000));
  const AccessCounts counts = random_accesses(accesses, kPercent, soak_command.number(1, 1));
  report_soak("etherbone_soak", "Random accesses to the registers of a board through a network with faults",
              {{"accesses", accesses},
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
