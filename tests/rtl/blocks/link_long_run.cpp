// Tests the mailbox of the link after many writes: its ticket starts near a carry and near its end. (Not for netlists,
// because their registers have other names.)
#include <gtest/gtest.h>

#include <cstdint>

#include "tests/rtl/blocks/link_bench.h"
#include "tests/rtl/inner_register.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

TEST(Link, TicketsWrap) {
  for (const std::uint32_t place : {0U, 0x8000'0000U, 0x0001'0000U}) {
    SCOPED_TRACE(place);
    Random random(place + 1);
    LinkBench bench(place + 1);
    LinkModel model(place - 8);
    Verilated::threadContextp(bench->contextp());
    InnerRegister("TOP.sp_link.u_registers.ticket_q").set(place - 8);
    LinkFigures figures;
    expect_link_equals_model(bench, model, random, 60, figures);
    ASSERT_FALSE(HasFailure());
    EXPECT_GT(figures.answers, 15U);
  }
}

}  // namespace
}  // namespace selfproj::test
