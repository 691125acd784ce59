// Compares the 3 x 3 median of a stream of code images with its model, alone and behind the decoder.
#include "selfproj/model/median3x3.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "Vsp_gray_core_median_ports.h"
#include "Vsp_median3x3_ports.h"
#include "selfproj/model/generated/selfproj_spec.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/model/little_endian.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/rtl/blocks/median3x3_bench.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

TEST(Median3x3, RandomImagesGapsAndBreaks) { median::random_images<Vsp_median3x3>(200); }

// Decoder and median together: whole frames at the least allowed distance from the frame of the previous codes, and one
// clock closer.
class CoreBench {
 public:
  CoreBench() {
    core_->take_i = 0;
    core_->beat_valid_i = 0;
    core_->frame_start_i = 0;
    core_->break_i = 0;
    core_.reset();
  }

  void frame(const std::vector<std::uint8_t>& pixels, const model::GraySettings& settings, int pattern, bool median) {
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
      core_->beat_pixels_i = model::load_little_endian<std::uint32_t>(pixels.data() + 4 * i);
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
  for_cases(60, [&](Random& random) {
    CoreBench bench;
    std::uint32_t refused = 0;
    std::vector<std::uint16_t> right;
    for (int run = 0; run < 4; ++run) {
      const model::GraySettings settings{.rows = random.between(1, 6),
                                         .columns = 4 * random.between(8, 16),
                                         .bits = random.between(1, 3),
                                         .threshold = random.between(0, 60)};
      const bool median = random.chance(70);
      model::GrayDecoder decoder(settings);
      const auto size = static_cast<std::size_t>(settings.rows) * static_cast<std::size_t>(settings.columns);
      const int groups = settings.columns / 4;
      int since = 1000;  // clocks from the last beat of the previous frame with codes to the first beat of the frame
      bool waits = false;
      for (int frame = 0; frame < 8 * settings.bits && !waits; ++frame) {
        const std::vector<std::uint8_t> pixels = random.bytes(size);
        std::vector<std::uint16_t> raw(size);
        const int pattern = frame % (2 * settings.bits);
        if (decoder.add_frame({pixels.data(), settings.rows, settings.columns, settings.columns}, pattern, true,
                              raw.data())) {
          if (since <= groups + 3) {  // the median is busy: the decoder waits for plane 0
            ++refused;
            waits = true;
          } else {
            std::vector<std::uint16_t> filtered = raw;
            if (median) {
              model::median3x3(raw.data(), settings.rows, settings.columns, filtered.data());
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
  });
}

}  // namespace
}  // namespace selfproj::test
