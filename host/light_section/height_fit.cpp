#include "host/light_section/height_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/rig/geometry.h"
#include "selfproj/files/user_error.h"
#include "selfproj/rig/height_correction.h"
#include "selfproj/rig/optics.h"
#include "selfproj/rig/rig.h"

namespace selfproj::light_section {
namespace {

// --- samples: where the camera saw which line, at which true height ---

struct HeightSample {
  double row = 0;  // from 0
  int column = 0;
  double line = 0;
  std::size_t position = 0;
  std::size_t level = 0;
  double height_mm = 0;        // true
  double x = 0, y = 0, z = 0;  // by the geometry alone
};

constexpr double kClose = 0.5;  // mm: how near to its tread a sample must be

bool place(const rig::RigOptics& optics, HeightSample& sample) {
  const std::optional<cv::Vec2d> ray = optics.ray({sample.row, static_cast<double>(sample.column)});
  const rig::LightSheet sheet{sample.line, 0, 0.5 * (optics.rig().projector.columns - 1)};
  const std::optional<double> z = ray ? optics.meet(*ray, sheet) : std::nullopt;
  if (z) {
    sample.x = *z * (*ray)[0];
    sample.y = *z * (*ray)[1];
    sample.z = *z;
  }
  return z.has_value();
}

// How the true height follows from that by the geometry, roughly: p . (1, x, y, height).
using Rough = cv::Vec4d;

double rough_height(const Rough& p, const rig::Rig& rig, const HeightSample& sample) {
  return p.dot({1, sample.x, sample.y, rig.plane_z_mm - sample.z});
}

// The tread nearest to a height; none if all are further than `close`.
std::optional<std::size_t> tread_of(const std::vector<double>& steps, double height, double close) {
  const auto nearest = std::min_element(
      steps.begin(), steps.end(), [height](double a, double b) { return std::abs(a - height) < std::abs(b - height); });
  return std::abs(*nearest - height) < close ? std::optional(static_cast<std::size_t>(nearest - steps.begin()))
                                             : std::nullopt;
}

// The shift of all heights, and the lean across the belt, with which most samples lie near treads, and most treads have
// samples.
Rough shifted(const rig::Rig& rig, const std::vector<HeightSample>& samples, const std::vector<double>& steps,
              double close) {
  constexpr int kOffsets = 60;  // to either side, of 0.5 mm
  constexpr int kLeans = 8;     // to either side, of 0.004
  Rough best;
  double most = -1;
  for (int k = -kLeans; k <= kLeans; ++k) {
    for (int i = -kOffsets; i <= kOffsets; ++i) {
      const Rough shift(0.5 * i, 0, 0.004 * k, 1);
      std::vector<double> on(steps.size(), 0);
      for (const HeightSample& sample : samples) {
        const double height = rough_height(shift, rig, sample);
        if (const auto tread = tread_of(steps, height, close)) {
          on[*tread] += 1 - std::abs(steps[*tread] - height) / close;
        }
      }
      double sum = 0;
      for (const double count : on) {
        sum += count + (count > 0 ? 0.02 * static_cast<double>(samples.size()) : 0);
      }
      if (sum > most) {
        most = sum;
        best = shift;
      }
    }
  }
  return best;
}

// From there by least squares over the samples near treads, which become more and the treads narrower.
Rough rough_heights(const rig::Rig& rig, const std::vector<HeightSample>& samples, const std::vector<double>& steps) {
  constexpr std::size_t kLooked = 2000;
  constexpr int kRounds = 8;
  double close = 10;
  for (std::size_t k = 1; k < steps.size(); ++k) {
    close = std::min(close, 0.3 * (steps[k] - steps[k - 1]));
  }
  std::vector<HeightSample> some;
  for (std::size_t i = 0; i < samples.size(); i += std::max<std::size_t>(1, samples.size() / kLooked)) {
    some.push_back(samples[i]);
  }
  Rough rough = shifted(rig, some, steps, close);
  for (int round = 0; round < kRounds; ++round) {
    cv::Matx44d matrix = cv::Matx44d::zeros();
    cv::Vec4d right(0, 0, 0, 0);
    for (const HeightSample& sample : some) {
      if (const auto tread = tread_of(steps, rough_height(rough, rig, sample), close)) {
        const cv::Vec4d terms(1, sample.x, sample.y, rig.plane_z_mm - sample.z);
        matrix += terms * terms.t();
        right += steps[*tread] * terms;
      }
    }
    rough = matrix.inv(cv::DECOMP_SVD) * right;
    close = std::max(std::min(kClose, close), 0.7 * close);
  }
  return rough;
}

// Gives each sample its tread, and leaves out those without one or near a step.
std::vector<HeightSample> on_treads(const rig::Rig& rig, std::vector<HeightSample> samples,
                                    const std::vector<double>& steps) {
  constexpr int kApart = 3;
  const Rough rough = rough_heights(rig, samples, steps);
  const std::size_t none = steps.size();
  for (HeightSample& sample : samples) {
    sample.level = tread_of(steps, rough_height(rough, rig, sample), kClose).value_or(none);
  }
  std::vector<HeightSample> kept;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    // The samples of an image lie side by side, in the order of their columns.
    bool good = samples[i].level != none;
    for (const int step : {-1, 1}) {
      for (std::size_t k = i; good;) {
        if ((step < 0 && k == 0) || (step > 0 && k + 1 == samples.size())) {
          break;
        }
        k = step < 0 ? k - 1 : k + 1;
        const bool beside = samples[k].line == samples[i].line && samples[k].position == samples[i].position &&
                            std::abs(samples[k].column - samples[i].column) <= kApart;
        if (!beside) {
          break;
        }
        good = samples[k].level == samples[i].level;
      }
    }
    if (good) {
      kept.push_back(samples[i]);
      kept.back().height_mm = steps[samples[i].level];
    }
  }
  return kept;
}

// All samples that the geometry can place. With steps, each gets the height of its tread; samples that belong to none,
// or lie within three columns of a step, are left out.
std::vector<HeightSample> height_samples(const rig::Rig& rig, const std::vector<HeightPosition>& positions,
                                         const HeightSettings& settings) {
  const rig::RigOptics optics(rig);
  std::vector<HeightSample> samples;
  for (std::size_t p = 0; p < positions.size(); ++p) {
    std::vector<LineSighting> lines = positions[p].seen;
    leave_out_reflections(rig, lines);
    for (const LineSighting& seen : lines) {
      HeightSample sample{seen.row, seen.column, seen.line, p, p, positions[p].height_mm};
      if (place(optics, sample)) {
        samples.push_back(sample);
      }
    }
  }
  return settings.steps_mm.empty() ? samples : on_treads(rig, std::move(samples), settings.steps_mm);
}

// Places the samples anew by the geometry of another rig.
void place_samples(const rig::RigOptics& optics, std::vector<HeightSample>& samples) {
  samples.erase(
      std::remove_if(samples.begin(), samples.end(), [&](HeightSample& sample) { return !place(optics, sample); }),
      samples.end());
}

// --- the correction as a problem of least squares: which orders the samples support, and what they leave open ---

// The terms of a correction that samples can tell, by their places among all of its terms. In a column of a laser, row
// and height say the same.
std::vector<std::size_t> told_terms(const rig::Rig& rig, int order, int order_heights) {
  const std::vector<std::array<int, 3>> terms = rig::height_terms(order, order_heights);
  std::vector<std::size_t> told;
  for (std::size_t i = 0; i < terms.size(); ++i) {
    if (!rig.light_plane || terms[i][1] == 0) {
      told.push_back(i);
    }
  }
  return told;
}

// Least squares of the corrections, from the samples of even and of odd columns apart.
class HeightModel {
 public:
  HeightModel(const rig::Rig& rig, const rig::RigHeights& most, const std::vector<HeightSample>& samples,
              const std::vector<char>& used, std::size_t levels)
      : terms_(rig::height_terms(most.order, most.order_heights)),
        with_rows_(!rig.light_plane),
        correction_(rig.camera, most),
        by_level_(terms_.size(), std::vector<double>(levels, 0)) {
    const auto n = static_cast<int>(terms_.size());
    for (Half& half : halves_) {
      half.matrix = cv::Mat::zeros(n, n, CV_64F);
      half.right = cv::Mat::zeros(n, 1, CV_64F);
    }
    std::vector<double> row;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const HeightSample& s = samples[i];
      if (used[i] == 0) {
        continue;
      }
      const double geometric = rig.plane_z_mm - s.z;
      correction_.terms(s.row, s.column, geometric, row);
      add(row, s.height_mm - geometric, halves_.at(static_cast<std::size_t>(s.column % 2)));
      for (std::size_t t = 0; t < row.size(); ++t) {
        by_level_[t][s.level] += row[t];
      }
    }
  }

