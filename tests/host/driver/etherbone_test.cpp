// Tests registers over Etherbone: the records, and accesses through a network that loses, repeats and reorders.
#include "host/driver/etherbone.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/driver/control.h"
#include "host/files/file_descriptor.h"
#include "model/spec/generated/register_table.h"
#include "selfproj/files/user_error.h"
#include "tests/host/driver/etherbone_accesses.h"
#include "tests/support/error_of.h"
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

TEST(Etherbone, AsManyWordsAsARecordHolds) {
  const std::vector<std::uint32_t> most(255, 7);
  const std::vector<std::uint32_t> more(256, 7);
  const driver::EtherboneRecord record{.write_address = 4, .writes = most, .tag = 5, .reads = most};
  EXPECT_EQ(driver::etherbone_record(driver::etherbone_bytes(record)), record);
  EXPECT_THROW(driver::etherbone_bytes({.writes = more}), std::invalid_argument);
  EXPECT_THROW(driver::etherbone_bytes({.reads = more}), std::invalid_argument);
}

// Each byte of the header counts, and so does each byte behind the words; only probes may be filled up.
TEST(Etherbone, WhatIsNoRecord) {
  const Bytes good = driver::etherbone_bytes({.write_address = 8, .writes = {1}, .tag = 9, .reads = {2}});
  ASSERT_TRUE(driver::etherbone_record(good));
  for (std::size_t at = 0; at < 4; ++at) {
    Bytes bytes = good;
    bytes[at] ^= at == 2 ? 0x20U : 1U;
    EXPECT_EQ(driver::etherbone_record(bytes), std::nullopt) << at;
  }
  for (std::size_t size = 0; size < good.size(); ++size) {
    EXPECT_EQ(driver::etherbone_record({good.data(), size}).has_value(), size == 8) << size;
  }
  Bytes longer = good;
  longer.push_back(0);
  EXPECT_EQ(driver::etherbone_record(longer), std::nullopt);
  for (const driver::EtherboneRecord& probe :
       {driver::EtherboneRecord{.probe = true}, driver::EtherboneRecord{.probe_answer = true}}) {
    Bytes bytes = driver::etherbone_bytes(probe);
    EXPECT_EQ(driver::etherbone_record(bytes), probe);
    bytes.resize(18);
    EXPECT_EQ(driver::etherbone_record(bytes), probe) << "filled up";
  }
}

// A board that answers as the test says; all on one thread of its own.
class OddBoard {
 public:
  using Answers = std::function<std::vector<driver::EtherboneRecord>(const driver::EtherboneRecord& question)>;

  explicit OddBoard(Answers answers)
      : answers_(std::move(answers)), thread_([this] {
          files::wait_readable(socket_.number(), 5'000'000);
          while (const std::optional<Datagram> came = socket_.receive()) {
            const std::optional<driver::EtherboneRecord> question = driver::etherbone_record(came->bytes);
            for (const driver::EtherboneRecord& answer : answers_(question.value())) {
              socket_.send({came->host, driver::etherbone_bytes(answer)});
            }
          }
        }) {}

  [[nodiscard]] std::string place() const { return "127.0.0.2:" + std::to_string(socket_.port()); }
  void stop() { thread_.stop(); }

 private:
  Answers answers_;
  BoardSocket socket_{"127.0.0.2"};
  Repeating thread_;
};

// Every word read is its address, but for the link's own registers.
driver::EtherboneRecord right_answer(const driver::EtherboneRecord& question, bool mailbox) {
  driver::EtherboneRecord answer{.write_address = question.tag, .writes = question.reads};
  for (std::uint32_t& word : answer.writes) {
    word = word == spec::kLinkId ? (mailbox ? spec::kLinkIdReset : 0) : word;
  }
  return answer;
}

