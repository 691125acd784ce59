// The link of a board on the network: questions of several hosts, good and malformed, and what the model says of them.
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_LINK_BENCH_H
#define SELFPROJ_TESTS_RTL_BLOCKS_LINK_BENCH_H

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "Vsp_link_ports.h"
#include "host/driver/etherbone.h"
#include "model/datagram.h"
#include "model/register_file.h"
#include "model/spec/generated/register_table.h"
#include "selfproj/model/little_endian.h"
#include "sim/board/etherbone_board.h"
#include "tests/host/driver/packets.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

// The registers of a board, as far as the link knows them: some refuse.
class PlainRegisters {
 public:
  model::RegisterAnswer access(bool write, std::uint32_t address, std::uint32_t data) {
    if (address % 4 != 0 || address >= (write ? 0xC0U : 0xE0U)) {
      return {.error = true};
    }
    std::uint32_t& word = words_[address / 4];
    word = write ? data : word;
    return {.data = word};
  }
  [[nodiscard]] bool runs() const {
    return (words_[spec::kRegControl / 4] >> static_cast<unsigned>(spec::kRegControlRunLsb) & 1U) != 0;
  }

  bool operator==(const PlainRegisters&) const = default;

 private:
  std::array<std::uint32_t, 64> words_{};
};

// What CMakeLists.txt builds.
inline constexpr model::VideoBuild kLinkVideo = {.sources = 1U << spec::kSourceCamera | 1U << spec::kSourceReplay,
                                                 .replay = {.columns = 512, .rows = 127}};

// What a link does, by the models: EtherboneBoard and its mailbox, and the rule about the owner.
class LinkModel {
 public:
  static constexpr std::size_t kMostBytes = 256;  // of sp_etherbone

  // `ticket`: of the last write that the mailbox performed before.
  explicit LinkModel(std::uint32_t ticket = 0)
      : board_([this](bool write, std::uint32_t address,
                      std::uint32_t data) { return registers.access(write, address, data); },
               true, ticket, kLinkVideo, &replay) {}

  std::optional<Bytes> answer(const Bytes& question, std::uint32_t from) {
    std::optional<driver::EtherboneRecord> record = driver::etherbone_record(question);
    if (!record || (question.size() > kMostBytes && !record->probe)) {
      return std::nullopt;
    }
    const bool ran = registers.runs();
    if (ran && from != owner_) {
      record->writes.clear();
    }
    const std::optional<driver::EtherboneRecord> answer = board_.answer(*record);
    if (!ran && registers.runs()) {
      owner_ = from;
    }
    return answer ? std::optional(driver::etherbone_bytes(*answer)) : std::nullopt;
  }

  PlainRegisters registers;
  model::ReplayModel replay{kLinkVideo.replay};

 private:
  sim::EtherboneBoard board_;
  std::uint32_t owner_ = 0;
};

// A link between a network, and a board whose answers take a while.
class LinkBench {
 public:
  struct Datagram {
    std::uint32_t to = 0;
    Bytes bytes;
  };

  explicit LinkBench(std::uint64_t seed) : random_(seed) {
    link_.valid_when({"answer_last_o", "answer_data_o", "answer_bytes_o", "answer_to_o"},
                     [this] { return link_->answer_valid_o != 0; });
    link_.valid_when({"datagram_last_o", "datagram_bytes_o", "datagram_to_o"},
                     [this] { return link_->datagram_valid_o != 0; });
    // The first word of a datagram has the number of the session, from a counter that begins anywhere.
    link_.valid_when({"datagram_data_o"}, [this] { return link_->datagram_valid_o != 0 && !datagram_.bytes.empty(); });
    link_.valid_when({"m_axil_awaddr", "m_axil_araddr", "m_axil_wdata"}, [] { return false; });
    link_->ask_valid_i = 0;
    link_->answer_ready_i = 0;
    link_->datagram_ready_i = 0;
    link_->s_axis_tvalid = 0;
    link_->m_axil_awready = 0;
    link_->m_axil_wready = 0;
    link_->m_axil_arready = 0;
    link_->m_axil_bvalid = 0;
    link_->m_axil_rvalid = 0;
    show_replay({});
    link_.reset();
  }

