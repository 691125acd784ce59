// Sends code images through the matching block, and compares every word with the model in the clock that the header of
// sp_gray_match states.
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_GRAY_MATCH_BENCH_H
#define SELFPROJ_TESTS_RTL_BLOCKS_GRAY_MATCH_BENCH_H

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "selfproj/model/generated/selfproj_spec.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/model/gray_match.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/rtl/blocks/code_beats.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

// The parameters of a build.
struct GrayMatchBuild {
  int groups;
  int bits;
  int latency;
};

template <typename Dut>
class GrayMatchBench {
 public:
  GrayMatchBench(Random& random, const GrayMatchBuild& build)
      : random_(random),
        build_(build),
        table_(static_cast<std::size_t>(4 * build.groups) << static_cast<unsigned>(build.bits)) {
    for (std::uint16_t& word : table_) {
      word = static_cast<std::uint16_t>(random_.bits());
    }
    match_.valid_when({"m_lines_o", "m_start_o", "m_line_start_o", "m_line_end_o"},
                      [this] { return match_->m_valid_o != 0; });
    match_.valid_when({"m_status_o"}, [this] { return match_->m_break_o != 0; });
    match_.valid_when({"mem_address_o"}, [this] { return match_->mem_read_o != 0; });
    match_->s_valid_i = 0;
    match_->s_break_i = 0;
    match_->mem_late_i = 0;
    match_.reset();
  }

  int late_permille = 0;
  std::uint32_t lates_before = 0;  // late_o before the first frame
  Dut& dut() { return match_.dut(); }

  [[nodiscard]] std::uint64_t pixels() const { return due_.pixels; }
  [[nodiscard]] std::uint64_t lates() const { return lates_; }

  // Plays one frame of random codes. `gaps` percent of the clocks have no beat. The frame breaks after `cut` beats if
  // it has more.
  void frame(int groups_of_line, int lines, int gaps, int cut) {
    const int groups = groups_of_line * lines;
    std::vector<std::uint16_t> codes;
    for (int i = 0; i < 4 * groups; ++i) {
      const int code = random_.chance(5) ? random_.between(0, 4095) : random_.between(0, (1 << build_.bits) - 1);
      codes.push_back(static_cast<std::uint16_t>(code | (random_.chance(90) ? model::GrayDecoder::kMeasurable : 0) |
                                                 (random_.chance(5) ? 0x7000 : 0)));
    }
    std::vector<std::uint16_t> lines_out(codes.size());
    model::GrayMatch::look_up(codes.data(), codes.size(), build_.bits, table_.data(), lines_out.data());
    bool lost = false;
    for (int i = 0; i < groups && i < cut; ++i) {
      while (random_.chance(gaps)) {
        clock();
      }
      const int group = i % groups_of_line;
      match_->s_valid_i = 1;
      match_->s_codes_i = four_words(codes.data() + 4 * i);
      match_->s_start_i = i == 0;
      match_->s_line_start_i = group == 0;
      match_->s_line_end_i = group == groups_of_line - 1;
      const std::int64_t now = match_.clock();
      const bool late = random_.between(1, 1000) <= late_permille;
      reads_[now + 1] = {i, late};
      if (late && !lost) {
        lost = true;
        ++lates_;
        due_.breaks[now + out() + 1] = spec::kStatusLateMemory;
      }
      if (!lost) {
        due_.beats[now + out()] = {four_words(lines_out.data() + 4 * i), i == 0, group == 0,
                                   group == groups_of_line - 1};
      }
      clock();
    }
    if (cut < groups && !random_.chance(20)) {
      const auto status = static_cast<std::uint32_t>(1U << static_cast<unsigned>(random_.between(0, 4)));
      match_->s_break_i = 1;
      match_->s_status_i = static_cast<CData>(status);
      if (!lost) {
        due_.breaks[match_.clock() + out()] = status;
      }
      clock();
    }
  }

