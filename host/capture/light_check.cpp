#include "host/capture/light_check.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

namespace selfproj::capture {
namespace {

constexpr int kBlock = 16;
constexpr int kLit = 10;           // grey values that white adds
constexpr double kNoise = 3;       // grey values by which a block may differ in any case
constexpr double kArrived = 0.97;  // of the way from the old grey to the new one
constexpr double kBlockArrived = 0.9;

int light_of(const WhiteAndBlack& levels, std::size_t pixel) {
  return levels.white.pixels[pixel] - levels.black.pixels[pixel];
}

// Whether every block passes. `passes` gets the lit pixels of a block.
template <class Passes>
bool every_block(const WhiteAndBlack& levels, const Passes& passes) {
  const int rows = levels.white.rows;
  const int columns = levels.white.columns;
  std::vector<std::size_t> lit;
  for (int top = 0; top < rows; top += kBlock) {
    for (int left = 0; left < columns; left += kBlock) {
      lit.clear();
      const int bottom = std::min(top + kBlock, rows);
      const int right = std::min(left + kBlock, columns);
      for (int row = top; row < bottom; ++row) {
        for (int column = left; column < right; ++column) {
          const auto at =
              static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column);
          if (light_of(levels, at) >= kLit) {
            lit.push_back(at);
          }
        }
      }
      if (4 * lit.size() >= static_cast<std::size_t>((bottom - top) * (right - left)) && !passes(lit)) {
        return false;
      }
    }
  }
  return true;
}

// The sum of a value over pixels.
template <class Value>
double sum_of(const std::vector<std::size_t>& pixels, const Value& value) {
  return std::accumulate(pixels.begin(), pixels.end(), 0.0, [&](double sum, std::size_t i) { return sum + value(i); });
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
  return share_of_light(levels, way) >= kArrived && every_block(levels, [&](const std::vector<std::size_t>& lit) {
           return sum_of(lit, way) >= kBlockArrived * sum_of(lit, [&](std::size_t i) { return light_of(levels, i); });
         });
}

// Whether a value is small beside the light that white adds, in every block.
template <class Value>
bool small_everywhere(const WhiteAndBlack& levels, const Value& value) {
  constexpr double kMost = 0.1;
  return every_block(levels, [&](const std::vector<std::size_t>& lit) {
    return sum_of(lit, value) <= kMost * sum_of(lit, [&](std::size_t i) { return light_of(levels, i); }) +
                                     kNoise * static_cast<double>(lit.size());
  });
}

// Whether what a pair is off is noise: in the mean of each block, and beside the stripes of the pair. Of stripes so
// fine that both images are nearly grey, an old picture is off by little, but darkens the stripes and lightens the
// gaps. With the share a of an old picture that has nothing to do with the new one, `follows` is a/2 of the stripes'
// contrast.
template <class Off>
bool off_by_noise(const images::Image& pattern, const images::Image& negative, const WhiteAndBlack& levels,
                  const Off& off) {
  constexpr double kMost = 0.05;     // of the light that white adds, or of the contrast
  constexpr double kDeviations = 4;  // standard errors of noise
  const auto contrast = [&](std::size_t i) { return static_cast<double>(pattern.pixels[i] - negative.pixels[i]); };
  const auto of_light = [&](std::size_t i) { return contrast(i) / light_of(levels, i); };
  return every_block(levels, [&](const std::vector<std::size_t>& lit) {
    const auto n = static_cast<double>(lit.size());
    const auto mean_of = [&](const auto& value) { return sum_of(lit, value) / n; };
    const double mean = mean_of(off);
    const double middle = mean_of(of_light);
    const double follows = mean_of([&](std::size_t i) { return of_light(i) > middle ? off(i) - mean : 0; }) -
                           mean_of([&](std::size_t i) { return of_light(i) < middle ? off(i) - mean : 0; });
    const double noise =
        kDeviations * std::sqrt(mean_of([&](std::size_t i) { return (off(i) - mean) * (off(i) - mean); }) / n);
    return std::abs(mean) <= kMost * mean_of([&](std::size_t i) { return light_of(levels, i); }) + noise &&
           std::abs(follows) <= std::max(kMost * mean_of([&](std::size_t i) { return std::abs(contrast(i)); }), noise);
  });
}

}  // namespace

bool all_white(const images::Image& image, const WhiteAndBlack& levels) {
  return arrived(levels, [&](std::size_t i) { return image.pixels[i] - levels.black.pixels[i]; });
}

bool all_black(const images::Image& image, const WhiteAndBlack& levels) {
  return arrived(levels, [&](std::size_t i) { return levels.white.pixels[i] - image.pixels[i]; });
}

bool is_negative(const images::Image& pattern, const images::Image& negative) {
  return pattern.rows == negative.rows && pattern.columns == negative.columns &&
         std::equal(pattern.pixels.begin(), pattern.pixels.end(), negative.pixels.begin(),
                    [](int a, int b) { return a + b == 255 && (a == 0 || b == 0); });
}

bool adds_up(const images::Image& pattern, const images::Image& negative, const WhiteAndBlack& levels) {
  const auto light = [&](std::size_t i) {
    return static_cast<double>(pattern.pixels[i] + negative.pixels[i] - 2 * levels.black.pixels[i]);
  };
  const double share = std::clamp(share_of_light(levels, light), 0.85, 1.2);
  const auto off = [&](std::size_t i) { return light(i) - share * light_of(levels, i); };
  return small_everywhere(levels, [&](std::size_t i) { return std::abs(off(i)); }) &&
         off_by_noise(pattern, negative, levels, off);
}

bool same_light(const images::Image& a, const images::Image& b, const WhiteAndBlack& levels) {
  return small_everywhere(levels, [&](std::size_t i) { return std::abs(a.pixels[i] - b.pixels[i]); });
}

}  // namespace selfproj::capture
