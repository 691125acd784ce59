// rise() by the parts of eval() is equivalent to eval() at the falling and at the rising edge. Two equal boards, one
// stepped in each way with the same random inputs, have the same outputs after every edge.
#include "sim/board/clocks.h"

#include <gtest/gtest.h>
#include <verilated.h>

#include <array>
#include <cstdint>
#include <memory>

#include "Vboard.h"
#include "Vboard_original.h"
#include "selfproj/model/packet.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

template <class Model>
struct Simulated {
  Simulated() {
    model.clk_i = 0;
    model.bus_clk_i = 0;
    model.eval();
  }
  ~Simulated() { model.final(); }
  Simulated(const Simulated&) = delete;
  Simulated& operator=(const Simulated&) = delete;
  VerilatedContext context;
  Model model{&context};
};

template <class Model>
std::array<std::uint32_t, 17> outputs(const Model& m) {
  return {m.s_axis_tready,   m.projector_trigger_o, m.camera_trigger_o, m.m_axis_tvalid,  m.m_axis_tdata[0],
          m.m_axis_tdata[1], m.m_axis_tdata[2],     m.m_axis_tdata[3],  m.m_axis_tlast,   m.s_axil_awready,
          m.s_axil_wready,   m.s_axil_bvalid,       m.s_axil_bresp,     m.s_axil_arready, m.s_axil_rvalid,
          m.s_axil_rdata,    m.s_axil_rresp};
}

// Video of 8 x 3 pixels with random gaps and faults, random register accesses, a random bus and encoder, and a reset
// from time to time.
template <class Model>
void expect_equal(std::uint64_t seed) {
  Random random(seed);
  const auto fast = std::make_unique<Simulated<Model>>();
  const auto plain = std::make_unique<Simulated<Model>>();
  sim::BoardClocks clocks(static_cast<std::uint64_t>(random.between(3000, 9000)),
                          static_cast<std::uint64_t>(random.between(3000, 9000)),
                          static_cast<std::uint64_t>(random.between(0, 3000)));
  constexpr std::array<std::uint32_t, 6> kWrites = {spec::kRegControl, spec::kRegSize,           spec::kRegMeasure,
                                                    spec::kRegTimeout, spec::kRegTriggerControl, spec::kRegFrames};
  const std::array<std::uint32_t, 6> values = {
      1U,
      8U << spec::kRegSizeColumnsLsb | 3U << spec::kRegSizeRowsLsb,
      static_cast<std::uint32_t>(random.between(0, 255)),
      static_cast<std::uint32_t>(random.between(0, 60)),
      1U << spec::kRegTriggerControlRunLsb | 5U << spec::kRegTriggerControlLastPatternLsb,
      0U};
  int beat = 0;
  int reset = 40;
  int packet_beats = 0;
  for (int edges = 0; edges < 6000; ++edges) {
    const sim::BoardClocks::Edge edge = clocks.next();
    reset = reset > 0 ? reset - 1 : (random.between(1, 1500) == 1 ? 40 : 0);
    const bool valid = random.chance(80);
    const bool user = random.chance(99) ? beat == 0 : !random.chance(50);
    const bool last = random.chance(99) ? beat % 2 == 1 : random.chance(50);
    const auto pixels = static_cast<std::uint32_t>(random.bits());
    const std::size_t which = static_cast<std::size_t>(random.between(0, 5));
    const auto flags = static_cast<unsigned>(random.bits());
    const bool ready = random.chance(60);
    packet_beats += edge.bus && plain->model.m_axis_tvalid != 0 && ready ? 1 : 0;
    for (Model* m : {&fast->model, &plain->model}) {
      if (edge.video) {
        m->rst_i = reset > 10;
        m->s_axis_tvalid = valid && reset == 0;
        m->s_axis_tdata = pixels;
        m->s_axis_tuser = user;
        m->s_axis_tlast = last;
        m->encoder_a_i = (flags & 0xF000U) == 0 ? flags & 1U : m->encoder_a_i;
        m->encoder_b_i = (flags & 0x0F00U) == 0 ? flags >> 1U & 1U : m->encoder_b_i;
      }
      if (edge.bus) {
        m->bus_rst_i = reset > 10;
        m->m_axis_tready = ready;
        m->s_axil_awvalid = (flags & 4U) != 0;
        m->s_axil_awaddr = static_cast<std::uint8_t>(kWrites[which]);
        m->s_axil_wvalid = (flags & 4U) != 0;
        m->s_axil_wdata = values[which];
        m->s_axil_wstrb = 0xF;
        m->s_axil_bready = flags >> 3U & 1U;
        m->s_axil_arvalid = flags >> 4U & 1U;
        m->s_axil_araddr = static_cast<std::uint8_t>(flags >> 24U);
        m->s_axil_rready = flags >> 5U & 1U;
      }
    }
    if (edge.video && valid && reset == 0) {
      beat = (beat + 1) % 6;
    }
    sim::BoardClocks::raise(fast->model, edge);
    plain->model.clk_i = edge.video;
    plain->model.bus_clk_i = edge.bus;
    sim::rise_by_eval(plain->model);
    ASSERT_EQ(outputs(fast->model), outputs(plain->model)) << "after edge " << edges;
  }
  EXPECT_GT(packet_beats, 100) << "too little of the board was seen";
}

TEST(BoardClocks, AnEdgeEqualsTwoEvaluations) {
  if (!sim::rises_fast<Vboard>() || !sim::rises_fast<Vboard_original>()) {
    GTEST_SKIP() << "rise() calls eval(): it was asked for, or this Verilator writes parts that are not known";
  }
  for_cases(10, [&](std::uint64_t seed) {
    expect_equal<Vboard>(seed);
    expect_equal<Vboard_original>(seed);
  });
}

}  // namespace
}  // namespace selfproj::test
