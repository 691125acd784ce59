// Tests the codes of the stripes, and compares the neighbourhood search with the geometry: which projector line does a
// pixel see?

#include "host/structured_light/match_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "host/structured_light/self_reference.h"
#include "selfproj/model/gray_match.h"
#include "selfproj/rig/rig.h"
#include "tests/host/light_section/seen_surface.h"
#include "tests/host/structured_light/pinhole.h"

namespace selfproj::test {
namespace {

// --- codes ---

TEST(StripeCode, CyclicCountsAroundAndReflectedBack) {
  for (int bits = 1; bits <= structured_light::Stripes::kMaxBits; ++bits) {
    const int codes = 1 << bits;
    for (int cell = -3 * codes; cell < 3 * codes; ++cell) {
      const int place = ((cell % codes) + codes) % codes;
      const int turn = (cell - place) / codes;
      EXPECT_EQ(structured_light::code_of_cell({bits, 2, structured_light::StripeCode::cyclic}, cell), place);
      EXPECT_EQ(structured_light::code_of_cell({bits, 2, structured_light::StripeCode::reflected}, cell),
                turn % 2 == 0 ? place : codes - 1 - place);
    }
  }
}

// The equations themselves, in the middle of cells and at their ends.
TEST(StripeCode, IsTheEquation) {
  for (const structured_light::StripeCode code :
       {structured_light::StripeCode::cyclic, structured_light::StripeCode::reflected}) {
    const structured_light::Stripes stripes{4, 2, code};
    for (int cell = -50; cell < 50; ++cell) {
      for (int plane = 0; plane < stripes.bits; ++plane) {
        for (const double within : {0.001, 0.5, 0.999}) {
          const double u = (cell + within) / 16;
          const double stripe = plane == 0 && code == structured_light::StripeCode::cyclic
                                    ? std::floor(2 * u)
                                    : std::floor(std::ldexp(u, plane) + 0.5);
          EXPECT_EQ(structured_light::is_light(stripes, cell, plane), std::fmod(std::abs(stripe), 2) == 1);
        }
      }
    }
  }
}

TEST(StripeCode, OneBitChangesFromCellToCell) {
  for (const structured_light::StripeCode code :
       {structured_light::StripeCode::cyclic, structured_light::StripeCode::reflected}) {
    for (int cell = -40; cell < 40; ++cell) {
      int changes = 0;
      for (int plane = 0; plane < 4; ++plane) {
        changes += structured_light::is_light({4, 2, code}, cell, plane) !=
                           structured_light::is_light({4, 2, code}, cell + 1, plane)
                       ? 1
                       : 0;
      }
      // Where the reflected code reverses, no bit changes: two cells have the same code.
      EXPECT_EQ(changes, code == structured_light::StripeCode::reflected && (cell + 1) % 16 == 0 ? 0 : 1) << cell;
    }
  }
}

TEST(StripeCode, CellsLieAroundTheMiddle) {
  EXPECT_EQ(structured_light::cell_of_row(255.5, 512, 2), 0);
  EXPECT_EQ(structured_light::cell_of_row(256, 512, 2), 0);
  EXPECT_EQ(structured_light::cell_of_row(257, 512, 2), 0);
  EXPECT_EQ(structured_light::cell_of_row(258, 512, 2), 1);
  EXPECT_EQ(structured_light::cell_of_row(255, 512, 2), -1);
  EXPECT_EQ(structured_light::cell_of_row(253, 512, 2), -2);
}

// --- search ---

// Smooth references: even, slanted along both axes, bent.
Surface slanted() {
  return [](double x, double y) { return 530 - 0.12 * x + 0.2 * y; };
}
Surface bump() {
  return [](double x, double y) { return 550 - 60 * std::exp(-(x * x + y * y) / (2 * 60 * 60)); };
}

struct Outcome {
  long right = 0;
  long wrong = 0;
  long missing = 0;
};

// For the pixels that `take` selects: light from every quarter line along the epipolar line, if its cell is in the
// window, must be matched to its origin. A match is right if the line of the light is in the matched run.
template <class Take>
Outcome try_all(const rig::Rig& rig, const structured_light::SelfReference& reference,
                const structured_light::MatchSettings& settings, int every_column, const Take& take) {
  const structured_light::MatchSearch search(rig, reference, settings);
  const structured_light::Stripes& stripes = reference.stripes;
  const int codes = 1 << stripes.bits;
  std::vector<structured_light::Match> matches;
  Outcome outcome;
  for (int r = 0; r < rig.camera.rows; ++r) {
    for (int c = r % every_column; c < rig.camera.columns; c += every_column) {
      const auto i =
          static_cast<std::size_t>(r) * static_cast<std::size_t>(rig.camera.columns) + static_cast<std::size_t>(c);
      // Nothing is matched where z does not decrease with θ.
      const bool falls = rig.projector.z_mm * test::on_ray(rig.camera, r, c, 1).x < rig.projector.x_mm;
      if (!reference.measurable(i) || !falls || !take(r, c)) {
        continue;
      }
      search.find(r, c, matches);
      const int own = static_cast<int>(std::floor((r - 0.5 * (rig.camera.rows - 1)) / stripes.width));
      for (double z = 400; z < 640; z += 0.25) {
        const Point3 p = test::on_ray(rig.camera, r, c, z);
        const Pixel lit = projector_lights(rig.projector, p);
        if (!test::within(rig.projector, lit)) {
          continue;
        }
        const int cell =
            reference.cell(static_cast<int>(std::lround(lit.row)), static_cast<int>(std::lround(lit.column)));
        const int n = own - cell;
        if (n < -settings.e || n >= codes - settings.e) {
          continue;
        }
        const structured_light::Match& match =
            matches[static_cast<std::size_t>(structured_light::code_of_cell(stripes, cell))];
        // A line: the corner of a projector pixel that the search misses with its steps of a quarter line.
        const bool right = std::abs(match.line - lit.row) <= match.half_width + 1;
        (match.candidates == 0 ? outcome.missing : right ? outcome.right : outcome.wrong) += 1;
      }
    }
  }
  return outcome;
}

constexpr auto kAll = [](int, int) { return true; };

TEST(MatchSearch, CyclicAndCorrectedIsNeverWrongWhereTheReferenceHasNoSteps) {
  const rig::Rig rig = coarse_scanner(4);
  for (const Surface& surface : {plane_at(550), slanted(), bump()}) {
    const structured_light::SelfReference reference = structured_light::make_self_reference(
        rig, test::points_of(rig, surface), {4, 2, structured_light::StripeCode::cyclic});
    for (int e = 0; e < 16; ++e) {
      const Outcome outcome = try_all(rig, reference, {e}, 9, kAll);
      EXPECT_EQ(outcome.wrong, 0) << "e " << e;
      EXPECT_GT(outcome.right, 50000) << "e " << e;
      // Light from the very corner of a projector pixel: steps of a quarter line miss such cells.
      EXPECT_LT(static_cast<double>(outcome.missing), 1e-4 * static_cast<double>(outcome.right)) << "e " << e;
    }
  }
}

TEST(MatchSearch, ReflectedCodeIsWrongWhereTwoCellsShareACode) {
  const rig::Rig rig = coarse_scanner(4);
  const structured_light::SelfReference reference = structured_light::make_self_reference(
      rig, test::points_of(rig, plane_at(550)), {4, 2, structured_light::StripeCode::reflected});
  const Outcome outcome = try_all(rig, reference, {8}, 3, kAll);
  const double share = static_cast<double>(outcome.wrong) / static_cast<double>(outcome.wrong + outcome.right);
  RecordProperty("wrong", std::to_string(share));
  EXPECT_GT(share, 0.1);
}

// A step of 60 mm: two windows away from it no match is wrong. Nearer, light may come from the other side of the step.
TEST(MatchSearch, StepsAreFeltNoFurtherThanAWindow) {
  const rig::Rig rig = coarse_scanner(2);
  const auto block = [](double x, double y) { return std::abs(x) < 50 && std::abs(y - 15) < 45 ? 490.0 : 550.0; };
  const structured_light::ProjectorPoints points = test::points_of(rig, block);
  const structured_light::SelfReference reference =
      structured_light::make_self_reference(rig, points, {4, 1, structured_light::StripeCode::cyclic});
  // Whether a step or an unlit pixel lies within this many pixels.
  const int reach = 16 * reference.stripes.width;
  images::FloatImage jump(rig.camera.rows, rig.camera.columns);
  for (int r = 1; r + 1 < jump.rows; ++r) {
    for (int c = 1; c + 1 < jump.columns; ++c) {
      const float here = points.line.row(r)[c];
      for (const float other : {points.line.row(r + 1)[c], points.line.row(r)[c + 1]}) {
        jump.row(r)[c] = std::abs(here - other) < 8 ? jump.row(r)[c] : 1.0F;
      }
    }
  }
  const auto far = [&](int row, int column) {
    for (int r = std::max(0, row - reach); r <= std::min(jump.rows - 1, row + reach); ++r) {
      for (int c = std::max(0, column - reach); c <= std::min(jump.columns - 1, column + reach); ++c) {
        if (jump.row(r)[c] != 0) {
          return false;
        }
      }
    }
    return true;
  };
  const Outcome beyond = try_all(rig, reference, {8}, 5, far);
  EXPECT_EQ(beyond.wrong, 0);
  EXPECT_GT(beyond.right, 10000);
  const Outcome near = try_all(rig, reference, {8}, 5, [&](int r, int c) { return !far(r, c); });
  RecordProperty("wrong_near_steps", std::to_string(static_cast<double>(near.wrong) /
                                                    static_cast<double>(near.wrong + near.right + near.missing)));
  EXPECT_GT(near.wrong, 0);
}

// The printed window of 48 lines does not hold 16 codes: some are missing, some occur twice. The window in cells holds
// each code once, except where it leaves the projector's image.
TEST(MatchTable, PrintedWindowMissesAndDoublesCodes) {
  const rig::Rig rig = coarse_scanner(4);
  const structured_light::SelfReference reference = structured_light::make_self_reference(
      rig, test::points_of(rig, plane_at(550)), {4, 2, structured_light::StripeCode::cyclic});
  const auto shares = [&](const structured_light::MatchSettings& settings) {
    const structured_light::MatchSearch search(rig, reference, settings);
    std::vector<structured_light::Match> matches;
    double missing = 0;
    double doubled = 0;
    for (int r = 48; r < 80; ++r) {  // all windows are whole
      search.find(r, 64, matches);
      for (const structured_light::Match& match : matches) {
        missing += match.candidates == 0 ? 1 : 0;
        doubled += match.candidates > 1 ? 1 : 0;
      }
    }
    return std::pair(missing / (32 * 16), doubled / (32 * 16));
  };
  EXPECT_EQ(shares({8}), std::pair(0.0, 0.0));
  const auto [missing, doubled] = shares({.e = 8, .printed_window = true});
  RecordProperty("missing", std::to_string(missing));
  RecordProperty("doubled", std::to_string(doubled));
  EXPECT_GT(missing, 0.02);
  EXPECT_GT(doubled, 0);
}

// On a plane that faces the camera, camera rows correspond to projector lines, so the direction of the search does not
// matter. On a slanted plane it does.
TEST(MatchTable, PrintedDirectionIsRightOnlyWithoutVariationAlongY) {
  const rig::Rig rig = coarse_scanner(4);
  const auto difference = [&](const Surface& surface) {
    const structured_light::SelfReference reference = structured_light::make_self_reference(
        rig, test::points_of(rig, surface), {4, 2, structured_light::StripeCode::cyclic});
    const structured_light::MatchTable along_ray(rig, reference, {8});
    const structured_light::MatchTable along_xp(rig, reference, {.e = 8, .printed_direction = true});
    double sum = 0;
    int count = 0;
    for (int r = 20; r < 100; ++r) {
      for (int c = 10; c < 118; ++c) {
        for (int code = 0; code < 16; ++code) {
          const std::uint16_t a = along_ray.word(r, c, code);
          const std::uint16_t b = along_xp.word(r, c, code);
          if (a != model::GrayMatch::kNone && b != model::GrayMatch::kNone) {
            sum += std::abs(model::GrayMatch::line_of(a) - model::GrayMatch::line_of(b));
            ++count;
          }
        }
      }
    }
    return sum / count;
  };
  EXPECT_LT(difference(plane_at(550)), 0.1);
  EXPECT_GT(difference(slanted()), 0.3);
}

TEST(MatchTable, HasTheWordsOfTheSearch) {
  rig::Rig rig = coarse_scanner(8);
  rig.camera.columns = 63;  // odd: words go by pairs
  const structured_light::SelfReference reference = structured_light::make_self_reference(
      rig, test::points_of(rig, bump()), {3, 1, structured_light::StripeCode::cyclic});
  const structured_light::MatchTable table(rig, reference, {3});
  const structured_light::MatchSearch search(rig, reference, {3});
  const std::vector<std::uint16_t> all = table.by_pixels();
  std::vector<structured_light::Match> matches;
  std::size_t at = 0;
  for (int r = 0; r < rig.camera.rows; ++r) {
    for (int c = 0; c < rig.camera.columns; ++c) {
      search.find(r, c, matches);
      for (int code = 0; code < 8; ++code, ++at) {
        const structured_light::Match& match = matches[static_cast<std::size_t>(code)];
        const std::uint16_t word =
            match.candidates > 0 ? model::GrayMatch::word_of(match.line) : model::GrayMatch::kNone;
        ASSERT_EQ(table.word(r, c, code), word);
        ASSERT_EQ(all[at], word);
      }
    }
  }
}

TEST(MatchTable, RefusesWhatIsOutOfRange) {
  const rig::Rig rig = coarse_scanner(8);
  const structured_light::SelfReference reference = structured_light::make_self_reference(
      rig, test::points_of(rig, plane_at(550)), {4, 2, structured_light::StripeCode::cyclic});
  EXPECT_THROW(structured_light::MatchTable(rig, reference, {-1}), std::invalid_argument);
  EXPECT_THROW(structured_light::MatchTable(rig, reference, {16}), std::invalid_argument);
  EXPECT_THROW(structured_light::MatchTable(rig, reference, {0, false, true, 0}), std::invalid_argument);
  EXPECT_THROW(structured_light::MatchTable(rig::load_rig("scanner"), reference, {0}), std::invalid_argument);
}

}  // namespace
}  // namespace selfproj::test
