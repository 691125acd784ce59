// The 3 x 3 median of a stream of code images against its model: every code, at the clock its header states.
#include "model/median3x3.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <utility>
#include <vector>

#include "Vsp_gray_core_median_ports.h"
#include "Vsp_median3x3_ports.h"
#include "model/gray_decoder.h"
#include "model/spec/generated/selfproj_spec.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

constexpr int kLatency = 5;      // from a beat to the group left of that above it
constexpr int kLastLatency = 6;  // from a line's last beat to the group above it
constexpr int kBreakLatency = 6;
constexpr int kAfterBusy = 3;              // clocks before the next frame may begin
constexpr std::uint16_t kUnused = 0x7000;  // bits 14..12 of a code word

class MedianBench {
 public:
  explicit MedianBench(Random& random) : random_(random) {
    for (const char* port : {"m_codes_o", "m_start_o", "m_line_start_o", "m_line_end_o"}) {
      median_.valid_when(port, [this] { return median_->m_valid_o != 0; });
    }
    median_.valid_when("m_status_o", [this] { return median_->m_break_o != 0; });
    median_->s_valid_i = 0;
    median_->s_break_i = 0;
    median_.reset();
  }

  // One frame, in `gaps` per cent of the clocks no beat. It breaks after `cut` beats where that is less than all.
  void frame(const std::vector<std::uint16_t>& codes, int rows, int columns, bool median, int gaps, int cut) {
    const int groups = columns / 4;
    std::vector<std::uint16_t> out(codes.size());
    if (median) {
      median3x3(codes.data(), rows, columns, out.data());
    } else {
      std::transform(codes.begin(), codes.end(), out.begin(),
                     [](std::uint16_t code) { return static_cast<std::uint16_t>(code & ~kUnused); });
    }
    const auto expect = [&](std::int64_t clock, int row, int group) {
      expected_[clock] = {words(out, row * columns + 4 * group), row == 0 && group == 0, group == 0,
                          group == groups - 1};
    };
    for (int i = 0; i < rows * groups && i < cut; ++i) {
      while (random_.chance(gaps)) {
        clock();
      }
      const int row = i / groups;
      const int group = i % groups;
      median_->s_valid_i = 1;
      median_->s_codes_i = words(codes, 4 * i);
      median_->s_start_i = i == 0;
      median_->s_line_start_i = group == 0;
      median_->s_line_end_i = group == groups - 1;
      median_->s_last_row_i = row == rows - 1;
      median_->s_median_i = i == 0 ? median : random_.chance(50);
      const std::int64_t now = median_.clock();
      if (row > 0 && group > 0) {
        expect(now + kLatency, row - 1, group - 1);
      }
      if (row > 0 && group == groups - 1) {
        expect(now + kLastLatency, row - 1, group);
      }
      if (i == rows * groups - 1) {
        for (int pass = 0; pass < groups; ++pass) {  // the last line
          const std::int64_t step = now + 1 + pass;
          if (pass > 0) {
            expect(step + kLatency, row, pass - 1);
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
    EXPECT_TRUE(expected_.empty());
  }

  [[nodiscard]] std::uint64_t pixels() const { return pixels_; }

 private:
  struct Codes {
    std::uint64_t words;
    bool start, line_start, line_end;
  };

  static std::uint64_t words(const std::vector<std::uint16_t>& codes, int at) {
    std::uint64_t all = 0;
    for (int i = 3; i >= 0; --i) {
      all = all << 16U | codes[static_cast<std::size_t>(at + i)];
    }
    return all;
  }

  void break_now(bool passed) {
    const auto status = static_cast<std::uint32_t>(random_.between(1, 31));
    median_->s_break_i = 1;
    median_->s_status_i = static_cast<CData>(status);
    if (passed) {
      breaks_[median_.clock() + kBreakLatency] = status;
    }
    clock();
  }

  void clock() {
    const std::int64_t now = median_.clock();
    median_.settle();
    const auto found = expected_.find(now);
    ASSERT_EQ(median_->m_valid_o != 0, found != expected_.end()) << "clock " << now;
    if (found != expected_.end()) {
      ASSERT_EQ(median_->m_codes_o, found->second.words) << "clock " << now;
      ASSERT_EQ(median_->m_start_o != 0, found->second.start) << "clock " << now;
      ASSERT_EQ(median_->m_line_start_o != 0, found->second.line_start) << "clock " << now;
      ASSERT_EQ(median_->m_line_end_o != 0, found->second.line_end) << "clock " << now;
      expected_.erase(found);
      pixels_ += 4;
    }
    const auto broken = breaks_.find(now);
    ASSERT_EQ(median_->m_break_o != 0, broken != breaks_.end()) << "clock " << now;
    if (broken != breaks_.end()) {
      ASSERT_EQ(median_->m_status_o, broken->second) << "clock " << now;
      breaks_.erase(broken);
    }
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
  Clocked<Vsp_median3x3> median_;
  std::map<std::int64_t, Codes> expected_;  // by clock
  std::map<std::int64_t, std::uint32_t> breaks_;
  std::uint64_t pixels_ = 0;
};

std::vector<std::uint16_t> random_codes(Random& random, int size) {
  const int percent = random.between(0, 100);
  const int most = random.chance(50) ? 4095 : random.between(0, 8);
  std::vector<std::uint16_t> codes(static_cast<std::size_t>(size));
  for (std::uint16_t& code : codes) {
    code = static_cast<std::uint16_t>(
        random.between(0, most) | (random.chance(percent) ? GrayDecoder::kMeasurable : 0) | (random.bits() & kUnused));
  }
  return codes;
}

TEST(Median3x3, RandomImagesGapsAndBreaks) {
  std::uint64_t pixels = 0;
  for (const std::uint64_t seed : seeds(200)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    MedianBench bench(random);
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
      ASSERT_FALSE(HasFatalFailure());
    }
    bench.idle(100);
    pixels += bench.pixels();
  }
  if (std::getenv("SELFPROJ_SEED") == nullptr) {
    EXPECT_GT(pixels, 200'000U) << "too little was compared";
  }
}

// Decoder and median together: whole frames, with the distance from a frame to that of the codes before it that is
// needed, and one clock less.
class CoreBench {
 public:
  CoreBench() {
    core_->take_i = 0;
    core_->beat_valid_i = 0;
    core_->frame_start_i = 0;
    core_->break_i = 0;
    core_.reset();
  }

  void frame(const std::vector<std::uint8_t>& pixels, const GraySettings& settings, int pattern, bool median) {
    const int groups = settings.columns / 4;
    core_->pattern_i = static_cast<SData>(pattern);
    core_->decode_i = 1;
    core_->bits_i = static_cast<CData>(settings.bits);
    core_->threshold_i = static_cast<CData>(settings.threshold);
    core_->columns_i = static_cast<CData>(settings.columns);
    core_->rows_i = static_cast<CData>(settings.rows);
    core_->median_i = median;
    for (int i = 0; i < settings.rows * groups; ++i) {
      core_->take_i = i == 0;
      core_->frame_start_i = i == 0;
      core_->beat_valid_i = 1;
      core_->beat_pixels_i = 0;
      for (int k = 0; k < 4; ++k) {
        core_->beat_pixels_i |= std::uint32_t{pixels[static_cast<std::size_t>(4 * i + k)]}
                                << 8U * static_cast<unsigned>(k);
      }
      core_->beat_line_start_i = i % groups == 0;
      core_->beat_line_end_i = i % groups == groups - 1;
      core_->beat_last_row_i = i / groups == settings.rows - 1;
      clock();
    }
    core_->beat_valid_i = 0;
    core_->frame_start_i = 0;
    core_->take_i = 0;
  }

  void idle(int clocks) {
    for (int i = 0; i < clocks; ++i) {
      clock();
    }
  }

  std::vector<std::uint16_t> codes;  // that came out
  [[nodiscard]] std::uint32_t abandoned() { return core_->abandoned_o; }

 private:
  void clock() {
    core_.settle();
    if (core_->codes_valid_o != 0) {
      for (int i = 0; i < 4; ++i) {
        codes.push_back(static_cast<std::uint16_t>(core_->codes_o >> (16 * i)));
      }
    }
    core_.rise();
  }

  Clocked<Vsp_gray_core_median> core_;
};

TEST(GrayCoreMedian, DecodesAndFilters) {
  for (const std::uint64_t seed : seeds(60)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    CoreBench bench;
    std::uint32_t refused = 0;
    std::vector<std::uint16_t> right;
    for (int run = 0; run < 4; ++run) {
      const GraySettings settings{.rows = random.between(1, 6),
                                  .columns = 4 * random.between(8, 16),
                                  .bits = random.between(1, 3),
                                  .threshold = random.between(0, 60)};
      const bool median = random.chance(70);
      GrayDecoder decoder(settings);
      const auto size = static_cast<std::size_t>(settings.rows) * static_cast<std::size_t>(settings.columns);
      const int groups = settings.columns / 4;
      int since = 1000;  // clocks from the last beat of the frame with codes before to the frame's first
      bool waits = false;
      for (int frame = 0; frame < 8 * settings.bits && !waits; ++frame) {
        const std::vector<std::uint8_t> pixels = random.bytes(size);
        std::vector<std::uint16_t> raw(size);
        const int pattern = frame % (2 * settings.bits);
        if (decoder.take({pixels.data(), settings.rows, settings.columns, settings.columns}, pattern, true,
                         raw.data())) {
          if (since <= groups + 3) {  // the median is busy: the decoder waits for plane 0
            ++refused;
            waits = true;
          } else {
            std::vector<std::uint16_t> filtered = raw;
            if (median) {
              median3x3(raw.data(), settings.rows, settings.columns, filtered.data());
            }
            right.insert(right.end(), filtered.begin(), filtered.end());
          }
          since = 0;
        }
        bench.frame(pixels, settings, pattern, median);
        const int gap = random.between(0, 5);
        bench.idle(gap);
        since += gap + (pattern % 2 == 0 ? static_cast<int>(size) / 4 + 1 : 0);
      }
      bench.idle(100);
      ASSERT_EQ(bench.codes, right);
    }
    ASSERT_EQ(bench.abandoned(), refused);
  }
}

}  // namespace
}  // namespace selfproj::test
