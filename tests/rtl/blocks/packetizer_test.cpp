// Tests the packetizer: packets equal those of model/packet byte by byte, decisions and beats come in the clocks that
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "Vsp_packetizer_image_ports.h"
#include "Vsp_packetizer_ports.h"
#include "selfproj/model/packet.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test::packetizer {
namespace {

constexpr int kOverhead = 5;  // header and trailer, in beats

Word128 beat_at(const std::vector<std::uint8_t>& bytes, std::size_t beat) {
  Word128 out{};
  for (std::size_t i = 0; i < 16; ++i) {
    out[i / 4] |= static_cast<std::uint32_t>(bytes[16 * beat + i]) << (8 * (i % 4));
  }
  return out;
}

template <typename Dut>
class PacketizerBench {
 public:
  static constexpr bool kPerLine = std::is_same_v<Dut, Vsp_packetizer_image>;
  static constexpr int kFifoDepth = kPerLine ? 256 : 2048;  // of these builds

  explicit PacketizerBench(Random& random) : random_(random) {
    packetizer_.valid_when({"fifo_data_o", "fifo_last_o"}, [this] { return packetizer_->fifo_valid_o != 0; });
    packetizer_->start_i = 0;
    packetizer_->break_i = 0;
    packetizer_->break_later_i = 0;
    packetizer_->spoiled_i = 0;
    packetizer_->payload_valid_i = 0;
    packetizer_->payload_break_i = 0;
    packetizer_->tail_valid_i = 0;
    set_free();
    packetizer_.reset();
  }

  // The request of the present clock.
  struct Request {
    bool start = false;
    int payload_beats = 1;
    int line = 1;
    std::uint32_t start_status = 0;
    bool break_first = false;
    bool break_with_start = false;  // break_later_i in the clock of start_i: the frame broke at the beat that causes it
    std::uint32_t break_status = 0;
  };

  // The payload that follows an accepted start.
  struct Plan {
    int early = -1;       // payload beats that come before the payload breaks; -1: all come
    int gaps = 0;         // percent
    bool marked = false;  // break_later_i, with its status, after the decision
    std::uint32_t status = 0;
  };

  bool spoil_next = false;
  int places = 32;  // places of the FIFO in use by the test; the rest is always full
  int drain = 100;  // percent of clocks in which the other side takes a beat from the FIFO

  void clock(const Request& asked, const Plan& plan = {}) {
    const std::int64_t now = packetizer_.clock();
    // a break never comes in the clock of another frame's request
    const Request request = mark_at_ == now ? Request{} : asked;
    packetizer_->start_i = request.start;
    packetizer_->payload_beats_i =
        static_cast<std::remove_reference_t<decltype(packetizer_->payload_beats_i)>>(request.payload_beats);
    packetizer_->line_i = static_cast<SData>(request.line);
    packetizer_->break_i = request.break_first || request.break_with_start;
    packetizer_->start_status_i = static_cast<CData>(request.start_status);
    packetizer_->break_status_i = static_cast<CData>(request.break_status);
    packetizer_->break_later_i = request.break_with_start;
    if (mark_at_ == now) {
      packetizer_->break_i = 1;
      packetizer_->break_later_i = 1;
      packetizer_->break_status_i = static_cast<CData>(mark_status_);
    }
    if (request.break_first || request.start) {
      const bool breaks = request.break_first || request.break_with_start;
      decisions_[now + 2] = {request.start, request.payload_beats,
                             request.line,  breaks ? request.break_status : request.start_status,
                             plan,          free_in(now + 1)};
    }
    // places in the FIFO that the writer still counts as taken
    set_free();
    if (const auto wanted = free_wanted_.find(now); wanted != free_wanted_.end()) {
      *wanted->second = places - in_fifo_;
    }
    packetizer_->spoiled_i = 0;
    decide(now);
    set_header_fields(now);
    feed_payload(now);
    packetizer_.settle();
    check(now);
    in_fifo_ += packetizer_->fifo_valid_o;
    in_fifo_ -= in_fifo_ > packetizer_->fifo_valid_o && random_.chance(drain) ? 1 : 0;
    ASSERT_LE(in_fifo_, places) << "clock " << now << ": more than the FIFO holds";
    packetizer_.rise();
  }

