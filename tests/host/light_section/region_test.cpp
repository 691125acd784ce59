// Regions of the sensor: what frames of few rows measure is what the whole sensor measures, or nothing; how many rows
// are needed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "host/light_section/line_finder.h"
#include "host/light_section/rows.h"
#include "selfproj/images/float_image.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/inspection.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/model/board.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"
#include "tests/host/light_section/lens_world.h"

namespace selfproj::test {
namespace {

using light_section::Validity;

// Columns with a line about the middle row, each elsewhere, and noise below the threshold.
std::vector<std::uint8_t> image_of_line(const rig::RigCamera& camera, double swing) {
  std::mt19937 random(3);
  std::vector<std::uint8_t> pixels(camera.pixels());
  for (int row = 0; row < camera.rows; ++row) {
    for (int column = 0; column < camera.columns; ++column) {
      const double centre = 0.5 * (camera.rows - 1) + swing * std::sin(0.05 * column);
      const double light = 180 * std::exp(-0.5 * std::pow((row - centre) / 1.5, 2));
      pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(camera.columns) +
             static_cast<std::size_t>(column)] = static_cast<std::uint8_t>(light + static_cast<double>(random() % 8));
    }
  }
  return pixels;
}

// The packet of a region of the image, as the board sends it.
std::vector<std::uint8_t> packet_of(const rig::Rig& rig, const std::vector<std::uint8_t>& pixels,
                                    const rig::RigRegion& region, bool placed = true, bool compact = false) {
  const int columns = rig.camera.columns;
  const model::ImageView image{pixels.data() + region.row_offset * columns + region.column_offset, region.rows,
                               region.columns, columns};
  model::PacketHeader header;
  header.region_row = placed ? static_cast<std::uint16_t>(region.row_offset + 1) : std::uint16_t{0};
  header.region_column = placed ? static_cast<std::uint16_t>(region.column_offset + 1) : std::uint16_t{0};
  header.kind = compact ? spec::kKindCompact : spec::kKindMoments;
  std::vector<std::uint8_t> packet;
  model::append_moments_packet(image, rig.measure.of_board(), header, packet);
  return packet;
}

light_section::Profile profile_of(const light_section::DifferentialProfiler& profiler,
                                  const std::vector<std::uint8_t>& packet) {
  model::PacketView view;
  EXPECT_EQ(model::parse_packet(packet, view), model::PacketError::none);
  light_section::Profile profile;
  profile.resize(profiler.columns());
  EXPECT_TRUE(profiler.profile(view, profile.view())) << profiler.unlike_camera(view.header);
  return profile;
}

class Region : public ::testing::TestWithParam<bool> {
 protected:
  Region() {
    if (GetParam()) {
      rig_ = rig::rig_of(distorted_calibration(rig_, {.k1 = 0.08, .k2 = 0.01, .turn = {0.3, -0.3, 0.3}}), rig_);
    }
    rig_.measure.max_z_per_line_mm = 100;
  }
  rig::Rig rig_ = rig::load_rig("light-section");
};

TEST_P(Region, FewRowsMeasureWhatTheWholeSensorDoes) {
  const light_section::DifferentialProfiler profiler(rig_, light_section::reference_of_plane(rig_));
  const int rows = rig_.camera.rows;
  const int columns = rig_.camera.columns;
  const std::vector<std::uint8_t> pixels = image_of_line(rig_.camera, 3);
  for (const bool strongest : {false, true}) {
    for (const model::Mode mode : {model::Mode::binary, model::Mode::grey, model::Mode::grey_over}) {
      rig_.measure.mode = mode;
      rig_.measure.runs = strongest ? std::optional(rig::RigRuns{}) : std::nullopt;
      const light_section::Profile whole = profile_of(
          profiler, packet_of(rig_, pixels, {.row_offset = 0, .rows = rows, .column_offset = 0, .columns = columns}));
      const rig::RigRegion region{
          .row_offset = rows / 2 - 10, .rows = 20, .column_offset = 40, .columns = columns - 100};
      const light_section::Profile few = profile_of(profiler, packet_of(rig_, pixels, region));
      int points = 0;
      for (int c = 0; c < columns; ++c) {
        const auto i = static_cast<std::size_t>(c);
        if (c < region.column_offset || c >= region.column_offset + region.columns) {
          EXPECT_EQ(few.validity[i], static_cast<std::uint8_t>(Validity::outside));
          EXPECT_TRUE(std::isnan(few.z[i]) && std::isnan(few.dz[i]) && std::isnan(few.centroid[i]));
          continue;
        }
        EXPECT_EQ(few.validity[i], whole.validity[i]) << c;
        if (few.validity[i] == 0) {
          ++points;
          // The same centroid, a few units in the last place of a 32-bit float apart
          EXPECT_NEAR(few.centroid[i], whole.centroid[i], 2e-5);
          EXPECT_NEAR(few.z[i], whole.z[i], 1e-3);
          EXPECT_NEAR(few.dz[i], whole.dz[i], 2e-5);
        }
      }
      EXPECT_GT(points, region.columns / 2);
    }
  }
}

// A compact column is 1/1024 row from the exact one at most, and is valid where that is.
TEST_P(Region, CompactColumnsMeasureWhatExactOnesDo) {
  const light_section::DifferentialProfiler profiler(rig_, light_section::reference_of_plane(rig_));
  const int columns = rig_.camera.columns;
  const rig::RigRegion region{
      .row_offset = rig_.camera.rows / 2 - 10, .rows = 20, .column_offset = 40, .columns = columns - 100};
  const std::vector<std::uint8_t> pixels = image_of_line(rig_.camera, 3);
  for (const bool strongest : {false, true}) {
    for (const model::Mode mode : {model::Mode::grey, model::Mode::grey_over}) {
      rig_.measure.mode = mode;
      rig_.measure.runs = strongest ? std::optional(rig::RigRuns{}) : std::nullopt;
      const std::vector<std::uint8_t> exact_packet = packet_of(rig_, pixels, region);
      const std::vector<std::uint8_t> compact_packet = packet_of(rig_, pixels, region, true, true);
      EXPECT_EQ(exact_packet.size() - compact_packet.size(), 4U * static_cast<std::size_t>(region.columns));
      const light_section::Profile exact = profile_of(profiler, exact_packet);
      const light_section::Profile compact = profile_of(profiler, compact_packet);
      int points = 0;
      int off = 0;
      for (std::size_t i = 0; i < exact.validity.size(); ++i) {
        ASSERT_EQ(compact.validity[i], exact.validity[i]) << i;
        if (exact.validity[i] == 0) {
          ++points;
          const auto difference = static_cast<double>(std::abs(compact.centroid[i] - exact.centroid[i]));
          ASSERT_LE(difference, 1.0 / 1024 + 1e-5);
          off += difference > 1.0 / 4096 ? 1 : 0;
          ASSERT_NEAR(compact.dz[i], exact.dz[i], 0.01);
        }
      }
      EXPECT_GT(points, region.columns / 2);
      EXPECT_GT(off, points / 4);  // it is rounded
    }
  }
}

TEST_P(Region, ALineThatLeavesItIsNeverMeasuredWrong) {
  const light_section::DifferentialProfiler profiler(rig_, light_section::reference_of_plane(rig_));
  const std::vector<std::uint8_t> pixels = image_of_line(rig_.camera, 25);
  const rig::RigRegion all{
      .row_offset = 0, .rows = rig_.camera.rows, .column_offset = 0, .columns = rig_.camera.columns};
  const light_section::Profile whole = profile_of(profiler, packet_of(rig_, pixels, all));
  int lost = 0;
  for (int first = 0; first + 20 <= rig_.camera.rows; first += 7) {
    rig::RigRegion region = all;
    region.row_offset = first;
    region.rows = 20;
    const light_section::Profile few = profile_of(profiler, packet_of(rig_, pixels, region));
    for (std::size_t i = 0; i < few.z.size(); ++i) {
      if (few.validity[i] == 0) {
        EXPECT_NEAR(few.z[i], whole.z[i], 1e-3);
      }
      lost += few.validity[i] != 0 ? 1 : 0;
    }
  }
  EXPECT_GT(lost, 1000);
}

INSTANTIATE_TEST_SUITE_P(Rigs, Region, ::testing::Bool(),
                         [](const auto& rig) { return std::string(rig.param ? "Lenses" : "Pinholes"); });

TEST(RegionOfARig, SaysWhereFramesLieThatDoNotSayItThemselves) {
  rig::Rig rig = rig::load_rig("light-section");
  const rig::RigRegion region{.row_offset = 38, .rows = 20, .column_offset = 0, .columns = rig.camera.columns};
  const std::vector<std::uint8_t> packet = packet_of(rig, image_of_line(rig.camera, 3), region, false);
  model::PacketView view;
  ASSERT_EQ(model::parse_packet(packet, view), model::PacketError::none);
  const light_section::ReferenceProfile reference = light_section::reference_of_plane(rig);
  light_section::Profile profile;
  profile.resize(rig.camera.columns);
  const light_section::DifferentialProfiler whole(rig, reference);
  EXPECT_FALSE(whole.profile(view, profile.view()));
  EXPECT_NE(whole.unlike_camera(view.header).find("do not say where on the sensor"), std::string::npos);
  rig.camera.region = region;
  const light_section::DifferentialProfiler few(rig, reference);
  EXPECT_TRUE(few.profile(view, profile.view()));
  EXPECT_NEAR(profile.centroid[0], 48.5, 0.2);
  model::PacketHeader beyond = view.header;
  beyond.region_row = 81;
  beyond.region_column = 1;
  EXPECT_EQ(few.unlike_camera(beyond),
            "its frames of 512 x 20 pixels begin at row 81, column 1 of the sensor, but the rig's has 512 x 96");
}

TEST(RegionOfARig, InspectionKeepsColumnsWhereTheyAre) {
  const rig::Rig rig = rig::load_rig("light-section");
  const rig::RigRegion region{.row_offset = 38, .rows = 20, .column_offset = 100, .columns = 200};
  const std::vector<std::uint8_t> packet = packet_of(rig, image_of_line(rig.camera, 3), region);
  model::PacketView view;
  ASSERT_EQ(model::parse_packet(packet, view), model::PacketError::none);
  const light_section::DifferentialProfiler profiler(rig, light_section::reference_of_plane(rig));
  light_section::Profile profile = profile_of(profiler, packet);
  light_section::Inspection inspection(rig, rig.camera.columns);
  inspection.add(view.header, view.payload, profile.view());
  const images::FloatImage centroids = inspection.centroid();
  EXPECT_EQ(inspection.values().m0[99], 0U);
  EXPECT_GT(inspection.values().m0[100], 0U);
  EXPECT_EQ(inspection.values().m0[300], 0U);
  for (std::size_t c = 100; c < 300; ++c) {
    EXPECT_NEAR(centroids.values[c], profile.centroid[c], 2e-5);
  }
}

TEST(RegionOfARig, TheHostFindsLinesInItsImages) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.camera.region = rig::RigRegion{.row_offset = 38, .rows = 20, .column_offset = 100, .columns = 200};
  const std::vector<std::uint8_t> pixels = image_of_line(rig.camera, 3);
  light_section::LineFinder whole(rig);
  light_section::LineFinder few(rig);
  const int columns = rig.camera.columns;
  whole.find(model::ImageView{pixels.data(), rig.camera.rows, columns, columns});
  few.find(model::ImageView{pixels.data() + 38 * columns + 100, 20, 200, columns});
  for (std::size_t c = 0; c < 512; ++c) {
    ASSERT_TRUE(whole.has_line(c));
    ASSERT_EQ(few.has_line(c), c >= 100 && c < 300) << c;
    if (few.has_line(c)) {
      EXPECT_DOUBLE_EQ(few.centroid(c), whole.centroid(c));
    }
  }
}

