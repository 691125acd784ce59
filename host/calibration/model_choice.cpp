#include "host/calibration/model_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/calibration/bundle_solver.h"
#include "host/calibration/starts.h"

namespace selfproj::calibration {
namespace {

constexpr std::array<int, 5> kLevels{0, 1, 2, 4, 5};  // coefficients that may be free
constexpr int kMaxByData = 4;

// Chi square of five standard deviations, by the degrees of freedom. Three would do for noise; but what paper and codes
// add is not quite independent from corner to corner.
double chance_limit(int freedom) {
  constexpr std::array<double, 5> kLimits{0, 25.0, 28.74, 31.81, 34.56};
  return kLimits.at(static_cast<std::size_t>(freedom));
}

BundleOptions options_of(const ModelSettings& settings, const FreeDistortion& free) {
  BundleOptions options;
  options.free = free;
  if (settings.free.camera == FreeDistortion::kByData) {
    options.uncertain.camera = kMaxByData;
  }
  if (settings.free.projector == FreeDistortion::kByData) {
    options.uncertain.projector = kMaxByData;
  }
  options.shape = settings.shape;
  options.plates = settings.plates;
  options.projector = settings.with_projector;
  return options;
}

// The shape's standard deviations that a fit begins with, of the chessboard's longer side.
void begin_shape(Bundle& bundle, const std::vector<View>& views) {
  constexpr double kBegin = 1e-3;
  const double side = board_side(views);
  bundle.noise.bend = bundle.noise.own = kBegin * side;
  bundle.noise.stretch = 0.1 * kBegin * side;
}

std::vector<Bundle> starts_of(const std::vector<View>& views, const ModelSettings& settings) {
  if (!settings.with_projector) {
    return camera_starts(views, settings.camera);
  }
  return settings.plates == nullptr ? bundle_starts(views, settings.camera, settings.projector)
                                    : bundle_starts_of(views, *settings.plates, settings.camera, settings.projector);
}

// The fits of a flat chessboard without distortion from all starts, the best one first.
std::vector<Bundle> first_fits(const std::vector<View>& views, const ModelSettings& settings) {
  std::vector<Bundle> fits;
  double least = 0;
  std::string reason = "the poses do not determine the lens; lean the chessboard in more directions";
  for (const Bundle& start : starts_of(views, settings)) {
    BundleOptions options;
    options.plates = settings.plates;
    options.projector = settings.with_projector;
    options.estimate_noise = false;  // so that costs compare
    options.deviations = false;
    try {
      const BundleResult found = solve_bundle(views, start, options);
      fits.push_back(found.bundle);
      if (fits.size() == 1 || found.cost < least) {
        std::swap(fits.front(), fits.back());
        least = found.cost;
      }
    } catch (const std::runtime_error& error) {
      reason = error.what();
    }
  }
  if (fits.empty()) {
    throw std::runtime_error(reason);
  }
  return fits;
}

// Chi square of the coefficients that `larger` frees beyond `smaller`.
double chi_square(const BundleResult& found, const FreeDistortion& smaller, const FreeDistortion& larger) {
  std::vector<int> rows;  // of the covariance
  std::vector<double> values;
  for (int i = smaller.camera; i < larger.camera; ++i) {
    rows.push_back(i);
    values.push_back(found.bundle.camera[static_cast<std::size_t>(kPinholeParameters + i)]);
  }
  for (int i = smaller.projector; i < larger.projector; ++i) {
    rows.push_back(larger.camera + i);
    values.push_back(found.bundle.projector[static_cast<std::size_t>(kPinholeParameters + i)]);
  }
  const int count = static_cast<int>(rows.size());
  cv::Mat1d covariance(count, count);
  for (int a = 0; a < count; ++a) {
    for (int b = 0; b < count; ++b) {
      covariance(a, b) =
          found.distortion_covariance(rows[static_cast<std::size_t>(a)], rows[static_cast<std::size_t>(b)]);
    }
  }
  const cv::Mat1d value(values, true);
  cv::Mat1d solved;
  if (!cv::solve(covariance, value, solved, cv::DECOMP_CHOLESKY)) {
    return 0;
  }
  return value.dot(solved);
}

// The number of coefficients `steps` levels above `now`, at most `limit`; `now` if there is none.
int level_above(int now, int steps, int limit) {
  const auto* at = std::find(kLevels.begin(), kLevels.end(), now);
  for (; steps > 0 && at + 1 != kLevels.end() && at[1] <= limit; --steps) {
    ++at;
  }
  return steps == 0 ? *at : now;
}

// Climbs from model to model.
class Ladder {
 public:
  Ladder(const std::vector<View>& views, const ModelSettings& settings) : views_(views), settings_(settings) {}

