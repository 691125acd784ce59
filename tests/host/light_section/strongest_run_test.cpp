// What the strongest run is for: a hot pixel and a second reflection move the moments of all lit pixels far, and those
// of the strongest run not at all, or the column is marked as ambiguous.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/light_section/strip_moments.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/packet_payload.h"
#include "selfproj/rig/rig.h"

namespace selfproj::test {
namespace {

// Images of a line of the built-in rig, 6 rows wide at its half, peak 180 over a background of 5, somewhere else
// between two rows in each column.
class StrongestRun : public ::testing::TestWithParam<model::Mode> {
 protected:
  StrongestRun() {
    rig_.measure.mode = GetParam();
    pixels_.resize(static_cast<std::size_t>(rig_.camera.rows) * static_cast<std::size_t>(rig_.camera.columns), 5);
    for (int column = 0; column < rig_.camera.columns; ++column) {
      add_line(column, 0, kPeak);
    }
  }

  // Adds a line `below` rows under the column's own.
  void add_line(int column, int below, double peak) {
    const double centre = 40 + 6 * std::sin(0.05 * column) + below;
    for (int row = 0; row < rig_.camera.rows; ++row) {
      const double light = peak * std::exp(-0.5 * std::pow((row - centre) / 1.5, 2));
      std::uint8_t& pixel = at(row, column);
      pixel = static_cast<std::uint8_t>(std::min(255L, std::lround(pixel + light)));
    }
  }

  std::uint8_t& at(int row, int column) {
    return pixels_[static_cast<std::size_t>(row) * static_cast<std::size_t>(rig_.camera.columns) +
                   static_cast<std::size_t>(column)];
  }

  // The profile by way of a packet's payload.
  light_section::Profile profile(model::Select select) {
    const int columns = rig_.camera.columns;
    const model::Measure measure{.mode = GetParam(), .threshold = rig_.measure.threshold, .select = select, .gap = 1};
    model::Runs runs;
    runs.resize(select, columns);
    model::measure_columns({pixels_.data(), rig_.camera.rows, columns, columns}, measure, runs.view());
    std::vector<std::uint8_t> payload(model::moments_payload_bytes(measure.mode, columns));
    model::pack_columns(model::column_word(select, measure.mode), columns, runs.view(), payload.data());
    const double far = rig_.plane_z_mm;
    const light_section::ReferenceProfile reference =
        light_section::reference_of_curve(rig_, {{-far, far}, {far, far}});
    light_section::Profile out;
    out.resize(columns);
    light_section::DifferentialProfiler(rig_, reference).profile(select, measure.mode, payload.data(), out.view());
    return out;
  }

  // The largest difference in height from `clean`, in mm, of columns that are valid in both.
  static double largest_error(const light_section::Profile& found, const light_section::Profile& clean) {
    double largest = 0;
    for (std::size_t i = 0; i < clean.z.size(); ++i) {
      if (found.validity[i] == 0 && clean.validity[i] == 0) {
        largest = std::max(largest, std::abs(static_cast<double>(found.z[i]) - static_cast<double>(clean.z[i])));
      }
    }
    return largest;
  }

  static std::ptrdiff_t count(const light_section::Profile& found, light_section::Validity validity) {
    return std::count(found.validity.begin(), found.validity.end(), static_cast<std::uint8_t>(validity));
  }

  static constexpr double kPeak = 180;
  rig::Rig rig_ = rig::load_rig("light-section");
  std::vector<std::uint8_t> pixels_;
};

TEST_P(StrongestRun, HotPixelThirtyRowsOff) {
  const light_section::Profile clean = profile(model::Select::all);
  ASSERT_EQ(count(clean, light_section::Validity::valid), rig_.camera.columns);
  EXPECT_EQ(profile(model::Select::strongest).z, clean.z);
  for (int column = 0; column < rig_.camera.columns; ++column) {
    at(std::min(rig_.camera.rows - 2, 70 + column % 7), column) = 255;
  }
  EXPECT_GT(largest_error(profile(model::Select::all), clean), 0.5);
  const light_section::Profile found = profile(model::Select::strongest);
  EXPECT_LE(largest_error(found, clean), 0.05);
  EXPECT_EQ(count(found, light_section::Validity::valid) + count(found, light_section::Validity::ambiguous),
            rig_.camera.columns);
  EXPECT_GT(count(found, light_section::Validity::valid), rig_.camera.columns / 2) << "marking everything is no answer";
}

TEST_P(StrongestRun, ReflectionOfThirtyPercentFifteenRowsOff) {
  const light_section::Profile clean = profile(model::Select::all);
  for (int column = 0; column < rig_.camera.columns; ++column) {
    add_line(column, 15, 0.3 * kPeak);
  }
  EXPECT_GT(largest_error(profile(model::Select::all), clean), 0.5);
  const light_section::Profile found = profile(model::Select::strongest);
  EXPECT_LE(largest_error(found, clean), 0.05);
  EXPECT_EQ(count(found, light_section::Validity::valid) + count(found, light_section::Validity::ambiguous),
            rig_.camera.columns);
  if (GetParam() != model::Mode::binary) {  // where the width counts, not the light, the reflection is half as strong
    EXPECT_EQ(count(found, light_section::Validity::valid), rig_.camera.columns);
  }
}

// The limit of the rig decides. What a binary word leaves open counts against the column.
TEST_P(StrongestRun, AmbiguousFromTheRigsShare) {
  for (int column = 0; column < rig_.camera.columns; ++column) {
    add_line(column, 15, 0.6 * kPeak);
  }
  rig_.measure.runs = rig::RigRuns{.gap_rows = 1, .ambiguous_from = 1.0 / 16};
  EXPECT_EQ(count(profile(model::Select::strongest), light_section::Validity::ambiguous), rig_.camera.columns);
  EXPECT_EQ(count(profile(model::Select::all), light_section::Validity::ambiguous), 0);
  rig_.measure.runs->ambiguous_from = 2;
  EXPECT_EQ(count(profile(model::Select::strongest), light_section::Validity::ambiguous), 0);
}

INSTANTIATE_TEST_SUITE_P(Modes, StrongestRun,
                         ::testing::Values(model::Mode::binary, model::Mode::grey, model::Mode::grey_over));

TEST(BinarySecond, WhatIsOpenCountsAgainstTheColumn) {
  EXPECT_EQ(light_section::max_of_binary_second(1, 0), 0);
  EXPECT_EQ(light_section::max_of_binary_second(2, 0), 7);
  EXPECT_EQ(light_section::max_of_binary_second(3, 0), 7);
  EXPECT_EQ(light_section::max_of_binary_second(2, 8), 16);
}

}  // namespace
}  // namespace selfproj::test