// Late answers, answers to others, and answers of another length change nothing.
TEST(EtherbonePort, OnlyTheAnswerToTheQuestion) {
  OddBoard board([](const driver::EtherboneRecord& question) {
    const driver::EtherboneRecord right = right_answer(question, false);
    driver::EtherboneRecord late = right;
    late.write_address -= 1;
    driver::EtherboneRecord early = right;
    early.write_address += 1;
    driver::EtherboneRecord more = right;
    more.writes.push_back(1);
    driver::EtherboneRecord fewer = right;
    fewer.writes.pop_back();
    for (driver::EtherboneRecord* const wrong : {&late, &early, &more, &fewer}) {
      for (std::uint32_t& word : wrong->writes) {
        word = 0xBAD;
      }
    }
    return std::vector<driver::EtherboneRecord>{late, early, more, fewer, {.probe_answer = true}, right};
  });
  const auto port = driver::make_etherbone_port(board.place(), {.patience = std::chrono::milliseconds(2000)});
  const std::vector<std::uint32_t> addresses = {4, 8, 12};
  EXPECT_EQ(port->read(addresses), addresses);
  EXPECT_EQ(port->word(16), 16U);
}

// Boards take a few words at a time; the answers come in the order of the addresses.
TEST(EtherbonePort, ManyWords) {
  std::vector<std::size_t> asked;
  OddBoard board([&](const driver::EtherboneRecord& question) {
    asked.push_back(question.reads.size());
    return std::vector<driver::EtherboneRecord>{right_answer(question, false)};
  });
  const auto port = driver::make_etherbone_port(board.place(), {.patience = std::chrono::milliseconds(2000)});
  std::vector<std::uint32_t> addresses;
  for (std::uint32_t i = 0; i < 17; ++i) {
    addresses.push_back(400 - 4 * i);
  }
  EXPECT_EQ(port->read(addresses), addresses);
  EXPECT_TRUE(port->read({}).empty());
  board.stop();
  EXPECT_EQ(asked, (std::vector<std::size_t>{1, 8, 8, 1})) << "the first one asks for the mailbox";
}

// A read is asked for as often as the options say; a write without a mailbox once.
TEST(EtherbonePort, AsOftenAsTheOptionsSay) {
  std::atomic<int> writes = 0;
  std::atomic<int> reads = 0;
  std::atomic<bool> silent = false;
  OddBoard board([&](const driver::EtherboneRecord& question) {
    reads += question.reads.front() == 4 && question.writes.empty() ? 1 : 0;
    writes += question.writes.empty() ? 0 : 1;
    return silent ? std::vector<driver::EtherboneRecord>{}
                  : std::vector<driver::EtherboneRecord>{right_answer(question, false)};
  });
  std::unique_ptr<driver::RegisterPort> port;
  for (int i = 0; i < 100 && port == nullptr; ++i) {  // a busy machine may not answer in time
    error_of([&] {
      port = driver::make_etherbone_port(board.place(), {.patience = std::chrono::milliseconds(10), .tries = 3});
    });
  }
  ASSERT_NE(port, nullptr);
  silent = true;
  EXPECT_EQ(error_of([&] { static_cast<void>(port->word(4)); }), "udp:" + board.place() + ": no board answers");
  EXPECT_EQ(error_of([&] { port->write(4, 5); }),
            "udp:" + board.place() + ": no answer to a write; it is not known whether the board has got it");
  board.stop();
  EXPECT_LE(reads, 3);
  EXPECT_LE(writes, 1);
}

// The board's mailbox says which write it has got: another one's is not this one's.
TEST(EtherbonePort, TheAnswerOfTheMailboxIsThatOfTheWrite) {
  for (const std::uint32_t wrong : {spec::kLinkTicket, spec::kLinkAddress, spec::kLinkValue, 0U}) {
    OddBoard board([&](const driver::EtherboneRecord& question) {
      driver::EtherboneRecord answer = right_answer(question, true);
      if (!question.writes.empty()) {
        for (std::size_t i = 0; i < 3; ++i) {
          answer.writes[i] = question.writes[i] + (question.reads[i] == wrong ? 4 : 0);
        }
        answer.writes[3] = 0;
      }
      return std::vector<driver::EtherboneRecord>{answer};
    });
    const auto port = driver::make_etherbone_port(board.place(), {.patience = std::chrono::milliseconds(2000)});
    if (wrong == 0) {
      EXPECT_EQ(port->write(spec::kRegTimeout, 5), driver::Written::applied);
      EXPECT_EQ(port->write(spec::kRegTimeout, 6), driver::Written::applied);
    } else {
      EXPECT_EQ(error_of([&] { port->write(spec::kRegTimeout, 5); }),
                "udp:" + board.place() + ": another host writes this board's registers, or the board was reset");
    }
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
