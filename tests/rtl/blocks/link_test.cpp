// Tests the link of a board on the network: registers by Etherbone, the mailbox, the owner, and sessions.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "tests/rtl/blocks/link_bench.h"

namespace selfproj::test {
namespace {

Bytes write_of(std::uint32_t address, std::uint32_t value) {
  return driver::etherbone_bytes({.write_address = address, .writes = {value}});
}

// Good and malformed questions of three hosts.
TEST(Link, AnswersAndRegistersAreThoseOfTheModel) {
  for_cases(4, [&](std::uint64_t seed) {
    LinkFigures figures;
    expect_link_equals_model(seed, 400, figures);
    ASSERT_FALSE(HasFailure());
    EXPECT_GT(figures.answers, 100U);
    EXPECT_LT(figures.answers, 390U);
  });
}

// What the mailbox has performed, as the network reads it.
bool expect_mailbox_of_model(LinkBench& bench, LinkModel& model, std::uint32_t from) {
  return expect_answer_of_model(
      bench, model,
      driver::etherbone_bytes(
          {.tag = 7,
           .reads = {spec::kLinkTicket, spec::kLinkAddress, spec::kLinkValue, spec::kLinkAnswer, spec::kLinkSource}}),
      from);
}

// Only the ticket after the last one performs a write: not one that differs from it in any one bit.
TEST(Link, EveryBitOfATicketCounts) {
  Random random(1);
  LinkBench bench(1);
  LinkModel model;
  const auto mail = [&](std::uint32_t ticket, std::uint32_t address) {
    const Bytes question = driver::etherbone_bytes(
        {.write_address = spec::kLinkTicket, .writes = {ticket, address, static_cast<std::uint32_t>(random.bits())}});
    expect_answer_of_model(bench, model, question, kHosts[0]);
    expect_mailbox_of_model(bench, model, kHosts[1]);
    ASSERT_FALSE(HasFailure()) << "ticket " << ticket;
  };
  std::uint32_t next = 1;
  for (int bit = 0; bit < 32; ++bit) {
    for (const std::uint32_t address : {std::uint32_t{0x20}, spec::kLinkSource}) {
      mail(next ^ std::uint32_t{1} << static_cast<unsigned>(bit), address);
    }
    mail(next, 0x20);
    ++next;
  }
}

// While the board runs, nobody but its owner moves the mailbox: not its ticket, its address or its source, in any step
// of a write that the owner makes in three, and whatever bit of the address of the other host differs.
TEST(Link, OnlyTheOwnerWritesTheMailbox) {
  Random random(1);
  LinkBench bench(1);
  LinkModel model;
  const std::uint32_t owner = random_host(random);
  const auto write = [&](std::uint32_t from, std::uint32_t address, std::vector<std::uint32_t> words) {
    expect_answer_of_model(bench, model,
                           driver::etherbone_bytes({.write_address = address, .writes = std::move(words)}), from);
    expect_mailbox_of_model(bench, model, from);
  };
  write(owner, spec::kRegControl, {1});
  ASSERT_TRUE(bench.registers.runs());
  std::uint32_t next = 1;
  for (unsigned bit = 0; bit < 32; ++bit) {
    const std::uint32_t other = owner ^ std::uint32_t{1} << bit;
    for (const std::uint32_t address : {std::uint32_t{0x20}, spec::kLinkSource, spec::kLinkReplaySession}) {
      const std::uint32_t replay = spec::kSourceReplay;
      write(other, spec::kLinkTicket, {next, address, replay});
      write(owner, spec::kLinkTicket, {next, address});
      write(other, spec::kLinkValue, {replay});
      write(other, spec::kLinkTicket, {next + 1});
      write(other, spec::kLinkAddress, {0x40});
      write(owner, spec::kLinkValue, {spec::kSourceCamera});
      ASSERT_FALSE(HasFailure()) << "bit " << bit << ", address " << address;
      ++next;
    }
  }
}

driver::EtherboneRecord random_record(Random& random, int writes, int reads) {
  driver::EtherboneRecord record{.write_address = 0x20, .tag = static_cast<std::uint32_t>(random.bits())};
  for (int i = 0; i < writes; ++i) {
    record.writes.push_back(static_cast<std::uint32_t>(random.bits()));
  }
  for (int i = 0; i < reads; ++i) {
    record.reads.push_back(static_cast<std::uint32_t>(4 * i % 0xE0));
  }
  return record;
}

// Records that need all the room of 64 words with any number of writes, and records that need more.
TEST(Link, RecordsUpTo64Words) {
  Random random(1);
  LinkBench bench(1);
  LinkModel model;
  EXPECT_TRUE(
      expect_answer_of_model(bench, model, driver::etherbone_bytes(random_record(random, 0, 60)), random_host(random)));
  EXPECT_FALSE(
      expect_answer_of_model(bench, model, driver::etherbone_bytes(random_record(random, 0, 61)), random_host(random)));
  expect_answer_of_model(bench, model, driver::etherbone_bytes(random_record(random, 60, 0)), random_host(random));
  for (int writes = 1; writes < 59; ++writes) {
    const Bytes fits = driver::etherbone_bytes(random_record(random, writes, 59 - writes));
    EXPECT_TRUE(expect_answer_of_model(bench, model, fits, random_host(random)));
    const Bytes longer = driver::etherbone_bytes(random_record(random, writes, 60 - writes));
    EXPECT_FALSE(expect_answer_of_model(bench, model, longer, random_host(random)));
    ASSERT_FALSE(HasFailure()) << writes << " writes";
  }
  for (const int words : {128, 255}) {
    const Bytes longer = driver::etherbone_bytes(random_record(random, words, words));
    EXPECT_FALSE(expect_answer_of_model(bench, model, longer, random_host(random)));
  }
}

// Of the datagrams that are longer than a record, up to the longest of UDP, only probes are answered.
TEST(Link, DatagramsUpToTheLongest) {
  Random random(1);
  LinkBench bench(1);
  LinkModel model;
  for (std::size_t bytes = 1; bytes < 0x20000; bytes *= 2) {
    for (const bool probe : {false, true}) {
      Bytes question =
          driver::etherbone_bytes(probe ? driver::EtherboneRecord{.probe = true} : random_record(random, 1, 1));
      question.resize(std::min<std::size_t>(bytes, 0xFFFF));
      EXPECT_EQ(expect_answer_of_model(bench, model, question, random_host(random)), probe && bytes >= 8);
      ASSERT_FALSE(HasFailure()) << question.size() << " bytes";
    }
  }
}

// What comes while a question is performed is lost as a whole, also if it ends later.
TEST(Link, QuestionsThatComeTooEarlyAreLost) {
  for_cases(20, [&](Random& random, std::uint64_t seed) {
    LinkBench bench(seed);
    const Bytes first =
        driver::etherbone_bytes({.write_address = 0x20, .writes = {1, 2, 3}, .tag = 1, .reads = {0x20, 0x24}});
    const Bytes second =
        driver::etherbone_bytes({.write_address = 0x20, .writes = {7, 8, 9}, .tag = 2, .reads = {0x20, 0x28}});
    bench.ask(first, kHosts[0]);
    bench.idle(random.between(0, 8));
    bench.ask(second, kHosts[1]);
    const std::optional<LinkBench::Datagram> answer = bench.settle();
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->to, kHosts[0]);
    EXPECT_EQ(answer->bytes, driver::etherbone_bytes({.write_address = 1, .writes = {1, 2}}));
    EXPECT_FALSE(bench.settle());
    bench.ask(second, kHosts[1]);
    EXPECT_EQ(bench.settle()->bytes, driver::etherbone_bytes({.write_address = 2, .writes = {7, 9}}));
  });
}

// Packets go to the host that has started the board, and each datagram to that of its session.
TEST(Link, PacketsGoToTheOwner) {
  for_cases(6, [&](Random& random, std::uint64_t seed) {
    LinkBench bench(seed);
    std::size_t sent = 0;
    const auto queue = [&](int packets) {
      for (int i = 0; i < packets; ++i, ++sent) {
        bench.packets.push_back(random.bytes(16 * static_cast<std::size_t>(random.between(1, 200))));
      }
    };
    bench.network_percent = random.between(20, 100);
    queue(2);
    bench.idle(2000);
    EXPECT_TRUE(bench.datagrams.empty()) << "before anybody has started the board";
    std::map<std::uint16_t, std::uint32_t> hosts;
    for (int round = 0; round < 6; ++round) {
      const std::uint32_t owner = random_host(random);
      bench.ask(write_of(spec::kRegControl, 1), owner);
      queue(random.between(1, 5));
      bench.idle(random.between(0, 3000));
      // Nobody else can stop it, start it anew or take it over.
      for (const std::uint32_t value : {0U, 1U}) {
        bench.ask(write_of(spec::kRegControl, value), owner ^ 1U << static_cast<unsigned>(random.between(0, 31)));
        bench.idle(100);
        EXPECT_TRUE(bench.registers.runs());
      }
      bench.ask(write_of(spec::kRegControl, 0), owner);
      bench.idle(100);
      EXPECT_FALSE(bench.registers.runs());
      bench.idle(random.between(0, 1) * 20000);
    }
    bench.idle(40000);
    EXPECT_TRUE(bench.packets.empty());
    std::size_t whole = 0;
    for (const LinkBench::Datagram& datagram : bench.datagrams) {
      const std::optional<model::DatagramHeader> header = model::read_datagram_header(datagram.bytes);
      ASSERT_TRUE(header);
      EXPECT_EQ(hosts.try_emplace(header->session, datagram.to).first->second, datagram.to);
      whole += header->length != 0 && header->offset == 0 ? 1 : 0;
    }
    EXPECT_EQ(whole, sent);
    // A start that comes while the packets of the one before still leave takes its place.
    EXPECT_GE(hosts.size(), 3U);
    EXPECT_TRUE(bench.answers.empty());
  });
}

// The source changes by the mailbox only; replay is open to the host of the session, while it is the source; and what
// replay says of itself is read.
TEST(Link, SourceAndReplay) {
  LinkBench bench(1);
  std::uint32_t ticket = 0;
  const auto read = [&](std::uint32_t address) {
    bench.ask(driver::etherbone_bytes({.tag = 1, .reads = {address}}), kHosts[0]);
    return driver::etherbone_record(bench.settle()->bytes)->writes.front();
  };
  const auto mail = [&](std::uint32_t address, std::uint32_t value) {
    bench.ask(driver::etherbone_bytes({.write_address = spec::kLinkTicket, .writes = {++ticket, address, value}}),
              kHosts[0]);
    bench.settle();
    return (read(spec::kLinkAnswer) & 1U) == 0;
  };
  EXPECT_EQ(read(spec::kLinkVideo), 5U << 28U | 127U << 16U | 512U);
  bench.ask(write_of(spec::kLinkSource, spec::kSourceReplay), kHosts[0]);
  bench.settle();
  EXPECT_EQ(read(spec::kLinkSource), spec::kSourceCamera);
  EXPECT_FALSE(mail(spec::kLinkSource, spec::kSourceTestCamera)) << "this build has none";
  EXPECT_FALSE(mail(spec::kLinkSource, 6));
  EXPECT_FALSE(mail(spec::kLinkReplaySession, 0x10000));
  EXPECT_TRUE(mail(spec::kLinkSource, spec::kSourceReplay));
  EXPECT_EQ(read(spec::kLinkSource), spec::kSourceReplay);
  EXPECT_EQ(bench->source_o, spec::kSourceReplay);
  EXPECT_FALSE(bench->replay_enable_o) << "no host has the session";
  EXPECT_TRUE(mail(spec::kRegControl, 1));
  EXPECT_TRUE(bench->replay_enable_o);
  EXPECT_EQ(bench->datagram_to_o, kHosts[0]);
  EXPECT_TRUE(mail(spec::kLinkReplaySession, 0xABCD));
  EXPECT_EQ(bench->replay_session_o, 0xABCD);
  bench.show_replay({.frame = 0x12345678, .offset = 0x9ABCDEF0, .frames = 3, .dropped = 4, .ignored = 5});
  EXPECT_EQ(read(spec::kLinkReplayFrame), 0x12345678U);
  EXPECT_EQ(read(spec::kLinkReplayOffset), 0x9ABCDEF0U);
  EXPECT_EQ(read(spec::kLinkReplayFrames), 3U);
  EXPECT_EQ(read(spec::kLinkReplayDropped), 4U);
  EXPECT_EQ(read(spec::kLinkReplayIgnored), 5U);
  EXPECT_TRUE(mail(spec::kLinkSource, spec::kSourceCamera));
  EXPECT_FALSE(bench->replay_enable_o);
}

}  // namespace
}  // namespace selfproj::test
