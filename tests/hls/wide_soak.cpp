// Soak: random small frames of 12 and 10 bits, and of 8 and 16 pixels a clock, and some of up to 4,096 columns, through
// the boards' RTL, with stalls and faults: every packet compared with the model, every loss counted. The images go
// whole through the host's fast kernels and the SystemC shells, too, and every column is compared with the model; of
// the board for 4,096 columns only the packets are.
//
//     wide_soak [FRAMES] [FIRST_SEED]      1,000,000 frames from seed 1 on by default
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "Vboard_eight.h"
#include "Vboard_eight_of_twelve.h"
#include "Vboard_sixteen.h"
#include "Vboard_ten.h"
#include "Vboard_twelve.h"
#include "Vboard_widest.h"
#include "selfproj/model/packet.h"
#include "sim/board/moments_blocks.h"
#include "tests/hls/model_and_kernel.h"
#include "tests/rtl/board/random_frames.h"
#include "tests/support/soak.h"

namespace selfproj::test {
namespace {

// Both shells of a format. All of them must exist before the kernel first runs.
template <int PixelBits, int Lanes>
struct Shells {
  using Format = hls::MomentsFormats<PixelBits, Lanes>;
  sim::ColumnMomentsBlockOf<Format> moments{sc_core::sc_gen_unique_name("moments")};
  sim::ColumnRunsBlockOf<Format> runs{sc_core::sc_gen_unique_name("runs")};

  std::vector<std::uint8_t> payload(const auto& image, const model::Measure& measure) {
    if (measure.select == model::Select::strongest) {
      sim::ColumnRunsPinsOf<Format> pins;
      pins.strongest_i = 1;
      pins.gap_i = static_cast<std::uint8_t>(measure.gap);
      return sim::payload_of(runs, pins, image, measure);
    }
    sim::ColumnMomentsPinsOf<Format> pins;
    pins.one_group_i = image.columns == Lanes;
    pins.two_groups_i = image.columns == 2 * Lanes;
    return sim::payload_of(moments, pins, image, measure);
  }
};

struct AllShells {
  Shells<12, 4> twelve;
  Shells<10, 4> ten;
  Shells<8, 8> eight;
  Shells<12, 8> eight_of_twelve;
  Shells<8, 16> sixteen;
};

AllShells& shells() {
  static AllShells all;
  return all;
}

// What the model says of the image, the fast kernel and the shells must say, too.
template <typename Pixel, typename OneShells>
void compare(const model::PixelView<Pixel>& image, const model::Measure& measure, OneShells& shells,
             std::uint64_t& columns) {
  model::PacketHeader header;
  header.kind = spec::kKindMoments;
  model::describe_frame(header, image.rows, image.columns, measure);
  model::Runs right;
  ASSERT_NO_FATAL_FAILURE(measure_by_both(image, measure, right));
  columns += static_cast<std::uint64_t>(image.columns);
  std::vector<std::uint8_t> payload(model::columns_payload_bytes(header));
  model::pack_columns(header, right.view(), payload.data());
  ASSERT_TRUE(shells.payload(image, measure) == payload) << "the shells differ";
}

template <class Board, typename OneShells>
void play(std::uint64_t seed, RandomFrames limits, OneShells& shells, FrameCounts& counts, std::uint64_t& columns) {
  Random random(seed);
  const int below = limits.pixel_bits - spec::kPixelBits;
  limits.also = [&](const TestImage& image, const model::BoardSettings& settings) {
    model::Measure measure = settings.measure();
    measure.bits = limits.pixel_bits;
    if (below == 0) {
      compare(image.view(), measure, shells, columns);
      return;
    }
    std::vector<std::uint16_t> pixels(image.pixels.size());
    std::ranges::transform(image.pixels, pixels.begin(), [&](std::uint8_t pixel) {
      return static_cast<std::uint16_t>(pixel << below | random.between(0, (1 << below) - 1));
    });
    compare(model::WideImageView{pixels.data(), image.rows, image.columns, image.columns}, measure, shells, columns);
  };
  play_random_frames<Board>(seed, limits, counts);
}

TEST(WideSoak, FourImplementationsAreEqual) {
  FrameCounts counts;
  std::uint64_t columns = 0;  // compared, of images
  soak(counts.frames, 1'000'000, [&](std::uint64_t seed) {
    const int faults = seed % 10 < 5 ? 0 : 20;
    if (seed % 25 == 0) {
      return play_random_frames<Vboard_widest>(
          seed, {.max_columns = 4096, .max_rows = 15, .runs = true, .compact = true, .fault_percent = faults}, counts);
    }
    switch (seed % 5) {
      case 0:
        return play<Vboard_twelve>(seed, {.pixel_bits = 12, .runs = true, .compact = true, .fault_percent = faults},
                                   shells().twelve, counts, columns);
      case 1:
        return play<Vboard_ten>(
            seed, {.pixel_bits = 10, .image = false, .runs = true, .region = false, .fault_percent = faults},
            shells().ten, counts, columns);
      case 2:
        return play<Vboard_eight>(seed, {.lanes = 8, .runs = true, .compact = true, .fault_percent = faults},
                                  shells().eight, counts, columns);
      case 3:
        return play<Vboard_eight_of_twelve>(seed, {.pixel_bits = 12, .lanes = 8, .runs = true, .fault_percent = faults},
                                            shells().eight_of_twelve, counts, columns);
      default:
        return play<Vboard_sixteen>(
            seed, {.lanes = 16, .runs = true, .region = false, .compact = true, .fault_percent = faults},
            shells().sixteen, counts, columns);
    }
  });
  nlohmann::ordered_json figures = figures_of(counts);
  figures["columns_of_kernels_and_shells"] = columns;
  report_soak(
      "wide_soak",
      "Boards for pixels of 12 and 10 bits, for 8 and 16 pixels a clock, and for 4,096 columns, with stalls and "
      "faults, the fast kernels and the SystemC shells, against the model",
      figures);
}

}  // namespace
}  // namespace selfproj::test
