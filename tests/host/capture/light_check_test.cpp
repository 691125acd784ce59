// Tests how an image of one pattern alone is told from others, on scenes of random light, noise and stripes.
#include "host/capture/light_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "host/images/image_files.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

constexpr int kSceneSide = 64;

// A scene whose pixels are lit by the columns or rows of a projector of as many pixels.
class LitScene {
 public:
  explicit LitScene(Random& random) : random_(random) {
    for (int i = 0; i < kSceneSide * kSceneSide; ++i) {
      black_.push_back(random.between(5, 20));
      light_.push_back(random.between(60, 150));
    }
  }

  // `light` 0..1 of a pixel from its row and column.
  images::Image seen(const std::function<double(int row, int column)>& light) {
    images::Image image{kSceneSide, kSceneSide, {}};
    for (int i = 0; i < kSceneSide * kSceneSide; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const double grey = black_[at] + light(i / kSceneSide, i % kSceneSide) * light_[at] + random_.between(-4, 4);
      image.pixels.push_back(static_cast<std::uint8_t>(std::clamp(grey, 0.0, 255.0)));
    }
    return image;
  }

  capture::WhiteAndBlack levels() {
    return {.white = seen([](int /*row*/, int /*column*/) { return 1; }),
            .black = seen([](int /*row*/, int /*column*/) { return 0; })};
  }

 private:
  Random& random_;
  std::vector<int> black_;
  std::vector<int> light_;
};

double stripe(int at, int width) { return at / width % 2; }

// Whatever the second image shows instead, wholly or in its lower 20 rows or during half of its exposure.
TEST(LightCheck, APatternAndItsNegativeAddUpAndNothingElseDoes) {
  for (const std::uint64_t seed : seeds(50)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    LitScene scene(random);
    const capture::WhiteAndBlack levels = scene.levels();
    const int width = 1 << random.between(1, 4);
    const auto pattern = [&](int /*row*/, int column) { return stripe(column, width); };
    const auto negative = [&](int row, int column) { return 1 - pattern(row, column); };
    const images::Image first = scene.seen(pattern);
    EXPECT_TRUE(capture::adds_up(first, scene.seen(negative), levels));
    // An iris that opens a little, as long as it does so for both.
    EXPECT_TRUE(capture::adds_up(scene.seen([&](int row, int column) { return 1.1 * pattern(row, column); }),
                                 scene.seen([&](int row, int column) { return 1.1 * negative(row, column); }), levels));
    const int other_width = 2 * width;
    const std::vector<std::function<double(int, int)>> others = {
        pattern, [](int /*row*/, int /*column*/) { return 1; }, [](int /*row*/, int /*column*/) { return 0; },
        [&](int /*row*/, int column) { return stripe(column, other_width); },
        [&](int row, int /*column*/) { return stripe(row, width); }};
    for (std::size_t i = 0; i < others.size(); ++i) {
      SCOPED_TRACE(i);
      const auto& other = others[i];
      EXPECT_FALSE(capture::adds_up(first, scene.seen(other), levels));
      const images::Image torn = scene.seen(
          [&](int row, int column) { return row < kSceneSide - 20 ? negative(row, column) : other(row, column); });
      EXPECT_FALSE(capture::adds_up(first, torn, levels));
      EXPECT_FALSE(capture::adds_up(torn, first, levels));
      const images::Image across =
          scene.seen([&](int row, int column) { return 0.5 * (negative(row, column) + other(row, column)); });
      EXPECT_FALSE(capture::adds_up(first, across, levels));
    }
    EXPECT_TRUE(capture::same_light(first, scene.seen(pattern), levels));
    EXPECT_FALSE(capture::same_light(first, scene.seen(negative), levels));
  }
}

// White of which a strip of two rows in a hundred is still black has more than 97 % of its light.
TEST(LightCheck, ApartOfTheLightIsNotAllOfIt) {
  Random random(1);
  LitScene scene(random);
  const capture::WhiteAndBlack levels = scene.levels();
  const auto white_above = [&](int row_of_change) {
    return scene.seen([=](int row, int /*column*/) { return row < row_of_change ? 1.0 : 0.0; });
  };
  EXPECT_TRUE(capture::all_white(white_above(kSceneSide), levels));
  EXPECT_FALSE(capture::all_white(white_above(kSceneSide - 2), levels));
  EXPECT_FALSE(capture::all_white(white_above(0), levels));
  EXPECT_TRUE(capture::all_black(white_above(0), levels));
  EXPECT_FALSE(capture::all_black(white_above(2), levels));
  EXPECT_FALSE(capture::all_black(white_above(kSceneSide), levels));
}

TEST(LightCheck, KnowsANegative) {
  const images::Image pattern{1, 4, {0, 255, 255, 0}};
  EXPECT_TRUE(capture::is_negative(pattern, {1, 4, {255, 0, 0, 255}}));
  EXPECT_FALSE(capture::is_negative(pattern, pattern));
  EXPECT_FALSE(capture::is_negative(pattern, {1, 4, {255, 0, 0, 0}}));
  EXPECT_FALSE(capture::is_negative(pattern, {2, 2, {255, 0, 0, 255}}));
  EXPECT_FALSE(capture::is_negative(pattern, {}));
  EXPECT_FALSE(capture::is_negative({1, 1, {100}}, {1, 1, {155}})) << "greys of a projector do not add up to white";
}

}  // namespace
}  // namespace selfproj::test