  // The terms of a smaller correction, by their places among all.
  [[nodiscard]] std::vector<int> places(int order, int order_heights) const {
    std::vector<int> places;
    for (std::size_t i = 0; i < terms_.size(); ++i) {
      const auto& [column, row, height] = terms_[i];
      if (column + row + height <= order && height <= order_heights && (with_rows_ || row == 0)) {
        places.push_back(static_cast<int>(i));
      }
    }
    return places;
  }

  struct Solved {
    cv::Mat inverse;       // of the normal matrix
    cv::Mat coefficients;  // n x 1
  };
  // `which`: 0 even columns, 1 odd ones, 2 all.
  [[nodiscard]] std::optional<Solved> solve(const std::vector<int>& places, int which) const {
    const Half half = of(which);
    const auto n = static_cast<int>(places.size());
    cv::Mat matrix(n, n, CV_64F);
    cv::Mat right(n, 1, CV_64F);
    for (int i = 0; i < n; ++i) {
      const int from = places[static_cast<std::size_t>(i)];
      right.at<double>(i) = half.right.at<double>(from);
      for (int k = 0; k < n; ++k) {
        matrix.at<double>(i, k) = half.matrix.at<double>(from, places[static_cast<std::size_t>(k)]);
      }
    }
    Solved solved;
    if (cv::invert(matrix, solved.inverse, cv::DECOMP_CHOLESKY) == 0) {
      return std::nullopt;
    }
    solved.coefficients = solved.inverse * right;
    return solved;
  }

