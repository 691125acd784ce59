// Tests the AXI4-Lite bridge: it answers every access once and correctly, with any two clocks and any delays. It times
#include <gtest/gtest.h>

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "Vsp_axil_bridge_ports.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test::axil_bridge {
namespace {

constexpr int kTimeout = 64;  // bus clocks: 2^TimeoutBits of this build
constexpr std::uint32_t kOkay = 0;
constexpr std::uint32_t kSlaveError = 2;

struct Access {
  bool write = false;
  std::uint8_t address = 0;
  std::uint32_t data = 0;
  std::uint8_t strobe = 15;
};

struct Answer {
  std::uint32_t response = 0;
  std::uint32_t data = 0;  // reads
};

// Whether the registers behind the bridge refuse this address.
bool refused(std::uint8_t address) { return (address & 0x70U) == 0x70U; }

// The bridge between a bus master and registers that answer after a random time. The master keeps writes in order, and
// reads in order. a is the video clock, b the bus clock.
class AxilBridgeBench {
 public:
  AxilBridgeBench(Random& random, TwoClocks clocks) : random_(random), clocks_(clocks) {
    bridge_.valid_when({"write_o", "address_o", "write_data_o"}, [this] { return bridge_->request_o != 0; });
    bridge_.valid_when({"s_axil_bresp_o"}, [this] { return bridge_->s_axil_bvalid_o != 0; });
    bridge_.valid_when({"s_axil_rresp_o"}, [this] { return bridge_->s_axil_rvalid_o != 0; });
    bridge_.valid_when({"s_axil_rdata_o"},
                       [this] { return bridge_->s_axil_rvalid_o != 0 && bridge_->s_axil_rresp_o == kOkay; });
    bridge_->clk_i = 1;
    bridge_->bus_clk_i = 1;
    bridge_->rst_i = 1;
    bridge_->bus_rst_i = 1;
    bridge_->s_axil_awvalid_i = 0;
    bridge_->s_axil_wvalid_i = 0;
    bridge_->s_axil_arvalid_i = 0;
    bridge_->s_axil_bready_i = 0;
    bridge_->s_axil_rready_i = 0;
    bridge_->answer_i = 0;
    int a = 0;
    int b = 0;
    int settled = 0;  // video clocks since the bus side was reset
    while (a < 6 || b < 6) {
      const auto rises = clocks_.next();
      a += rises.a;
      b += rises.b;
      settled += b > 0 && rises.a ? 1 : 0;
      step_clocks(
          bridge_, bridge_->clk_i, bridge_->bus_clk_i, rises,
          [&] {
            if (rises.a) {
              bridge_->rst_i = a <= 4;
            }
            if (rises.b) {
              bridge_->bus_rst_i = b <= 4;
            }
          },
          [&] {
            if (rises.a && settled > 3 && a <= 5) {  // 5: the first clock after its reset
              EXPECT_EQ(bridge_->request_o, 0) << "a request with the reset";
            }
          });
    }
    bridge_.outputs_are_known();
  }

  // The tasks of the master. `percent` is the probability per clock that a channel acts.
  void ask(const Access& access) { (access.write ? writes_ : reads_).push_back(access); }
  int eager_request = 100;
  int eager_answer = 100;
  bool registers_answer_at_once = false;
  bool video_stopped = false;

  // Steps to the next rising edge of either clock.
  void step() {
    TwoClocks::Rises rises = clocks_.next();
    rises.a = rises.a && !video_stopped;
    if (!rises.a && !rises.b) {
      return;
    }
    step_clocks(
        bridge_, bridge_->clk_i, bridge_->bus_clk_i, rises,
        [&] {
          if (rises.b) {
            set_bus();
          }
          if (rises.a) {
            set_video();
          }
        },
        [&] {
          if (rises.b) {
            look_at_bus();
          }
          if (rises.a) {
            look_at_video();
          }
        });
  }

  // Runs until all accesses are answered. Returns false if that takes too long.
  bool finish(int steps) {
    for (int i = 0; i < steps; ++i) {
      if (writes_.empty() && reads_.empty() && write_under_way_ == 0 && read_under_way_ == 0) {
        return true;
      }
      step();
    }
    return false;
  }

  std::int64_t bus_clock() const { return bus_clock_; }

  std::vector<Answer> write_answers;
  std::vector<Answer> read_answers;
  std::vector<bool> order;        // kinds of the requests at the registers: true = write
  std::vector<Access> requested;  // likewise
  std::map<std::uint8_t, std::uint32_t> registers;
  std::int64_t last_answer_clock = 0;
  std::int64_t last_taken_clock = 0;

