// A small but complete board, for the recordings that Icarus and the netlists must reproduce: register writes and
// reads, frames in every mode, broken frames, a sink that stalls. This test checks that the packets are whole;
// tests/rtl/board compares them with the model.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <deque>
#include <vector>

#include "Vsp_board_small_binary_ports.h"
#include "Vsp_board_small_ports.h"
#include "selfproj/model/packet.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

template <typename Dut>
class SmallBoardBench {
 public:
  SmallBoardBench(Random& random, TwoClocks clocks) : random_(random), clocks_(clocks) {
    board_.valid_when({"m_axis_tdata", "m_axis_tlast"}, [this] { return board_->m_axis_tvalid != 0; });
    board_.valid_when({"s_axil_bresp"}, [this] { return board_->s_axil_bvalid != 0; });
    board_.valid_when({"s_axil_rresp"}, [this] { return board_->s_axil_rvalid != 0; });
    board_.valid_when({"s_axil_rdata"}, [this] { return board_->s_axil_rvalid != 0 && board_->s_axil_rresp == 0; });
    board_->clk_i = 1;
    board_->bus_clk_i = 1;
    board_->rst_i = 1;
    board_->bus_rst_i = 1;
    board_->s_axis_tvalid = 0;
    board_->encoder_a_i = 0;
    board_->encoder_b_i = 0;
    board_->s_axil_awvalid = 0;
    board_->s_axil_wvalid = 0;
    board_->s_axil_arvalid = 0;
    board_->s_axil_bready = 1;
    board_->s_axil_rready = 1;
    board_->m_axis_tready = 0;
    for (int i = 0; i < 40; ++i) {
      step();
    }
    received.clear();  // before the reset the outputs may have had any value
    board_->rst_i = 0;
    board_->bus_rst_i = 0;
    board_.outputs_are_known();
  }

  struct Beat {
    std::uint32_t pixels;
    bool user;
    bool last;
    bool gap;
  };

  int sink_percent = 100;

  void write(std::uint32_t address, std::uint32_t data) {
    board_->s_axil_awvalid = 1;
    board_->s_axil_wvalid = 1;
    board_->s_axil_awaddr = static_cast<CData>(address);
    board_->s_axil_wdata = data;
    board_->s_axil_wstrb = 15;
    answered_ = false;
    for (int i = 0; i < 5000 && !answered_; ++i) {
      step();
    }
    ASSERT_TRUE(answered_);
  }

  std::uint32_t read(std::uint32_t address) {
    board_->s_axil_arvalid = 1;
    board_->s_axil_araddr = static_cast<CData>(address);
    answered_ = false;
    for (int i = 0; i < 5000 && !answered_; ++i) {
      step();
    }
    EXPECT_TRUE(answered_);
    return read_data_;
  }

  void send(const Beat& beat) { video_.push_back(beat); }

  void run_until_sent() {
    while (!video_.empty() && !::testing::Test::HasFatalFailure()) {
      step();
    }
  }
  void run(int steps) {
    for (int i = 0; i < steps && !::testing::Test::HasFatalFailure(); ++i) {
      step();
    }
  }

  std::vector<std::uint8_t> received;
  bool video_stands = false;  // without edges of the video clock
  int encoder_step = 1;       // direction of the belt: 1, or -1 backwards; 2 if both lines jump
  int encoder_percent = 10;   // share of clocks in which the belt moves

  // The answer of the last access was an error.
  bool refused() const { return refused_; }

 private:
  void step() {
    auto rises = clocks_.next();
    rises.a = rises.a && !video_stands;
    if (rises.a) {
      board_->clk_i = 0;
      board_->s_axis_tvalid = !video_.empty() && !video_.front().gap;
      if (!video_.empty()) {
        const Beat& beat = video_.front();
        board_->s_axis_tdata = beat.pixels;
        board_->s_axis_tuser = beat.user;
        board_->s_axis_tlast = beat.last;
        video_.pop_front();
      }
      if (random_.chance(encoder_percent)) {  // the belt runs on
        encoder_ = (encoder_ + encoder_step) & 3;
        board_->encoder_a_i = encoder_ == 1 || encoder_ == 2;
        board_->encoder_b_i = encoder_ >= 2;
      }
    }
    if (rises.b) {
      board_->bus_clk_i = 0;
      board_->m_axis_tready = random_.chance(sink_percent);
    }
    board_.eval();
    bool aw_taken = false, w_taken = false, ar_taken = false;
    if (rises.b) {
      if (board_->m_axis_tvalid && board_->m_axis_tready) {
        for (int i = 0; i < 16; ++i) {
          received.push_back(
              static_cast<std::uint8_t>(board_->m_axis_tdata[static_cast<std::size_t>(i / 4)] >> (8 * (i % 4))));
        }
      }
      aw_taken = board_->s_axil_awvalid && board_->s_axil_awready;
      w_taken = board_->s_axil_wvalid && board_->s_axil_wready;
      ar_taken = board_->s_axil_arvalid && board_->s_axil_arready;
      if (board_->s_axil_bvalid || board_->s_axil_rvalid) {
        answered_ = true;
        read_data_ = board_->s_axil_rdata;
        refused_ = board_->s_axil_bvalid ? board_->s_axil_bresp != 0 : board_->s_axil_rresp != 0;
      }
    }
    if (rises.a) {
      board_->clk_i = 1;
    }
    if (rises.b) {
      board_->bus_clk_i = 1;
    }
    board_.eval();
    // taken over with the edge; inputs change in the next clock
    board_->s_axil_awvalid = board_->s_axil_awvalid && !aw_taken;
    board_->s_axil_wvalid = board_->s_axil_wvalid && !w_taken;
    board_->s_axil_arvalid = board_->s_axil_arvalid && !ar_taken;
  }

