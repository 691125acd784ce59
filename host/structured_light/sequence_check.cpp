#include "host/structured_light/sequence_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "selfproj/model/gray_decoder.h"

namespace selfproj::structured_light {
namespace {

constexpr int kTile = 64;
constexpr std::size_t kMostPixels = std::size_t{1} << 20U;
constexpr int kMinContrast = 10;           // grey values
constexpr double kContrastDeviations = 8;  // of noise
constexpr std::size_t kMinLit = 200;       // of fewer pixels nothing can be said
constexpr std::size_t kMinBorders = 50;
constexpr double kFlat = 0.25;          // a pair with less of the contrast is dark, bright or grey in both
constexpr double kOther = 0.6;          // of the contrast, by which its sum is then off
constexpr double kUnpaired = 0.15;      // of the lit pixels; what moves stays below
constexpr double kPartUnpaired = 0.02;  // where the other pairs are good: a part of an image is late
constexpr double kTimesUsual = 5;
constexpr double kDarker = 0.05;  // of the pixels that white lights
constexpr double kJumping = 0.5;  // of a plane's borders
constexpr double kMinPace = 0.15;
constexpr double kSlowPace = 0.6;  // surfaces that lean by 45 degrees are slower or faster only in extreme setups
constexpr double kFastPace = 1.6;
constexpr double kAcross = 2;
constexpr double kBeyond = 0.05;  // of the codes
constexpr double kFewPoints = 1e-3;
constexpr double kFewOfUnmet = 0.02;  // points, where many codes meet no ray
constexpr double kUnmet = 0.3;
constexpr double kFewCodes = 0.05;
constexpr double kOffLine = 0.5;   // of the pixels of which both codes are on the projector
constexpr int kNone = -1;          // no Gray code
constexpr std::size_t kReach = 6;  // pixels from a clear pixel to the next, where a border may lie between them

int code_of_gray(int gray) {
  int code = gray;
  for (int shift = 1; shift < model::GrayDecoder::kMaxBits; shift *= 2) {
    code ^= code >> shift;
  }
  return code;
}

}  // namespace

SequenceCheck::SequenceCheck(int rows, int columns, int bits, bool cyclic)
    : bits_(bits), cyclic_(cyclic), side_(std::max(rows, columns)), images_(2 * static_cast<std::size_t>(bits)) {
  const auto all = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  const int every = static_cast<int>((all + kMostPixels - 1) / kMostPixels);
  for (int r = 0; r < rows; r += kTile) {
    for (int c = 0; c < columns; c += kTile) {
      if ((r / kTile + c / kTile) % every == 0) {
        tiles_.push_back({r, c, std::min(kTile, rows - r), std::min(kTile, columns - c), pixels_});
        pixels_ += static_cast<std::size_t>(tiles_.back().rows) * static_cast<std::size_t>(tiles_.back().columns);
      }
    }
  }
}

void SequenceCheck::add(int pattern, const model::ImageView& image) {
  std::vector<std::uint8_t>& to = images_[static_cast<std::size_t>(pattern)];
  taken_ += to.empty() ? 1 : 0;
  to.clear();
  to.reserve(pixels_);
  for (const Tile& tile : tiles_) {
    for (int r = 0; r < tile.rows; ++r) {
      const std::uint8_t* const from = image.pixels + (tile.row + r) * image.stride + tile.column;
      to.insert(to.end(), from, from + tile.columns);
    }
  }
}

SequenceCheck::Lit SequenceCheck::lit() const {
  Lit lit;
  lit.levels.resize(pixels_);
  for (std::size_t plane = 0; plane < images_.size(); plane += 2) {
    for (std::size_t i = 0; i < pixels_; ++i) {
      const int positive = images_[plane][i];
      const int negative = images_[plane + 1][i];
      const int contrast = std::abs(positive - negative);
      if (contrast > lit.levels[i].contrast) {
        lit.levels[i] = {contrast, positive + negative, plane};
      }
    }
  }
  // The sums of good pairs differ by the noise of two differences. The quarter that differs least leaves out bad pairs.
  std::array<std::size_t, 512> off{};
  std::size_t count = 0;
  for (std::size_t plane = 0; plane < images_.size(); plane += 2) {
    for (std::size_t i = 0; i < pixels_; ++i) {
      const Levels& at = lit.levels[i];
      const int sum = images_[plane][i] + images_[plane + 1][i];
      if (at.contrast >= kMinContrast && plane != at.plane &&
          4 * std::abs(images_[plane][i] - images_[plane + 1][i]) > 3 * at.contrast) {
        ++off.at(static_cast<std::size_t>(std::abs(sum - at.sum)));
        ++count;
      }
    }
  }
  // Whole grey values: those of q lie from q - 1/2 to q + 1/2.
  constexpr double kQuarterOfNormal = 0.3186;  // standard deviations within which a quarter lies
  double left = 0.25 * static_cast<double>(count);
  std::size_t quarter = 0;
  while (quarter + 1 < off.size() && left > static_cast<double>(off.at(quarter))) {
    left -= static_cast<double>(off.at(quarter));
    ++quarter;
  }
  const double share = left / std::max(1.0, static_cast<double>(off.at(quarter)));
  const double within = quarter == 0 ? 0.5 * share : static_cast<double>(quarter) - 0.5 + share;
  lit.noise = within / kQuarterOfNormal / std::numbers::sqrt2;
  lit.contrast = std::max(kMinContrast, static_cast<int>(std::ceil(kContrastDeviations * lit.noise)));
  return lit;
}

std::optional<SequenceCheck::Pair> SequenceCheck::unpaired() const {
  if (!complete() || bits_ < 2) {
    return std::nullopt;
  }
  const Lit lit = this->lit();
  std::vector<std::size_t> bad(static_cast<std::size_t>(bits_));
  std::vector<int> sums(bad.size());
  std::size_t count = 0;
  for (std::size_t i = 0; i < pixels_; ++i) {
    const Levels& at = lit.levels[i];
    if (at.contrast < lit.contrast) {
      continue;
    }
    ++count;
    for (std::size_t plane = 0; plane < sums.size(); ++plane) {
      sums[plane] = images_[2 * plane][i] + images_[2 * plane + 1][i];
    }
    // The pair with the most contrast may be the bad one itself.
    const auto middle = sums.begin() + static_cast<std::ptrdiff_t>(sums.size() / 2);
    std::nth_element(sums.begin(), middle, sums.end());
    const int usual_sum = sums.size() < 3 ? at.sum : *middle;
    for (std::size_t plane = 0; plane < bad.size(); ++plane) {
      const int positive = images_[2 * plane][i];
      const int negative = images_[2 * plane + 1][i];
      const int off = positive + negative - usual_sum;
      const bool clipped = off > 0 && std::max(positive, negative) >= UINT8_MAX - 5;
      bad[plane] +=
          std::abs(positive - negative) < kFlat * at.contrast && std::abs(off) > kOther * at.contrast && !clipped ? 1
                                                                                                                  : 0;
    }
  }
  if (count < kMinLit) {
    return std::nullopt;
  }
  const auto worst = std::max_element(bad.begin(), bad.end());
  const Pair pair{static_cast<int>(worst - bad.begin()), static_cast<double>(*worst) / static_cast<double>(count)};
  std::nth_element(bad.begin(), bad.begin() + (bits_ - 1) / 2, bad.end());
  const double usual = static_cast<double>(bad[static_cast<std::size_t>(bits_ - 1) / 2]) / static_cast<double>(count);
  const bool alone = pair.share > kPartUnpaired && pair.share > kTimesUsual * usual;
  return pair.share > kUnpaired || alone ? std::optional(pair) : std::nullopt;
}

// The bits of every lit pixel in `planes` planes from `first` on; kNone where a pair is not clear.
std::vector<int> SequenceCheck::gray_of(const Lit& lit, int first, int planes) const {
  std::vector<int> gray(pixels_, kNone);
  for (std::size_t i = 0; i < pixels_; ++i) {
    const int contrast = lit.levels[i].contrast;
    int bits = 0;
    bool clear = contrast >= lit.contrast;
    for (std::size_t plane = 0; plane < static_cast<std::size_t>(planes) && clear; ++plane) {
      const std::size_t image = 2 * (static_cast<std::size_t>(first) + plane);
      const int difference = images_[image][i] - images_[image + 1][i];
      clear = std::abs(difference) > kFlat * contrast;
      bits = 2 * bits + (difference > 0 ? 1 : 0);
    }
    gray[i] = clear ? bits : kNone;
  }
  return gray;
}

// Gives `look` the clear pixels of each row (direction 0) and column (1) of the tiles.
template <class Look>
void SequenceCheck::for_each_line(const std::vector<int>& gray, const Look& look) const {
  std::vector<Clear> line;
  for (const Tile& tile : tiles_) {
    const auto rows = static_cast<std::size_t>(tile.rows);
    const auto columns = static_cast<std::size_t>(tile.columns);
    for (std::size_t direction = 0; direction < 2; ++direction) {
      const auto [lines, length, next_line, next] = direction == 0 ? std::array{rows, columns, columns, std::size_t{1}}
                                                                   : std::array{columns, rows, std::size_t{1}, columns};
      for (std::size_t l = 0; l < lines; ++l) {
        line.clear();
        for (std::size_t at = 0; at < length; ++at) {
          if (const int code = gray[tile.first + l * next_line + at * next]; code != kNone) {
            line.push_back({at, code});
          }
        }
        look(direction, line);
      }
    }
  }
}

// How often the code changes from a pixel to the next, in the direction in which it does so more. Where a border lies,
// no pixel of its own may be clear.
double SequenceCheck::changes_of(const std::vector<int>& gray, std::size_t& distance) const {
  std::array<std::size_t, 2> changes{};
  std::array<std::size_t, 2> distances{};
  for_each_line(gray, [&](std::size_t direction, const std::vector<Clear>& line) {
    for (std::size_t i = 1; i < line.size(); ++i) {
      if (const std::size_t step = line[i].at - line[i - 1].at; step <= kReach) {
        changes.at(direction) += line[i].gray != line[i - 1].gray ? 1 : 0;
        distances.at(direction) += step;
      }
    }
  });
  const auto rate = [&](std::size_t direction) {
    return static_cast<double>(changes.at(direction)) /
           static_cast<double>(std::max<std::size_t>(1, distances.at(direction)));
  };
  distance = std::max(distances[0], distances[1]);
  return std::max(rate(0), rate(1));
}

std::vector<SequenceCheck::Jump> SequenceCheck::jumps_of(const std::vector<int>& gray, int planes) const {
  std::vector<Jump> jumps(static_cast<std::size_t>(planes));
  for_each_line(gray, [&](std::size_t /*direction*/, const std::vector<Clear>& line) {
    for (std::size_t i = 1; i + 2 < line.size(); ++i) {
      const int changed = line[i].gray ^ line[i + 1].gray;
      if (!std::has_single_bit(static_cast<unsigned>(changed)) || line[i + 1].at - line[i].at > kReach ||
          (((line[i - 1].gray ^ line[i].gray) | (line[i + 1].gray ^ line[i + 2].gray)) & changed) != 0) {
        continue;  // the bit of a single pixel may be noise
      }
      Jump& plane = jumps[static_cast<std::size_t>(planes - 1 - std::countr_zero(static_cast<unsigned>(changed)))];
      ++plane.borders;
      const int change = std::abs(code_of_gray(line[i].gray) - code_of_gray(line[i + 1].gray));
      plane.jumps += change != 1 && !(cyclic_ && change == (1 << planes) - 1) ? 1 : 0;
    }
  });
  return jumps;
}

// The first planes alone are a Gray code, too, of wider stripes. Of narrow ones two borders may lie between a pixel and
// the next.
std::optional<SequenceCheck::Jump> SequenceCheck::jumping() const {
  constexpr double kNarrow = 1.0 / 3;  // borders a pixel
  std::optional<Jump> worst;
  if (!complete()) {
    return worst;
  }
  const Lit lit = this->lit();
  for (int planes = 2; planes <= bits_; ++planes) {
    const std::vector<int> gray = gray_of(lit, 0, planes);
    std::size_t distance = 0;
    if (changes_of(gray, distance) > kNarrow) {
      break;
    }
    std::vector<Jump> jumps = jumps_of(gray, planes);
    for (int plane = 0; plane < planes; ++plane) {
      Jump& jump = jumps[static_cast<std::size_t>(plane)];
      jump.plane = plane;
      if (jump.borders >= kMinBorders &&
          static_cast<double>(jump.jumps) > kJumping * static_cast<double>(jump.borders) &&
          (!worst || jump.jumps > worst->jumps)) {
        worst = jump;
      }
    }
  }
  return worst;
}

std::optional<SequenceCheck::Coarse> SequenceCheck::coarser() const {
  constexpr double kFine = 0.1;  // borders a pixel
  constexpr double kTimes = 3;
  constexpr double kMany = 1.5;
  constexpr double kClear = 0.5;
  constexpr double kNyquist = 0.5;
  if (!complete()) {
    return std::nullopt;
  }
  const Lit lit = this->lit();
  std::vector<double> rates;
  std::vector<double> clear;
  for (int plane = 0; plane < bits_; ++plane) {
    const std::vector<int> gray = gray_of(lit, plane, 1);
    std::size_t distance = 0;
    rates.push_back(changes_of(gray, distance));
    clear.push_back(static_cast<double>(gray.size()) -
                    static_cast<double>(std::count(gray.begin(), gray.end(), kNone)));
  }
  for (std::size_t later = 1; later < rates.size(); ++later) {
    for (std::size_t plane = 0; plane < later; ++plane) {
      // Stripes narrower than the camera's pixels may look like wide ones, if those of the plane are as many as it has.
      const bool aliased = std::ldexp(rates[plane], static_cast<int>(later - plane)) > kNyquist &&
                           rates[plane] * side_ <= kMany * std::ldexp(1, static_cast<int>(plane));
      if (aliased) {
        continue;
      }
      const bool blurred = clear[plane] < kClear * clear[later];
      const bool finer = clear[later] >= kClear * clear[plane] && rates[plane] > std::max(kFine, kTimes * rates[later]);
      if (clear[later] >= static_cast<double>(kMinLit) && (blurred || finer)) {
        return Coarse{static_cast<int>(plane), static_cast<int>(later)};
      }
    }
  }
  return std::nullopt;
}

bool SequenceCheck::is_white_and_black(const model::ImageView& white, const model::ImageView& black) {
  std::size_t brighter = 0;
  std::size_t darker = 0;
  for (int r = 0; r < white.rows; ++r) {
    for (int c = 0; c < white.columns; ++c) {
      const int light = white.pixels[r * white.stride + c] - black.pixels[r * black.stride + c];
      brighter += light >= kMinContrast ? 1 : 0;
      darker += light <= -kMinContrast ? 1 : 0;
    }
  }
  return brighter >= kMinLit && static_cast<double>(darker) <= kDarker * static_cast<double>(brighter);
}

std::string contradiction_of(const SequenceCheck& check, const std::vector<std::string>& names) {
  if (const auto pair = check.unpaired()) {
    const auto first = 2 * static_cast<std::size_t>(pair->plane);
    return fmt::format(
        "{} and {} are no pattern and its negative: {:.0f} % of the lit pixels are dark in both or bright in both; is "
        "one "
        "of them late, missing or in another place?",
        names[first], names[first + 1], 100 * pair->share);
  }
  if (const auto jump = check.jumping()) {
    return fmt::format(
        "the images are in another order than pos0 neg0 pos1 neg1 ... from the most significant bit on, or positive "
        "and "
        "negative are exchanged: at {} of {} borders of {} the code jumps instead of counting on",
        jump->jumps, jump->borders, names[2 * static_cast<std::size_t>(jump->plane)]);
  }
  if (const auto coarse = check.coarser()) {
    return fmt::format(
        "the images are in another order than pos0 neg0 pos1 neg1 ... from the most significant bit on: the stripes of "
        "{} "
        "are narrower than those of {}",
        names[2 * static_cast<std::size_t>(coarse->plane)], names[2 * static_cast<std::size_t>(coarse->later)]);
  }
  return "";
}

std::vector<std::string> names_of_patterns(const std::string& uri, int patterns) {
  std::vector<std::string> names;
  for (int pattern = 1; pattern <= patterns; ++pattern) {
    names.push_back(fmt::format("{}: image {} of the sequence", uri, pattern));
  }
  return names;
}

std::optional<Pace> pace_of(const Triangulation& triangulation, const std::uint16_t* codes) {
  constexpr std::size_t kPairs = std::size_t{1} << 17U;
  constexpr int kMostChange = 3;  // codes; more is a step of the surface
  struct Way {
    double expected = 0;
    double made = 0;
    double net = 0;
    std::size_t borders = 0;
  };
  const auto columns = static_cast<std::size_t>(triangulation.columns());
  const std::size_t pixels = triangulation.pixels();
  const std::size_t every = pixels / kPairs + 1;
  std::vector<std::uint16_t> first(pixels);
  std::vector<std::uint16_t> same(pixels);
  std::vector<std::uint16_t> more(pixels);
  std::vector<float> z_first(pixels);
  std::vector<float> z_same(pixels);
  std::vector<float> z_more(pixels);
  std::vector<Way> ways;
  for (const std::size_t step : {std::size_t{1}, columns}) {
    const auto line_of = [&](std::size_t pixel) { return step == 1 ? pixel / columns : pixel % columns; };
    const auto change_at = [&](std::size_t next) {
      return (codes[next] & model::GrayDecoder::kCode) - (codes[next - step] & model::GrayDecoder::kCode);
    };
    // From a pixel to the next one: the depth of the first, and of the next with the same code and with one more.
    for (std::vector<std::uint16_t>* const words : {&first, &same, &more}) {
      std::fill(words->begin(), words->end(), std::uint16_t{0});
    }
    for (std::size_t next = step; next < pixels; ++next) {
      const std::size_t here = next - step;
      const bool measurable = ((codes[here] & codes[next]) & model::GrayDecoder::kMeasurable) != 0;
      if (line_of(next) % every == 0 && measurable && std::abs(change_at(next)) <= kMostChange &&
          line_of(here) == line_of(next) &&
          (codes[here] & model::GrayDecoder::kCode) < (1 << triangulation.bits()) - 1) {
        first[here] = same[next] = codes[here];
        more[next] = static_cast<std::uint16_t>(codes[here] + 1);
      }
    }
    triangulation.depth(first.data(), z_first.data());
    triangulation.depth(same.data(), z_same.data());
    triangulation.depth(more.data(), z_more.data());
    Way way;
    std::vector<int> net(std::max(columns, pixels / columns));
    for (std::size_t next = step; next < pixels; ++next) {
      const double move = static_cast<double>(z_same[next]) - static_cast<double>(z_first[next - step]);
      const double worth = static_cast<double>(z_more[next]) - static_cast<double>(z_same[next]);
      if (same[next] != 0 && !std::isnan(move) && !std::isnan(worth) && worth != 0) {
        const int change = change_at(next);
        const double expected = -move / worth;
        way.borders += change != 0 ? 1 : 0;
        way.expected += std::abs(expected);
        way.made += expected < 0 ? -change : change;
        net[line_of(next)] += change;
      }
    }
    way.net = std::accumulate(net.begin(), net.end(), 0.0, [](double sum, int line) { return sum + std::abs(line); });
    ways.push_back(way);
  }
  const Way& along = ways[ways[0].expected > ways[1].expected ? 0 : 1];
  const Way& across = ways[ways[0].expected > ways[1].expected ? 1 : 0];
  return along.borders >= kMinBorders && along.expected > 0
             ? std::optional(Pace{along.made / along.expected, across.net / std::max(1.0, along.net)})
             : std::nullopt;
}

std::string contradiction_of(const Triangulation& triangulation, const std::uint16_t* codes,
                             const DepthShares& shares) {
  const auto of = [&](PointState state) { return static_cast<double>(shares.of(state)); };
  const double measured = static_cast<double>(shares.total()) - of(PointState::not_measurable);
  if (measured < kMinLit) {
    return "";
  }
  if (of(PointState::no_line) > kBeyond * measured) {
    return fmt::format(
        "{:.0f} % of the codes belong to no line of the projector: are bits, lines and geometry those of the images, "
        "and are these the images of the axis that the geometry codes?",
        100 * of(PointState::no_line) / measured);
  }
  const double met = measured - of(PointState::no_line) - of(PointState::no_intersection);
  if (of(PointState::off_line) > kOffLine * met) {
    return fmt::format(
        "the codes of the two axes belong to no common point at {:.0f} % of the pixels: do the columns' images come "
        "first, and are lines, row lines and geometry those of the images?",
        100 * of(PointState::off_line) / std::max(1.0, met));
  }
  const std::optional<Pace> pace = pace_of(triangulation, codes);
  if (pace && (pace->along < kMinPace || (pace->along < kSlowPace && pace->across > kAcross))) {
    return "the code does not run across the image as the geometry says: is the picture mirrored, are positive and "
           "negative exchanged, are these the images of the projector's other axis (those of `selfproj pattern gray` "
           "begin with the columns; "
           "--row-bits takes both), or is the geometry that of another setup?";
  }
  const double unmet = of(PointState::no_line) + of(PointState::no_intersection) + of(PointState::off_line);
  if (of(PointState::valid) < kFewOfUnmet * measured && unmet > kUnmet * measured) {
    return fmt::format(
        "{:.1f} % of the pixels with a code have a point, and the codes of {:.0f} % contradict the geometry: are "
        "geometry, bits and lines those of the images?",
        100 * of(PointState::valid) / measured, 100 * unmet / measured);
  }
  if (of(PointState::valid) < kFewPoints * measured && of(PointState::out_of_range) > 0.5 * measured) {
    return fmt::format("{:.0f} % of the codes have a point outside of the limits of z: are these right?",
                       100 * of(PointState::out_of_range) / measured);
  }
  if (of(PointState::valid) < kFewPoints * measured) {
    return fmt::format(
        "{:.0f} of {:.0f} pixels with a code have a point: are bits, lines and geometry those of the images?",
        of(PointState::valid), measured);
  }
  return "";
}

std::string doubt_of(const Triangulation& triangulation, const std::uint16_t* codes) {
  const std::size_t pixels = triangulation.pixels();
  const auto coded = static_cast<double>(std::count_if(
      codes, codes + pixels, [](std::uint16_t code) { return (code & model::GrayDecoder::kMeasurable) != 0; }));
  if (kFewCodes * static_cast<double>(pixels) > std::max(coded, static_cast<double>(kMinLit))) {
    return fmt::format("{:.1f} % of the pixels have a code: is there enough light?",
                       100 * coded / static_cast<double>(pixels));
  }
  const std::optional<Pace> pace = pace_of(triangulation, codes);
  return !pace || (pace->along > kSlowPace && pace->along < kFastPace)
             ? ""
             : fmt::format(
                   "the code changes {:.2f} times as much across the image as on a surface of constant depth: do the "
                   "surfaces lean so much, or are bits, lines (--lines) or geometry not those of the images?",
                   pace->along);
}

}  // namespace selfproj::structured_light
