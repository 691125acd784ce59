#include "host/calibration/line_removal.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <vector>

namespace selfproj::calibration {
namespace {

cv::Mat mat_of(const images::Image& image) {
  return {image.rows, image.columns, CV_8UC1, const_cast<std::uint8_t*>(image.pixels.data())};  // NOLINT
}

// The value that a share of the values do not reach. The values are put into another order.
template <class T>
T at_share(std::vector<T>& values, double share) {
  const auto nth = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + nth, values.end());
  return values[static_cast<std::size_t>(nth)];
}

// Pixels that are clearly lit.
std::vector<cv::Point2d> lit_pixels(const images::Image& light) {
  constexpr double kMost = 0.999;       // of all pixels: a line covers more than the rest
  constexpr double kShareOfMost = 0.4;  // of the brightest light
  constexpr int kLeast = 20;            // grey values
  std::vector<std::uint8_t> values = light.pixels;
  const int limit = std::max(kLeast, static_cast<int>(kShareOfMost * at_share(values, kMost)));
  std::vector<cv::Point2d> lit;
  for (int row = 0; row < light.rows; ++row) {
    for (int column = 0; column < light.columns; ++column) {
      if (light.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(light.columns) +
                       static_cast<std::size_t>(column)] > limit) {
        lit.emplace_back(column, row);
      }
    }
  }
  return lit;
}

std::vector<cv::Point2d> inside(const std::vector<cv::Point2d>& points, const LightBand& band) {
  std::vector<cv::Point2d> on;
  std::copy_if(points.begin(), points.end(), std::back_inserter(on),
               [&](const cv::Point2d& p) { return std::abs(band.off(p)) <= band.half; });
  return on;
}

// The band of this width through two points that most points lie in.
LightBand widest_agreement(const std::vector<cv::Point2d>& points, double half) {
  constexpr int kTries = 300;
  constexpr std::size_t kLooked = 1500;  // so many points tell
  cv::RNG random(1);
  std::vector<cv::Point2d> looked;
  for (std::size_t i = 0; i < std::min(kLooked, points.size()); ++i) {
    looked.push_back(points[static_cast<std::size_t>(random.uniform(0, static_cast<int>(points.size())))]);
  }
  LightBand best{points.front(), {1, 0}, half};
  std::ptrdiff_t most = 0;
  for (int i = 0; i < kTries; ++i) {
    const cv::Point2d a = looked[static_cast<std::size_t>(random.uniform(0, static_cast<int>(looked.size())))];
    const cv::Point2d b = looked[static_cast<std::size_t>(random.uniform(0, static_cast<int>(looked.size())))];
    const double length = cv::norm(b - a);
    if (length < 8 * half) {
      continue;
    }
    const LightBand band{a, (b - a) / length, half};
    const auto count = std::count_if(looked.begin(), looked.end(),
                                     [&](const cv::Point2d& p) { return std::abs(band.off(p)) <= half; });
    if (count > most) {
      most = count;
      best = band;
    }
  }
  return best;
}

// The line of least squares through the points.
LightBand fitted(const std::vector<cv::Point2d>& points, double half) {
  cv::Point2d middle(0, 0);
  for (const cv::Point2d& p : points) {
    middle += p;
  }
  middle /= static_cast<double>(points.size());
  double xx = 0;
  double xy = 0;
  double yy = 0;
  for (const cv::Point2d& p : points) {
    const cv::Point2d d = p - middle;
    xx += d.x * d.x;
    xy += d.x * d.y;
    yy += d.y * d.y;
  }
  const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
  return {middle, {std::cos(angle), std::sin(angle)}, half};
}

// What the darkest tenth of the pixels has at each distance from the band, less what it has far away.
class Veil {
 public:
  Veil(const cv::Mat& image, const LightBand& band) : band_(band) {
    const auto reach = static_cast<std::size_t>(std::hypot(image.rows, image.cols) / kStep) + 1;
    std::vector<std::vector<std::uint8_t>> at(reach);
    for (int row = 0; row < image.rows; ++row) {
      for (int column = 0; column < image.cols; ++column) {
        const double off = std::abs(band.off(cv::Point2d(column, row)));
        if (off > band.half) {
          at[static_cast<std::size_t>(off / kStep)].push_back(image.at<std::uint8_t>(row, column));
        }
      }
    }
    double least = 255;
    for (std::vector<std::uint8_t>& values : at) {
      constexpr std::size_t kEnough = 200;
      dark_.push_back(values.size() < kEnough ? least : at_share(values, kDarkest));
      least = std::min(least, dark_.back());
    }
    // It only falls off with the distance; what does not is the scene.
    double so_far = 255;
    for (double& dark : dark_) {
      so_far = std::min(so_far, dark);
      dark = so_far - least;
    }
  }