 private:
  // Valid rises at random, and then stays with its data until it is taken. Ready changes at random.
  void set_bus() {
    if (!aw_valid_ && aw_sent_ < writes_.size() && random_.chance(eager_request)) {
      aw_valid_ = true;
      bridge_->s_axil_awaddr_i = writes_[aw_sent_].address;
    }
    if (!w_valid_ && w_sent_ < writes_.size() && random_.chance(eager_request)) {
      w_valid_ = true;
      bridge_->s_axil_wdata_i = writes_[w_sent_].data;
      bridge_->s_axil_wstrb_i = writes_[w_sent_].strobe;
    }
    if (!ar_valid_ && ar_sent_ < reads_.size() && random_.chance(eager_request)) {
      ar_valid_ = true;
      bridge_->s_axil_araddr_i = reads_[ar_sent_].address;
    }
    bridge_->s_axil_awvalid_i = aw_valid_;
    bridge_->s_axil_wvalid_i = w_valid_;
    bridge_->s_axil_arvalid_i = ar_valid_;
    bridge_->s_axil_bready_i = random_.chance(eager_answer);
    bridge_->s_axil_rready_i = random_.chance(eager_answer);
  }

  void look_at_bus() {
    // answers stay until they are taken
    if (b_waits_) {
      EXPECT_TRUE(bridge_->s_axil_bvalid_o && bridge_->s_axil_bresp_o == b_waits_->response);
    }
    if (r_waits_) {
      EXPECT_TRUE(bridge_->s_axil_rvalid_o && bridge_->s_axil_rresp_o == r_waits_->response &&
                  bridge_->s_axil_rdata_o == r_waits_->data);
    }
    b_waits_.reset();
    r_waits_.reset();
    if (bridge_->s_axil_bvalid_o) {
      EXPECT_GT(write_under_way_, 0U) << "an answer without a write";
      const Answer answer = {bridge_->s_axil_bresp_o, 0};
      if (bridge_->s_axil_bready_i) {
        write_answers.push_back(answer);
        write_under_way_ -= write_under_way_ > 0 ? 1 : 0;
        last_answer_clock = bus_clock_;
      } else {
        b_waits_ = answer;
      }
    }
    if (bridge_->s_axil_rvalid_o) {
      EXPECT_GT(read_under_way_, 0U) << "an answer without a read";
      const Answer answer = {bridge_->s_axil_rresp_o, bridge_->s_axil_rdata_o};
      if (bridge_->s_axil_rready_i) {
        read_answers.push_back(answer);
        read_under_way_ -= read_under_way_ > 0 ? 1 : 0;
        last_answer_clock = bus_clock_;
      } else {
        r_waits_ = answer;
      }
    }
    if (aw_valid_ && bridge_->s_axil_awready_o) {
      aw_valid_ = false;
      ++aw_sent_;
      last_taken_clock = bus_clock_;
    }
    if (w_valid_ && bridge_->s_axil_wready_o) {
      w_valid_ = false;
      ++w_sent_;
      last_taken_clock = bus_clock_;
    }
    while (aw_sent_ > 0 && w_sent_ > 0) {
      --aw_sent_;
      --w_sent_;
      writes_.pop_front();
      ++write_under_way_;
    }
    if (ar_valid_ && bridge_->s_axil_arready_o) {
      ar_valid_ = false;
      reads_.pop_front();
      ++read_under_way_;
      last_taken_clock = bus_clock_;
    }
    ++bus_clock_;
  }

  // The registers answer one request at a time, some clocks later.
  void set_video() {
    bridge_->answer_i = 0;
    if (pending_ && (registers_answer_at_once || random_.chance(30))) {
      const Access access = *pending_;
      pending_.reset();
      bridge_->answer_i = 1;
      bridge_->error_i = refused(access.address);
      bridge_->read_data_i = static_cast<std::uint32_t>(random_.bits());
      if (!refused(access.address)) {
        if (access.write) {
          registers[access.address] = access.data;
        } else {
          bridge_->read_data_i = registers[access.address];
        }
      }
    }
  }

  void look_at_video() {
    if (bridge_->request_o) {
      EXPECT_FALSE(pending_) << "a request before the answer to the last one";
      pending_ = Access{bridge_->write_o != 0, bridge_->address_o, bridge_->write_data_o, 15};
      requested.push_back(*pending_);
      order.push_back(pending_->write);
    }
    if (pending_) {  // they must not change before the answer
      EXPECT_EQ(bridge_->address_o, pending_->address);
      EXPECT_EQ(bridge_->write_o, pending_->write);
      EXPECT_EQ(bridge_->write_data_o, pending_->write ? pending_->data : bridge_->write_data_o);
    }
  }

