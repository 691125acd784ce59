#include "host/calibration/capture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/files/numbers.h"
#include "host/images/frame_options.h"
#include "host/structured_light/sequence_check.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/structured_light/fast_decoder.h"

namespace selfproj::calibration {
namespace {

// Reads images of one size in turn and keeps their sum.
class Images {
 public:
  explicit Images(images::ImageSequence& images) : images_(images) {}

  // The file of the image that next() gave last.
  [[nodiscard]] const std::string& name() const { return images_.files()[next_ - 1]; }

  // The next image, valid until the one after its successor is read.
  const images::Image& next() {
    images::Image& image = pair_[next_ % 2];
    image = images_.read(next_);
    if (next_ == 0) {
      if (std::max(image.rows, image.columns) > structured_light::FastGrayDecoder::kMaxSide) {
        throw UserError(images_.files()[0], fmt::format("is {}; at most {} rows and columns are taken",
                                                        images::size_text(image.rows, image.columns),
                                                        structured_light::FastGrayDecoder::kMaxSide));
      }
      sum_.resize(image.pixels.size());
      rows_ = image.rows;
      columns_ = image.columns;
    }
    std::transform(sum_.begin(), sum_.end(), image.pixels.begin(), sum_.begin(),
                   [](std::uint32_t sum, std::uint8_t pixel) { return sum + pixel; });
    ++next_;
    return image;
  }

  // The sum of all images so far, stretched to 0..255.
  [[nodiscard]] images::Image stretched() const {
    const auto [low, high] = std::minmax_element(sum_.begin(), sum_.end());
    const std::uint32_t range = std::max(1U, *high - *low);
    images::Image result{rows_, columns_, std::vector<std::uint8_t>(sum_.size())};
    std::transform(sum_.begin(), sum_.end(), result.pixels.begin(), [&, least = *low](std::uint32_t sum) {
      return static_cast<std::uint8_t>((255 * (sum - least) + range / 2) / range);
    });
    return result;
  }

 private:
  images::ImageSequence& images_;
  std::array<images::Image, 2> pair_;
  std::vector<std::uint32_t> sum_;
  std::size_t next_ = 0;
  int rows_ = 0;
  int columns_ = 0;
};

// The codes along one axis from its pairs of images; kNone if a pair is ambiguous.
std::vector<std::int16_t> decode_axis(Images& images, int bits, int threshold, std::string& contradiction) {
  std::optional<structured_light::FastGrayDecoder> decoder;
  std::optional<structured_light::SequenceCheck> check;
  std::vector<std::string> names;
  std::size_t pixels = 0;
  for (int i = 0; i < 2 * bits; ++i) {
    const images::Image& image = images.next();
    if (!decoder) {
      decoder.emplace(model::GraySettings{image.rows, image.columns, bits, threshold});
      check.emplace(image.rows, image.columns, bits);
      pixels = image.pixels.size();
    }
    decoder->add_frame(image.view(), i);
    check->add(i, image.view());
    names.push_back(images.name());
  }
  if (contradiction.empty()) {
    contradiction = structured_light::contradiction_of(*check, names);
  }
  std::vector<std::uint16_t> words(pixels);
  structured_light::unambiguous_code_words(decoder->codes(), words.data());
  std::vector<std::int16_t> codes(pixels);
  std::transform(words.begin(), words.end(), codes.begin(), [&](std::uint16_t word) {
    const bool valid = (word & model::GrayDecoder::kMeasurable) != 0;
    return valid ? static_cast<std::int16_t>(word & model::GrayDecoder::kCode) : Capture::kNone;
  });
  return codes;
}

// What codes beyond the projector say of its size, if they are more than single wrong ones.
std::string beyond_text(std::size_t beyond, std::size_t measured, int greatest, const char* lines, int side) {
  constexpr double kMost = 0.01;
  return static_cast<double>(beyond) <= kMost * static_cast<double>(measured)
             ? ""
             : fmt::format("{:.1f} % of the pixels see {} from {} on, up to {}, but the projector is said to have {}",
                           100 * static_cast<double>(beyond) / static_cast<double>(measured), lines, side, greatest,
                           side);
}

}  // namespace

std::size_t Capture::decoded() const {
  return projector_column.size() -
         static_cast<std::size_t>(std::count(projector_column.begin(), projector_column.end(), kNone));
}

Capture decode_capture(const std::string& name, images::ImageSequence& captured,
                       const structured_light::GraySequence& sequence, const DecodeSettings& settings) {
  constexpr int kMaxBits = model::GrayDecoder::kMaxBits;
  if (sequence.column_bits() > kMaxBits || sequence.row_bits() > kMaxBits) {
    throw UserError("--projector", fmt::format("has a side of more than {} pixels", 1 << kMaxBits));
  }
  if (captured.count() != static_cast<std::size_t>(sequence.count())) {
    throw UserError(
        name, fmt::format("has {} images; {} are expected for a projector of {}: {} pairs for columns, {} for "
                          "rows, white, black",
                          captured.count(), sequence.count(), images::size_text(sequence.rows(), sequence.columns()),
                          sequence.column_bits(), sequence.row_bits()));
  }
  Images images(captured);
  Capture capture;
  capture.projector_column = decode_axis(images, sequence.column_bits(), settings.threshold, capture.contradiction);
  capture.projector_row = decode_axis(images, sequence.row_bits(), settings.threshold, capture.contradiction);
  const images::Image& white = images.next();
  const images::Image& black = images.next();
  capture.rows = white.rows;
  capture.columns = white.columns;
  capture.lit.resize(white.pixels.size());
  std::size_t measured = 0;
  std::array<std::size_t, 2> beyond{};  // columns, rows
  std::array<int, 2> greatest{};
  for (std::size_t i = 0; i < white.pixels.size(); ++i) {
    std::int16_t& column = capture.projector_column[i];
    std::int16_t& row = capture.projector_row[i];
    const bool lit = white.pixels[i] - black.pixels[i] > settings.contrast;
    capture.lit[i] = lit;
    bool has_code = lit && column != Capture::kNone && row != Capture::kNone;
    if (has_code) {
      ++measured;
      greatest = {std::max<int>(greatest[0], column), std::max<int>(greatest[1], row)};
      beyond[0] += column >= sequence.columns() ? 1 : 0;
      beyond[1] += row >= sequence.rows() ? 1 : 0;
      has_code = column < sequence.columns() && row < sequence.rows();
    }
    if (!has_code) {
      column = row = Capture::kNone;
    }
  }
  if (capture.contradiction.empty() &&
      !structured_light::SequenceCheck::is_white_and_black(white.view(), black.view())) {
    capture.contradiction = "the last two images are not white and black";
  }
  if (capture.contradiction.empty()) {
    const std::string columns = beyond_text(beyond[0], measured, greatest[0], "columns", sequence.columns());
    capture.contradiction =
        columns.empty() ? beyond_text(beyond[1], measured, greatest[1], "rows", sequence.rows()) : columns;
  }
  capture.mean = images.stretched();
  return capture;
}

namespace {

constexpr int kMinPixels = 25;

// A pixel with a code. Its position is relative to the corner, in units of the window, so that sums are well scaled.
struct Sample {
  cv::Vec2d at;
  cv::Vec2d code;
};

// Models of the code as a function of the place. Parameters are linear about a start. `value` gives the code and its
// derivatives by the parameters.
struct Homography {
  static constexpr int kParameters = 8;
  using Parameters = cv::Vec<double, kParameters>;
  using Derivative = cv::Matx<double, 2, kParameters>;

