// Compares the definition of the strongest run with values computed by hand and with a second, slower definition that
// cuts the list of lit rows. Integer sums are exact, so no test here has a tolerance.
#include "selfproj/model/column_runs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "selfproj/model/board.h"
#include "tests/support/moments_refusals.h"
#include "tests/support/random_cases.h"
#include "tests/support/random_runs.h"

namespace selfproj::test {
namespace {

model::Runs runs_of(const std::vector<std::uint8_t>& pixels, int rows, int columns, model::Measure measure) {
  measure.select = model::Select::strongest;
  model::Runs runs;
  runs.resize(measure.select, columns);
  model::column_runs({pixels.data(), rows, columns, columns}, measure, runs.view());
  return runs;
}

// One column, from the letters '.' (dark) and '1'..'9' (10 to 90).
model::Runs runs_of(const std::string& column, const model::Measure& measure) {
  std::vector<std::uint8_t> pixels;
  for (const char letter : column) {
    pixels.push_back(static_cast<std::uint8_t>(letter == '.' ? 0 : 10 * (letter - '0')));
  }
  return runs_of(pixels, static_cast<int>(column.size()), 1, measure);
}

model::Runs one(std::uint32_t m0, std::uint32_t m1, std::uint32_t n, std::uint8_t runs, std::uint8_t second) {
  return {.moments = {.m0 = {m0}, .m1 = {m1}, .n = {n}}, .runs = {runs}, .second = {second}};
}

TEST(ColumnRuns, ByHand) {
  const model::Measure binary{.mode = model::Mode::binary, .threshold = 5};
  const model::Measure grey{.mode = model::Mode::grey, .threshold = 5};
  const model::Measure over{.mode = model::Mode::grey_over, .threshold = 5};
  EXPECT_EQ(runs_of("......", binary), one(0, 0, 0, 0, 0));
  EXPECT_EQ(runs_of("..11..", binary), one(2, 7, 2, 1, 0));
  EXPECT_EQ(runs_of("1..111", binary), one(3, 15, 3, 2, 5));  // 16 / 3 = 5.33
  EXPECT_EQ(runs_of("9..111", grey), one(90, 90, 1, 2, 5));   // 16 * 30 / 90
  EXPECT_EQ(runs_of("9..111", over), one(85, 85, 1, 2, 2));   // 16 * 15 / 85 = 2.8
  EXPECT_EQ(runs_of("11.11.", binary), one(2, 3, 2, 2, 16));  // equal: the smaller rows
  EXPECT_EQ(runs_of("1.11.3", grey), one(30, 180, 1, 3, 10));
  EXPECT_EQ(runs_of("1.1.1.1.1", binary), one(1, 1, 1, 3, 16));  // three or more
}

TEST(ColumnRuns, Gaps) {
  const auto with_gap = [](int gap) { return model::Measure{.mode = model::Mode::binary, .threshold = 5, .gap = gap}; };
  const std::string column = "11.1..11...1....1";
  EXPECT_EQ(runs_of(column, with_gap(0)), one(2, 3, 2, 3, 16));
  EXPECT_EQ(runs_of(column, with_gap(1)), one(3, 7, 3, 3, 10));
  EXPECT_EQ(runs_of(column, with_gap(2)), one(5, 22, 5, 3, 3));
  EXPECT_EQ(runs_of(column, with_gap(3)), one(6, 34, 6, 2, 2));
}

TEST(ColumnRuns, RowsThatCount) {
  const auto within = [](int first, int last) {
    return model::Measure{.mode = model::Mode::binary, .threshold = 5, .gap = 1, .window = {first, last}};
  };
  const std::string column = "111.11..1";
  EXPECT_EQ(runs_of(column, within(0, 0)), one(5, 17, 5, 2, 3));
  EXPECT_EQ(runs_of(column, within(1, 9)), one(5, 17, 5, 2, 3));
  EXPECT_EQ(runs_of(column, within(3, 0)), one(3, 14, 3, 2, 5));
  EXPECT_EQ(runs_of(column, within(0, 3)), one(3, 6, 3, 1, 0));
  EXPECT_EQ(runs_of(column, within(6, 1000)), one(1, 6, 1, 2, 16));
  EXPECT_EQ(runs_of(column, within(10, 0)), one(0, 0, 0, 0, 0));
  EXPECT_EQ(runs_of(column, within(5, 4)), one(0, 0, 0, 0, 0));
}

// The largest sums fit the words; 1023 equal runs do not overflow the number of runs.
TEST(ColumnRuns, LargestSums) {
  const std::vector<std::uint8_t> bright(spec::kMaxRows, 255);
  EXPECT_EQ(runs_of(bright, spec::kMaxRows, 1, {.mode = model::Mode::binary, .threshold = 0}),
            one(spec::kBinaryRunM0Max, spec::kBinaryRunM1Max, spec::kMaxRows, 1, 0));
  EXPECT_EQ(runs_of(bright, spec::kMaxRows, 1, {.mode = model::Mode::grey, .threshold = 0}),
            one(spec::kGreyRunM0Max, spec::kGreyRunM1Max, spec::kGreyRunNMax, 1, 0));
  std::vector<std::uint8_t> stripes(spec::kMaxRows, 0);
  for (std::size_t i = 0; i < stripes.size(); i += 2) {
    stripes[i] = 255;
  }
  EXPECT_EQ(runs_of(stripes, spec::kMaxRows, 1, {.mode = model::Mode::grey_over, .threshold = 0}),
            one(255, 255, 1, 3, 16));
}

// All runs of a column by another way: the list of lit rows, cut where it jumps.
template <typename Pixel>
model::Runs by_list(const model::PixelView<Pixel>& image, const model::Measure& measure) {
  model::Runs out;
  out.resize(model::Select::strongest, image.columns);
  for (int column = 0; column < image.columns; ++column) {
    std::vector<int> rows;
    for (int row = std::max(1, measure.window.first);
         row <= (measure.window.last == 0 ? image.rows : std::min(measure.window.last, image.rows)); ++row) {
      if (image.pixels[(row - 1) * image.stride + column] > measure.threshold) {
        rows.push_back(row);
      }
    }
    struct Sums {
      std::uint32_t m0, m1, n;
    };
    std::vector<Sums> runs;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (i == 0 || rows[i] - rows[i - 1] > measure.gap + 1) {
        runs.push_back({0, 0, 0});
      }
      const int p = image.pixels[(rows[i] - 1) * image.stride + column];
      const auto w = static_cast<std::uint32_t>(measure.mode == model::Mode::binary ? 1
                                                : measure.mode == model::Mode::grey ? p
                                                                                    : p - measure.threshold);
      runs.back().m0 += w;
      runs.back().m1 += w * static_cast<std::uint32_t>(rows[i]);
      ++runs.back().n;
    }
    std::stable_sort(runs.begin(), runs.end(), [](const Sums& a, const Sums& b) { return a.m0 > b.m0; });
    const auto at = static_cast<std::size_t>(column);
    if (!runs.empty()) {
      out.moments.m0[at] = runs[0].m0;
      out.moments.m1[at] = runs[0].m1;
      out.moments.n[at] = runs[0].n;
      out.second[at] = static_cast<std::uint8_t>(runs.size() > 1 ? runs[1].m0 * 16 / runs[0].m0 : 0);
    }
    out.runs[at] = static_cast<std::uint8_t>(std::min<std::size_t>(runs.size(), 3));
  }
  return out;
}

// Pixels of 9 to 12 bits, dark ones and few values among them.
TEST(ColumnRuns, RandomImagesOfMoreBits) {
  for_cases(1000, [](Random& random) {
    const int bits = random.between(9, model::kMaxPixelBits);
    const int largest = (1 << bits) - 1;
    const int rows = random.between(1, random.chance(5) ? spec::kMaxRows : 60);
    const int columns = random.between(1, 40);
    const int dark_percent = random.between(10, 90);
    const model::Measure measure{.mode = static_cast<model::Mode>(random.between(0, 2)),
                                 .threshold = random.between(0, largest - 1),
                                 .select = model::Select::strongest,
                                 .gap = random.between(0, 3),
                                 .window = {.first = random.chance(60) ? 0 : random.between(0, rows),
                                            .last = random.chance(60) ? 0 : random.between(0, rows)},
                                 .bits = bits};
    std::vector<std::uint16_t> pixels(static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns));
    for (std::uint16_t& pixel : pixels) {
      pixel = static_cast<std::uint16_t>(random.chance(dark_percent) ? random.between(0, measure.threshold)
                                         : random.chance(50)         ? largest
                                                                     : random.between(measure.threshold + 1, largest));
    }
    const model::WideImageView image{pixels.data(), rows, columns, columns};
    model::Runs found;
    found.resize(model::Select::strongest, columns);
    model::column_runs(image, measure, found.view());
    ASSERT_EQ(found, by_list(image, measure));
    model::Runs again;
    again.resize(model::Select::strongest, columns);
    model::measure_columns(image, measure, again.view());
    ASSERT_EQ(again, found);
    EXPECT_THROW(model::column_runs(image, {.threshold = largest + 1, .bits = bits}, found.view()),
                 std::invalid_argument);
    EXPECT_THROW(model::column_runs(image, {.gap = 4, .bits = bits}, found.view()), std::invalid_argument);
  });
}