  // The mean square error of the coefficients on the samples of `which`.
  [[nodiscard]] double error(const std::vector<int>& places, const cv::Mat& coefficients, int which) const {
    const Half half = of(which);
    double sum = half.square;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const double at = coefficients.at<double>(static_cast<int>(i));
      sum -= 2 * at * half.right.at<double>(places[i]);
      for (std::size_t k = 0; k < places.size(); ++k) {
        sum += at * coefficients.at<double>(static_cast<int>(k)) * half.matrix.at<double>(places[i], places[k]);
      }
    }
    return std::max(0.0, sum) / half.count;
  }

  [[nodiscard]] std::size_t levels() const { return by_level_.front().size(); }

  // The sum of a term over the samples of a level.
  [[nodiscard]] double sum_of_level(int place, std::size_t level) const {
    return by_level_[static_cast<std::size_t>(place)][level];
  }

 private:
  struct Half {
    cv::Mat matrix, right;
    double square = 0, count = 0;
  };
  static void add(const std::vector<double>& row, double off, Half& half) {
    const auto n = static_cast<int>(row.size());
    for (int i = 0; i < n; ++i) {
      auto* to = half.matrix.ptr<double>(i);
      const double at = row[static_cast<std::size_t>(i)];
      for (int k = 0; k < n; ++k) {
        to[k] += at * row[static_cast<std::size_t>(k)];
      }
      half.right.at<double>(i) += at * off;
    }
    half.square += off * off;
    half.count += 1;
  }
  [[nodiscard]] Half of(int which) const {
    if (which < 2) {
      return halves_.at(static_cast<std::size_t>(which));
    }
    return {halves_[0].matrix + halves_[1].matrix, halves_[0].right + halves_[1].right,
            halves_[0].square + halves_[1].square, halves_[0].count + halves_[1].count};
  }

  std::vector<std::array<int, 3>> terms_;
  bool with_rows_;
  rig::HeightCorrection correction_;
  std::vector<std::vector<double>> by_level_;
  std::array<Half, 2> halves_;
};

// A correction of one order, fitted to all samples.
struct FittedHeights {
  rig::RigHeights heights;
  std::vector<int> places;        // of its terms among those of the model,
  std::vector<std::size_t> told;  // and among its own
  HeightModel::Solved solved;
  double rms = 0;
  double uncertain = 0;  // greatest standard deviation by noise on the grid
};