  [[nodiscard]] double at(int column, int row) const {
    return dark_[static_cast<std::size_t>(std::abs(band_.off(cv::Point2d(column, row))) / kStep)];
  }

 private:
  static constexpr double kStep = 4;  // pixels
  static constexpr double kDarkest = 0.1;
  LightBand band_;
  std::vector<double> dark_;
};

}  // namespace

images::Image thin_light(const images::Image& image, int most_px) {
  const cv::Mat grey = mat_of(image);
  cv::Mat wide;
  cv::morphologyEx(grey, wide, cv::MORPH_OPEN, cv::getStructuringElement(cv::MORPH_ELLIPSE, {most_px, most_px}));
  // White paper is not light, and neither are the corners of its squares.
  constexpr double kWhite = 0.98;
  std::vector<std::uint8_t> values(wide.begin<std::uint8_t>(), wide.end<std::uint8_t>());
  cv::max(wide, static_cast<double>(at_share(values, kWhite)), wide);
  images::Image light{image.rows, image.columns, std::vector<std::uint8_t>(image.pixels.size())};
  cv::subtract(grey, wide, mat_of(light));
  return light;
}

std::optional<LightBand> line_of_light(const images::Image& light) {
  constexpr double kShortest = 0.25;  // of the image's shorter side
  constexpr double kWidest = 0.04;    // half of the band, of the image's shorter side
  constexpr double kMostBeside = 0.95;
  constexpr double kMargin = 3;  // pixels
  // Of the line's length: black squares may hide it, but what a row of white squares has of thin light, at their
  // corners, is less.
  constexpr double kCovered = 0.35;
  constexpr std::size_t kFewest = 50;
  constexpr int kRounds = 4;
  const double side = std::min(light.rows, light.columns);
  const std::vector<cv::Point2d> lit = lit_pixels(light);
  if (lit.size() < kFewest) {
    return std::nullopt;
  }
  LightBand band = widest_agreement(lit, 2);
  band.half = kWidest * side;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<cv::Point2d> on = inside(lit, band);
    if (on.size() < kFewest) {
      return std::nullopt;
    }
    std::vector<double> offs;
    std::vector<double> along;
    for (const cv::Point2d& p : on) {
      offs.push_back(std::abs(band.off(p)));
      along.push_back(band.direction.dot(p - band.at));
    }
    constexpr double kEnds = 0.02;
    const double length = at_share(along, 1 - kEnds) - at_share(along, kEnds);
    const double half = at_share(offs, kMostBeside) + kMargin;
    std::set<int> places;
    std::transform(along.begin(), along.end(), std::inserter(places, places.end()),
                   [](double place) { return static_cast<int>(std::floor(place)); });
    if (length < kShortest * side || half > kWidest * side || static_cast<double>(places.size()) < kCovered * length) {
      return std::nullopt;
    }
    band = fitted(on, half);
  }
  return band;
}

images::Image without_band(const images::Image& image, const LightBand& band) {
  images::Image result = image;
  cv::Mat grey = mat_of(result);
  const Veil veil(grey, band);
  for (int row = 0; row < grey.rows; ++row) {
    for (int column = 0; column < grey.cols; ++column) {
      auto& pixel = grey.at<std::uint8_t>(row, column);
      pixel = static_cast<std::uint8_t>(std::max(0.0, pixel - veil.at(column, row)));
    }
  }
  // Along columns if the line lies flat, else along rows.
  const bool flat = std::abs(band.direction.x) >= std::abs(band.direction.y);
  const cv::Point2d turned = flat ? band.direction : cv::Point2d(band.direction.y, band.direction.x);
  const cv::Point2d at = flat ? band.at : cv::Point2d(band.at.y, band.at.x);
  const int lines = flat ? grey.cols : grey.rows;
  const int places = flat ? grey.rows : grey.cols;
  const double half = band.half / std::abs(turned.x);
  for (int line = 0; line < lines; ++line) {
    const auto pixel = [&](int place) -> std::uint8_t& {
      return flat ? grey.at<std::uint8_t>(place, line) : grey.at<std::uint8_t>(line, place);
    };
    const double middle = at.y + (line - at.x) * turned.y / turned.x;
    const int before = static_cast<int>(std::floor(middle - half));
    const int after = static_cast<int>(std::ceil(middle + half));
    if (after < 0 || before >= places || (before < 0 && after >= places)) {
      continue;
    }
    const double first = before < 0 ? pixel(after) : pixel(before);
    const double last = after >= places ? pixel(before) : pixel(after);
    for (int place = std::max(0, before + 1); place < std::min(places, after); ++place) {
      const double share = static_cast<double>(place - before) / (after - before);
      pixel(place) = static_cast<std::uint8_t>(std::lround((1 - share) * first + share * last));
    }
  }
  return result;
}

}  // namespace selfproj::calibration
