#include "host/capture/light_check.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>

namespace selfproj {
namespace {

constexpr int kBlock = 16;
constexpr int kLit = 10;           // grey values that white adds
constexpr double kNoise = 3;       // grey values by which a block may differ in any case
constexpr double kArrived = 0.97;  // of the way from the old grey to the new one
constexpr double kBlockArrived = 0.9;

int light_of(const WhiteAndBlack& levels, std::size_t pixel) {
  return levels.white.pixels[pixel] - levels.black.pixels[pixel];
}

// The sum of a value over the lit pixels of a block, the light that white adds to them, and their number.
struct BlockSum {
  double value = 0;
  double light = 0;
  int lit = 0;
};

// Whether every block passes. `value` is called for each lit pixel.
template <class Value>
bool every_block(const WhiteAndBlack& levels, const Value& value, const std::function<bool(const BlockSum&)>& passes) {
  const int rows = levels.white.rows;
  const int columns = levels.white.columns;
  for (int top = 0; top < rows; top += kBlock) {
    for (int left = 0; left < columns; left += kBlock) {
      BlockSum sum;
      const int bottom = std::min(top + kBlock, rows);
      const int right = std::min(left + kBlock, columns);
      for (int row = top; row < bottom; ++row) {
        for (int column = left; column < right; ++column) {
          const auto at =
              static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column);
          const int light = light_of(levels, at);
          if (light >= kLit) {
            sum.value += value(at);
            sum.light += light;
            ++sum.lit;
          }
        }
      }
      if (4 * sum.lit >= (bottom - top) * (right - left) && !passes(sum)) {
        return false;
      }
    }
  }
  return true;
}

// The share of the light that white adds, over all lit pixels.
template <class Value>
double share_of_light(const WhiteAndBlack& levels, const Value& value) {
  double sum = 0;
  double all = 0;
  for (std::size_t i = 0; i < levels.white.pixels.size(); ++i) {
    if (light_of(levels, i) >= kLit) {
      sum += value(i);
      all += light_of(levels, i);
    }
  }
  return all > 0 ? sum / all : 0;
}

// Whether the light has gone from the one level to the other, by what each pixel has gone of its way.
template <class Way>
bool arrived(const WhiteAndBlack& levels, const Way& way) {
  return share_of_light(levels, way) >= kArrived &&
         every_block(levels, way, [](const BlockSum& sum) { return sum.value >= kBlockArrived * sum.light; });
}

}  // namespace

bool all_white(const Image& image, const WhiteAndBlack& levels) {
  return arrived(levels, [&](std::size_t i) { return image.pixels[i] - levels.black.pixels[i]; });
}

bool all_black(const Image& image, const WhiteAndBlack& levels) {
  return arrived(levels, [&](std::size_t i) { return levels.white.pixels[i] - image.pixels[i]; });
}

bool is_negative(const Image& pattern, const Image& negative) {
  return pattern.rows == negative.rows && pattern.columns == negative.columns &&
         std::equal(pattern.pixels.begin(), pattern.pixels.end(), negative.pixels.begin(),
                    [](int a, int b) { return a + b == 255 && (a == 0 || b == 0); });
}

bool adds_up(const Image& pattern, const Image& negative, const WhiteAndBlack& levels) {
  constexpr double kMost = 0.1;
  const auto light = [&](std::size_t i) {
    return static_cast<double>(pattern.pixels[i] + negative.pixels[i] - 2 * levels.black.pixels[i]);
  };
  const double share = std::clamp(share_of_light(levels, light), 0.8, 1.25);
  return every_block(
      levels, [&](std::size_t i) { return std::abs(light(i) - share * light_of(levels, i)); },
      [](const BlockSum& sum) { return sum.value <= kMost * sum.light + kNoise * sum.lit; });
}

bool same_light(const Image& a, const Image& b, const WhiteAndBlack& levels) {
  constexpr double kMost = 0.1;
  return every_block(
      levels, [&](std::size_t i) { return std::abs(a.pixels[i] - b.pixels[i]); },
      [](const BlockSum& sum) { return sum.value <= kMost * sum.light + kNoise * sum.lit; });
}

}  // namespace selfproj
