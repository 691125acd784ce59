// Tests reference, patterns and scanner of self-projected structured light on images drawn from the geometry.

#include "host/structured_light/self_scanner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/structured_light/match_table.h"
#include "host/structured_light/point_scan.h"
#include "host/structured_light/self_reference.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/model/gray_match.h"
#include "selfproj/rig/rig.h"
#include "tests/host/light_section/seen_surface.h"
#include "tests/host/structured_light/pinhole.h"
#include "tests/support/allocations.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

Surface round_bump() {
  return [](double x, double y) { return 550 - 60 * std::exp(-(x * x + y * y) / (2 * 60 * 60)); };
}

// The camera's image of the points under a pattern: light 200, dark 20.
std::vector<std::uint8_t> picture(const structured_light::ProjectorPoints& points, const images::FloatImage& pattern) {
  std::vector<std::uint8_t> pixels;
  for (std::size_t i = 0; i < points.line.values.size(); ++i) {
    const bool seen = !std::isnan(points.line.values[i]);
    const bool light =
        seen &&
        pattern.row(static_cast<int>(std::lround(points.line.values[i])))[std::lround(points.column.values[i])] > 0.5F;
    pixels.push_back(light ? 200 : 20);
  }
  return pixels;
}

TEST(SelfReference, TurnsTheScanRound) {
  const rig::Rig rig = coarse_scanner(2);
  const structured_light::ProjectorPoints points = test::points_of(rig, round_bump());
  const structured_light::SelfReference reference = structured_light::make_self_reference(rig, points, {});
  int seen = 0;
  for (int l = 0; l < rig.projector.lines; l += 3) {
    for (int c = 0; c < rig.projector.columns; c += 3) {
      const float row = reference.row.row(l)[c];
      const float column = reference.column.row(l)[c];
      ASSERT_TRUE(std::isfinite(row) && std::isfinite(column)) << "every projector pixel has a place";
      if (reference.seen[static_cast<std::size_t>(l * rig.projector.columns + c)] == 0) {
        continue;
      }
      ++seen;
      const auto p =
          seen_point(rig.camera, static_cast<double>(row), static_cast<double>(column), round_bump(), 400, 620, 1);
      ASSERT_TRUE(p);
      const Pixel lit = projector_lights(rig.projector, *p);
      ASSERT_NEAR(lit.row, l, 0.05);
      ASSERT_NEAR(lit.column, c, 0.05);
    }
  }
  EXPECT_GT(seen, 10000);
}

// A plane that faces the camera continues as the same plane where the camera does not see it.
TEST(SelfReference, ContinuesAPlane) {
  const rig::Rig rig = coarse_scanner(4);
  const structured_light::SelfReference reference =
      structured_light::make_self_reference(rig, test::points_of(rig, plane_at(550)), {});
  int filled = 0;
  for (int l = 0; l < rig.projector.lines; ++l) {
    for (int c = 0; c < rig.projector.columns; ++c) {
      if (reference.seen[static_cast<std::size_t>(l * rig.projector.columns + c)] != 0) {
        continue;
      }
      ++filled;
      const Point3 p = test::on_ray(rig.camera, static_cast<double>(reference.row.row(l)[c]),
                                    static_cast<double>(reference.column.row(l)[c]), 550);
      const Pixel lit = projector_lights(rig.projector, p);
      ASSERT_NEAR(lit.row, l, 0.01);
      ASSERT_NEAR(lit.column, c, l < 40 ? 0.5 : 0.05);  // at this height one line of this rig is 20 mm of z
    }
  }
  EXPECT_GT(filled, 5000);
}

// Seen on the reference the stripes are straight: along rows, `width` rows a cell.
TEST(SelfReference, PatternsAreStraightOnTheReference) {
  const rig::Rig rig = coarse_scanner(2);
  const structured_light::ProjectorPoints points = test::points_of(rig, round_bump());
  for (const structured_light::StripeCode code :
       {structured_light::StripeCode::cyclic, structured_light::StripeCode::reflected}) {
    const structured_light::SelfReference reference = structured_light::make_self_reference(rig, points, {4, 4, code});
    for (int index = 0; index < 8; ++index) {
      const std::vector<std::uint8_t> seen =
          picture(points, structured_light::self_projected_pattern(reference, index));
      int wrong = 0;
      int count = 0;
      for (int r = 0; r < rig.camera.rows; ++r) {
        const double from_middle = r - 0.5 * (rig.camera.rows - 1);
        const int cell = static_cast<int>(std::floor(from_middle / 4));
        const bool light = structured_light::is_light(reference.stripes, cell, index / 2) == (index % 2 == 0);
        for (int c = 0; c < rig.camera.columns; ++c) {
          const auto i = static_cast<std::size_t>(r * rig.camera.columns + c);
          if (reference.measurable(i)) {
            ++count;
            wrong += (seen[i] == 200) != light ? 1 : 0;
          }
        }
      }
      // The edges of stripes consist of projector pixels, which are up to one camera pixel wide.
      EXPECT_LT(wrong, count / 12) << index;
    }
  }
}

