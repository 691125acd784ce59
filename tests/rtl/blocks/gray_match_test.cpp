// Compares the matching block with its model.
#include "selfproj/model/gray_match.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "Vsp_gray_match_ports.h"
#include "Vsp_gray_match_small_ports.h"
#include "tests/rtl/blocks/gray_match_bench.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

template <typename Dut>
void random_frames(const GrayMatchBuild& build, int cases) {
  for_cases(cases, [&](Random& random) {
    GrayMatchBench<Dut> bench(random, build);
    bench.late_permille = random.chance(50) ? 0 : random.between(1, 20);
    play_match_frames(bench, build, 20, random);
  });
}

TEST(GrayMatch, RandomFramesEqualTheModel) { random_frames<Vsp_gray_match>({1024, 4, 2}, 40); }
TEST(GrayMatchSmall, RandomFramesEqualTheModel) { random_frames<Vsp_gray_match_small>({6, 2, 5}, 40); }

// Enough late words to use the upper half of the counter: each frame has one beat, whose word never comes.
TEST(GrayMatch, ManyLateFramesAreCounted) {
  constexpr int kMatchLatency = 2;
  Clocked<Vsp_gray_match> match;
  match->s_break_i = 0;
  match->s_valid_i = 0;
  match->mem_late_i = 1;
  match.reset();
  match->s_valid_i = 1;
  match->s_start_i = 1;
  for (std::uint32_t clock = 0; clock < 200'000; ++clock) {
    match.settle();
    if (match->late_o != (clock < kMatchLatency + 2 ? 0 : clock - kMatchLatency - 1) || match->m_valid_o) {
      FAIL() << match->late_o << " late, clock " << clock;
    }
    match.rise();
  }
}

// Compares the model with its definition.
TEST(GrayMatchModel, TakesTheWordOfPixelAndCode) {
  const std::vector<std::uint16_t> table{10, 11, 12, 13, 20, 21, 22, 23, 30, 31, 32, 33};
  const std::vector<std::uint16_t> codes{0x8000, 0x8003, 0x0001};
  std::vector<std::uint16_t> lines(3);
  model::GrayMatch::look_up(codes.data(), 3, 2, table.data(), lines.data());
  EXPECT_EQ(lines, (std::vector<std::uint16_t>{10, 23, model::GrayMatch::kNone}));
  const std::uint16_t too_large = 0x8004;
  model::GrayMatch::look_up(&too_large, 1, 2, table.data(), lines.data());
  EXPECT_EQ(lines[0], model::GrayMatch::kNone);
  EXPECT_THROW(model::GrayMatch::look_up(codes.data(), 3, 9, table.data(), lines.data()), std::invalid_argument);
  EXPECT_EQ(model::GrayMatch::word_of(2.5), 160);
  EXPECT_EQ(model::GrayMatch::word_of(-1), model::GrayMatch::kNone);
  EXPECT_EQ(model::GrayMatch::word_of(1023.99), 65535);  // is none
  EXPECT_EQ(model::GrayMatch::line_of(160), 2.5);
}

}  // namespace
}  // namespace selfproj::test
