#include "host/capture/grey_response.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "host/files/user_error.h"

namespace selfproj {
namespace {

constexpr double kWhite = 255;

// The exponent of the power law nearest to the shares of light, by golden sections of the sum of squares. The squares
// are those of the light itself: in logarithms the dark levels, which are mostly noise, would count most.
double nearest_gamma(const std::vector<std::pair<double, double>>& shares) {
  const auto sum = [&](double gamma) {
    double squares = 0;
    for (const auto& [grey, light] : shares) {
      const double off = std::pow(grey, gamma) - light;
      squares += off * off;
    }
    return squares;
  };
  constexpr double kGolden = 0.6180339887498949;
  double low = 0.1;
  double high = 10;
  for (int i = 0; i < 60; ++i) {
    const double left = high - kGolden * (high - low);
    const double right = low + kGolden * (high - low);
    if (sum(left) < sum(right)) {
      high = right;
    } else {
      low = left;
    }
  }
  return (low + high) / 2;
}

}  // namespace

std::vector<int> grey_levels(int levels) {
  std::vector<int> greys;
  for (int i = 0; i < levels; ++i) {
    greys.push_back(static_cast<int>(std::lround(kWhite * i / (levels - 1))));
  }
  return greys;
}

ImageSequence grey_patterns(const std::vector<int>& greys, int rows, int columns) {
  std::vector<std::string> names;
  for (const int grey : greys) {
    names.push_back(fmt::format("grey {}", grey));
  }
  return {std::move(names), [greys, rows, columns](std::size_t i) {
            const std::size_t pixels = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
            return Image{rows, columns, std::vector<std::uint8_t>(pixels, static_cast<std::uint8_t>(greys[i]))};
          }};
}

GreyResponse grey_response(const std::vector<int>& greys, const std::vector<Image>& images, const std::string& camera) {
  constexpr int kLeastLight = 30;
  constexpr int kMostGrey = 250;
  constexpr std::size_t kLeastPixels = 100;
  constexpr double kNoise = 0.01;
  const std::vector<std::uint8_t>& black = images.front().pixels;
  const std::vector<std::uint8_t>& white = images.back().pixels;
  std::vector<double> sums(images.size());
  GreyResponse response;
  for (std::size_t k = 0; k < white.size(); ++k) {
    if (white[k] - black[k] >= kLeastLight && white[k] <= kMostGrey) {
      ++response.pixels;
      for (std::size_t i = 0; i < images.size(); ++i) {
        sums[i] += images[i].pixels[k] - black[k];
      }
    }
  }
  if (response.pixels < kLeastPixels) {
    throw UserError(camera, fmt::format("only {} pixels are lit by white and not saturated; {} are needed; change the "
                                        "exposure",
                                        response.pixels, kLeastPixels));
  }
  const double full = sums.back();
  double last = 0;
  std::vector<std::pair<double, double>> shares;
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (sums[i] < last - kNoise * full) {
      throw UserError(camera,
                      fmt::format("sees less light under grey {} than under grey {}; does other light change, or "
                                  "is an automatic setting of the camera or projector on?",
                                  greys[i], greys[i - 1]));
    }
    last = std::min(std::max(last, sums[i]), full);
    const double grey = greys[i] / kWhite;
    shares.emplace_back(grey, last / full);
    response.curve.points.push_back({static_cast<double>(greys[i]), last / static_cast<double>(response.pixels)});
    response.off_line = std::max(response.off_line, std::abs(last / full - grey));
  }
  response.gamma = nearest_gamma(shares);
  for (const auto& [grey, light] : shares) {
    response.off_law = std::max(response.off_law, std::abs(std::pow(grey, response.gamma) - light));
  }
  return response;
}

}  // namespace selfproj