TEST(Rows, MoreRowsMeasureMore) {
  const rig::Rig rig = rig::load_rig("light-section");
  const light_section::DifferentialProfiler profiler(rig, light_section::reference_of_plane(rig));
  const light_section::RowTable table(rig, profiler, 6);
  EXPECT_EQ(table.columns(), 512);
  // z0 / f of a camera pixel, over tan θ of the projector: a row is 0.39 mm of height on the plane.
  EXPECT_NEAR(table.mm_per_row(), 0.39, 0.005);
  double before = -1;
  for (const int rows : {10, 12, 16, 20, 32, 64, 96}) {
    const light_section::RowTable::Choice choice = table.best(rows, 1);
    EXPECT_GT(choice.both_sides_mm(), before) << rows;
    before = choice.both_sides_mm();
    // The line has 6 lit rows and a dark one on each side; the rest is the range.
    EXPECT_NEAR(choice.range.high_mm - choice.range.low_mm, (rows - 8) * table.mm_per_row(), 0.03 * rows) << rows;
    EXPECT_NEAR(choice.first_row, (96 - rows) / 2.0, 1) << rows;
  }
  const light_section::RowTable::Range none = table.range(0, 20, 1);
  EXPECT_GT(none.low_mm, none.high_mm);
}

// Lines at each eighth of a row: those within the range are measured, whatever column, those beyond it nowhere are.
TEST(Rows, TheRangeIsWhatFramesOfTheRegionMeasure) {
  constexpr std::uint32_t kLit = 6;
  constexpr int kPerRow = 8;
  rig::Rig rig = rig::load_rig("light-section");
  rig.measure.mode = model::Mode::grey_over;
  const light_section::DifferentialProfiler profiler(rig, light_section::reference_of_plane(rig));
  const light_section::RowTable table(rig, profiler, kLit);
  const int columns = rig.camera.columns;
  const auto count = static_cast<std::size_t>(columns);
  for (const auto& [first_row, rows] : {std::pair{38, 20}, {44, 10}, {35, 20}, {40, 24}, {0, 96}}) {
    SCOPED_TRACE(::testing::Message() << rows << " rows from " << first_row);
    double low = -std::numeric_limits<double>::infinity();  // least height that all columns measure
    double high = std::numeric_limits<double>::infinity();
    std::vector<double> lowest(count, high);
    std::vector<double> highest(count, low);
    for (int step = kPerRow; step <= kPerRow * rows; ++step) {
      model::Runs runs;
      runs.resize(model::Select::all, columns);
      std::fill(runs.moments.m0.begin(), runs.moments.m0.end(), kPerRow * kLit);
      std::fill(runs.moments.m1.begin(), runs.moments.m1.end(), static_cast<std::uint32_t>(step) * kLit);
      std::fill(runs.moments.n.begin(), runs.moments.n.end(), kLit);
      model::PacketHeader header;
      header.kind = spec::kKindMoments;
      header.region_row = static_cast<std::uint16_t>(first_row + 1);
      header.region_column = 1;
      model::describe_frame(header, rows, columns, rig.measure.of_board());
      std::vector<std::uint8_t> payload(model::columns_payload_bytes(header));
      model::pack_columns(header, runs.view(), payload.data());
      std::vector<std::uint8_t> packet;
      model::append_packet(header, payload, 0, packet);
      const light_section::Profile profile = profile_of(profiler, packet);
      for (std::size_t i = 0; i < count; ++i) {
        if (profile.validity[i] == static_cast<std::uint8_t>(Validity::valid)) {
          const auto height = static_cast<double>(-profile.dz[i]);
          lowest[i] = std::min(lowest[i], height);
          highest[i] = std::max(highest[i], height);
        }
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      low = std::max(low, lowest[i]);
      high = std::min(high, highest[i]);
    }
    const light_section::RowTable::Range range = table.range(first_row, rows, 1);
    const double step_mm = 1.5 * table.mm_per_row() / kPerRow;
    EXPECT_NEAR(range.low_mm, low, step_mm);
    EXPECT_NEAR(range.high_mm, high, step_mm);
  }
}

// The formula against images with such noise.
TEST(Rows, NoiseOfACentroidIsThatOfImages) {
  const rig::RigImaging imaging = rig::load_rig("light-section").imaging;
  std::mt19937 random(5);
  // Whole images, short exposures with a threshold just above the noise, narrow and wide lines
  const std::vector<std::tuple<double, double, int>> lines = {{140, 6, 20}, {60, 6, 20},  {25, 6, 9},
                                                              {20, 7.5, 9}, {20, 6.5, 9}, {40, 3.5, 12}};
  for (const auto& [peak, lit, threshold] : lines) {
    double variance = 0;
    constexpr int kPlaces = 10;  // of the line within a row; what the threshold cuts off moves the centroid with them
    constexpr int kLines = 4000;
    for (int place = 0; place < kPlaces; ++place) {
      double sum = 0;
      double squares = 0;
      for (int i = 0; i < kLines; ++i) {
        double m0 = 0;
        double m1 = 0;
        for (int r = -8; r <= 9; ++r) {
          const double far = r - static_cast<double>(place) / kPlaces;
          const double mean = imaging.dark + peak * std::exp(-0.5 * far * far / (lit * lit / 16));
          const double sigma = std::hypot(imaging.read_noise, std::sqrt(mean / imaging.electrons_per_grey));
          const double grey = std::round(std::normal_distribution(mean, sigma)(random));
          if (grey > threshold) {
            m0 += grey - threshold;
            m1 += far * (grey - threshold);
          }
        }
        sum += m1 / m0;
        squares += m1 / m0 * m1 / m0;
      }
      variance += (squares - sum * sum / kLines) / kLines / kPlaces;
    }
    const double found = std::sqrt(variance);
    const double predicted = light_section::centroid_noise(imaging, peak, lit, threshold);
    EXPECT_NEAR(found / predicted, 1, 0.1) << peak << ' ' << lit;  // greys are whole numbers
  }
}

TEST(Rows, RatesOfBoardAndWire) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.measure.mode = model::Mode::binary;
  EXPECT_NEAR(light_section::board_rate_hz(rig, 96, 512), 151.2e6 / (96 * 128), 1e-6);
  EXPECT_NEAR(light_section::board_rate_hz(rig, 1, 512), 151.2e6 / (2048.0 / 16 + 5 + 8), 1e-6);
  // 2,128 bytes in two datagrams
  EXPECT_NEAR(light_section::ethernet_rate_hz(rig, 512), 125e6 / (2128 + 2 * (16 + 66)), 1e-6);
}

}  // namespace
}  // namespace selfproj::test