  Random& random_;
  TwoClocks clocks_;
  Model<Dut> board_;
  std::deque<Beat> video_;
  int encoder_ = 0;
  bool answered_ = false;
  bool refused_ = false;
  std::uint32_t read_data_ = 0;
};

template <typename Dut>
void small_frames(bool grey, bool image) {
  Random random(1);
  SmallBoardBench<Dut> bench(random, {1000, 1234, 500});
  bench.write(spec::kRegTimeout, 60);
  bench.write(spec::kRegTriggerPeriod, 70);
  bench.write(spec::kRegTriggerWidth, 9);
  bench.write(spec::kRegTriggerControl,
              1U << spec::kRegTriggerControlRunLsb | 3U << spec::kRegTriggerControlLastPatternLsb);
  bench.write(spec::kRegControl, 1U << spec::kRegControlRunLsb | (image ? 1U << spec::kRegControlImageLsb : 0));
  int frames = 0;
  for (int i = 0; i < 24; ++i) {
    const int columns = i == 0 ? 16 : 4 * random.between(1, 4);
    const int rows = i == 0 ? 15 : random.between(1, 6);
    const int mode = grey ? i % 3 : 0;
    bench.write(spec::kRegSize, static_cast<std::uint32_t>(columns | rows << spec::kRegSizeRowsLsb));
    bench.write(spec::kRegMeasure,
                static_cast<std::uint32_t>(random.between(0, 255) | mode << spec::kRegMeasureModeLsb));
    bench.sink_percent = i % 4 == 3 ? 15 : 90;
    for (int copy = 0; copy < 3; ++copy) {
      ++frames;
      const bool breaks = random.chance(25);
      const int break_at = random.between(1, rows * columns / 4);
      int beats = 0;
      for (int row = 0; row < rows; ++row) {
        for (int group = 0; group < columns / 4 && beats < 1000; ++group) {
          const bool last = group == columns / 4 - 1;
          ++beats;
          const bool wrong = breaks && beats == break_at;
          bench.send({static_cast<std::uint32_t>(random.bits()), beats == 1, last != wrong, false});
          if (random.chance(20)) {
            bench.send({0, false, false, true});
          }
        }
      }
      for (int gap = random.between(0, 40); gap > 0; --gap) {
        bench.send({0, false, false, true});
      }
    }
    bench.run_until_sent();
    for (const std::uint32_t address :
         {spec::kRegFrames, spec::kRegLostMoments, spec::kRegTimeLow, spec::kRegTimeHigh}) {
      bench.read(address);
    }
    ASSERT_FALSE(::testing::Test::HasFatalFailure());
  }
  bench.sink_percent = 100;
  bench.run(2000);

  // whole packets, one after another; every frame is delivered or counted
  std::uint32_t moments = 0;
  std::uint32_t images = 0;
  std::size_t at = 0;
  while (at < bench.received.size()) {
    model::PacketView packet;
    const model::PacketError error = model::parse_packet(std::span(bench.received).subspan(at), packet);
    ASSERT_EQ(error, model::PacketError::none) << model::to_string(error) << " at byte " << at;
    (packet.header.kind == spec::kKindMoments ? moments : images) += 1;
    at += packet.size;
  }
  EXPECT_EQ(bench.read(spec::kRegFrames), static_cast<std::uint32_t>(frames));
  EXPECT_EQ(moments + bench.read(spec::kRegLostMoments), static_cast<std::uint32_t>(frames));
  EXPECT_EQ(images > 0, image);
}