  // Runs until the packet under way has left.
  void finish() {
    for (int i = 0; i < 400; ++i) {
      clock({});
      ASSERT_FALSE(::testing::Test::HasFatalFailure());
    }
    EXPECT_TRUE(expected_.empty());
  }

  std::int64_t now() const { return packetizer_.clock(); }
  int delivered() const { return delivered_; }
  int asked() const { return asked_; }
  std::uint32_t lost() const { return lost_; }
  std::int64_t idle_from() const { return idle_from_; }

 private:
  void set_free() {
    packetizer_->fifo_free_i =
        static_cast<std::remove_reference_t<decltype(packetizer_->fifo_free_i)>>(places - in_fifo_);
  }

  struct Decision {
    bool start;
    int payload_beats;
    int line;
    std::uint32_t status;
    Plan plan;
    std::shared_ptr<int> free;  // places a clock after the request
  };

  std::shared_ptr<int> free_in(std::int64_t clock) {
    auto& free = free_wanted_[clock];
    if (!free) {
      free = std::make_shared<int>(0);
    }
    return free;
  }

  // Accepted if idle, with room for all of it, and not spoiled. Fixes all of the packet except the payload.
  void decide(std::int64_t now) {
    const auto found = decisions_.find(now);
    if (accept_change_) {
      accept_ = *accept_change_;
      accept_change_.reset();
    }
    if (found == decisions_.end()) {
      return;
    }
    const Decision d = found->second;
    decisions_.erase(found);
    ++asked_;
    const bool spoiled = d.start && spoil_next;
    packetizer_->spoiled_i = spoiled;
    const int need = kOverhead + (d.start ? d.payload_beats : 0);
    const bool taken = now >= idle_from_ && *d.free >= need && !spoiled;
    if (d.start) {
      accept_change_ = taken;
    }
    if (!taken) {
      // the count shows in the headers of all packets decided later, and at the port three clocks from now
      ++lost_;
      lost_shows_.push_back(now + 3);
      return;
    }
    ++delivered_;
    idle_from_ = INT64_MAX;
    begin(now, d);
  }

  void begin(std::int64_t now, const Decision& d) {
    header_ = {};
    header_.kind = kPerLine ? spec::kKindImage : spec::kKindMoments;
    header_.stream = static_cast<std::uint8_t>(random_.bits());
    header_.lost = lost_;
    header_.sequence = random_.bits();
    header_.time_stamp = random_.bits();
    header_.encoder = static_cast<std::uint32_t>(random_.bits());
    header_.columns = static_cast<std::uint16_t>(random_.between(1, 4095));
    header_.rows = static_cast<std::uint16_t>(random_.between(1, 1023));
    header_.pattern = static_cast<std::uint16_t>(random_.bits());
    header_.mode = static_cast<std::uint8_t>(random_.between(0, 2));
    header_.threshold = static_cast<std::uint8_t>(random_.bits());
    header_.select = static_cast<std::uint8_t>(random_.between(0, 1));
    header_.first_row = static_cast<std::uint16_t>(random_.between(0, 1023));
    header_.last_row = static_cast<std::uint16_t>(random_.between(0, 1023));
    header_.gap = static_cast<std::uint8_t>(random_.between(0, 3));
    header_.region_row = static_cast<std::uint16_t>(random_.bits());
    header_.region_column = static_cast<std::uint16_t>(random_.bits());
    header_.first_line = static_cast<std::uint16_t>(kPerLine ? d.line : 1);
    header_.lines = kPerLine ? std::uint16_t{1} : header_.rows;
    header_.flags = random_.chance(50) ? spec::kFlagStrayBefore : std::uint8_t{0};
    header_from_ = now + 1;
    const int beats = d.start ? d.payload_beats : 0;
    payload_.clear();
    payload_beats_ = beats;
    plan_ = d.plan;
    const std::uint32_t status = d.start && d.plan.marked ? d.plan.status : d.status;
    if (d.start && d.plan.marked) {
      mark_at_ = now + 1;  // it counts three clocks later: before the trailer
      mark_status_ = d.plan.status;
    }
    for (int i = 0; i < beats; ++i) {
      const bool comes = d.plan.early < 0 || i < d.plan.early;
      for (int k = 0; k < 16; ++k) {
        payload_.push_back(comes ? static_cast<std::uint8_t>(random_.bits()) : std::uint8_t{0});
      }
    }
    payload_next_ = 0;
    payload_from_ = beats > 0 ? now + 5 : INT64_MAX;  // seven clocks after the start
    std::vector<std::uint8_t> packet;
    model::append_packet(header_, payload_, status, packet);
    std::copy_n(packet.begin(), spec::kHeaderBytes, info_.begin());
    for (std::size_t i = 0; i < packet.size() / 16; ++i) {
      expected_.push_back({beat_at(packet, i), i + 1 == packet.size() / 16});
    }
    header_beats_due_ = {now + 2, now + 3, now + 4, now + 5};
    if (beats == 0) {
      payload_done(now + 4);  // as if the last header beat were the payload
    }
  }