// Places (row, column, height) over the image and the calibrated heights.
std::vector<std::array<double, 3>> grid_of(const rig::Rig& rig, const rig::RigHeights& heights) {
  constexpr int kSteps = 8;
  std::vector<std::array<double, 3>> grid;
  for (int r = 0; r <= kSteps; ++r) {
    for (int c = 0; c <= kSteps; ++c) {
      for (int h = 0; h <= kSteps; ++h) {
        grid.push_back({r * (rig.camera.rows - 1.0) / kSteps, c * (rig.camera.columns - 1.0) / kSteps,
                        heights.min_mm + h * (heights.max_mm - heights.min_mm) / kSteps});
      }
    }
  }
  return grid;
}

constexpr double kMaxUncertain = 0.02;  // mm, one standard deviation by noise: more is not determined

cv::Mat terms_at(const rig::HeightCorrection& correction, const std::array<double, 3>& place,
                 const std::vector<std::size_t>& told) {
  std::vector<double> values;
  correction.terms(place[0], place[1], place[2], values);
  cv::Mat terms(static_cast<int>(told.size()), 1, CV_64F);
  std::transform(told.begin(), told.end(), terms.begin<double>(), [&](std::size_t i) { return values[i]; });
  return terms;
}

std::optional<FittedHeights> fitted(const HeightModel& model, const rig::Rig& rig, const rig::RigHeights& range,
                                    int order, int order_heights) {
  FittedHeights fit{range, model.places(order, order_heights), {}, {}};
  const auto solved = model.solve(fit.places, 2);
  if (!solved) {
    return std::nullopt;
  }
  fit.solved = *solved;
  fit.heights.order = order;
  fit.heights.order_heights = std::min(order, order_heights);
  fit.told = told_terms(rig, order, order_heights);
  fit.heights.corrections_mm.assign(rig::height_terms(order, order_heights).size(), 0);
  for (std::size_t i = 0; i < fit.told.size(); ++i) {
    fit.heights.corrections_mm[fit.told[i]] = solved->coefficients.at<double>(static_cast<int>(i));
  }
  fit.rms = std::sqrt(model.error(fit.places, solved->coefficients, 2));
  const rig::HeightCorrection correction(rig.camera, fit.heights);
  for (const auto& place : grid_of(rig, fit.heights)) {
    const cv::Mat terms = terms_at(correction, place, fit.told);
    const cv::Mat variance = terms.t() * solved->inverse * terms;
    fit.uncertain = std::max(fit.uncertain, fit.rms * std::sqrt(std::max(0.0, variance.at<double>(0))));
  }
  return fit;
}

// The smallest correction that predicts the other half of the columns as well as any, among those of at most the orders
// of `range` that the samples determine. Throws UserError if there is none.
FittedHeights choose(const HeightModel& model, const rig::Rig& rig, const rig::RigHeights& range) {
  constexpr double kAsWell = 1.002;
  constexpr double kNone = std::numeric_limits<double>::infinity();
  struct Candidate {
    int order;
    double error;
  };
  std::vector<Candidate> candidates;
  double least = kNone;
  double uncertain = kNone;
  for (int order = 1; order <= range.order; ++order) {
    const std::optional<FittedHeights> fit = fitted(model, rig, range, order, range.order_heights);
    uncertain = fit && order == 1 ? fit->uncertain : uncertain;
    if (!fit || fit->uncertain > kMaxUncertain) {
      continue;
    }
    double error = 0;
    for (const int half : {0, 1}) {
      if (const auto solved = model.solve(fit->places, half)) {
        error += model.error(fit->places, solved->coefficients, 1 - half);
      } else {
        error = kNone;
      }
    }
    candidates.push_back({order, error});
    least = std::min(least, error);
  }
  for (const Candidate& candidate : candidates) {
    if (candidate.error <= kAsWell * kAsWell * least) {
      return *fitted(model, rig, range, candidate.order, range.order_heights);
    }
  }
  throw UserError("heights", fmt::format("the positions do not determine the heights of the whole image (a standard "
                                         "deviation of {:.3g} mm somewhere, {} is allowed); add positions, or lines",
                                         uncertain, kMaxUncertain));
}

