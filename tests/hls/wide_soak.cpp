// Soak: random small frames of 12 and 10 bits, and of 8 and 16 pixels a clock, and some of up to 4,096 columns or 2,047
// rows, or with the Gray decoder, through the boards' RTL, with stalls and faults: every packet compared with the
// model, every loss counted. The images go whole through the host's fast kernels and the SystemC shells, too, and every
// column is compared with the model. The shells end at 1,023 rows; of 4,096 columns and of codes only packets are
// compared.
//
//     wide_soak [FRAMES] [FIRST_SEED]      1,000,000 frames from seed 1 on by default
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "Vboard_codes_sixteen.h"
#include "Vboard_eight.h"
#include "Vboard_eight_of_twelve.h"
#include "Vboard_sixteen.h"
#include "Vboard_tall.h"
#include "Vboard_tall_binary.h"
#include "Vboard_tall_of_ten.h"
#include "Vboard_ten.h"
#include "Vboard_twelve.h"
#include "Vboard_widest.h"
#include "selfproj/model/packet.h"
#include "sim/board/moments_blocks.h"
#include "tests/hls/model_and_kernel.h"
#include "tests/rtl/board/random_codes.h"
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

// What was compared
struct WideCounts {
  FrameCounts frames;
  std::uint64_t tall = 0;     // frames of the boards for 2,047 rows, among them
  std::uint64_t columns = 0;  // of images: kernels, and shells if there are any
  CodeCounts codes;
};

// What the model says of the image, the fast kernel and the shells must say, too.
template <typename Pixel, typename... OneShells>
void compare(const model::PixelView<Pixel>& image, const model::Measure& measure, WideCounts& counts,
             OneShells&... shells) {
  model::PacketHeader header;
  header.kind = spec::kKindMoments;
  model::describe_frame(header, image.rows, image.columns, measure);
  model::Runs right;
  ASSERT_NO_FATAL_FAILURE(measure_by_both(image, measure, right));
  counts.columns += static_cast<std::uint64_t>(image.columns);
  std::vector<std::uint8_t> payload(model::columns_payload_bytes(header));
  model::pack_columns(header, right.view(), payload.data());
  ASSERT_TRUE((... && (shells.payload(image, measure) == payload))) << "the shells differ";
}

template <class Board, typename... OneShells>
void play(std::uint64_t seed, RandomFrames limits, WideCounts& counts, OneShells&... shells) {
  Random random(seed);
  const int below = limits.pixel_bits - spec::kPixelBits;
  limits.also = [&](const TestImage& image, const model::BoardSettings& settings) {
    model::Measure measure = settings.measure();
    measure.bits = limits.pixel_bits;
    if (below == 0) {
      compare(image.view(), measure, counts, shells...);
      return;
    }
    std::vector<std::uint16_t> pixels(image.pixels.size());
    std::ranges::transform(image.pixels, pixels.begin(), [&](std::uint8_t pixel) {
      return static_cast<std::uint16_t>(pixel << below | random.between(0, (1 << below) - 1));
    });
    compare(model::WideImageView{pixels.data(), image.rows, image.columns, image.columns}, measure, counts, shells...);
  };
  play_random_frames<Board>(seed, limits, counts.frames);
}

// Rows to 2,047 take long: fewer frames of one seed
template <class Board>
void play_tall(std::uint64_t seed, RandomFrames limits, WideCounts& counts) {
  limits.max_rows = spec::kRowLimit;
  limits.changes = 15;
  const std::uint64_t before = counts.frames.frames;
  play<Board>(seed, limits, counts);
  counts.tall += counts.frames.frames - before;
}

TEST(WideSoak, FourImplementationsAreEqual) {
  WideCounts counts;
  soak(counts.frames.frames, 1'000'000, [&](std::uint64_t seed) {
    const int faults = seed / 5 % 2 == 0 ? 0 : 20;
    switch (seed % 25) {
      case 0:
        return play_random_frames<Vboard_widest>(
            seed, {.max_columns = 4096, .max_rows = 15, .runs = true, .compact = true, .fault_percent = faults},
            counts.frames);
      case 1:
        return play_tall<Vboard_tall>(seed, {.runs = true, .compact = true, .fault_percent = faults}, counts);
      case 2:
        return play_tall<Vboard_tall_of_ten>(
            seed, {.pixel_bits = 10, .lanes = 8, .region = false, .compact = true, .fault_percent = faults}, counts);
      case 3:
        return play_tall<Vboard_tall_binary>(
            seed, {.grey = false, .image = false, .runs = true, .region = false, .fault_percent = faults}, counts);
      case 4:
        if (seed % 2 == 0) {
          return play_random_sequences<Vboard_eight_of_twelve>(seed, true, faults, counts.codes, {}, {}, 12, 8);
        }
        return play_random_sequences<Vboard_codes_sixteen>(seed, true, faults, counts.codes, {}, {}, spec::kPixelBits,
                                                           16);
      default:
        break;
    }
    switch (seed % 5) {
      case 0:
        return play<Vboard_twelve>(seed, {.pixel_bits = 12, .runs = true, .compact = true, .fault_percent = faults},
                                   counts, shells().twelve);
      case 1:
        return play<Vboard_ten>(
            seed, {.pixel_bits = 10, .image = false, .runs = true, .region = false, .fault_percent = faults}, counts,
            shells().ten);
      case 2:
        return play<Vboard_eight>(seed, {.lanes = 8, .runs = true, .compact = true, .fault_percent = faults}, counts,
                                  shells().eight);
      case 3:
        return play<Vboard_eight_of_twelve>(seed, {.pixel_bits = 12, .lanes = 8, .runs = true, .fault_percent = faults},
                                            counts, shells().eight_of_twelve);
      default:
        return play<Vboard_sixteen>(
            seed, {.lanes = 16, .runs = true, .region = false, .compact = true, .fault_percent = faults}, counts,
            shells().sixteen);
    }
  });
  nlohmann::ordered_json figures = figures_of(counts.frames);
  figures["frames_of_tall_boards"] = counts.tall;
  figures["columns_of_kernels_and_shells"] = counts.columns;
  figures["frames_of_codes"] = counts.codes.frames;
  figures["lines_of_codes"] = counts.codes.delivered;
  report_soak("wide_soak",
              "Boards for pixels of 12 and 10 bits, for 8 and 16 pixels a clock, for 4,096 columns and for 2,047 rows, "
              "and codes of 8 and 16 pixels a clock, with stalls and faults, the fast kernels and the SystemC shells, "
              "against the model",
              figures);
}

}  // namespace
}  // namespace selfproj::test
