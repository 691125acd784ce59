// Shared by the tests of streams: sides with changing eagerness, and two clocks.
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_STREAMS_BENCH_H
#define SELFPROJ_TESTS_RTL_BLOCKS_STREAMS_BENCH_H

#include <array>
#include <cstddef>
#include <cstdint>

#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test::streams {

// How eager the two sides are, in percent. It changes within a case, so that stalls come in bursts.
struct Eagerness {
  int in = 100;
  int out = 100;

  void maybe_change(Random& random) {
    constexpr std::array<int, 5> kPercent = {0, 10, 50, 90, 100};
    if (random.chance(2)) {
      in = kPercent[static_cast<std::size_t>(random.between(0, 4))];
      out = kPercent[static_cast<std::size_t>(random.between(0, 4))];
    }
  }
};

// A number that one clock writes and the other clock sees two edges later, as behind a two-flop synchronizer.
struct Crossing {
  std::uint64_t meta = 0;
  std::uint64_t seen = 0;
  void rise(std::uint64_t value) {
    seen = meta;
    meta = value;
  }
};

// Steps a model with a write and a read clock to the next rising edge. `set` sets the inputs of a side whose clock
// rises; `check` checks the outputs before the edge.
template <typename Dut, typename Set, typename Check>
TwoClocks::Rises step(Model<Dut>& model, TwoClocks& clocks, Set set, Check check) {
  const TwoClocks::Rises rises = clocks.next();
  step_clocks(
      model, model->wr_clk_i, model->rd_clk_i, rises, [&] { set(rises); }, [&] { check(rises); });
  return rises;
}

template <typename Dut>
void reset_both(Model<Dut>& model, TwoClocks& clocks) {
  model->wr_clk_i = 1;
  model->rd_clk_i = 1;
  model->wr_valid_i = 0;
  model->rd_ready_i = 0;
  model->wr_rst_i = 1;
  model->rd_rst_i = 1;
  int a = 0;
  int b = 0;
  while (a < 4 || b < 4) {
    const TwoClocks::Rises rises = step(
        model, clocks, [](auto) {}, [](auto) {});
    a += rises.a;
    b += rises.b;
  }
  // each side leaves reset in its own clock
  int left = 0;
  while (left != 3) {
    left |= [&] {
      const TwoClocks::Rises rises = step(
          model, clocks,
          [&](TwoClocks::Rises r) {
            model->wr_rst_i = r.a ? 0 : model->wr_rst_i;
            model->rd_rst_i = r.b ? 0 : model->rd_rst_i;
          },
          [](auto) {});
      return (rises.a ? 1 : 0) | (rises.b ? 2 : 0);
    }();
  }
  model.outputs_are_known();
}

}  // namespace selfproj::test::streams

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_STREAMS_BENCH_H
