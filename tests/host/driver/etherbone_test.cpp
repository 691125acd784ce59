// Tests registers over Etherbone: the records, and accesses through a network that loses, repeats and reorders.
#include "host/driver/etherbone.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/driver/control.h"
#include "selfproj/files/user_error.h"
#include "tests/host/driver/etherbone_accesses.h"
#include "tests/support/network_board.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

// The bytes that LiteX's own client sends for a read and for a write.
TEST(Etherbone, RecordsOfLiteX) {
  EXPECT_EQ(driver::etherbone_bytes({.tag = 0x11223344, .reads = {0x14}}),
            (Bytes{0x4E, 0x6F, 0x10, 0x44, 0, 0, 0, 0, 0, 0x0F, 0, 1, 0x11, 0x22, 0x33, 0x44, 0, 0, 0, 0x14}));
  EXPECT_EQ(driver::etherbone_bytes({.write_address = 0x18, .writes = {0xDEADBEEF}}),
            (Bytes{0x4E, 0x6F, 0x10, 0x44, 0, 0, 0, 0, 0, 0x0F, 1, 0, 0, 0, 0, 0x18, 0xDE, 0xAD, 0xBE, 0xEF}));
  EXPECT_EQ(driver::etherbone_bytes({.probe = true}), (Bytes{0x4E, 0x6F, 0x11, 0x44, 0, 0, 0, 0}));
}

TEST(Etherbone, RandomRecordsAndDamage) {
  for (const std::uint64_t seed : seeds(200)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    driver::EtherboneRecord record;
    const auto words = [&](int most) {
      std::vector<std::uint32_t> all(static_cast<std::size_t>(random.between(0, most)));
      for (std::uint32_t& word : all) {
        word = static_cast<std::uint32_t>(random.bits());
      }
      return all;
    };
    record.writes = words(5);
    record.reads = words(5);
    record.write_address = record.writes.empty() ? 0 : 0x104;
    record.tag = record.reads.empty() ? 0 : 77;
    Bytes bytes = driver::etherbone_bytes(record);
    EXPECT_EQ(driver::etherbone_record(bytes), record);
    if (bytes.size() > 8) {
      bytes.resize(static_cast<std::size_t>(random.between(9, static_cast<int>(bytes.size()) - 1)));
      EXPECT_EQ(driver::etherbone_record(bytes), std::nullopt);
    }
    static_cast<void>(driver::etherbone_record(random.bytes(static_cast<std::size_t>(random.between(0, 60)))));
  }
}

// Every write reaches the registers once, or is refused once, whatever the network does.
TEST(EtherbonePort, RandomAccessesThroughABadNetwork) {
  const std::uint64_t seed = seeds(1).front();
  SCOPED_TRACE(how_to_repeat(seed));
  const AccessCounts counts = random_accesses(1500, 4, seed);
  EXPECT_GT(counts.refused, 150U);
  EXPECT_GT(std::min({counts.lost, counts.repeated, counts.late}), 60U);
}

TEST(EtherbonePort, ControlOverTheNetwork) {
  WrittenBoard board(true);
  const BadNetwork network(board, 0, 1);
  const std::unique_ptr<driver::Control> control =
      std::make_unique<driver::Control>(driver::make_etherbone_port(network.place()));
  control->set({.columns = 64, .rows = 12, .threshold = 9});
  EXPECT_EQ(control->read("size.columns"), 64U);
  EXPECT_THROW(control->write("size.columns", 6), UserError);
  EXPECT_EQ(control->uri(), "udp:" + network.place());
}

// Without the mailbox a write is sent once. If its answer is lost, that is an error, not a second write.
TEST(EtherbonePort, ABoardWithoutTheMailbox) {
  WrittenBoard good(false);
  {
    const BadNetwork network(good, 0, 1);
    driver::Control control(driver::make_etherbone_port(network.place()));
    control.write("measure.threshold", 60);
    EXPECT_THROW(control.write("measure.mode", 3), UserError);
  }
  EXPECT_EQ(good.registers().settings().threshold, 60);
  WrittenBoard board(false);
  std::size_t sent = 0;
  {
    const BadNetwork network(board, 10, 3);
    const std::unique_ptr<driver::RegisterPort> port =
        driver::make_etherbone_port(network.place(), {.patience = std::chrono::milliseconds(4), .tries = 20});
    int unanswered = 0;
    for (; sent < 60; ++sent) {
      try {
        EXPECT_EQ(port->write(spec::kRegTimeout, static_cast<std::uint32_t>(sent)), driver::Written::unknown);
      } catch (const UserError& error) {
        EXPECT_NE(std::string(error.what()).find("not known"), std::string::npos);
        ++unanswered;
      }
    }
    EXPECT_GT(unanswered, 0);
  }
  EXPECT_GT(board.writes().size(), 30U);
}

TEST(EtherbonePort, NobodyAndTwoHosts) {
  EXPECT_THROW(driver::make_etherbone_port("127.0.0.2:9", {.patience = std::chrono::milliseconds(1), .tries = 2}),
               UserError);
  WrittenBoard board(true);
  const BadNetwork network(board, 0, 1);
  const std::unique_ptr<driver::RegisterPort> one = driver::make_etherbone_port(network.place());
  const std::unique_ptr<driver::RegisterPort> other = driver::make_etherbone_port(network.place());
  EXPECT_EQ(one->write(spec::kRegTimeout, 1), driver::Written::applied);
  EXPECT_EQ(other->write(spec::kRegTimeout, 2), driver::Written::applied);
  EXPECT_THROW(one->write(spec::kRegTimeout, 3), UserError);
  EXPECT_EQ(one->write(spec::kRegTimeout, 4), driver::Written::applied);
}

}  // namespace
}  // namespace selfproj::test