// What heights move by if each level is off by the tolerance, in the worst way, anywhere in the image, mm.
double open_by_levels(const HeightModel& model, const FittedHeights& fit, const rig::Rig& rig, double tolerance) {
  const rig::HeightCorrection correction(rig.camera, fit.heights);
  std::vector<cv::Mat> responses;
  for (std::size_t k = 0; k < model.levels(); ++k) {
    cv::Mat right(static_cast<int>(fit.places.size()), 1, CV_64F);
    for (std::size_t i = 0; i < fit.places.size(); ++i) {
      right.at<double>(static_cast<int>(i)) = model.sum_of_level(fit.places[i], k);
    }
    responses.emplace_back(fit.solved.inverse * right);
  }
  double greatest = 0;
  for (const auto& place : grid_of(rig, fit.heights)) {
    const cv::Mat terms = terms_at(correction, place, fit.told);
    double sum = 0;
    for (const cv::Mat& response : responses) {
      sum += std::abs(terms.dot(response));
    }
    greatest = std::max(greatest, tolerance * sum);
  }
  return greatest;
}

// --- levels, and what is wrong with them ---

constexpr std::size_t kMinLevels = 3;
constexpr std::size_t kMinSamples = 200;  // of a level
constexpr int kMaxFittedOrder = 6;
constexpr int kMaxHeightOrder = 2;  // the rest of a geometry is hardly curved in height
constexpr int kParts = 16;          // of the columns, for unevenness
constexpr double kMinPartSamples = 20;
constexpr double kSure = 4;  // standard deviations that noise does not reach

std::vector<HeightLevel> levels_of(const std::vector<HeightPosition>& positions, const HeightSettings& settings) {
  std::vector<HeightLevel> levels;
  if (settings.steps_mm.empty()) {
    for (const HeightPosition& position : positions) {
      levels.push_back({.name = position.name, .height_mm = position.height_mm});
    }
  }
  for (const double step : settings.steps_mm) {
    levels.push_back({.name = fmt::format("the tread of {} mm", step), .height_mm = step});
  }
  return levels;
}

// The errors of one level, as sums for each column.
struct ColumnErrors {
  double n = 0, sum = 0;
};

// The part of the columns first..last, nothing if it has too few samples.
std::optional<HeightPart> part_of(const std::vector<ColumnErrors>& columns, std::size_t first, std::size_t last) {
  HeightPart part{static_cast<int>(first), static_cast<int>(last)};
  double n = 0;
  double seen = 0;
  for (std::size_t c = first; c <= last; ++c) {
    n += columns[c].n;
    seen += columns[c].n > 0 ? 1 : 0;
    part.mean_mm += columns[c].sum;
  }
  if (n <= kMinPartSamples || seen < 2) {
    return std::nullopt;
  }
  part.mean_mm /= n;
  double square = 0;
  for (std::size_t c = first; c <= last; ++c) {
    const double off = columns[c].n > 0 ? columns[c].sum / columns[c].n - part.mean_mm : 0;
    square += off * off;
  }
  part.noise_mm = std::sqrt(square / (seen - 1) / seen);
  return part;
}

// Errors of the samples, level by level: `error` gives that of each, NaN for one that does not count.
template <class Error>
void set_errors(const std::vector<HeightSample>& samples, int columns, const Error& error,
                std::vector<HeightLevel>& levels) {
  struct Sums {
    double n = 0, sum = 0, square = 0;
    std::vector<ColumnErrors> columns;
  };
  const auto width = static_cast<std::size_t>(columns);
  std::vector<Sums> all(levels.size());
  for (Sums& sums : all) {
    sums.columns.resize(width);
  }
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double off = error(i);
    if (std::isnan(off)) {
      continue;
    }
    Sums& sums = all[samples[i].level];
    sums.n += 1;
    sums.sum += off;
    sums.square += off * off;
    ColumnErrors& column = sums.columns[static_cast<std::size_t>(samples[i].column)];
    column.n += 1;
    column.sum += off;
  }
  for (std::size_t k = 0; k < levels.size(); ++k) {
    HeightLevel& level = levels[k];
    const Sums& sums = all[k];
    level.samples = static_cast<std::size_t>(sums.n);
    level.mean_mm = sums.n > 0 ? sums.sum / sums.n : 0;
    level.rms_mm = sums.n > 0 ? std::sqrt(sums.square / sums.n) : 0;
    level.uneven_mm = 0;
    level.parts.clear();
    for (std::size_t p = 0; p < kParts; ++p) {
      const std::size_t first = (p * width + kParts - 1) / kParts;
      const std::size_t end = ((p + 1) * width + kParts - 1) / kParts;
      if (const auto part = first < end ? part_of(sums.columns, first, end - 1) : std::nullopt) {
        level.parts.push_back(*part);
        level.uneven_mm = std::max(level.uneven_mm, std::abs(part->mean_mm));
      }
    }
  }
}