TEST(SelfReference, RefusesWhatDoesNotFit) {
  const rig::Rig rig = coarse_scanner(8);
  const structured_light::ProjectorPoints points = test::points_of(rig, plane_at(550));
  EXPECT_THROW(structured_light::make_self_reference(rig, points, {0, 2}), std::invalid_argument);
  EXPECT_THROW(structured_light::make_self_reference(rig, points, {9, 2}), std::invalid_argument);
  EXPECT_THROW(structured_light::make_self_reference(rig, points, {4, 0}), std::invalid_argument);
  EXPECT_THROW(structured_light::make_self_reference(rig::load_rig("scanner"), points, {}), std::invalid_argument);
  structured_light::ProjectorPoints none = points;
  std::fill(none.line.values.begin(), none.line.values.end(), std::nanf(""));
  EXPECT_THROW(structured_light::make_self_reference(rig, none, {}), std::invalid_argument);
  EXPECT_THROW(structured_light::self_projected_pattern(structured_light::make_self_reference(rig, points, {}), 8),
               std::invalid_argument);
}

TEST(GrayPattern, IsTheEquationOverTheCodedLines) {
  const rig::Rig rig = rig::load_rig("scanner");
  for (const int bits : {4, 8}) {
    for (int index = 0; index < 2 * bits; ++index) {
      const images::FloatImage pattern = structured_light::gray_pattern(rig, bits, 512, index);
      for (int l = 0; l < 768; ++l) {
        bool light = false;
        if (l >= 128 && l < 640) {
          const int code = (l - 128) * (1 << bits) / 512;
          const int gray = code ^ (code >> 1);
          light = ((gray >> (bits - 1 - index / 2)) & 1) == (index % 2 == 0 ? 1 : 0);
        }
        ASSERT_EQ(pattern.row(l)[0] > 0.5F, light) << bits << ' ' << index << ' ' << l;
        ASSERT_EQ(pattern.row(l)[1023], pattern.row(l)[0]);
      }
    }
  }
}

// Frames in, depth out: compares every step with the models and with double precision. Nothing is allocated.
TEST(SelfScanner, EqualsItsStepsByTheModels) {
  for (const std::uint64_t seed : seeds(12)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    rig::Rig rig = coarse_scanner(8);
    rig.camera.columns = random.between(1, 64);
    rig.measure.max_z_per_line_mm = 40;
    const int bits = random.between(1, 6);
    const structured_light::SelfReference reference = structured_light::make_self_reference(
        rig, test::points_of(rig, round_bump()),
        {bits, random.between(1, 3),
         random.chance(50) ? structured_light::StripeCode::cyclic : structured_light::StripeCode::reflected});
    const structured_light::MatchTable table(rig, reference, {random.between(0, (1 << bits) - 1)});
    const std::vector<std::uint16_t> words = table.by_pixels();
    const int threshold = random.between(0, 30);
    structured_light::SelfScanner scanner(rig, reference, table, threshold);
    structured_light::SelfScanner of_board(rig, reference, table, threshold);
    model::GrayDecoder decoder({rig.camera.rows, rig.camera.columns, bits, threshold});
    const auto count = static_cast<std::size_t>(rig.camera.rows * rig.camera.columns);
    std::vector<std::uint16_t> codes(count);
    std::vector<std::uint16_t> lines(count);
    std::vector<std::vector<std::uint8_t>> frames(2);
    int images = 0;
    long valid = 0;
    for (int i = 0; i < 6 * bits; ++i) {
      auto& pixels = frames[static_cast<std::size_t>(i % 2)];
      pixels = random.bytes(count);
      const bool good = !random.chance(3);
      const model::ImageView view{pixels.data(), rig.camera.rows, rig.camera.columns, rig.camera.columns};
      const bool due = decoder.add_frame(view, i % (2 * bits), good, codes.data());
      const std::uint64_t before = allocations();
      const bool found = scanner.add_frame(view, i % (2 * bits), good);
      ASSERT_EQ(allocations(), before) << "the scanner allocates";
      ASSERT_EQ(found, due);
      if (!due) {
        continue;
      }
      ++images;
      model::GrayMatch::look_up(codes.data(), count, bits, words.data(), lines.data());
      of_board.add_codes(codes.data());
      for (std::size_t k = 0; k < count; ++k) {
        const float z = scanner.depth().values[k];
        const float board = of_board.depth().values[k];
        ASSERT_TRUE(z == board || (std::isnan(z) && std::isnan(board)));
        if (lines[k] == model::GrayMatch::kNone) {
          ASSERT_TRUE(std::isnan(z));
        } else if (!std::isnan(z)) {
          ++valid;
          const int r = static_cast<int>(k) / rig.camera.columns;
          const Point3 p =
              test::on_ray(rig.camera, r, static_cast<int>(k) % rig.camera.columns, static_cast<double>(z));
          ASSERT_NEAR(projector_lights(rig.projector, p).row, model::GrayMatch::line_of(lines[k]), 2e-3);
          const float difference = scanner.reference_depth().values[k] - z;
          ASSERT_TRUE(scanner.difference().values[k] == difference || std::isnan(difference));
        }
      }
    }
    EXPECT_TRUE(images == 0 || valid > 0);
  }
}

