// Sends code images through the 3 x 3 median, and compares every code with the model in the clock that the header of
// sp_median3x3 states.
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_MEDIAN3X3_BENCH_H
#define SELFPROJ_TESTS_RTL_BLOCKS_MEDIAN3X3_BENCH_H

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "selfproj/model/generated/selfproj_spec.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/model/median3x3.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/rtl/blocks/code_beats.h"
#include "tests/support/random_cases.h"

namespace selfproj::test::median {

constexpr int kMedianLatency = 5;  // from a beat to the group above and to the left of it
constexpr int kLastLatency = 6;    // from a line's last beat to the group above it
constexpr int kBreakLatency = 6;
constexpr int kAfterBusy = 3;              // clocks before the next frame may begin
constexpr std::uint16_t kUnused = 0x7000;  // bits 14..12 of a code word

template <typename Dut>
class MedianBench {
 public:
  explicit MedianBench(Random& random) : random_(random) {
    median_.valid_when({"m_codes_o", "m_start_o", "m_line_start_o", "m_line_end_o"},
                       [this] { return median_->m_valid_o != 0; });
    median_.valid_when({"m_status_o"}, [this] { return median_->m_break_o != 0; });
    median_->s_valid_i = 0;
    median_->s_break_i = 0;
    median_.reset();
  }

  // Plays one frame. `gaps` percent of the clocks have no beat. The frame breaks after `cut` beats if it has more.
  void frame(const std::vector<std::uint16_t>& codes, int rows, int columns, bool median, int gaps, int cut) {
    const int groups = columns / 4;
    std::vector<std::uint16_t> out(codes.size());
    if (median) {
      model::median3x3(codes.data(), rows, columns, out.data());
    } else {
      std::transform(codes.begin(), codes.end(), out.begin(),
                     [](std::uint16_t code) { return static_cast<std::uint16_t>(code & ~kUnused); });
    }
    const auto expect = [&](std::int64_t clock, int row, int group) {
      due_.beats[clock] = {four_words(out.data() + row * columns + 4 * group), row == 0 && group == 0, group == 0,
                           group == groups - 1};
    };
    for (int i = 0; i < rows * groups && i < cut; ++i) {
      while (random_.chance(gaps)) {
        clock();
      }
      const int row = i / groups;
      const int group = i % groups;
      median_->s_valid_i = 1;
      median_->s_codes_i = four_words(codes.data() + 4 * i);
      median_->s_start_i = i == 0;
      median_->s_line_start_i = group == 0;
      median_->s_line_end_i = group == groups - 1;
      median_->s_last_row_i = row == rows - 1;
      median_->s_median_i = i == 0 ? median : random_.chance(50);
      const std::int64_t now = median_.clock();
      if (row > 0 && group > 0) {
        expect(now + kMedianLatency, row - 1, group - 1);
      }
      if (row > 0 && group == groups - 1) {
        expect(now + kLastLatency, row - 1, group);
      }
      if (i == rows * groups - 1) {
        for (int pass = 0; pass < groups; ++pass) {  // the last line
          const std::int64_t step = now + 1 + pass;
          if (pass > 0) {
            expect(step + kMedianLatency, row, pass - 1);
          }
          if (pass == groups - 1) {
            expect(step + kLastLatency, row, pass);
          }
        }
      }
      clock();
      ASSERT_FALSE(::testing::Test::HasFatalFailure());
    }
    if (cut < rows * groups) {
      break_now(true);
    } else if (random_.chance(30)) {
      break_now(false);  // of another frame, which does not come in
    }
  }

  void wait() {
    while (median_->busy_o != 0 && !::testing::Test::HasFatalFailure()) {
      clock();
    }
    for (int i = 0; i < kAfterBusy; ++i) {
      clock();
    }
  }

  void idle(int clocks) {
    for (int i = 0; i < clocks && !::testing::Test::HasFatalFailure(); ++i) {
      clock();
    }
    EXPECT_TRUE(due_.empty());
  }

  [[nodiscard]] std::uint64_t pixels() const { return due_.pixels; }

 private:
  void break_now(bool passed) {
    const auto status = static_cast<std::uint32_t>(random_.between(1, 31));
    median_->s_break_i = 1;
    median_->s_status_i = static_cast<CData>(status);
    if (passed) {
      due_.breaks[median_.clock() + kBreakLatency] = status;
    }
    clock();
  }

  void clock() {
    median_.settle();
    ASSERT_NO_FATAL_FAILURE(due_.check(
        median_.clock(), median_->m_valid_o != 0,
        {median_->m_codes_o, median_->m_start_o != 0, median_->m_line_start_o != 0, median_->m_line_end_o != 0},
        median_->m_break_o != 0, median_->m_status_o));
    median_.rise();
    median_->s_valid_i = 0;
    median_->s_break_i = 0;
    median_->s_codes_i = random_.bits();
    median_->s_start_i = random_.bits() & 1U;
    median_->s_line_start_i = random_.bits() & 1U;
    median_->s_line_end_i = random_.bits() & 1U;
    median_->s_last_row_i = random_.bits() & 1U;
  }

  Random& random_;
  Clocked<Dut> median_;
  CodesDue due_;
};

inline std::vector<std::uint16_t> random_codes(Random& random, int size) {
  const int percent = random.between(0, 100);
  const int most = random.chance(50) ? 4095 : random.between(0, 8);
  std::vector<std::uint16_t> codes(static_cast<std::size_t>(size));
  for (std::uint16_t& code : codes) {
    code = static_cast<std::uint16_t>(random.between(0, most) |
                                      (random.chance(percent) ? model::GrayDecoder::kMeasurable : 0) |
                                      (random.bits() & kUnused));
  }
  return codes;
}

// Random images, with and without gaps, as close to each other as allowed. Some break.
template <typename Dut>
void random_images(int cases) {
  std::uint64_t pixels = 0;
  for_cases(cases, [&](Random& random) {
    MedianBench<Dut> bench(random);
    for (int frame = 0; frame < 20; ++frame) {
      const int rows = random.between(1, random.chance(50) ? 3 : 9);
      const int columns = 4 * random.between(1, random.chance(50) ? 3 : 16);
      const int beats = rows * columns / 4;
      bench.frame(random_codes(random, rows * columns), rows, columns, random.chance(80),
                  random.chance(50) ? 0 : random.between(0, 60), random.chance(20) ? random.between(1, beats) : beats);
      if (random.chance(30)) {
        bench.idle(100);
      } else {
        bench.wait();
      }
      ASSERT_FALSE(::testing::Test::HasFatalFailure());
    }
    bench.idle(100);
    pixels += bench.pixels();
  });
  if (runs_all_cases()) {
    EXPECT_GT(pixels, static_cast<std::uint64_t>(1000 * cases)) << "too little was compared";
  }
}

}  // namespace selfproj::test::median

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_MEDIAN3X3_BENCH_H