void expect_samples(const std::vector<HeightLevel>& levels) {
  if (levels.size() < kMinLevels) {
    throw UserError("heights",
                    fmt::format("{} are too few; {} or more are needed, 5 are good", levels.size(), kMinLevels));
  }
  for (const HeightLevel& level : levels) {
    if (level.samples < kMinSamples) {
      throw UserError(level.name,
                      fmt::format("the line was found in {} places only; {} are needed", level.samples, kMinSamples));
    }
  }
}

// Heights by the geometry must rise with the true ones.
void expect_order(const std::vector<HeightLevel>& levels) {
  for (std::size_t k = 1; k < levels.size(); ++k) {
    const double true_step = levels[k].height_mm - levels[k - 1].height_mm;
    // The mean error is that of the geometry, so the step by the geometry is the true one plus the change of the error.
    const double step = true_step + levels[k].mean_mm - levels[k - 1].mean_mm;
    if (!(step > 0.5 * true_step && step < 2 * true_step)) {
      throw UserError(levels[k].name,
                      fmt::format("is given as {} mm above {}, but the rig sees it {:.3f} mm above; are the heights in "
                                  "the order of the folders?",
                                  true_step, levels[k - 1].name, step));
    }
  }
}

// a, b, c and s of z = a x + b y + c - s height, by least squares. A laser tells nothing of a.
cv::Vec4d plane_of(const rig::Rig& rig, const std::vector<HeightSample>& samples) {
  const double along = rig.light_plane ? 0 : 1;
  cv::Matx44d matrix = cv::Matx44d::zeros();
  matrix(0, 0) = 1 - along;  // cv::invert gives zeros for a singular matrix
  cv::Vec4d right(0, 0, 0, 0);
  for (const HeightSample& s : samples) {
    const cv::Vec4d terms(along * s.x, s.y, 1, -s.height_mm);
    matrix += terms * terms.t();
    right += s.z * terms;
  }
  return matrix.inv(cv::DECOMP_SVD) * right;
}

// Heights that are all wrong by one factor fit as well as right ones. What the rig makes of them tells.
void expect_scale(const rig::Rig& rig, double seen, const HeightSettings& settings) {
  const double allowed = settings.scale_tolerance.value_or(rig.calibration ? HeightSettings::kCalibratedScale
                                                                           : HeightSettings::kDrawnScale);
  if (!(std::abs(seen - 1) <= allowed)) {
    throw CheckFailed(
        fmt::format("heights: the rig sees {:.3f} mm for each mm of the given heights; {:g} % more or less are allowed "
                    "(--scale-tolerance): all are likely wrong by one factor, or this is not the rig that took the "
                    "images",
                    seen, 100 * allowed));
  }
}

// The rig with its belt where the plates lie, by plane_of.
rig::Rig with_belt(const rig::Rig& rig, const cv::Vec4d& found) {
  rig::Rig result = rig;
  if (rig.belt_pose || !rig.calibration) {  // known better than from a strip of the plate, or not to be known at all
    result.plane_z_mm = found[2];
    return result;
  }
  const cv::Vec3d normal = cv::normalize(cv::Vec3d(-found[0], -found[1], 1));  // rows first
  const cv::Vec3d along = cv::normalize(cv::Vec3d(1, 0, 0) - normal[0] * normal);
  result.plane_z_mm = found[2] * normal[2];
  result.belt_pose = rig::RigBeltPose{{along[1], along[0], along[2]}, {normal[1], normal[0], normal[2]}};
  return result;
}

// The heights by the geometry of the samples used, but for a thousandth at either end.
void set_range(const rig::Rig& rig, const std::vector<HeightSample>& samples, const std::vector<char>& used,
               rig::RigHeights& heights) {
  std::vector<double> all;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (used[i] != 0) {
      all.push_back(rig.plane_z_mm - samples[i].z);
    }
  }
  std::sort(all.begin(), all.end());
  heights.min_mm = all[all.size() / 1000];
  heights.max_mm = all[all.size() - 1 - all.size() / 1000];
}