// A reference of a bump and a part with something on it: heights are right to half a code's width.
TEST(SelfScanner, MeasuresWhatIsOnTheReference) {
  const rig::Rig rig = rig::load_rig("scanner");
  rig::Rig narrow = rig;
  narrow.camera.columns = 64;  // the middle columns
  const Surface part = [](double x, double y) {
    return round_bump()(x, y) - (std::abs(x - 20) < 25 && std::abs(y) < 15 ? 9.0 : 0.0);
  };
  const structured_light::ProjectorPoints points = test::points_of(narrow, round_bump());
  const structured_light::SelfReference reference = structured_light::make_self_reference(narrow, points, {});
  const structured_light::MatchTable table(narrow, reference, {8});
  structured_light::SelfScanner scanner(narrow, reference, table, 5);
  const structured_light::ProjectorPoints seen = test::points_of(narrow, part, 400, 620, 1);
  std::vector<std::vector<std::uint8_t>> images;
  for (int i = 0; i < 8; ++i) {
    images.push_back(picture(seen, structured_light::self_projected_pattern(reference, i)));
    const model::ImageView view{images.back().data(), narrow.camera.rows, narrow.camera.columns, narrow.camera.columns};
    EXPECT_EQ(scanner.add_frame(view, i), i == 7);
  }
  std::vector<structured_light::PointState> states;
  scanner.explain(states);
  const structured_light::MatchSearch search(narrow, reference, {8});
  std::vector<structured_light::Match> matches;
  double sum = 0;
  int on_part = 0;
  int compared = 0;
  for (int r = 60; r < 400; ++r) {
    for (int c = 0; c < 64; ++c) {
      const auto i = static_cast<std::size_t>(r * 64 + c);
      const float z = scanner.depth().values[i];
      const float truth = seen.line.values[i];
      if (std::isnan(z) || std::isnan(truth)) {
        continue;
      }
      ASSERT_EQ(states[i], structured_light::PointState::valid);
      search.find(r, c, matches);
      const Point3 p = test::on_ray(narrow.camera, r, c, static_cast<double>(z));
      const double line = projector_lights(narrow.projector, p).row;
      double half_width = 0;
      for (const structured_light::Match& match : matches) {
        half_width = match.candidates > 0 && std::abs(match.line - line) < 0.1 ? match.half_width : half_width;
      }
      ASSERT_GT(half_width, 0);
      ASSERT_LE(std::abs(line - static_cast<double>(truth)), half_width + 1) << r << ' ' << c;
      ++compared;
      const auto wanted = seen_point(narrow.camera, r, c, part, 400, 620, 1);
      if (wanted && std::abs(wanted->x - 20) < 18 && std::abs(wanted->y) < 10) {
        sum += static_cast<double>(scanner.difference().values[i]);
        ++on_part;
      }
    }
  }
  EXPECT_GT(compared, 15000);
  ASSERT_GT(on_part, 500);
  // The part lies 9 mm above a slope; along the camera's rays this is nearly 9 mm.
  EXPECT_NEAR(sum / on_part, 9, 1);
}