// Every bit of every register crosses in both directions. Refused accesses get an error, and so does every access while
// the video clock stands still.
TEST(BoardSmall, RegistersBitByBit) {
  Random random(3);
  SmallBoardBench<Vsp_board_small> bench(random, {1000, 1234, 500});
  struct Register {
    std::uint32_t address, mask;
  };
  constexpr std::array<Register, 6> kRegisters = {{{spec::kRegMeasure, 0x00FF'00FF},
                                                   {spec::kRegTimeout, 0x00FF'FFFF},
                                                   {spec::kRegTriggerControl, 0x00FF'0000},
                                                   {spec::kRegTriggerPeriod, 0x00FF'FFFF},
                                                   {spec::kRegTriggerCamera, 0x00FF'FFFF},
                                                   {spec::kRegTriggerWidth, 0x0000'FFFF}}};
  for (const Register& reg : kRegisters) {
    for (int bit = 0; bit < 32; ++bit) {
      if ((reg.mask >> bit & 1) != 0) {
        for (const std::uint32_t data : {1U << bit, reg.mask ^ 1U << bit}) {
          bench.write(reg.address, data);
          EXPECT_FALSE(bench.refused());
          EXPECT_EQ(bench.read(reg.address), data) << std::hex << reg.address;
          EXPECT_FALSE(bench.refused());
        }
      }
    }
    bench.write(reg.address, reg.address == spec::kRegTriggerControl ? 0 : 1);
  }
  // What it says while the sequencer counts frames, and while it runs
  for (const std::uint32_t on : {1U << spec::kRegTriggerControlOnFrameLsb, 1U << spec::kRegTriggerControlRunLsb}) {
    for (const std::uint32_t data : {on, 0U}) {
      bench.write(spec::kRegTriggerControl, data);
      EXPECT_FALSE(bench.refused());
      EXPECT_EQ(bench.read(spec::kRegTriggerControl), data);
    }
  }
  bench.write(spec::kRegId, 0xFFFF'FFFF);
  EXPECT_TRUE(bench.refused());
  // Addresses without a register, of a read-only register, and between two registers.
  for (const std::uint32_t address :
       {0xFCU, 0x80U, spec::kRegFrames, spec::kRegLostMoments, spec::kRegTimeout + 1, spec::kRegTimeout + 2}) {
    bench.write(address, 9);
    EXPECT_TRUE(bench.refused()) << std::hex << address;
  }
  for (const std::uint32_t address : {0xFCU, 0x80U, spec::kRegId + 1, spec::kRegId + 2, spec::kRegId + 3}) {
    bench.read(address);
    EXPECT_TRUE(bench.refused()) << std::hex << address;
  }
  EXPECT_EQ(bench.read(spec::kRegId), spec::kMagic);
  EXPECT_FALSE(bench.refused());
  bench.video_stands = true;
  bench.read(spec::kRegId);
  EXPECT_TRUE(bench.refused());
  bench.write(spec::kRegTimeout, 0);
  EXPECT_TRUE(bench.refused());
  bench.video_stands = false;
  bench.run(200);
  bench.write(spec::kRegTimeout, 9);
  EXPECT_FALSE(bench.refused());
  EXPECT_EQ(bench.read(spec::kRegTimeout), 9U);
}

// The belt runs back and forth across count zero, and both lines jump.
TEST(BoardSmall, EncoderRunsBack) {
  Random random(4);
  SmallBoardBench<Vsp_board_small> bench(random, {1000, 1234, 500});
  bench.write(spec::kRegControl, 1U << spec::kRegControlRunLsb);
  bench.write(spec::kRegSize, 4U | 1U << spec::kRegSizeRowsLsb);
  for (const int step : {-1, 1, -1, 1}) {
    bench.encoder_step = step;
    for (int i = 0; i < 60; ++i) {
      bench.run(40);
      bench.send({0x1234'5678, true, true, false});
    }
    const auto count = static_cast<std::int32_t>(bench.read(spec::kRegEncoder));
    EXPECT_GT(std::abs(count), 10);
    EXPECT_EQ(count < 0, step < 0);
    bench.encoder_step = step > 0 ? -1 : 1;
    while (std::abs(static_cast<std::int32_t>(bench.read(spec::kRegEncoder))) > 3) {
      ASSERT_FALSE(::testing::Test::HasFailure());
    }
  }
}

// Jumps of both lines count as errors, up to the last bit of that counter, and do not change the position.
TEST(BoardSmall, EncoderErrorsWrap) {
  Random random(5);
  SmallBoardBench<Vsp_board_small> bench(random, {1000, 1000, 500});
  bench.encoder_percent = 0;
  const std::uint32_t count = bench.read(spec::kRegEncoder);
  bench.encoder_step = 2;
  const auto jump = [&] {
    bench.encoder_percent = 100;
    bench.run(2);  // edges: one of each clock
    bench.encoder_percent = 0;
    bench.run(8);
  };
  for (std::uint32_t jumps = 0; jumps < 0x1'0004; ++jumps) {
    if (jumps % 0x1000 < 4) {
      bench.run(20);
      ASSERT_EQ(bench.read(spec::kRegEncoderErrors), jumps & 0xFFFFU);
    }
    jump();
  }
  EXPECT_EQ(bench.read(spec::kRegEncoder), count);
}

TEST(BoardSmall, FramesRegistersAndStalls) { small_frames<Vsp_board_small>(true, true); }
TEST(BoardSmallBinary, FramesRegistersAndStalls) { small_frames<Vsp_board_small_binary>(false, false); }

}  // namespace
}  // namespace selfproj::test
