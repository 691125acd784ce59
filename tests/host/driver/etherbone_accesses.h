#ifndef SELFPROJ_TESTS_HOST_DRIVER_ETHERBONE_ACCESSES_H
#define SELFPROJ_TESTS_HOST_DRIVER_ETHERBONE_ACCESSES_H

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <vector>

#include "host/driver/etherbone.h"
#include "model/register_file.h"
#include "tests/support/network_board.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

// What random accesses through a bad network came to.
struct AccessCounts {
  std::uint64_t reads = 0;
  std::uint64_t writes = 0;
  std::uint64_t refused = 0;  // of the writes
  std::uint64_t lost = 0;     // datagrams, in both directions
  std::uint64_t repeated = 0;
  std::uint64_t late = 0;
};

// Expects that every write reaches the registers once, in order, or is refused once, and that every read is right,
// while the network loses, repeats and delays `percent` of the datagrams each.
inline AccessCounts random_accesses(int accesses, int percent, std::uint64_t seed) {
  AccessCounts counts;
  WrittenBoard board(true);
  std::vector<WrittenBoard::Write> asked;
  {
    BadNetwork network(board, percent, seed);
    const std::unique_ptr<driver::RegisterPort> port =
        driver::make_etherbone_port(network.place(), {.patience = std::chrono::milliseconds(2), .tries = 30});
    model::RegisterFile model;
    Random random(seed);
    for (int i = 0; i < accesses && !::testing::Test::HasFailure(); ++i) {
      const auto address = static_cast<std::uint32_t>(4 * random.between(0, 31));
      if (random.chance(60)) {
        const auto data = static_cast<std::uint32_t>(random.bits()) & (random.chance(50) ? 0x00FF01FFU : ~0U);
        const bool error = model.write(address, data).error;
        EXPECT_EQ(port->write(address, data), error ? driver::Written::refused : driver::Written::applied)
            << "access " << i;
        asked.push_back({address, data, error});
        counts.refused += error ? 1 : 0;
      } else {
        const std::array<std::uint32_t, 2> both{address, spec::kRegSize};
        const std::vector<std::uint32_t> words = port->read(both);
        EXPECT_EQ(words[0], model.read(address, {}).data) << "access " << i;
        EXPECT_EQ(words[1], model.value(spec::kRegSize)) << "access " << i;
        ++counts.reads;
      }
    }
    network.stop();
    counts.lost = network.lost();
    counts.repeated = network.repeated();
    counts.late = network.late();
  }
  EXPECT_EQ(board.writes(), asked);
  counts.writes = asked.size();
  return counts;
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_HOST_DRIVER_ETHERBONE_ACCESSES_H