// A line of light, blurred and noisy, moved over both axes.
TEST(LinePointScan, FindsThePointsOfASweep) {
  const rig::Rig rig = coarse_scanner(4);
  const structured_light::ProjectorPoints points = test::points_of(rig, round_bump());
  Random random(1);
  structured_light::LinePointScan scan(rig);
  const auto count = static_cast<std::size_t>(rig.camera.rows * rig.camera.columns);
  const auto add = [&](const images::FloatImage& coordinate, int line) {
    std::vector<std::uint8_t> pixels(count);
    for (std::size_t i = 0; i < count; ++i) {
      const double away = static_cast<double>(coordinate.values[i]) - line;
      const double light = std::isnan(away) ? 0 : 60 * std::exp(-away * away / (2 * 1.5 * 1.5));
      pixels[i] = static_cast<std::uint8_t>(std::lround(10 + light + 0.5 * random.between(-2, 2)));
    }
    scan.add({pixels.data(), rig.camera.rows, rig.camera.columns, rig.camera.columns});
  };
  for (int l = 0; l < rig.projector.lines; ++l) {
    add(points.line, l);
  }
  for (int c = 0; c < rig.projector.columns; ++c) {
    add(points.column, c);
  }
  const structured_light::ProjectorPoints found = scan.points();
  double square = 0;
  int both = 0;
  int missing = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const float truth = points.line.values[i];
    if (std::isnan(truth)) {
      EXPECT_TRUE(std::isnan(found.line.values[i]));
    } else if (std::isnan(found.line.values[i])) {
      ++missing;
    } else {
      ++both;
      square += std::pow(static_cast<double>(found.line.values[i] - truth), 2);
      EXPECT_NEAR(found.line.values[i], truth, 0.3);
      EXPECT_NEAR(found.column.values[i], points.column.values[i], 0.3);
    }
  }
  EXPECT_LT(std::sqrt(square / both), 0.1);
  EXPECT_GT(both, 3 * missing);  // light at the ends of the axes is cut off
  EXPECT_THROW(scan.add({nullptr, rig.camera.rows, rig.camera.columns, rig.camera.columns}), std::invalid_argument);
}

// A pixel that sees two places equally bright has no point.
TEST(AxisScan, TwoPlacesAreNone) {
  for (const int other : {20, 90}) {
    structured_light::AxisScan scan(1, 1, 5);
    for (int l = 0; l < 100; ++l) {
      const std::uint8_t value = l == 50 ? 100 : l == 20 ? static_cast<std::uint8_t>(other) : 10;
      scan.add({&value, 1, 1, 1});
    }
    const float found = scan.coordinates().values[0];
    EXPECT_EQ(std::isnan(found), other == 90);
    if (other == 20) {
      EXPECT_EQ(found, 50);
    }
  }
}

// Codes of a slanted surface: positions are right to a fraction of a line, even where the finest planes are lost.
TEST(CoordinatesOfCodes, AverageTheSteps) {
  Random random(3);
  for (const int lost : {0, 1, 2}) {
    structured_light::AmbiguousCodes codes{40, 40, 10, std::vector<std::uint16_t>(1600),
                                           std::vector<std::uint16_t>(1600)};
    const auto truth = [](int r, int c) { return 700 - 3.1 * r + 0.37 * c; };
    for (int r = 0; r < 40; ++r) {
      for (int c = 0; c < 40; ++c) {
        const auto i = static_cast<std::size_t>(40 * r + c);
        const auto code = static_cast<unsigned>(std::lround(truth(r, c)));
        unsigned gray = code ^ (code >> 1U);
        gray &= ~((1U << static_cast<unsigned>(lost)) - 1);
        unsigned binary = 0;
        for (unsigned bit = 512; bit > 0; bit >>= 1U) {
          binary |= ((gray & bit) != 0) != ((binary & (bit << 1U)) != 0) ? bit : 0;
        }
        codes.codes[i] = static_cast<std::uint16_t>(binary);
        codes.ambiguous[i] = static_cast<std::uint16_t>((1U << static_cast<unsigned>(lost)) - 1);
      }
    }
    codes.ambiguous[5] = 0x300;  // two planes ambiguous: no point
    const images::FloatImage found = structured_light::coordinates_of_codes(codes, 4, 2, 6);
    EXPECT_TRUE(std::isnan(found.values[5]));
    for (int r = 2; r < 38; ++r) {
      for (int c = 2; c < 38; ++c) {
        EXPECT_NEAR(found.row(r)[c], truth(r, c), lost == 2 ? 0.9 : 0.5) << lost;
      }
    }
  }
}

}  // namespace
}  // namespace selfproj::test
