// Compares the scanner with its steps by the models: decoder, median, triangulation, foreground.

#include "selfproj/structured_light/scanner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "selfproj/model/gray_decoder.h"
#include "selfproj/model/median3x3.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/triangulation.h"
#include "tests/support/allocations.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

bool same_bits(const images::FloatImage& a, const std::vector<float>& b) {
  return a.values.size() == b.size() && std::memcmp(a.values.data(), b.data(), b.size() * sizeof(float)) == 0;
}

TEST(Scanner, EqualsItsStepsByTheModels) {
  for (const std::uint64_t seed : seeds(40)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    rig::Rig rig = rig::load_rig("scanner");
    rig.camera.rows = random.between(1, 40);
    rig.camera.columns = random.between(1, 40);
    const int bits = random.between(1, 10);
    const int threshold = random.between(0, 30);
    const structured_light::PlaneTriangulation triangulation(rig, bits);
    const bool filter = random.chance(50);
    const structured_light::SteadySettings steady =
        random.chance(50) ? structured_light::SteadySettings{} : structured_light::SteadySettings{40, 1};
    structured_light::Scanner scanner(
        triangulation, {.threshold = threshold, .median = filter, .min_difference_mm = 2, .steady = steady});
    structured_light::SteadyFilter steady_filter(rig.camera.rows, rig.camera.columns, steady);
    model::GrayDecoder decoder({rig.camera.rows, rig.camera.columns, bits, threshold});
    const std::size_t count = triangulation.pixels();
    std::vector<std::uint16_t> codes(count), filtered(count);
    std::vector<float> z(count), background(count);
    std::vector<std::vector<std::uint8_t>> frames(2);
    bool has_background = false;
    int images = 0;
    for (int i = 0; i < 8 * bits; ++i) {
      auto& pixels = frames[static_cast<std::size_t>(i % 2)];
      pixels = random.bytes(count);
      const bool good = !random.chance(3);
      const int pattern = i % (2 * bits);
      const model::ImageView view{pixels.data(), rig.camera.rows, rig.camera.columns, rig.camera.columns};
      const bool due = decoder.add_frame(view, pattern, good, codes.data());
      const std::uint64_t before = allocations();
      const bool found = scanner.add_frame(view, pattern, good);
      ASSERT_EQ(allocations(), before) << "the scanner allocates";
      ASSERT_EQ(found, due);
      if (!due) {
        continue;
      }
      ++images;
      if (filter) {
        model::median3x3(codes.data(), rig.camera.rows, rig.camera.columns, filtered.data());
      } else {
        filtered = codes;
      }
      triangulation.depth(filtered.data(), z.data());
      ASSERT_EQ(scanner.codes(), filtered);
      ASSERT_TRUE(same_bits(scanner.depth(), z));
      if (has_background) {
        const float* candidates = z.data();
        if (steady_filter.is_on()) {
          steady_filter.apply(z.data(), background.data(), 2);
          candidates = steady_filter.kept();
        }
        const structured_light::Foreground expected =
            structured_light::foreground_of(triangulation, candidates, background.data(), 2);
        ASSERT_EQ(scanner.foreground().pixels, expected.pixels);
        images::FloatImage difference(rig.camera.rows, rig.camera.columns);
        scanner.difference(difference);
        std::int64_t differing = 0;
        for (const float value : difference.values) {
          differing += std::isnan(value) ? 0 : 1;
        }
        ASSERT_EQ(differing, expected.pixels);
      } else {
        ASSERT_EQ(scanner.foreground().pixels, 0);
        scanner.set_background(scanner.depth());
        background = z;
        has_background = true;
      }
      if (steady_filter.is_on()) {
        steady_filter.remember(z.data());
      }
    }
    EXPECT_TRUE(images > 0 || !has_background);
  }
}

TEST(Scanner, TakesCodesOfTheBoard) {
  const rig::Rig rig = rig::load_rig("scanner");
  const structured_light::PlaneTriangulation triangulation(rig, 8);
  structured_light::Scanner scanner(triangulation, {});
  Random random(1);
  std::vector<std::uint16_t> codes(triangulation.pixels());
  for (std::uint16_t& code : codes) {
    code = static_cast<std::uint16_t>(random.between(0, 255) | (random.chance(80) ? 0x8000 : 0));
  }
  scanner.add_codes(codes.data());
  std::vector<float> z(codes.size());
  triangulation.depth(codes.data(), z.data());
  EXPECT_TRUE(same_bits(scanner.depth(), z));
}

// Strict: a pixel with one ambiguous pair has a code but no depth.
TEST(Scanner, StrictLeavesOutPixelsWithOneAmbiguousPair) {
  rig::Rig rig = rig::load_rig("scanner");
  rig.camera.rows = 1;
  rig.camera.columns = 3;
  const structured_light::PlaneTriangulation triangulation(rig, 3);
  const std::vector<std::uint8_t> dark{50, 50, 50};
  const std::vector<std::uint8_t> one_equal{50, 90, 90};  // pixel 0 is ambiguous in the last plane
  const std::vector<std::uint8_t> two_equal{90, 90, 90};
  for (const bool strict : {false, true}) {
    structured_light::Scanner scanner(triangulation, {.median = false, .strict = strict});
    for (int pattern = 0; pattern < 6; ++pattern) {
      const auto& pixels = pattern % 2 == 1 ? dark : pattern == 4 ? one_equal : two_equal;
      scanner.add_frame({pixels.data(), 1, 3, 3}, pattern);
    }
    EXPECT_EQ((scanner.codes()[0] & 0x8000) == 0, strict);
    EXPECT_NE(scanner.codes()[1] & 0x8000, 0);
  }
}

TEST(Scanner, RefusesWhatIsOutOfRange) {
  const rig::Rig rig = rig::load_rig("scanner");
  const structured_light::PlaneTriangulation triangulation(rig, 8);
  EXPECT_THROW(structured_light::Scanner(triangulation, {.threshold = 256}), std::invalid_argument);
  EXPECT_THROW(structured_light::Scanner(triangulation, {.min_difference_mm = -1}), std::invalid_argument);
  EXPECT_THROW(structured_light::Scanner(triangulation, {.median = true, .strict = true}), std::invalid_argument);
  structured_light::Scanner scanner(triangulation, {});
  EXPECT_THROW(scanner.set_background(images::FloatImage(4, 4)), std::invalid_argument);
}

}  // namespace
}  // namespace selfproj::test