  // The last payload beat came in this clock, so the trailer reaches the FIFO four clocks later.
  void payload_done(std::int64_t clock) {
    trailer_at_ = clock + 4;
    idle_from_ = clock + 7;
    payload_from_ = INT64_MAX;
  }

  // A beat of info_i is valid only in the clock in which it is read, and the sequence in the clock before its beat. At
  // other times they are random, and so are the fields that the packetizer itself fills in.
  void set_header_fields(std::int64_t now) {
    constexpr std::size_t kSequenceFrom = spec::kHeaderSequence;
    constexpr std::size_t kSequenceTo = kSequenceFrom + sizeof(model::PacketHeader::sequence);
    for (std::size_t byte = 0; byte < spec::kHeaderBytes; ++byte) {
      const bool sequence = byte >= kSequenceFrom && byte < kSequenceTo;
      const auto beat = static_cast<std::int64_t>(byte / spec::kPacketBeatBytes) - (sequence ? 1 : 0);
      const bool right = now == header_from_ + beat && frame_bytes_.at(byte) != 0;
      const auto value = right ? info_.at(byte) : static_cast<std::uint8_t>(random_.bits());
      auto& word = packetizer_->info_i[byte / 4];
      const auto shift = 8U * static_cast<unsigned>(byte % 4);
      word = (word & ~(0xFFU << shift)) | std::uint32_t{value} << shift;
    }
  }

  void feed_payload(std::int64_t now) {
    packetizer_->payload_valid_i = 0;
    packetizer_->payload_break_i = 0;
    packetizer_->tail_valid_i = 0;
    set128(packetizer_->payload_data_i, {0xDEAD, 0xBEEF, 0xDEAD, 0xBEEF});
    if (now < payload_from_ || random_.chance(plan_.gaps)) {
      return;
    }
    const bool breaks = plan_.early >= 0;
    if (!breaks || payload_next_ < plan_.early) {
      packetizer_->payload_valid_i = 1;
      set128(packetizer_->payload_data_i, beat_at(payload_, static_cast<std::size_t>(payload_next_)));
      ++payload_next_;
      payload_at_.push_back(now + 1);
      if (payload_next_ == payload_beats_) {
        payload_done(now);
      }
    }
    // the break comes with the last beat that came, or later
    if (breaks && payload_next_ == plan_.early &&
        (plan_.early == 0 || random_.chance(50) || !packetizer_->payload_valid_i)) {
      packetizer_->payload_break_i = 1;
      if (payload_next_ < payload_beats_) {
        // zeros, one a clock, from the next clock on
        const int rest = payload_beats_ - payload_next_;
        for (int i = 1; i <= rest; ++i) {
          payload_at_.push_back(now + i + 1);
        }
        payload_done(now + rest);
      }
    }
  }