// Leaves out of the samples used those whose error is far beyond the rest.
std::vector<char> without_outliers(const std::vector<HeightSample>& samples, const std::vector<char>& used,
                                   const rig::Rig& rig, const rig::RigHeights& heights) {
  constexpr double kFar = 6;
  const rig::HeightCorrection correction(rig.camera, heights);
  std::vector<double> off(samples.size(), rig::kUnknown);
  std::vector<double> sorted;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const HeightSample& s = samples[i];
    if (used[i] != 0) {
      const double geometric = rig.plane_z_mm - s.z;
      off[i] = std::abs(geometric + correction.at(s.row, s.column, geometric) - s.height_mm);
      sorted.push_back(off[i]);
    }
  }
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const double limit = kFar * 1.4826 * *middle;  // of a normal distribution's standard deviation
  std::vector<char> kept;
  for (const double error : off) {
    kept.push_back(error <= limit ? 1 : 0);  // an unknown one is not
  }
  return kept;
}

// A correction fitted to all levels, or to all but one.
struct Corrected {
  HeightModel model;
  FittedHeights fit;
  std::vector<HeightLevel> levels;  // with what is left of their errors
};

Corrected correct(const rig::Rig& rig, const std::vector<HeightSample>& samples, std::vector<HeightLevel> levels,
                  std::optional<std::size_t> left_out = {}) {
  std::vector<char> used;
  for (const HeightSample& s : samples) {
    used.push_back(s.level == left_out ? 0 : 1);
  }
  const std::size_t count = levels.size() - (left_out ? 1 : 0);
  rig::RigHeights range;
  range.order = kMaxFittedOrder;
  range.order_heights = std::min(kMaxHeightOrder, static_cast<int>(count) - 2);
  set_range(rig, samples, used, range);
  const auto model = [&] { return HeightModel(rig, range, samples, used, levels.size()); };
  const FittedHeights first = choose(model(), rig, range);
  used = without_outliers(samples, used, rig, first.heights);
  HeightModel last_model = model();
  FittedHeights last = choose(last_model, rig, range);
  const rig::HeightCorrection correction(rig.camera, last.heights);
  set_errors(
      samples, rig.camera.columns,
      [&](std::size_t i) {
        const HeightSample& s = samples[i];
        const double geometric = rig.plane_z_mm - s.z;
        return used[i] != 0 ? geometric + correction.at(s.row, s.column, geometric) - s.height_mm : rig::kUnknown;
      },
      levels);
  return {std::move(last_model), std::move(last), std::move(levels)};
}

// How far a level is uneven, as a share of what is allowed: tolerance, flatness and kSure deviations of the noise.
double share_of(const HeightLevel& level, const HeightSettings& settings) {
  double greatest = 0;
  for (const HeightPart& part : level.parts) {
    const double allowed = settings.flatness_mm + settings.tolerance_mm + kSure * part.noise_mm;
    greatest = std::max(greatest, std::abs(part.mean_mm) / allowed);
  }
  return greatest;
}

double greatest_share(const Corrected& all, const HeightSettings& settings) {
  double greatest = 0;
  for (const HeightLevel& level : all.levels) {
    greatest = std::max(greatest, share_of(level, settings));
  }
  return greatest;
}

double greatest_uneven(const std::vector<HeightLevel>& levels) {
  double greatest = 0;
  for (const HeightLevel& level : levels) {
    greatest = std::max(greatest, level.uneven_mm);
  }
  return greatest;
}