TEST(ColumnRuns, RandomImages) {
  for (const std::uint64_t seed : seeds(3000)) {
    SCOPED_TRACE(how_to_repeat(seed));
    const RandomRuns random(seed);
    model::Runs found;
    found.resize(model::Select::strongest, random.image.columns);
    model::column_runs(random.image, random.measure, found.view());
    const model::Runs right = by_list(random.image, random.measure);
    ASSERT_EQ(found, right);
    // A column with one run has the plain moments of the rows that count.
    model::Moments all;
    all.resize(random.image.columns);
    model::column_moments(random.image, random.measure.mode, random.measure.threshold, all.view(),
                          random.measure.window);
    for (std::size_t i = 0; i < all.m0.size(); ++i) {
      if (found.runs[i] <= 1) {
        ASSERT_EQ(found.moments.m1[i], all.m1[i]);
        ASSERT_EQ(found.moments.n[i], all.n[i]);
      }
      ASSERT_LE(found.moments.m0[i], all.m0[i]);
    }
  }
}

// With Select::all the rows that count are all that is added to the plain moments.
TEST(ColumnRuns, SelectAllWithinAWindowIsTheMomentsOfThatPart) {
  for (const std::uint64_t seed : seeds(300)) {
    SCOPED_TRACE(how_to_repeat(seed));
    RandomRuns random(seed);
    random.measure.select = model::Select::all;
    model::Runs found;
    found.resize(model::Select::all, random.image.columns);
    model::measure_columns(random.image, random.measure, found.view());
    std::vector<std::uint8_t> cut = random.pixels;
    for (int row = 1; row <= random.image.rows; ++row) {
      if (!random.measure.window.counts(row)) {
        std::fill_n(cut.begin() + (row - 1) * random.image.stride, random.image.stride, 0);
      }
    }
    model::Moments right;
    right.resize(random.image.columns);
    const model::ImageView image = {cut.data(), random.image.rows, random.image.columns, random.image.stride};
    model::column_moments(image, random.measure.mode, random.measure.threshold, right.view());
    ASSERT_EQ(found.moments, right);
    ASSERT_TRUE(found.runs.empty() && found.second.empty());
  }
}