  void check(std::int64_t now) {
    ASSERT_EQ(packetizer_->accept_o, accept_ ? 1 : 0) << "clock " << now;
    while (!lost_shows_.empty() && lost_shows_.front() <= now) {
      lost_shows_.pop_front();
      ++lost_shown_;
    }
    ASSERT_EQ(packetizer_->lost_o, lost_shown_) << "clock " << now;
    bool due = trailer_at_ == now;
    for (auto* times : {&header_beats_due_, &payload_at_}) {
      if (!times->empty() && times->front() == now) {
        times->pop_front();
        due = true;
      }
    }
    ASSERT_EQ(packetizer_->fifo_valid_o, due ? 1 : 0) << "clock " << now;
    if (due) {
      ASSERT_FALSE(expected_.empty());
      ASSERT_EQ(word128(packetizer_->fifo_data_o), expected_.front().data) << "clock " << now;
      ASSERT_EQ(packetizer_->fifo_last_o, expected_.front().last ? 1 : 0) << "clock " << now;
      expected_.pop_front();
    }
  }

  struct FifoBeat {
    Word128 data;
    bool last;
  };

  Random& random_;
  Clocked<Dut> packetizer_;
  std::map<std::int64_t, Decision> decisions_;  // by clock
  std::map<std::int64_t, std::shared_ptr<int>> free_wanted_;
  std::int64_t idle_from_ = 0;
  bool accept_ = false;
  std::optional<bool> accept_change_;
  std::uint32_t lost_ = 0;
  std::uint32_t lost_shown_ = 0;
  std::deque<std::int64_t> lost_shows_;
  int asked_ = 0;
  int delivered_ = 0;
  int in_fifo_ = 0;

  // 1 for header bytes that describe the frame
  static std::array<std::uint8_t, spec::kHeaderBytes> frame_bytes() {
    std::array<std::uint8_t, spec::kHeaderBytes> bytes{};
    const auto mark = [&](std::size_t at, std::size_t size) { std::fill_n(bytes.begin() + at, size, std::uint8_t{1}); };
    mark(spec::kHeaderStream, 1);
    mark(spec::kHeaderPattern, 2);
    mark(spec::kHeaderMode, 1);
    mark(spec::kHeaderThreshold, 1);
    mark(spec::kHeaderSequence, 8);
    mark(spec::kHeaderTimeStamp, 8);
    mark(spec::kHeaderEncoder, 4);
    mark(spec::kHeaderColumns, 2);
    mark(spec::kHeaderRows, 2);
    mark(spec::kHeaderLines, kPerLine ? 0 : 2);
    mark(spec::kHeaderFlags, 1);
    mark(spec::kHeaderSelect, 1);
    mark(spec::kHeaderFirstRow, 2);
    mark(spec::kHeaderLastRow, 2);
    mark(spec::kHeaderGap, 1);
    mark(spec::kHeaderRegionRow, 2);
    mark(spec::kHeaderRegionColumn, 2);
    return bytes;
  }