// Refuses levels of which one is not flat or not at its height. The corrections follow such a level in part, so that
// the greatest error may be at another one. So each level in turn is left out: that one is off without which the others
// fit. Three levels do not tell.
void expect_flat(const Corrected& all, const rig::Rig& rig, const std::vector<HeightSample>& samples,
                 const HeightSettings& settings) {
  constexpr double kAsGood = 2;     // shares that differ by less do not tell one level from the other,
  constexpr double kNothing = 0.2;  // nor do shares of less than this
  if (greatest_share(all, settings) <= 1) {
    return;
  }
  const std::string allowed =
      fmt::format("{} mm of flatness and {} mm of tolerance are allowed", settings.flatness_mm, settings.tolerance_mm);
  std::vector<double> shares;
  std::vector<double> rests;
  for (std::size_t k = 0; k < all.levels.size() && all.levels.size() > kMinLevels; ++k) {
    const Corrected others = correct(rig, samples, all.levels, k);
    shares.push_back(greatest_share(others, settings));
    rests.push_back(greatest_uneven(others.levels));
  }
  const double least = shares.empty() ? 0 : *std::min_element(shares.begin(), shares.end());
  std::vector<std::size_t> suspects;
  for (std::size_t k = 0; k < all.levels.size(); ++k) {
    if (shares.empty() || shares[k] <= std::min(1.0, std::max(kAsGood * least, kNothing))) {
      suspects.push_back(k);
    }
  }
  if (suspects.empty()) {
    throw UserError("heights", fmt::format("more than one position is not flat, or not at its height; {}", allowed));
  }
  if (suspects.size() > 1) {
    std::vector<std::string> names;
    std::transform(suspects.begin(), suspects.end(), std::back_inserter(names),
                   [&](std::size_t k) { return all.levels[k].name; });
    throw UserError("heights", fmt::format("one position is not flat, or not at its height: {}; {}",
                                           fmt::join(names, " or "), allowed));
  }
  const std::size_t k = suspects.front();
  throw UserError(
      all.levels[k].name,
      fmt::format(
          "is not flat, or not at its height: with it heights are up to {:.3f} mm off, without it {:.3f} mm; {}",
          greatest_uneven(all.levels), rests[k], allowed));
}

}  // namespace

HeightFit fit_heights(const rig::Rig& given, const std::vector<HeightPosition>& positions,
                      const HeightSettings& settings) {
  if (given.light_plane && !given.belt_pose) {
    throw UserError(given.name, "does not say how its belt lies; a laser needs `selfproj calibrate belt` first");
  }
  HeightFit fit;
  rig::Rig rig = given;
  rig.heights.reset();
  std::vector<HeightSample> samples = height_samples(rig, positions, settings);
  fit.levels = levels_of(positions, settings);
  set_errors(
      samples, rig.camera.columns, [&](std::size_t i) { return rig.plane_z_mm - samples[i].z - samples[i].height_mm; },
      fit.levels);
  expect_samples(fit.levels);
  expect_order(fit.levels);
  const cv::Vec4d plane = plane_of(rig, samples);
  expect_scale(rig, plane[3], settings);
  rig = with_belt(rig, plane);
  place_samples(rig::RigOptics(rig), samples);
  const auto geometric = [&](std::size_t i) { return rig.plane_z_mm - samples[i].z; };
  set_errors(
      samples, rig.camera.columns, [&](std::size_t i) { return geometric(i) - samples[i].height_mm; }, fit.levels);
  for (HeightLevel& level : fit.levels) {
    level.before_mean_mm = level.mean_mm;
    level.before_rms_mm = level.rms_mm;
  }
  const Corrected all = correct(rig, samples, fit.levels);
  fit.levels = all.levels;
  fit.rms_mm = all.fit.rms;
  expect_flat(all, rig, samples, settings);
  const rig::HeightCorrection correction(rig.camera, all.fit.heights);
  for (const auto& [row, column, height] : grid_of(rig, all.fit.heights)) {
    fit.correction_mm = std::max(fit.correction_mm, std::abs(correction.at(row, column, height)));
  }
  fit.open_by_tolerance_mm = open_by_levels(all.model, all.fit, rig, settings.tolerance_mm);
  fit.open_by_flatness_mm = settings.flatness_mm;
  fit.open_by_noise_mm = all.fit.uncertain;
  rig.heights = all.fit.heights;
  if (rig.sources) {
    rig.sources->belt = rig::ValueSource::measured;
  }
  fit.rig = rig;
  return fit;
}

std::vector<HeightLevel> check_heights(const rig::Rig& rig, const std::vector<HeightPosition>& positions,
                                       const HeightSettings& settings) {
  const std::vector<HeightSample> samples = height_samples(rig, positions, settings);
  std::vector<HeightLevel> levels = levels_of(positions, settings);
  const rig::RigOptics optics(rig);
  set_errors(
      samples, rig.camera.columns,
      [&](std::size_t i) {
        const rig::CameraPlace place{samples[i].row, static_cast<double>(samples[i].column)};
        return rig.plane_z_mm - optics.corrected(place, samples[i].z) - samples[i].height_mm;
      },
      levels);
  return levels;
}

double allowed_mm(const HeightPart& part, const HeightSettings& settings) {
  return 2 * (settings.tolerance_mm + settings.flatness_mm) + kSure * part.noise_mm;
}

}  // namespace selfproj::light_section