  // Sends a question, a word in each clock that is not a pause. `padding`: bytes behind those that UDP tells of.
  void ask(const Bytes& question, std::uint32_t from, bool error = false, std::size_t padding = 0) {
    Bytes words = question;
    words.resize((question.size() + 3) / 4 * 4 + padding, 0xA5);
    asked_ = std::min<std::size_t>(words.size() / 4, 64);
    for (std::size_t at = 0; at < words.size(); at += 4) {
      while (random_.chance(10)) {
        clock();
      }
      link_->ask_valid_i = 1;
      link_->ask_last_i = at + 4 == words.size();
      link_->ask_error_i = at + 4 == words.size() ? error : random_.chance(50);
      link_->ask_data_i = model::load_little_endian<std::uint32_t>(words.data() + at);
      link_->ask_bytes_i = static_cast<SData>(question.size());
      link_->ask_from_i = from;
      clock();
      link_->ask_valid_i = 0;
    }
  }

  // What replay tells the link.
  void show_replay(const model::ReplayCounts& counts) {
    link_->replay_frame_i = counts.frame;
    link_->replay_offset_i = counts.offset;
    link_->replay_frames_i = counts.frames;
    link_->replay_dropped_i = counts.dropped;
    link_->replay_ignored_i = counts.ignored;
  }

  void idle(int clocks) {
    for (int i = 0; i < clocks; ++i) {
      clock();
    }
  }

  Vsp_link* operator->() { return link_.operator->(); }

  // The answer to what was asked, once no access is under way any more. (Those of the link itself do not show.)
  std::optional<Datagram> settle() {
    for (int quiet = 0; quiet < 30 + 4 * static_cast<int>(asked_); ++quiet) {
      if (link_->answer_valid_o || aw_ || w_ || ar_ || b_ || r_) {
        quiet = 0;
      }
      clock();
    }
    if (answers.empty()) {
      return std::nullopt;
    }
    Datagram answer = std::move(answers.front());
    answers.pop_front();
    return answer;
  }

  void clock() {
    link_->answer_ready_i = random_.chance(70);
    link_->datagram_ready_i = random_.chance(network_percent);
    board_side();
    const bool offered = !packets.empty();
    link_->s_axis_tvalid = offered;
    if (offered) {
      Word128 beat{};
      for (std::size_t i = 0; i < beat.size(); ++i) {
        beat[i] = model::load_little_endian<std::uint32_t>(packets.front().data() + at_ + 4 * i);
      }
      set128(link_->s_axis_tdata, beat);
      link_->s_axis_tlast = at_ + 16 == packets.front().size();
    }
    link_.settle();
    collect(answers, answer_, link_->answer_valid_o, link_->answer_ready_i, link_->answer_last_o, link_->answer_data_o,
            link_->answer_bytes_o, link_->answer_to_o);
    collect(datagrams, datagram_, link_->datagram_valid_o, link_->datagram_ready_i, link_->datagram_last_o,
            link_->datagram_data_o, link_->datagram_bytes_o, link_->datagram_to_o);
    if (offered && link_->s_axis_tready) {
      at_ += 16;
      if (at_ == packets.front().size()) {
        packets.pop_front();
        at_ = 0;
      }
    }
    take_accesses();
    const bool begins = link_->replay_begin_o != 0;
    link_.rise();
    if (begins) {
      link_->replay_frame_i = 0;
      link_->replay_offset_i = 0;
    }
  }

  PlainRegisters registers;
  std::deque<Datagram> answers;
  std::deque<Datagram> datagrams;
  std::deque<Bytes> packets;  // of the board, to come
  int network_percent = 100;  // of clocks in which the network takes a word of a datagram

 private:
  // Both of AXI's responses with which a board can refuse an access.
  static constexpr CData kSlaveError = 2;
  static constexpr CData kDecodeError = 3;