  model::PacketHeader header_;
  std::array<std::uint8_t, spec::kHeaderBytes> info_{};  // the header as bytes
  std::array<std::uint8_t, spec::kHeaderBytes> frame_bytes_ = frame_bytes();
  std::int64_t header_from_ = -1;
  Plan plan_;
  std::int64_t mark_at_ = -1;
  std::uint32_t mark_status_ = 0;
  std::vector<std::uint8_t> payload_;
  int payload_beats_ = 0;
  int payload_next_ = 0;
  std::int64_t payload_from_ = INT64_MAX;
  std::deque<std::int64_t> header_beats_due_, payload_at_;
  std::int64_t trailer_at_ = -1;
  std::deque<FifoBeat> expected_;
};

// --- Tests ---

template <typename Dut>
class Packetizer : public ::testing::Test {};
using Kinds = ::testing::Types<Vsp_packetizer, Vsp_packetizer_image>;
struct KindNames {
  template <typename Dut>
  static std::string GetName(int) {  // NOLINT(readability-identifier-naming): GoogleTest's name
    return std::is_same_v<Dut, Vsp_packetizer> ? "Moments" : "Image";
  }
};
TYPED_TEST_SUITE(Packetizer, Kinds, KindNames);

// Each packet is requested as soon as the previous one is done: all are delivered.
TYPED_TEST(Packetizer, AStartSevenClocksAfterTheLastPayloadIsTaken) {
  Random random(1);
  for (int early = -1; early < 2; ++early) {
    PacketizerBench<TypeParam> bench(random);
    for (int i = 0; i < 200; ++i) {
      // decided two clocks after the start, in the first clock in which the packetizer is idle
      while (bench.idle_from() == INT64_MAX || bench.now() + 2 < bench.idle_from()) {
        bench.clock({});
        ASSERT_FALSE(::testing::Test::HasFatalFailure());
      }
      bench.clock({.start = true, .payload_beats = random.between(1, 20), .line = random.between(1, 1023)},
                  {early, 0, early >= 0, 1});
      for (int k = 0; k < 3; ++k) {
        bench.clock({});
      }
      ASSERT_FALSE(::testing::Test::HasFatalFailure());
    }
    bench.finish();
    EXPECT_EQ(bench.delivered(), 200);
  }
}

// One clock earlier it is dropped and counted.
TYPED_TEST(Packetizer, AStartSixClocksAfterTheLastPayloadIsLost) {
  Random random(1);
  PacketizerBench<TypeParam> bench(random);
  bench.clock({.start = true, .payload_beats = 3});
  for (int k = 0; k < 3; ++k) {
    bench.clock({});
  }
  while (bench.idle_from() == INT64_MAX || bench.now() + 3 < bench.idle_from()) {
    bench.clock({});
  }
  bench.clock({.start = true, .payload_beats = 3});
  bench.finish();
  EXPECT_EQ(bench.delivered(), 1);
  EXPECT_EQ(bench.lost(), 1U);
}

// Lengths with a single bit set, and the longest that the FIFO holds: complete, and cut short after one beat.
TYPED_TEST(Packetizer, LongPayloads) {
  Random random(1);
  constexpr int kDepth = PacketizerBench<TypeParam>::kFifoDepth;
  for (int early : {-1, 1}) {
    PacketizerBench<TypeParam> bench(random);
    bench.places = kDepth;
    int packets = 0;
    const auto packet = [&](int beats) {
      bench.clock({.start = true, .payload_beats = beats, .line = random.between(1, 1023)}, {early, 0, early >= 0, 1});
      const std::int64_t decided = bench.now() + 3;
      while (bench.now() < decided || bench.idle_from() == INT64_MAX || bench.now() < bench.idle_from() + kDepth) {
        bench.clock({});  // until the FIFO is empty again
        ASSERT_FALSE(::testing::Test::HasFatalFailure());
      }
      EXPECT_EQ(bench.delivered(), ++packets) << beats << " beats";
    };
    for (int beats = 2; beats < kDepth; beats *= 2) {
      packet(beats);
    }
    packet(kDepth - kOverhead);
    bench.clock({.start = true, .payload_beats = kDepth - kOverhead + 1});
    bench.finish();
    EXPECT_EQ(bench.delivered(), packets);
    EXPECT_EQ(bench.lost(), 1U);
    // free places with a single bit set, and a packet that needs one place more
    std::uint32_t lost = 1;
    for (int places = 8; places < kDepth; places *= 2) {
      bench.places = places;
      bench.clock({.start = true, .payload_beats = places - kOverhead + 1});
      bench.finish();
      EXPECT_EQ(bench.delivered(), packets);
      EXPECT_EQ(bench.lost(), ++lost) << places << " places";
      packet(places - kOverhead);
    }
  }
}

// Enough losses to use more than one chain of the counter. Each shows five clocks after its request.
TYPED_TEST(Packetizer, ManyLossesAreCounted) {
  Clocked<TypeParam> packetizer;
  packetizer->break_i = 0;
  packetizer->break_later_i = 0;
  packetizer->spoiled_i = 0;
  packetizer->payload_valid_i = 0;
  packetizer->payload_break_i = 0;
  packetizer->tail_valid_i = 0;
  packetizer->payload_beats_i = 1;
  packetizer->fifo_free_i = 0;
  packetizer->start_i = 0;
  packetizer.reset();
  packetizer->start_i = 1;
  for (std::uint32_t clock = 0; clock < 200'000; ++clock) {
    packetizer.settle();
    if (packetizer->lost_o != (clock < 5 ? 0 : clock - 4) || packetizer->fifo_valid_o || packetizer->accept_o) {
      FAIL() << packetizer->lost_o << " lost, clock " << clock;
    }
    packetizer.rise();
  }
}

// The header after losses of powers of two, and one less.
TYPED_TEST(Packetizer, HeadersTellManyLosses) {
  Random random(1);
  PacketizerBench<TypeParam> bench(random);
  int packets = 0;
  const auto quiet = [&](int clocks) {
    for (int i = 0; i < clocks; ++i) {
      bench.clock({});
    }
  };
  for (std::uint32_t power = 2; power <= 0x10000; power *= 2) {
    for (const std::uint32_t losses : {power - 1, power}) {
      bench.places = 0;
      while (bench.asked() - bench.delivered() < static_cast<int>(losses)) {
        bench.clock({.start = true, .payload_beats = 1});
        quiet(bench.lost() + 8 > losses ? 3 : 0);
        ASSERT_FALSE(::testing::Test::HasFatalFailure());
      }
      bench.places = 32;
      quiet(3);
      bench.clock({.start = true, .payload_beats = 1});
      quiet(40);
      ASSERT_FALSE(::testing::Test::HasFatalFailure());
      EXPECT_EQ(bench.delivered(), ++packets);
      EXPECT_EQ(bench.lost(), losses);
    }
  }
}

// Requests at any time, a FIFO that is often full, payloads with gaps and early ends.
TYPED_TEST(Packetizer, RandomRequests) {
  for_cases(80, [&](Random& random) {
    PacketizerBench<TypeParam> bench(random);
    const int often = random.between(1, 25);
    const int gaps = random.chance(50) ? 0 : random.between(1, 80);
    const bool breaks = random.chance(70);
    int quiet = 0;  // clocks without a request
    for (int i = 0; i < 3000; ++i) {
      if (random.chance(1)) {
        bench.drain = random.chance(50) ? 100 : random.between(0, 60);
      }
      bench.spoil_next = random.chance(3);
      typename PacketizerBench<TypeParam>::Request request;
      typename PacketizerBench<TypeParam>::Plan plan;
      request.payload_beats =
          random.between(1, random.chance(80)                      ? 12
                            : random.chance(80)                    ? 40
                            : PacketizerBench<TypeParam>::kPerLine ? 255
                                                                   : 2047);  // some larger than the FIFO
      request.line = random.between(1, 1023);
      request.break_status = static_cast<std::uint32_t>(1 << random.between(0, 4));
      // a frame breaks before the next one asks for anything
      quiet -= quiet > 0 ? 1 : 0;
      request.start = quiet == 0 && random.chance(often);
      request.break_first = breaks && quiet == 0 && !request.start && random.chance(often);
      request.start_status =
          request.start && random.chance(30) ? static_cast<std::uint32_t>(1 << random.between(0, 4)) : 0;
      request.break_with_start = request.start && breaks && random.chance(20);
      if (request.start) {
        plan.gaps = gaps;
        plan.marked = breaks && random.chance(30);
        quiet = plan.marked ? 4 : 0;
        plan.status = static_cast<std::uint32_t>(1 << random.between(0, 4));
        plan.early = plan.marked && random.chance(80) ? random.between(0, request.payload_beats) : -1;
      }
      bench.clock(request, plan);
      ASSERT_FALSE(::testing::Test::HasFatalFailure());
    }
    bench.drain = 100;
    bench.spoil_next = false;
    bench.finish();
    EXPECT_EQ(static_cast<std::uint32_t>(bench.asked() - bench.delivered()), bench.lost());
    EXPECT_GT(bench.delivered(), 5);
  });
}

}  // namespace

}  // namespace selfproj::test::packetizer