  void finish() {
    for (int i = 0; i < out() + 4; ++i) {
      clock();
    }
    EXPECT_TRUE(due_.empty());
    EXPECT_EQ(match_->late_o, lates_before + static_cast<std::uint32_t>(lates_));
  }

 private:
  struct Read {
    int group;
    bool late;
  };

  [[nodiscard]] int out() const { return 2 + build_.latency; }

  // The address of a lane. Ports of more than 64 bits are arrays of words.
  [[nodiscard]] std::uint64_t address(int lane) {
    const int bits = address_bits();
    std::uint64_t value = 0;
    for (int b = 0; b < bits; ++b) {
      const int at = bits * lane + b;
      std::uint64_t bit = 0;
      if constexpr (requires { match_->mem_address_o[0]; }) {
        bit = match_->mem_address_o[static_cast<std::size_t>(at / 32)] >> (at % 32) & 1U;
      } else {
        bit = static_cast<std::uint64_t>(match_->mem_address_o) >> at & 1U;
      }
      value |= bit << b;
    }
    return value;
  }
  [[nodiscard]] int address_bits() const {
    int bits = build_.bits;
    for (int groups = build_.groups - 1; groups > 0; groups /= 2) {
      ++bits;
    }
    return bits;
  }

  void clock() {
    // The memory gives the words that were requested Latency clocks ago.
    const std::int64_t now = match_.clock();
    const auto due = answers_.find(now);
    match_->mem_data_i = due != answers_.end() ? due->second.first : random_.bits();
    match_->mem_late_i = due != answers_.end() ? due->second.second : random_.chance(50);
    match_.settle();
    const auto read = reads_.find(now);
    ASSERT_EQ(match_->mem_read_o != 0, read != reads_.end());
    if (read != reads_.end()) {
      std::uint64_t data = 0;
      for (int lane = 0; lane < 4; ++lane) {
        const std::uint64_t at = address(lane);
        ASSERT_EQ(at >> static_cast<unsigned>(build_.bits), static_cast<std::uint64_t>(read->second.group));
        // The model's table is ordered by pixels, this one by groups and lanes.
        const std::uint64_t code = at & ((1U << static_cast<unsigned>(build_.bits)) - 1);
        const auto pixel = static_cast<std::size_t>(4 * read->second.group + lane);
        data |= std::uint64_t{table_[(pixel << static_cast<unsigned>(build_.bits)) + code]} << (16 * lane);
      }
      answers_[now + build_.latency] = {data, read->second.late};
      reads_.erase(read);
    }
    answers_.erase(now);
    ASSERT_NO_FATAL_FAILURE(
        due_.check(now, match_->m_valid_o != 0,
                   {match_->m_lines_o, match_->m_start_o != 0, match_->m_line_start_o != 0, match_->m_line_end_o != 0},
                   match_->m_break_o != 0, match_->m_status_o));
    match_.rise();
    match_->s_valid_i = 0;
    match_->s_break_i = 0;
    match_->s_codes_i = random_.bits();
    match_->s_start_i = random_.chance(50);
  }

  Random& random_;
  GrayMatchBuild build_;
  std::vector<std::uint16_t> table_;
  Clocked<Dut> match_;
  CodesDue due_;
  std::map<std::int64_t, Read> reads_;
  std::map<std::int64_t, std::pair<std::uint64_t, bool>> answers_;
  std::uint64_t lates_ = 0;
};

// Random frames of up to all groups of the build.
template <typename Dut>
void play_match_frames(GrayMatchBench<Dut>& bench, const GrayMatchBuild& build, int frames, Random& random) {
  for (int i = 0; i < frames && !::testing::Test::HasFatalFailure(); ++i) {
    const int line = random.between(1, build.groups < 16 ? build.groups : 16);
    const int lines = random.between(1, build.groups / line);
    bench.frame(line, lines, random.chance(50) ? 0 : random.between(0, 60),
                random.chance(80) ? line * lines : random.between(1, line * lines));
  }
  bench.finish();
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_GRAY_MATCH_BENCH_H