  // The board's port at the beginning of a clock.
  void board_side() {
    link_->m_axil_awready = random_.chance(50);
    link_->m_axil_wready = random_.chance(50);
    link_->m_axil_arready = random_.chance(50);
    if (aw_ && w_ && !b_ && random_.chance(50)) {
      const model::RegisterAnswer answer = registers.access(true, *aw_, *w_);
      b_ = answer.error;
      refusal_ = random_.chance(50) ? kSlaveError : kDecodeError;
      aw_.reset();
      w_.reset();
    }
    if (ar_ && !r_ && random_.chance(50)) {
      r_ = registers.access(false, *ar_, 0);
      refusal_ = random_.chance(50) ? kSlaveError : kDecodeError;
      ar_.reset();
    }
    link_->m_axil_bvalid = b_.has_value();
    link_->m_axil_bresp = b_ && *b_ ? refusal_ : 0;
    link_->m_axil_rvalid = r_.has_value();
    link_->m_axil_rresp = r_ && r_->error ? refusal_ : 0;
    link_->m_axil_rdata = r_ && !r_->error ? r_->data : static_cast<std::uint32_t>(random_.bits());
  }

  void take_accesses() {
    if (b_ && link_->m_axil_bready) {
      b_.reset();
    }
    if (r_ && link_->m_axil_rready) {
      r_.reset();
    }
    if (link_->m_axil_awvalid && link_->m_axil_awready) {
      EXPECT_FALSE(aw_ || ar_) << "two accesses at a time";
      aw_ = link_->m_axil_awaddr;
    }
    if (link_->m_axil_wvalid && link_->m_axil_wready) {
      w_ = link_->m_axil_wdata;
      EXPECT_EQ(link_->m_axil_wstrb, 15);
    }
    if (link_->m_axil_arvalid && link_->m_axil_arready) {
      EXPECT_FALSE(aw_ || w_ || ar_) << "two accesses at a time";
      ar_ = link_->m_axil_araddr;
    }
  }

  static void collect(std::deque<Datagram>& all, Datagram& part, bool valid, bool ready, bool last, std::uint32_t word,
                      std::uint32_t bytes, std::uint32_t to) {
    EXPECT_TRUE(valid || part.bytes.empty()) << "a gap within a datagram";
    if (!valid || !ready) {
      return;
    }
    EXPECT_TRUE(part.bytes.empty() || part.to == to) << "the receiver changes within a datagram";
    part.to = to;
    part.bytes.resize(part.bytes.size() + 4);
    model::store_little_endian(part.bytes.data() + part.bytes.size() - 4, word);
    EXPECT_EQ(last, part.bytes.size() == bytes);
    if (last) {
      all.push_back(std::exchange(part, {}));
    }
  }

  Random random_;
  Clocked<Vsp_link> link_;
  Datagram answer_;
  Datagram datagram_;
  std::size_t at_ = 0;
  std::size_t asked_ = 0;  // words of the last question
  std::optional<std::uint32_t> aw_, w_, ar_;
  std::optional<bool> b_;
  std::optional<model::RegisterAnswer> r_;
  CData refusal_ = kSlaveError;
};

// --- Questions ---

using Hosts = std::array<std::uint32_t, 3>;

inline constexpr Hosts kHosts = {0xC0A80101, 0xC0A80102, 0x0A000001};

inline std::uint32_t random_host(Random& random) { return static_cast<std::uint32_t>(random.bits()); }

// An address of a register, mostly one that is there.
inline std::uint32_t random_address(Random& random) {
  switch (random.between(0, 9)) {
    case 0:
      return static_cast<std::uint32_t>(random.chance(50) ? random.bits() : random.bits() % 256);
    case 1:
    case 2:
      return spec::kLinkId + static_cast<std::uint32_t>(random.between(0, 60));
    case 3:
      return spec::kRegControl;
    default:
      return static_cast<std::uint32_t>(4 * random.between(0, 63));
  }
}

