// Tests the front end for serial LVDS sensors from the edges of the sensor's clock on, with models of the ECP5's
// deserializer cells (constraints/lvds_sensor): both edges of the clock bring a bit of each lane.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "Vecp5_lvds_sensor_codes_ports.h"
#include "Vecp5_lvds_sensor_ports.h"
#include "tests/rtl/blocks/lvds_bench.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// Lanes that are up to three whole bits early or late, from any edge of the clock on.
template <typename Dut>
void expect_frames_from_edges(const LvdsFormat& format) {
  for_cases(10, [&](Random& random, std::uint64_t seed) {
    Model<Dut> dut{Begin::zeros};
    LvdsFrames frames(random, format);
    frames.pause(3000);  // training
    std::vector<Frame> sent;
    for (int frame = 0; frame < 6; ++frame) {
      sent.push_back(frames.send(random.between(1, 5), random.between(2, 8), 3, random.between(3, 40)));
    }
    frames.pause(100);

    // Each lane's bits in the order in which they arrive
    std::vector<std::vector<bool>> bits(static_cast<std::size_t>(format.lanes) + 1);
    for (std::size_t lane = 0; lane < bits.size(); ++lane) {
      bits[lane].assign(static_cast<std::size_t>(random.between(0, 3)), false);
    }
    for (const LvdsWord& word : frames.queue()) {
      for (std::size_t lane = 0; lane < bits.size(); ++lane) {
        const unsigned of_lane = lane + 1 == bits.size() ? word.control : word.data[lane];
        for (int i = 0; i < format.bits; ++i) {
          const int at = format.msb_first ? format.bits - 1 - i : i;
          bits[lane].push_back((of_lane >> static_cast<unsigned>(at) & 1U) != 0);
        }
      }
    }

    dut->eclk_i = 0;
    dut->clk_i = 0;
    dut->good_i = 0;
    dut->lanes_i = 0;
    dut->rst_i = 1;
    std::vector<Beat> beats;
    TwoClocks clocks(1000, random.between(1300, 2000), random.between(0, 900));  // a bit, a clock of the board
    std::size_t at = 0;
    int board = 0;
    while (at < frames.queue().size() * static_cast<std::size_t>(format.bits)) {
      const TwoClocks::Rises rises = clocks.next();
      if (rises.a && dut->good_i) {
        std::uint32_t lanes = 0;
        for (std::size_t lane = 0; lane < bits.size(); ++lane) {
          lanes |= static_cast<std::uint32_t>(bits[lane][at]) << lane;
        }
        ++at;
        dut->lanes_i = static_cast<std::uint8_t>(lanes);
        dut.eval();
        dut->eclk_i = dut->eclk_i == 0;
        dut.eval();
      }
      if (rises.b) {
        dut->clk_i = 0;
        dut->rst_i = board < 4;
        dut->good_i = board > static_cast<int>(seed % 7);
        dut.eval();
        if (board > 10 && dut->m_valid_o) {
          beats.push_back(beat_of(dut));
        }
        EXPECT_EQ(board > 10 && (dut->overrun_o || dut->cut_o || dut->lost_o), false);
        dut->clk_i = 1;
        dut.eval();
        ++board;
      }
    }
    EXPECT_EQ(dut->damaged_o, 0);
    EXPECT_EQ(expect_frames(beats, sent, std::vector<bool>(sent.size(), false)), 0);
  });
}
TEST(LvdsEdges, Flags) {
  expect_frames_from_edges<Vecp5_lvds_sensor>({.lanes = 4, .msb_first = true, .columns = 16, .burst = 16});
}
TEST(LvdsEdges, Codes) {
  expect_frames_from_edges<Vecp5_lvds_sensor_codes>({.lanes = 4, .codes = true, .msb_first = true});
}

}  // namespace
}  // namespace selfproj::test