  Random& random_;
  TwoClocks clocks_;
  Model<Vsp_axil_bridge> bridge_;
  std::deque<Access> writes_, reads_;
  bool aw_valid_ = false, w_valid_ = false, ar_valid_ = false;
  std::size_t aw_sent_ = 0, w_sent_ = 0, ar_sent_ = 0;
  std::size_t write_under_way_ = 0, read_under_way_ = 0;
  std::optional<Answer> b_waits_, r_waits_;
  std::optional<Access> pending_;
  std::int64_t bus_clock_ = 0;
};

// --- Tests ---

// Writes and reads at the same time. A read may return any value that its register had while the read was under way.
// Therefore each address is written once in one phase and read in the next.
TEST(AxilBridge, EveryAccessIsAnsweredRight) {
  for_cases(60, [&](Random& random) {
    // nearly equal clocks: no access times out
    AxilBridgeBench bench(random, {1000, 900 + random.between(0, 700), random.between(0, 900)});
    bench.registers_answer_at_once = true;
    std::map<std::uint8_t, std::uint32_t> reference;
    for (int phase = 0; phase < 8; ++phase) {
      constexpr std::array<int, 4> kPercent = {100, 50, 20, 5};
      bench.eager_request = kPercent[static_cast<std::size_t>(random.between(0, 3))];
      bench.eager_answer = kPercent[static_cast<std::size_t>(random.between(0, 3))];
      // even addresses are written, odd ones (written in the phase before) read
      std::vector<Answer> write_answers, read_answers;
      for (int i = random.between(0, 12); i > 0; --i) {
        const Access access = {true, static_cast<std::uint8_t>(random.bits() << 1 | (phase & 1U)),
                               static_cast<std::uint32_t>(random.bits()),
                               static_cast<std::uint8_t>(random.chance(80) ? 15 : random.between(0, 14))};
        bench.ask(access);
        const bool good = access.strobe == 15 && !refused(access.address);
        write_answers.push_back({good ? kOkay : kSlaveError, 0});
        if (good) {
          reference[access.address] = access.data;
        }
      }
      for (int i = random.between(0, 12); i > 0; --i) {
        const auto address = static_cast<std::uint8_t>(random.bits() << 1 | (~phase & 1U));
        bench.ask({false, address, 0, 0});
        read_answers.push_back({refused(address) ? kSlaveError : kOkay, reference[address]});
      }
      bench.write_answers.clear();
      bench.read_answers.clear();
      ASSERT_TRUE(bench.finish(200000)) << "an access has no answer";
      ASSERT_EQ(bench.write_answers.size(), write_answers.size());
      ASSERT_EQ(bench.read_answers.size(), read_answers.size());
      for (std::size_t i = 0; i < write_answers.size(); ++i) {
        ASSERT_EQ(bench.write_answers[i].response, write_answers[i].response) << "write " << i;
      }
      for (std::size_t i = 0; i < read_answers.size(); ++i) {
        ASSERT_EQ(bench.read_answers[i].response, read_answers[i].response) << "read " << i;
        if (read_answers[i].response == kOkay) {
          ASSERT_EQ(bench.read_answers[i].data, read_answers[i].data) << "read " << i;
        }
      }
      ASSERT_FALSE(::testing::Test::HasFailure());
    }
    for (const auto& [address, value] : reference) {
      ASSERT_EQ(bench.registers[address], value);
    }
  });
}

// With any two clocks every access is answered. If the video clock is fast enough for no time-out, every answer is
// right.
TEST(AxilBridge, AnyTwoClocks) {
  for_cases(60, [&](Random& random) {
    TwoClocks clocks = random_clocks(random);
    SCOPED_TRACE(clocks.describe());
    AxilBridgeBench bench(random, clocks);
    bench.eager_request = random.between(5, 100);
    bench.eager_answer = random.between(5, 100);
    for (int i = 0; i < 40; ++i) {
      bench.ask(
          {random.chance(50), static_cast<std::uint8_t>(random.bits()), static_cast<std::uint32_t>(random.bits()), 15});
    }
    ASSERT_TRUE(bench.finish(400000)) << "an access has no answer";
    ASSERT_EQ(bench.write_answers.size() + bench.read_answers.size(), 40U);
  });
}

TEST(AxilBridge, ReadsAndWritesTakeTurns) {
  Random random(1);
  AxilBridgeBench bench(random, {1000, 1100, 300});
  bench.registers_answer_at_once = true;
  for (int i = 0; i < 20; ++i) {
    bench.ask({true, static_cast<std::uint8_t>(i), 0, 15});
    bench.ask({false, static_cast<std::uint8_t>(i), 0, 15});
  }
  ASSERT_TRUE(bench.finish(20000));
  ASSERT_EQ(bench.order.size(), 40U);
  for (std::size_t i = 1; i < bench.order.size(); ++i) {
    EXPECT_NE(bench.order[i], bench.order[i - 1]) << "two of a kind in a row, number " << i;
  }
}

// If a write and a read come in the same clock, the kind that did not come last goes first.
TEST(AxilBridge, TheOtherKindThanTheLastGoesFirst) {
  Random random(1);
  AxilBridgeBench bench(random, {1000, 1100, 300});
  bench.registers_answer_at_once = true;
  for (const bool last : {true, false, false, true, true, false}) {
    bench.ask({last, 4, 1, 15});
    ASSERT_TRUE(bench.finish(2000));
    bench.ask({true, 8, 2, 15});
    bench.ask({false, 8, 0, 15});
    ASSERT_TRUE(bench.finish(2000));
    ASSERT_EQ(bench.order.size() % 3, 0U);
    EXPECT_EQ(bench.order[bench.order.size() - 3], last);
    EXPECT_NE(bench.order[bench.order.size() - 2], last) << "two of a kind in a row";
  }
  EXPECT_FALSE(::testing::Test::HasFailure());
}

// The camera is off: the first access gets SLVERR after 2^TimeoutBits bus clocks, further ones immediately. When the
// clock is back, the late answer is discarded and the next access is right.
TEST(AxilBridge, TimesOutWhileTheVideoClockStandsAndRecovers) {
  for_cases(40, [&](Random& random) {
    AxilBridgeBench bench(random, {1000, 900 + random.between(0, 300), random.between(0, 900)});
    bench.registers_answer_at_once = true;
    bench.ask({true, 0x10, 0x1111'1111, 15});
    bench.ask({true, 0x14, 0x2222'2222, 15});
    ASSERT_TRUE(bench.finish(2000));
    ASSERT_EQ(bench.write_answers.back().response, kOkay);

    for (int i = random.between(0, 20); i > 0; --i) {
      bench.step();
    }
    bench.video_stopped = true;
    const bool write = random.chance(50);
    bench.ask({write, 0x10, 0x3333'3333, 15});
    ASSERT_TRUE(bench.finish(2000));
    const Answer late = write ? bench.write_answers.back() : bench.read_answers.back();
    EXPECT_EQ(late.response, kSlaveError);
    // the access is taken in the last clock counted; it starts a clock later, and its answer shows two clocks after the
    // last
    const std::int64_t waited = bench.last_answer_clock - bench.last_taken_clock;
    EXPECT_GE(waited, kTimeout);
    EXPECT_LE(waited, kTimeout + 4);

    // immediately from now on
    for (int i = 0; i < 6; ++i) {
      const bool next_write = random.chance(50);
      bench.ask({next_write, 0x14, 0x4444'4444, 15});
      ASSERT_TRUE(bench.finish(2000));
      EXPECT_EQ((next_write ? bench.write_answers : bench.read_answers).back().response, kSlaveError);
      EXPECT_LE(bench.last_answer_clock - bench.last_taken_clock, 3);
    }

    bench.video_stopped = false;
    const std::size_t answers = bench.write_answers.size() + bench.read_answers.size();
    for (int i = 0; i < 100; ++i) {
      bench.step();
    }
    EXPECT_EQ(bench.write_answers.size() + bench.read_answers.size(), answers) << "the late answer went to somebody";
    bench.ask({false, 0x14, 0, 15});
    ASSERT_TRUE(bench.finish(2000));
    EXPECT_EQ(bench.read_answers.back().response, kOkay);
    EXPECT_EQ(bench.read_answers.back().data, 0x2222'2222U) << "a refused write has written";
    bench.ask({true, 0x18, 0x5555'5555, 15});
    ASSERT_TRUE(bench.finish(2000));
    EXPECT_EQ(bench.write_answers.back().response, kOkay);
    EXPECT_EQ(bench.registers[0x18], 0x5555'5555U);
  });
}

// The video clock comes back while accesses go on: each is answered, and the registers see each request at most once.
TEST(AxilBridge, AccessesGoOnWhileTheVideoClockStopsAndStarts) {
  for_cases(40, [&](Random& random) {
    AxilBridgeBench bench(random, random_clocks(random));
    bench.eager_request = random.between(20, 100);
    bench.eager_answer = random.between(20, 100);
    std::uint32_t number = 0;
    for (int i = 0; i < 40; ++i) {
      bench.video_stopped = random.chance(50);
      for (int k = 0; k < 3; ++k) {
        bench.ask({random.chance(50), static_cast<std::uint8_t>(4 * random.between(0, 20)), ++number, 15});
      }
      for (int k = random.between(0, 300); k > 0; --k) {
        bench.step();
      }
    }
    ASSERT_TRUE(bench.finish(400000)) << "an access has no answer";
    EXPECT_EQ(bench.write_answers.size() + bench.read_answers.size(), 120U);
    std::uint32_t last = 0;
    for (const Access& access : bench.requested) {
      if (access.write) {
        EXPECT_GT(access.data, last) << "a write came twice or out of order";
        last = access.data;
      }
    }
  });
}

}  // namespace

}  // namespace selfproj::test::axil_bridge