  static cv::Vec2d value(const Parameters& h, const cv::Vec2d& p, Derivative& d) {
    const double w = 1 / (h[6] * p[0] + h[7] * p[1] + 1);
    const cv::Vec2d code(w * (h[0] * p[0] + h[1] * p[1] + h[2]), w * (h[3] * p[0] + h[4] * p[1] + h[5]));
    const cv::Vec3d q(w * p[0], w * p[1], w);
    d = {q[0], q[1], q[2], 0,    0,    0,    -code[0] * q[0], -code[0] * q[1],  //
         0,    0,    0,    q[0], q[1], q[2], -code[1] * q[0], -code[1] * q[1]};
    return code;
  }

  // A first map by consensus, which wrong codes do not affect.
  static bool start(const std::vector<Sample>& samples, Parameters& h) {
    constexpr double kConsensus = 3;  // projector pixels
    std::vector<cv::Point2d> from;
    std::vector<cv::Point2d> to;
    for (const Sample& sample : samples) {
      from.emplace_back(sample.at);
      to.emplace_back(sample.code);
    }
    const cv::Mat found = cv::findHomography(from, to, cv::RANSAC, kConsensus);
    if (found.empty() || !(std::abs(found.at<double>(2, 2)) > 0)) {
      return false;
    }
    for (int i = 0; i < kParameters; ++i) {
      h[i] = found.at<double>(i / 3, i % 3) / found.at<double>(2, 2);
    }
    return true;
  }
};

struct Quadratic {
  static constexpr int kTerms = 6;
  static constexpr int kParameters = 2 * kTerms;
  using Parameters = cv::Vec<double, kParameters>;
  using Derivative = cv::Matx<double, 2, kParameters>;

  static cv::Vec2d value(const Parameters& a, const cv::Vec2d& p, Derivative& d) {
    const std::array<double, kTerms> terms{1, p[0], p[1], p[0] * p[0], p[0] * p[1], p[1] * p[1]};
    d = Derivative::zeros();
    cv::Vec2d code;
    for (int axis = 0; axis < 2; ++axis) {
      for (int i = 0; i < kTerms; ++i) {
        const double term = terms[static_cast<std::size_t>(i)];
        d(axis, kTerms * axis + i) = term;
        code[axis] += a[kTerms * axis + i] * term;
      }
    }
    return code;
  }

