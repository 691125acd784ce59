// Soak of the strongest runs: random small frames through the RTL, the SystemC shells, the model and the host's fast
// kernel.
//
//     runs_soak [FRAMES] [FIRST_SEED]      1,000,000 frames from seed 1 on by default
//
// Every frame goes through the board's RTL, one grey and one binary build in turns, with stalls on both sides; in half
// of the runs every fifth frame has a fault. Every packet is compared with the model's. The same image goes whole
// through the shells and the fast kernel, whose every column is compared with the model.
#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "Vboard_codes.h"
#include "Vboard_codes_raw.h"
#include "host/files/results_file.h"
#include "selfproj/model/column_runs.h"
#include "sim/board/engines.h"
#include "tests/hls/model_and_kernel.h"
#include "tests/rtl/board/random_frames.h"
#include "tests/support/soak.h"

namespace selfproj::test {
namespace {

struct ImageCounts {
  std::uint64_t columns = 0;  // with select strongest
  std::uint64_t several = 0;  // of these, with two runs or more
  std::uint64_t ties = 0;     // of these, with two equal strongest runs
  std::uint64_t windows = 0;  // frames of which not all rows count
  std::uint64_t shells = 0;   // columns of the shells
};

// Compares the fast kernel with the model, and counts what the image has.
void compare_fast(const TestImage& image, const model::Measure& measure, ImageCounts& images) {
  model::Runs right;
  ASSERT_NO_FATAL_FAILURE(measure_by_both(image.view(), measure, right));
  images.columns += right.runs.size();
  images.several +=
      static_cast<std::uint64_t>(std::count_if(right.runs.begin(), right.runs.end(), [](auto n) { return n > 1; }));
  images.ties += static_cast<std::uint64_t>(std::count(right.second.begin(), right.second.end(), 16));
  images.windows += measure.window == model::RowWindow{} ? 0 : 1;
}

// Compares the SystemC shells with the model.
void compare_shells(const TestImage& image, const model::Measure& measure, ImageCounts& images) {
  static const auto shells = sim::make_moments_hls_engine();
  static const auto model = sim::make_moments_model_engine();
  const sim::MomentsSettings settings{.rows = image.rows, .columns = image.columns, .measure = measure};
  const std::vector<model::ImageView> frames{image.view()};
  std::vector<model::Runs> right(1);
  std::vector<model::Runs> found(1);
  model->process(frames, settings, right);
  shells->process(frames, settings, found);
  ASSERT_TRUE(found == right) << "the shells differ";
  images.shells += static_cast<std::uint64_t>(image.columns);
}

template <class Model>
void play(std::uint64_t seed, RandomFrames limits, FrameCounts& counts, ImageCounts& images) {
  limits.also = [&](const TestImage& image, const model::BoardSettings& settings) {
    compare_fast(image, settings.measure(), images);
    compare_shells(image, settings.measure(), images);
  };
  play_random_frames<Model>(seed, limits, counts);
}

TEST(RunsSoak, FourImplementationsAreEqual) {
  FrameCounts counts;
  ImageCounts images;
  soak(counts.frames, 1'000'000, [&](std::uint64_t seed) {
    const int faults = seed % 4 < 2 ? 0 : 20;
    if (seed % 2 == 0) {
      play<Vboard_codes>(seed, {.runs = true, .fault_percent = faults}, counts, images);
    } else {
      play<Vboard_codes_raw>(seed,
                             {.max_columns = 128, .grey = false, .image = false, .runs = true, .fault_percent = faults},
                             counts, images);
    }
  });
  report_soak("runs_soak", "Strongest runs: the board's RTL, the SystemC shells and the fast kernel against the model",
              {{"frames", counts.frames},
               {"packets", counts.delivered},
               {"bytes", counts.bytes},
               {"lost_counted", counts.lost},
               {"frames_with_rows_that_do_not_count", images.windows},
               {"columns", images.columns},
               {"columns_with_several_runs", images.several},
               {"columns_with_a_tie", images.ties},
               {"shell_columns", images.shells},
               {"mismatches", 0}});
}

}  // namespace
}  // namespace selfproj::test