  ModelChoice climb() {
    const FreeDistortion& asked = settings_.free;
    choice_.starts = first_fits(views_, settings_);
    BundleOptions options;
    options.plates = settings_.plates;
    options.projector = settings_.with_projector;
    options.deviations = false;
    Bundle start = solve_bundle(views_, choice_.starts.front(), options).bundle;
    begin_shape(start, views_);
    choice_.free = {0, 0};
    for (const int level : kLevels) {  // what was asked for, a step at a time
      const FreeDistortion next{std::max(choice_.free.camera, std::min(level, asked.camera)),
                                std::max(choice_.free.projector, std::min(level, asked.projector))};
      if (next.camera != choice_.free.camera || next.projector != choice_.free.projector) {
        BundleOptions rough = options_of(settings_, next);
        rough.deviations = false;
        rough.estimate_noise = false;
        start = solve_bundle(views_, start, rough).bundle;
        choice_.free = next;
      }
    }
    choice_.result = solve_bundle(views_, start, options_of(settings_, choice_.free));
    while (free_one_step(1) || free_one_step(2)) {
    }
    return std::move(choice_);
  }

 private:
  // Tries to free the next coefficients of each lens that the data decide on, and takes the step that more speaks for.
  // Returns whether there was one.
  bool free_one_step(int levels) {
    std::optional<BundleResult> best;
    std::size_t taken = 0;
    double excess = 0;
    for (const bool camera : {true, false}) {
      if ((camera ? settings_.free.camera : settings_.free.projector) != FreeDistortion::kByData) {
        continue;
      }
      FreeDistortion next = choice_.free;
      int& count = camera ? next.camera : next.projector;
      const int before = count;
      count = level_above(before, levels, kMaxByData);
      if (count == before) {
        continue;
      }
      ModelStep step{next, 0, chance_limit(count - before), false};
      BundleResult found;
      try {
        BundleOptions options = options_of(settings_, next);
        options.estimate_noise = false;  // that of the smaller model is on the safe side
        found = solve_bundle(views_, choice_.result.bundle, options);
        step.chi_square = chi_square(found, choice_.free, next);
      } catch (const std::invalid_argument&) {  // too few corners for this model
        continue;
      }
      choice_.steps.push_back(step);
      if (step.chi_square - step.limit > excess) {
        excess = step.chi_square - step.limit;
        best = found;
        taken = choice_.steps.size() - 1;
      }
    }
    if (best) {
      choice_.steps[taken].taken = true;
      choice_.free = choice_.steps[taken].free;
      choice_.result = solve_bundle(views_, best->bundle, options_of(settings_, choice_.free));
    }
    return best.has_value();
  }