  // Starts with the median code; the weights of the first step are wide around it.
  static bool start(const std::vector<Sample>& samples, Parameters& a) {
    a = Parameters::all(0);
    for (int axis = 0; axis < 2; ++axis) {
      std::vector<double> codes;
      codes.reserve(samples.size());
      std::transform(samples.begin(), samples.end(), std::back_inserter(codes),
                     [axis](const Sample& sample) { return sample.code[axis]; });
      const auto middle = codes.begin() + static_cast<std::ptrdiff_t>(codes.size() / 2);
      std::nth_element(codes.begin(), middle, codes.end());
      a[kTerms * axis] = *middle;
    }
    return true;
  }
};

// Gauss-Newton with Tukey's weights. Gives the code at the corner, where the place is 0.
template <class Model>
CornerCode fit(const std::vector<Sample>& samples, double max_sd_px) {
  constexpr int kSteps = 12;
  constexpr double kTukey = 4.685;     // standard deviations above which a sample does not count
  constexpr double kMinScale = 0.3;    // projector pixels: a code is rounded to a whole one
  constexpr double kPerMedian = 0.85;  // standard deviation of one direction for a median length of 1
  constexpr int kSize = Model::kParameters;
  CornerCode result;
  result.pixels = static_cast<int>(samples.size());
  typename Model::Parameters parameters;
  if (!Model::start(samples, parameters)) {
    return result;
  }
  cv::Matx<double, kSize, kSize> covariance;
  double scale = 0;
  std::vector<double> lengths(samples.size());
  for (int step = 0; step < kSteps; ++step) {
    typename Model::Derivative d;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      lengths[i] = cv::norm(samples[i].code - Model::value(parameters, samples[i].at, d));
    }
    scale = std::max(kMinScale, kPerMedian * files::median_of(lengths));
    cv::Matx<double, kSize, kSize> normal = cv::Matx<double, kSize, kSize>::zeros();
    cv::Vec<double, kSize> right = cv::Vec<double, kSize>::all(0);
    double weights = 0;
    double squares = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double t = lengths[i] / (kTukey * scale);
      if (t >= 1) {
        continue;
      }
      const double weight = (1 - t * t) * (1 - t * t);
      const cv::Vec2d off = samples[i].code - Model::value(parameters, samples[i].at, d);
      normal += weight * (d.t() * d);
      right += weight * (d.t() * off);
      weights += weight;
      squares += weight * off.dot(off);
    }
    bool ok = false;
    covariance = normal.inv(cv::DECOMP_CHOLESKY, &ok);
    if (!ok) {
      return result;
    }
    parameters += covariance * right;
    result.residual_px = std::sqrt(squares / weights);
  }
  typename Model::Derivative d;
  const cv::Vec2d code = Model::value(parameters, {0, 0}, d);
  const cv::Matx22d spread = d * covariance * d.t();
  result.projector = {code[0], code[1]};
  result.sd_px = std::max(scale, result.residual_px / std::sqrt(2.0)) * std::sqrt(std::max(spread(0, 0), spread(1, 1)));
  result.valid = std::isfinite(code[0]) && std::isfinite(code[1]) && result.sd_px <= max_sd_px;
  return result;
}

}  // namespace

CornerCode corner_code(const Capture& capture, const cv::Point2d& camera, double spacing_px,
                       const CornerSettings& settings) {
  constexpr double kShareOfSpacing = 0.7;
  constexpr double kMinWindow = 6;
  const double window =
      settings.window_px > 0 ? settings.window_px : std::max(kMinWindow, kShareOfSpacing * spacing_px);
  const auto first = [&](double centre) { return std::max(0, static_cast<int>(std::ceil(centre - window))); };
  const auto last = [&](double centre, int size) {
    return std::min(size - 1, static_cast<int>(std::floor(centre + window)));
  };
  std::vector<Sample> samples;
  std::array<bool, 4> sides{};  // left, right, above, below the corner
  for (int r = first(camera.y); r <= last(camera.y, capture.rows); ++r) {
    for (int c = first(camera.x); c <= last(camera.x, capture.columns); ++c) {
      const std::size_t i =
          static_cast<std::size_t>(r) * static_cast<std::size_t>(capture.columns) + static_cast<std::size_t>(c);
      if (capture.projector_column[i] == Capture::kNone) {
        continue;
      }
      const cv::Vec2d at((c - camera.x) / window, (r - camera.y) / window);
      samples.push_back(
          {at, {static_cast<double>(capture.projector_column[i]), static_cast<double>(capture.projector_row[i])}});
      sides[0] = sides[0] || at[0] < 0;
      sides[1] = sides[1] || at[0] > 0;
      sides[2] = sides[2] || at[1] < 0;
      sides[3] = sides[3] || at[1] > 0;
    }
  }
  CornerCode result;
  result.pixels = static_cast<int>(samples.size());
  result.sd_px = std::numeric_limits<double>::infinity();
  if (result.pixels < kMinPixels || !std::all_of(sides.begin(), sides.end(), [](bool side) { return side; })) {
    return result;
  }
  return settings.method == CornerMethod::homography ? fit<Homography>(samples, settings.max_sd_px)
                                                     : fit<Quadratic>(samples, settings.max_sd_px);
}

}  // namespace selfproj::calibration
