// Compares the depths at the borders between codes with the surfaces from which this test computes codes and images, by
// formulas of its own.
#include "host/structured_light/code_borders.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numbers>
#include <opencv2/core/matx.hpp>
#include <random>
#include <stdexcept>
#include <vector>

#include "selfproj/model/column_moments.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/rig/calibration.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/triangulation.h"

namespace selfproj::test {
namespace {

constexpr int kSceneBits = 8;
using Surface = std::function<double(double x, double y)>;  // z, mm

// A surface as rig B sees it: its code words, the depths of whole codes, and the depths at the borders between codes.
class SeenBorders {
 public:
  // `contrast` is the greatest difference between the images of a pair, `noise` a standard deviation, in grey values.
  SeenBorders(const Surface& surface, double contrast, double noise)
      : rig_(rig::load_rig("scanner")), plane_(rig_, kSceneBits) {
    const std::size_t pixels = plane_.pixels();
    const auto matrix = rig::depth_matrices(rig_, kSceneBits).projector;
    words.resize(pixels);
    whole.resize(pixels);
    borders.resize(pixels);
    std::vector<double> codes(pixels);
    for (std::size_t i = 0; i < pixels; ++i) {
      double z = 520;
      for (int step = 0; step < 4; ++step) {
        const structured_light::Point3f p = plane_.point(i, static_cast<float>(z));
        z = surface(static_cast<double>(p.x), static_cast<double>(p.y));
      }
      const structured_light::Point3f p = plane_.point(i, static_cast<float>(z));
      const auto line = matrix * cv::Vec4d(static_cast<double>(p.x), static_cast<double>(p.y), z, 1);
      codes[i] = line(0) / line(1);
      const bool lit = codes[i] >= 1 && codes[i] < (1 << kSceneBits) - 1;
      words[i] = lit ? static_cast<std::uint16_t>(static_cast<int>(codes[i]) | model::GrayDecoder::kMeasurable) : 0;
    }
    structured_light::CodeBorders at_borders(plane_, 5);
    std::mt19937_64 random(3);
    std::normal_distribution<double> grey(0, noise);
    std::vector<std::uint8_t> positive(pixels), negative(pixels);
    for (int plane = 0; plane < kSceneBits; ++plane) {
      for (std::size_t i = 0; i < pixels; ++i) {
        const double half = contrast / 2 * light(codes[i], kSceneBits - 1 - plane);
        positive[i] = static_cast<std::uint8_t>(std::clamp(std::lround(128 + half + grey(random)), 0L, 255L));
        negative[i] = static_cast<std::uint8_t>(std::clamp(std::lround(128 - half + grey(random)), 0L, 255L));
      }
      at_borders.add_plane(plane, view(positive), view(negative));
    }
    plane_.depth(words.data(), whole.data());
    at_borders.depth(words.data(), borders.data());
  }

  // Returns the amplitude (mm) of a wave of this shape in depths around a level, by least squares.
  [[nodiscard]] double amplitude(const std::vector<float>& depths, double level, const Surface& shape) const {
    double up = 0;
    double all = 0;
    for (std::size_t i = 0; i < depths.size(); ++i) {
      if (!std::isnan(depths[i])) {
        const structured_light::Point3f p = plane_.point(i, depths[i]);
        const double s = shape(static_cast<double>(p.x), static_cast<double>(p.y));
        up += s * (level - static_cast<double>(depths[i]));
        all += s * s;
      }
    }
    return up / all;
  }
  [[nodiscard]] structured_light::Point3f point(std::size_t i, float z) const { return plane_.point(i, z); }

  std::vector<std::uint16_t> words;
  std::vector<float> whole, borders;

 private:
  // Returns the bit of the Gray code at a place, as -1 or 1, blurred over one code.
  static double light(double code, int bit) {
    const auto sign = [&](int c) { return ((c ^ (c >> 1)) >> bit & 1) != 0 ? 1.0 : -1.0; };
    const double place = code - 0.5;
    const int before = static_cast<int>(std::floor(place));
    const double share = place - before;
    return (1 - share) * sign(before) + share * sign(before + 1);
  }
  [[nodiscard]] model::ImageView view(const std::vector<std::uint8_t>& image) const {
    return {image.data(), rig_.camera.rows, rig_.camera.columns, rig_.camera.columns};
  }

  rig::Rig rig_;
  structured_light::PlaneTriangulation plane_;
};

TEST(CodeBorders, LieOnTheSurface) {
  const Surface leaning = [](double x, double y) { return 515 + 0.05 * x - 0.03 * y; };
  const SeenBorders seen(leaning, 160, 1);
  double squares = 0, whole_squares = 0, most = 0, count = 0, whole_count = 0;
  for (std::size_t i = 0; i < seen.borders.size(); ++i) {
    const auto error = [&](float z) {
      const structured_light::Point3f p = seen.point(i, z);
      return static_cast<double>(z) - leaning(static_cast<double>(p.x), static_cast<double>(p.y));
    };
    if (!std::isnan(seen.borders[i])) {
      squares += error(seen.borders[i]) * error(seen.borders[i]);
      most = std::max(most, std::abs(error(seen.borders[i])));
      count += 1;
    }
    if (!std::isnan(seen.whole[i])) {
      whole_squares += error(seen.whole[i]) * error(seen.whole[i]);
      whole_count += 1;
    }
  }
  EXPECT_GT(count, 50'000);
  EXPECT_LT(std::sqrt(squares / count), 0.1);
  EXPECT_LT(most, 1) << "a fifth of a code";
  EXPECT_GT(std::sqrt(whole_squares / whole_count), 1) << "whole codes are rounded";
}

// The amplitude of this wave is a hundredth of a code. Depths of whole codes do not show such a wave, because on a
// level surface all pixels of a row have the same rounding error.
TEST(CodeBorders, ShowWavesFarSmallerThanACode) {
  constexpr double kLevel = 520;
  constexpr double kHigh = 0.05;
  const Surface shape = [](double x, double y) {
    return std::cos(2 * std::numbers::pi * (x - 7) / 120) * std::cos(2 * std::numbers::pi * y / 170);
  };
  const SeenBorders seen([&](double x, double y) { return kLevel - kHigh * shape(x, y); }, 160, 1);
  EXPECT_NEAR(seen.amplitude(seen.borders, kLevel, shape), kHigh, 0.15 * kHigh);
}

TEST(CodeBorders, NoneInNoise) {
  const SeenBorders seen([](double /*x*/, double /*y*/) { return 520; }, 4, 0.2);
  EXPECT_TRUE(std::all_of(seen.borders.begin(), seen.borders.end(), [](float z) { return std::isnan(z); }));
}

TEST(CodeBorders, BadArguments) {
  const structured_light::PlaneTriangulation plane(rig::load_rig("scanner"), kSceneBits);
  EXPECT_THROW(structured_light::CodeBorders(plane, 256), std::invalid_argument);
  EXPECT_THROW(structured_light::CodeBorders(plane, -1), std::invalid_argument);
  structured_light::CodeBorders borders(plane, 5);
  const std::vector<std::uint8_t> image(plane.pixels());
  const model::ImageView whole{image.data(), plane.rows(), plane.columns(), plane.columns()};
  const model::ImageView small{image.data(), plane.rows() - 1, plane.columns(), plane.columns()};
  EXPECT_THROW(borders.add_plane(kSceneBits, whole, whole), std::invalid_argument);
  EXPECT_THROW(borders.add_plane(0, whole, small), std::invalid_argument);
  EXPECT_NO_THROW(borders.add_plane(0, whole, whole));
}

}  // namespace
}  // namespace selfproj::test