  const std::vector<View>& views_;
  const ModelSettings& settings_;
  ModelChoice choice_;
};

// The parameter in which two solutions differ most, in standard deviations.
struct Difference {
  double deviations = 0;
  std::string text;
};

Difference difference(const BundleResult& found, const Bundle& other) {
  Difference most;
  const auto compare = [&](const char* what, const char* name, double a, double b, double deviation) {
    const double off = deviation > 0 ? std::abs(a - b) / deviation : 0;
    if (off > most.deviations) {
      most = {off, fmt::format("{} {} {:.5g} or {:.5g}", what, name, a, b)};
    }
  };
  const Bundle& bundle = found.bundle;
  for (std::size_t i = 0; i < kLensParameters; ++i) {
    compare("camera", kLensNames[i], bundle.camera[i], other.camera[i], found.deviation.camera[i]);
    compare("projector", kLensNames[i], bundle.projector[i], other.projector[i], found.deviation.projector[i]);
  }
  for (int i = 0; i < 3; ++i) {
    compare("projector", "place (mm)", bundle.stereo.translation[i], other.stereo.translation[i],
            found.deviation.stereo.translation[i]);
  }
  return most;
}

// A focal length or a baseline that is as good as unknown.
std::string undetermined(const BundleResult& found, const ModelSettings& settings) {
  constexpr double kSane = 50;  // times longer or shorter than the image is no focal length
  const auto sane = [&](const LensParameters& lens, cv::Size size) {
    const double side = std::max(size.width, size.height);
    return std::all_of(lens.begin(), lens.begin() + 2, [&](double f) { return f > side / kSane && f < side * kSane; });
  };
  const bool both = settings.with_projector;
  if (!sane(found.bundle.camera, settings.camera) || (both && !sane(found.bundle.projector, settings.projector))) {
    return "the poses do not determine the focal lengths; lean the chessboard in more directions";
  }
  constexpr double kUnknown = 0.1;  // relative standard deviation
  const auto check = [&](const char* what, double value, double deviation) {
    return deviation <= kUnknown * std::abs(value)
               ? std::string()
               : fmt::format(
                     "the poses do not determine the {} ({:.4g} ± {:.2g}); lean the chessboard in more "
                     "directions",
                     what, value, deviation);
  };
  const std::array<std::string, 3> all{
      check("camera's focal length", found.bundle.camera[0], found.deviation.camera[0]),
      both ? check("projector's focal length", found.bundle.projector[0], found.deviation.projector[0]) : "",
      both ? check("distance between camera and projector", cv::norm(found.bundle.stereo.translation),
                   found.baseline_deviation)
           : ""};
  for (const std::string& reason : all) {
    if (!reason.empty()) {
      return reason;
    }
  }
  return {};
}

// Whether two fits of the flat chessboard are one: the same lenses and pose between them, within 0.01 % of each number.
bool is_same(const Bundle& a, const Bundle& b) {
  constexpr double kNear = 1e-4;
  const auto near = [&](double x, double y) { return std::abs(x - y) <= kNear * (std::abs(x) + std::abs(y)); };
  bool same = true;
  for (std::size_t i = 0; i < kPinholeParameters; ++i) {
    same = same && near(a.camera[i], b.camera[i]) && near(a.projector[i], b.projector[i]);
  }
  return same && cv::norm(a.stereo.translation - b.stereo.translation) <= kNear * cv::norm(a.stereo.translation);
}

// Where the fit of a start leads with the noise and the model of the choice; nothing if it leads nowhere.
std::optional<BundleResult> follow(const std::vector<View>& views, const ModelSettings& settings,
                                   const ModelChoice& choice, Bundle start) {
  if (start.chessboard.size() != views.size()) {
    return std::nullopt;
  }
  start.noise = choice.result.bundle.noise;
  BundleOptions options = options_of(settings, choice.free);
  options.estimate_noise = false;
  options.deviations = false;
  try {
    return solve_bundle(views, start, options);
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
}

}  // namespace

ModelChoice choose_model(const std::vector<View>& views, const ModelSettings& settings) {
  return Ladder(views, settings).climb();
}

void refit(const std::vector<View>& views, const ModelSettings& settings, ModelChoice& choice) {
  choice.result = solve_bundle(views, choice.result.bundle, options_of(settings, choice.free));
}

void check_starts(const std::vector<View>& views, const ModelSettings& settings, ModelChoice& choice) {
  constexpr double kBetter = 1;  // chi square by which another solution is better
  constexpr double kClear = 20;  // chi square by which another solution is out of the question: less likely by e^-10
  // Standard deviations within which solutions are the same: what is left of the rough minimum of a start, and too
  // little to matter beside the deviations themselves.
  constexpr double kSame = 0.3;
  constexpr int kMaxBetter = 3;
  const auto excess_of = [&](const BundleResult& other) { return 2 * (other.cost - choice.result.cost); };
  const auto seems_another = [&](const BundleResult& other) {
    const double excess = excess_of(other);
    return excess >= -kBetter && excess <= kClear && difference(choice.result, other.bundle).deviations >= kSame;
  };
  for (int round = 0; round <= kMaxBetter; ++round) {
    choice.agreeing = choice.worse = choice.failed = 0;
    choice.refusal = undetermined(choice.result, settings);
    std::optional<BundleResult> better;
    std::optional<BundleResult> found;
    for (std::size_t i = 0; i < choice.starts.size(); ++i) {
      if (i == 0 || !is_same(choice.starts[i], choice.starts[i - 1])) {
        found = follow(views, settings, choice, choice.starts[i]);
        if (found && seems_another(*found)) {  // or the solver has stopped in a flat valley, and goes on from there
          found = follow(views, settings, choice, found->bundle);
        }
      }
      if (!found) {
        ++choice.failed;
        continue;
      }
      const double excess = excess_of(*found);
      const Difference off = difference(choice.result, found->bundle);
      if (off.deviations < kSame) {
        ++choice.agreeing;
      } else if (excess < -kBetter) {
        better = !better || found->cost < better->cost ? found : better;
      } else if (excess > kClear) {
        ++choice.worse;
      } else if (choice.refusal.empty()) {
        choice.refusal =
            fmt::format("different starts end in different solutions that fit alike: {}; capture more poses", off.text);
      }
    }
    if (!better) {
      return;
    }
    choice.result = solve_bundle(views, better->bundle, options_of(settings, choice.free));
  }
  choice.refusal = "the least squares find ever better solutions from other starts; capture more poses";
}

}  // namespace selfproj::calibration