TEST(ColumnRuns, RefusesWhatIsOutOfRange) {
  std::vector<std::uint8_t> small(8);
  const auto runs = [&](const model::ImageView& image, model::Mode mode, int threshold, const model::MomentsView& out) {
    model::column_runs(image, {.mode = mode, .threshold = threshold, .select = model::Select::strongest},
                       {out, small.data(), small.data()});
  };
  expect_refusals_of_moments(runs);
  const std::vector<std::uint8_t> pixels(64, 255);
  model::Runs out;
  out.resize(model::Select::strongest, 8);
  for (const int gap : {-1, model::kMaxGap + 1}) {
    EXPECT_THROW(model::column_runs({pixels.data(), 8, 8, 8}, {.gap = gap}, out.view()), std::invalid_argument);
  }
  out.resize(model::Select::all, 8);
  EXPECT_THROW(model::column_runs({pixels.data(), 8, 8, 8}, {}, out.view()), std::invalid_argument);
  EXPECT_EQ(out.moments.m0, std::vector<std::uint32_t>(8, 0));
}

// The board says in the header what it measured, and its words hold it, also for a frame that breaks in its last row.
TEST(ColumnRuns, PacketsOfTheBoard) {
  for (const model::Mode mode : {model::Mode::binary, model::Mode::grey, model::Mode::grey_over}) {
    const model::BoardSettings settings{.columns = 8,
                                        .rows = 6,
                                        .mode = mode,
                                        .threshold = 90,
                                        .select = model::Select::strongest,
                                        .gap = 1,
                                        .window = {2, 6}};
    std::vector<model::BoardPacket> packets;
    model::BoardModel board([&](model::BoardPacket&& packet) { packets.push_back(std::move(packet)); });
    board.write(settings);
    Random random(static_cast<std::uint64_t>(mode) + 1);
    std::vector<std::vector<std::uint8_t>> frames;
    std::uint64_t clock = 10;
    for (int frame = 0; frame < 2; ++frame) {
      frames.push_back(random.bytes(48));
      for (int beat = 0; beat < (frame == 0 ? 12 : 11); ++beat) {  // the second lacks its last beat
        model::VideoBeat video{.start = beat == 0, .line_end = beat % 2 == 1};
        std::copy_n(frames.back().begin() + 4 * beat, 4, video.pixels.begin());
        video.line_end = video.line_end || (frame == 1 && beat == 10);
        board.beat({.clock = ++clock}, video);
      }
    }
    ASSERT_EQ(packets.size(), 2U);
    for (std::size_t frame = 0; frame < 2; ++frame) {
      const model::PacketHeader& header = packets[frame].header;
      EXPECT_EQ(header.select, spec::kSelectStrongest);
      EXPECT_EQ(header.gap, 1);
      EXPECT_EQ(header.first_row, 2);
      EXPECT_EQ(header.last_row, 6);
      EXPECT_EQ(packets[frame].status, frame == 0 ? 0U : spec::kStatusShortLine);
      model::Runs right = by_list(model::ImageView{frames[frame].data(), 6, 8, 8},
                                  {.mode = mode, .threshold = 90, .gap = 1, .window = {2, 6}});
      for (std::size_t i = 0; i < 8; ++i) {
        right.second[i] = mode == model::Mode::binary ? right.second[i] / 8 > 0 ? 8 : 0 : right.second[i];
        if (frame == 1 && i >= 4) {
          right.moments.m0[i] = right.moments.m1[i] = right.moments.n[i] = 0;
          right.runs[i] = right.second[i] = 0;
        }
      }
      model::Runs found;
      found.resize(model::Select::strongest, 8);
      model::unpack_columns(model::column_word(model::Select::strongest, mode), 8, packets[frame].payload.data(),
                            found.view());
      EXPECT_EQ(found, right);
    }
  }
}

}  // namespace
}  // namespace selfproj::test