// What a host would ask, what another tool would, and what nobody in his right mind would.
inline Bytes random_question(Random& random, std::uint32_t next_ticket) {
  driver::EtherboneRecord record;
  record.tag = static_cast<std::uint32_t>(random.bits());
  if (random.chance(50)) {  // a write by the mailbox, mostly of the next ticket
    record.write_address = spec::kLinkTicket;
    record.writes = {next_ticket - (random.chance(20) ? 1U : 0U), random_address(random),
                     static_cast<std::uint32_t>(random.bits() >> (random.chance(50) ? 32 : random.between(32, 63)))};
    record.reads = {spec::kLinkTicket, spec::kLinkAddress, spec::kLinkValue, spec::kLinkAnswer};
  } else {
    record.write_address = random_address(random);
    const int most = random.chance(5) ? (random.chance(50) ? 70 : 255) : 5;
    for (int i = random.between(0, most); i > 0; --i) {
      record.writes.push_back(static_cast<std::uint32_t>(random.bits()));
    }
    for (int i = random.between(0, most); i > 0; --i) {
      record.reads.push_back(random_address(random));
    }
    record.probe = random.chance(3);
    record.probe_answer = random.chance(3);
  }
  Bytes bytes = driver::etherbone_bytes(record);
  if (random.chance(10)) {
    bytes[static_cast<std::size_t>(random.between(0, 11)) % bytes.size()] ^=
        static_cast<std::uint8_t>(random.between(1, 255));
  }
  if (random.chance(5)) {
    bytes.resize(static_cast<std::size_t>(random.between(1, static_cast<int>(bytes.size()))));
  }
  if (random.chance(3)) {
    bytes.resize(bytes.size() + static_cast<std::size_t>(random.between(1, 300)));
  }
  return bytes;
}

struct LinkFigures {
  std::uint64_t questions = 0;
  std::uint64_t answers = 0;
};

// Asks a question. The answer, and the registers after it, must be those of the model. Returns whether there is one.
inline bool expect_answer_of_model(LinkBench& bench, LinkModel& model, const Bytes& question, std::uint32_t from,
                                   bool damaged = false, std::size_t padding = 0) {
  bench.ask(question, from, damaged, padding);
  const std::optional<Bytes> due = damaged ? std::nullopt : model.answer(question, from);
  const std::optional<LinkBench::Datagram> answer = bench.settle();
  EXPECT_EQ(answer.has_value(), due.has_value()) << ::testing::PrintToString(question);
  if (answer && due) {
    EXPECT_EQ(answer->bytes, *due) << ::testing::PrintToString(question);
    EXPECT_EQ(answer->to, from);
    EXPECT_LE(answer->bytes.size(), question.size());
  }
  EXPECT_TRUE(bench.registers == model.registers) << ::testing::PrintToString(question);
  return due.has_value();
}

// Asks so many questions.
inline void expect_link_equals_model(LinkBench& bench, LinkModel& model, Random& random, int questions,
                                     LinkFigures& figures) {
  const Hosts hosts = {random_host(random), random_host(random), random_host(random)};
  for (int i = 0; i < questions; ++i) {
    const std::optional<Bytes> last = model.answer(driver::etherbone_bytes({.reads = {spec::kLinkTicket}}), 0);
    const std::uint32_t performed = driver::etherbone_record(*last)->writes.front();
    const Bytes question = random_question(random, performed + 1);
    const std::uint32_t from = hosts.at(static_cast<std::size_t>(random.between(0, 2)));
    const std::size_t padding = question.size() < 18 ? 4 * static_cast<std::size_t>(random.between(0, 4)) : 0;
    figures.answers += expect_answer_of_model(bench, model, question, from, random.chance(5), padding) ? 1 : 0;
    ++figures.questions;
    ASSERT_FALSE(::testing::Test::HasFailure()) << "question " << i;
  }
}
inline void expect_link_equals_model(std::uint64_t seed, int questions, LinkFigures& figures) {
  Random random(seed);
  LinkBench bench(seed);
  LinkModel model;
  expect_link_equals_model(bench, model, random, questions, figures);
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_LINK_BENCH_H
