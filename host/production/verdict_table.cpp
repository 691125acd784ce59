#include "host/production/verdict_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <limits>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/files/numbers.h"
#include "host/light_section/rows.h"
#include "host/production/height_map.h"
#include "host/rig/geometry.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/light_section/strip_moments.h"
#include "selfproj/model/column_moments.h"

namespace selfproj::production {
namespace {

constexpr int kParts = model::kRowParts;

// A rig whose whole sensor counts, so that only geometry decides where there is a point.
rig::Rig whole_sensor(rig::Rig rig) {
  rig.camera.region.reset();
  rig.measure.window.reset();
  return rig;
}

enum class Lies : std::uint8_t { outside, across_the_border, inside };

// How the rectangle lies to the polygon: whether a side of the polygon runs through it, and whether its middle is
// inside.
Lies lies(const ToleranceRegion& region, double along0, double along1, double across0, double across1) {
  constexpr double kTouch = 1e-6;  // mm: sides may touch
  const double u0 = along0 + kTouch, u1 = along1 - kTouch, w0 = across0 + kTouch, w1 = across1 - kTouch;
  const double u = 0.5 * (along0 + along1), w = 0.5 * (across0 + across1);
  bool inside = false;
  const std::vector<double>& corners = region.corners_mm;
  for (std::size_t i = 0; i + 1 < corners.size(); i += 2) {
    const std::size_t next = (i + 2) % corners.size();
    const double au = corners[i], aw = corners[i + 1], bu = corners[next], bw = corners[next + 1];
    // The share of the side, from `from` to `to`, that is within the rectangle (Liang and Barsky)
    double from = 0, to = 1;
    for (const auto& [p, q] : {std::pair(au - bu, au - u0), std::pair(bu - au, u1 - au), std::pair(aw - bw, aw - w0),
                               std::pair(bw - aw, w1 - aw)}) {
      if (p == 0) {
        to = q < 0 ? -1 : to;
      } else {
        (p < 0 ? from : to) = p < 0 ? std::max(from, q / p) : std::min(to, q / p);
      }
    }
    if (from <= to) {
      return Lies::across_the_border;
    }
    if ((aw > w) != (bw > w) && u < au + (bu - au) * (w - aw) / (bw - aw)) {
      inside = !inside;
    }
  }
  return inside ? Lies::inside : Lies::outside;
}

// A rectangle that is larger by `more_mm` on each side; any other polygon as it is.
ToleranceRegion widened(ToleranceRegion region, double more_mm) {
  std::vector<double>& corners = region.corners_mm;
  std::array<double, 2> low{};  // along, across
  std::array<double, 2> high{};
  for (const std::size_t axis : {0U, 1U}) {
    low.at(axis) = high.at(axis) = corners[axis];
    for (std::size_t i = axis; i < corners.size(); i += 2) {
      low.at(axis) = std::min(low.at(axis), corners[i]);
      high.at(axis) = std::max(high.at(axis), corners[i]);
    }
  }
  const double area = (high[0] - low[0]) * (high[1] - low[1]);
  bool rectangle = corners.size() == 8;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    rectangle = rectangle && (corners[i] == low.at(i % 2) || corners[i] == high.at(i % 2));
  }
  if (rectangle && area > 0) {
    for (std::size_t i = 0; i < corners.size(); ++i) {
      corners[i] += corners[i] == low.at(i % 2) ? -more_mm : more_mm;
    }
  }
  return region;
}

// The limits that hold where both do: a column is out only if it is out of both.
model::ColumnLimits joined(const model::ColumnLimits& a, const model::ColumnLimits& b) {
  if (!a.judged || !b.judged) {
    return {};
  }
  return {.low = std::min(a.low, b.low), .high = std::max(a.high, b.high), .judged = true};
}

void join(std::vector<model::ColumnLimits>& to, const std::vector<model::ColumnLimits>& other) {
  std::transform(to.begin(), to.end(), other.begin(), to.begin(), joined);
}

// Out of `of` trials, each of this probability, at least `hits`.
double at_least(int hits, int of, double probability) {
  double sum = 0;
  double ways = 1;  // of choosing k
  for (int k = 0; k <= of; ++k) {
    if (k >= hits) {
      sum += ways * std::pow(probability, k) * std::pow(1 - probability, of - k);
    }
    ways *= static_cast<double>(of - k) / (k + 1);
  }
  return sum;
}

double beyond(double distance, double sigma) { return 0.5 * std::erfc(distance / (sigma * std::sqrt(2.0))); }

// Standard deviations by which the mean of `count` values must be beyond a limit, so that all are beyond it 999 times
// in 1000.
double deviations_of_all(int count) {
  constexpr double kMissed = 1e-3;
  double deviations = 0;
  while (count * beyond(deviations, 1) > kMissed) {
    deviations += 0.01;
  }
  return deviations;
}

void check_bands(const VerdictTable& table, const std::string& source) {
  for (const VerdictTable::Section& section : table.sections) {
    for (const model::ColumnLimits& limits : section.limits) {
      const std::uint32_t band = limits.judged ? limits.high - limits.low : 0;
      if (band > model::kMaxBand) {
        throw UserError(
            source, fmt::format("with a margin of {} mm makes bands of {:.1f} rows; a board takes less "
                                "than {}",
                                table.margin_mm, static_cast<double>(band) / kParts, (model::kMaxBand + 1) / kParts));
      }
    }
  }
}

std::ptrdiff_t judged_in(const VerdictTable::Section& section) {
  return std::count_if(section.limits.begin(), section.limits.end(), [](const auto& limits) { return limits.judged; });
}

// Parts by the encoder begin where the first limits hold and end behind the last, so that sections without limits, the
// first and the last, need no room in a board.
void leave_out_ends(VerdictTable& table) {
  std::vector<VerdictTable::Section>& sections = table.sections;
  if (sections.size() > 1 && judged_in(sections.back()) == 0) {
    table.rule.length = sections.back().begin;
    sections.pop_back();
  }
  if (sections.size() > 1 && judged_in(sections.front()) == 0) {
    const std::uint32_t first = sections[1].begin;
    sections.erase(sections.begin());
    for (VerdictTable::Section& section : sections) {
      section.begin -= first;
    }
    table.rule.start = (table.rule.start + first) & model::kCountMask;
    table.rule.length -= first;
  }
}

}  // namespace

int VerdictTable::judged() const {
  int count = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(columns); ++i) {
    count +=
        std::any_of(sections.begin(), sections.end(), [&](const Section& s) { return s.limits[i].judged; }) ? 1 : 0;
  }
  return count;
}

model::VerdictSettings shifted_settings(const VerdictTable& table, double across_mm, double higher_mm,
                                        const std::string& source) {
  model::VerdictSettings settings = table.settings;
  const double columns = std::round(across_mm / table.column_mm) + settings.shift_columns;
  const double rows = std::round(higher_mm / table.row_mm * kParts) + settings.shift_rows;
  if (!(std::abs(columns) <= table.max_shift_columns)) {
    throw UserError(source, fmt::format("its limits hold for shifts of up to {} columns; {:.3f} mm are {:.0f} "
                                        "(--max-shift of `selfproj verdict table`)",
                                        table.max_shift_columns, across_mm, columns));
  }
  if (!(std::abs(rows) <= model::kMaxShiftRows)) {
    throw UserError(source, fmt::format("a part cannot be {:.3f} mm higher: a shift has at most {:.0f} rows", higher_mm,
                                        static_cast<double>(model::kMaxShiftRows) / kParts));
  }
  settings.shift_columns = static_cast<int>(columns);
  settings.shift_rows = static_cast<int>(rows);
  return settings;
}

std::vector<std::string> never(const VerdictTable& table) {
  std::vector<std::string> found;
  const model::VerdictSettings& settings = table.settings;
  const int judged = table.judged();
  int longest = 0;  // stretch of neighbouring columns that are judged
  for (const VerdictTable::Section& section : table.sections) {
    int stretch = 0;
    for (const model::ColumnLimits& limits : section.limits) {
      stretch = limits.judged ? stretch + 1 : 0;
      longest = std::max(longest, stretch);
    }
  }
  if (judged == 0) {
    found.emplace_back("no column is judged");
  } else if (settings.width > longest) {
    found.push_back(
        fmt::format("there is never a defect: it takes {} neighbouring columns, and no more than {} are judged",
                    settings.width, longest));
  } else if (!settings.above && !settings.below) {
    found.emplace_back("there is never a defect: neither above nor below is asked for");
  }
  if (settings.most_unlit < model::kUnlitNotJudged && settings.most_unlit >= judged) {
    found.push_back(fmt::format("a frame never lacks light: {} columns are judged, and {} of them may be unlit", judged,
                                settings.most_unlit));
  }
  return found;
}

VerdictTables::VerdictTables(const rig::Rig& rig, const light_section::ReferenceProfile& reference,
                             const Tolerance& tolerance, const VerdictOptions& options, const std::string& source)
    : rig_(rig),
      sent_(rig.camera.sent()),
      tolerance_(tolerance),
      options_(options),
      source_(source),
      profiler_(whole_sensor(rig), reference),
      section_(section_of(whole_sensor(rig), reference, profiler_)),
      lit_rows_(options.lit_rows.value_or(light_section::usual_lit_rows(rig))) {
  if (!rig.parts || !rig.parts->by_encoder || !(rig.conveyor.encoder_mm_per_count > 0)) {
    throw UserError(rig.name,
                    "a verdict needs parts along a belt with an encoder that counts up: section `parts` with "
                    "belt: encoder, conveyor.encoder_mm_per_count greater than 0 (`selfproj calibrate belt --counts`)");
  }
  if (sent_.rows > spec::kMaxRows) {
    throw UserError(rig.name,
                    fmt::format("sends {} rows; boards for more than {} give no verdicts (camera.region takes "
                                "fewer)",
                                sent_.rows, spec::kMaxRows));
  }
  check_tolerance(tolerance, rig, section_, source);
  widest_mm_ = 3 * pixel_mm(rig);
  jumps_ = section_.jumps(rig, widest_mm_);
  std::transform(tolerance_.regions.begin(), tolerance_.regions.end(), std::back_inserter(widened_),
                 [&](const ToleranceRegion& region) { return widened(region, 0.5 * tolerance_.edge_mm.value_or(0)); });
  const light_section::LineRules rules =
      light_section::line_rules(rig.camera, rig.measure, sent_.row_offset, sent_.rows);
  first_ = static_cast<double>(rules.first) + sent_.row_offset;
  last_ = static_cast<double>(rules.last) + sent_.row_offset;
  frame_mm_ = options.frame_mm.value_or(rig.conveyor.speed_mm_per_s / sent_.frame_rate_hz);
  play_along_mm_ = options.play_along_mm.value_or(0.5 * lit_rows_ * pixel_mm(rig) + frame_mm_);
  light_mm_ = belt_view(rig).along_mm;
  sample();
  measure_scale();
}

// What the profiler says of each column at whole rows.
void VerdictTables::sample() {
  const auto columns = static_cast<std::size_t>(rig_.camera.columns);
  model::Moments moments;
  moments.resize(rig_.camera.columns);
  std::fill(moments.m0.begin(), moments.m0.end(), kParts);
  std::fill(moments.n.begin(), moments.n.end(), static_cast<std::uint32_t>(std::max(rig_.measure.min_lit_px, 1)));
  light_section::Profile profile;
  profile.resize(rig_.camera.columns);
  for (int row = 1; row <= rig_.camera.rows; ++row) {
    std::fill(moments.m1.begin(), moments.m1.end(), static_cast<std::uint32_t>(kParts * row));
    profiler_.profile(moments.view(), profile.view());
    for (std::size_t i = 0; i < columns; ++i) {
      const bool valid = profile.validity[i] == static_cast<std::uint8_t>(light_section::Validity::valid);
      height_.push_back(valid ? static_cast<float>(rig_.plane_z_mm - static_cast<double>(profile.z[i]))
                              : images::kNoValue);
      across_.push_back(valid ? profile.y[i] : images::kNoValue);
      along_.push_back(valid ? profile.x[i] : images::kNoValue);
    }
  }
}

void VerdictTables::measure_scale() {
  std::vector<double> columns;
  std::vector<double> rows;
  const Placed part = placed(0, play_along_mm_);
  for (const SeenRegion& region : part.regions) {
    for (int c = 0; c < rig_.camera.columns; ++c) {
      const auto i = static_cast<std::size_t>(c);
      if (!region.places[i]) {
        continue;
      }
      if (c > 0 && region.places[i - 1]) {
        columns.push_back(region.places[i]->across_mm - region.places[i - 1]->across_mm);
      }
      const ToleranceRegion& of = tolerance_.regions[static_cast<std::size_t>(&region - part.regions.data())];
      const int row = row_of(part, c, 0.5 * (of.low_mm + of.high_mm));
      rows.push_back(static_cast<double>(part.difference[at(row + 1, c)] - part.difference[at(row, c)]));
    }
  }
  if (columns.empty()) {
    throw UserError(source_, fmt::format("no column of {} sees a region of it", rig_.name));
  }
  // Regions are met one after another where heights differ and the light leans: from the middle of them.
  double first = 1e9;
  double last = -1e9;
  double end = -1e9;
  for (const SeenRegion& region : part.regions) {
    if (std::any_of(region.places.begin(), region.places.end(), [](const auto& at) { return at.has_value(); })) {
      first = std::min(first, region.along_mm);
      last = std::max(last, region.along_mm);
      end = std::max(end, region.along_mm + region.spread_mm);
    }
  }
  meets_mm_ = 0.5 * (first + last);
  reach_mm_ = end - meets_mm_;
  column_mm_ = files::median_of(columns);
  row_mm_ = files::median_of(rows);
}

// The row after which the difference of a column passes this value; 0 if it does nowhere, or more than once.
int VerdictTables::row_of(const Placed& part, int column, double difference_mm) const {
  int found = 0;
  for (int row = 1; row < rig_.camera.rows; ++row) {
    const auto a = static_cast<double>(part.difference[at(row, column)]) - difference_mm;
    const auto b = static_cast<double>(part.difference[at(row + 1, column)]) - difference_mm;
    if (!std::isnan(a) && !std::isnan(b) && (a < 0) != (b < 0)) {
      if (found != 0) {
        return 0;
      }
      found = row;
    }
  }
  return found;
}

VerdictTables::Placed VerdictTables::placed(double shift_mm, double play_along_mm) const {
  Placed part;
  part.shift_mm = shift_mm;
  part.play_along_mm = play_along_mm;
  part.difference.resize(height_.size());
  for (std::size_t i = 0; i < height_.size(); ++i) {
    part.difference[i] = static_cast<float>(static_cast<double>(height_[i]) -
                                            section_.at(static_cast<double>(across_[i]) - shift_mm, widest_mm_));
  }
  for (const ToleranceRegion& region : widened_) {
    SeenRegion seen;
    double left = 1e9;
    double right = -1e9;
    for (std::size_t i = 1; i < region.corners_mm.size(); i += 2) {
      left = std::min(left, region.corners_mm[i]);
      right = std::max(right, region.corners_mm[i]);
    }
    double low = 1e9;
    double high = -1e9;
    for (int c = 0; c < rig_.camera.columns; ++c) {
      auto& place = seen.places.emplace_back();
      const double middle = 0.5 * (region.low_mm + region.high_mm);
      const int row = row_of(part, c, middle);
      if (row == 0) {
        continue;
      }
      const std::size_t above = at(row, c);
      const std::size_t below = at(row + 1, c);
      const auto from = static_cast<double>(part.difference[above]);
      const double share = (middle - from) / (static_cast<double>(part.difference[below]) - from);
      const auto between = [&](const std::vector<float>& values) {
        return (1 - share) * static_cast<double>(values[above]) + share * static_cast<double>(values[below]);
      };
      const double across = between(across_);
      const bool at_jump = std::any_of(jumps_.begin(), jumps_.end(),
                                       [&](const auto& jump) { return across > jump.first && across < jump.second; });
      const double on_part = across - shift_mm;
      if (at_jump || on_part < left || on_part > right) {
        continue;
      }
      const double per_mm =
          static_cast<double>(across_[below] - across_[above]) / (static_cast<double>(part.difference[below]) - from);
      const double along = between(along_) - light_mm_ - meets_mm_;
      place =
          SeenPlace{on_part, along, std::abs(per_mm) * (0.5 * (region.high_mm - region.low_mm) + options_.margin_mm)};
      low = std::min(low, along);
      high = std::max(high, along);
    }
    if (low <= high) {
      seen.along_mm = 0.5 * (low + high);
      seen.spread_mm = 0.5 * (high - low);
    }
    part.regions.push_back(std::move(seen));
  }
  return part;
}

// Where, along the belt from the part's beginning, a column may begin or cease to be judged.
std::vector<double> VerdictTables::boundaries(const Placed& part) const {
  std::vector<double> result;
  for (std::size_t r = 0; r < part.regions.size(); ++r) {
    const double play = part.play_along_mm + part.regions[r].spread_mm;
    for (const ToleranceRegion* const region : {&tolerance_.regions[r], &widened_[r]}) {
      for (std::size_t i = 0; i < region->corners_mm.size(); i += 2) {
        result.push_back(region->corners_mm[i] + part.regions[r].along_mm - play);
        result.push_back(region->corners_mm[i] + part.regions[r].along_mm + play);
      }
    }
  }
  return result;
}

// The surface of a region goes on in the strip that the tolerance leaves out along edges and walls. Half of it is
// judged as the region is, as far as it belongs to no other region, and the pattern does not jump there. The other half
// is where the line and the cells of a map see both sides of the edge.
bool VerdictTables::in_strip(std::size_t region, double along0, double along1, double across0, double across1) const {
  const double edge = 0.5 * tolerance_.edge_mm.value_or(0);
  if (edge == 0 || along0 < edge || along1 > tolerance_.length_mm - edge || across0 < tolerance_.left_mm + edge ||
      across1 > tolerance_.right_mm - edge || std::any_of(jumps_.begin(), jumps_.end(), [&](const auto& jump) {
        return across1 > jump.first && across0 < jump.second;
      })) {
    return false;
  }
  for (std::size_t other = 0; other < widened_.size(); ++other) {
    const Lies there =
        lies(other == region ? widened_[other] : tolerance_.regions[other], along0, along1, across0, across1);
    if (there != (other == region ? Lies::inside : Lies::outside)) {
      return false;
    }
  }
  return true;
}

VerdictTables::Wanted VerdictTables::wanted(const Placed& part, double from_mm, double to_mm) const {
  Wanted result(static_cast<std::size_t>(rig_.camera.columns));
  for (std::size_t r = 0; r < part.regions.size(); ++r) {
    const SeenRegion& seen = part.regions[r];
    const ToleranceRegion& region = tolerance_.regions[r];
    for (std::size_t c = 0; c < result.size(); ++c) {
      if (!seen.places[c]) {
        continue;
      }
      const double across = seen.places[c]->across_mm;
      const double play = options_.play_across_mm + seen.places[c]->play_mm;
      const double from = from_mm - seen.places[c]->along_mm - part.play_along_mm;
      const double to = to_mm - seen.places[c]->along_mm + part.play_along_mm;
      if (lies(region, from, to, across - play, across + play) != Lies::inside) {
        if (!result[c] && in_strip(r, from, to, across - play, across + play)) {
          result[c] = Range{region.low_mm, region.high_mm};
        }
        continue;
      }
      const Range before = result[c].value_or(Range{region.low_mm, region.high_mm});
      result[c] = Range{std::max(before.low, region.low_mm), std::min(before.high, region.high_mm)};
      if (!(result[c]->low < result[c]->high)) {
        throw UserError(source_, fmt::format("region '{}' has no height in common with another one at ({:.2f}, {:.2f}) "
                                             "mm",
                                             region.name, 0.5 * (from + to), across));
      }
    }
  }
  return result;
}

// By bisection: for each column the last row, in 1/kRowParts, on both sides that is outside.
VerdictTables::Limits VerdictTables::limits(const Placed& part, const Wanted& wanted) const {
  const auto columns = static_cast<std::size_t>(rig_.camera.columns);
  const double sign = row_mm_ < 0 ? -1 : 1;
  // Heights are 32-bit floats near plane_z: three units in their last place.
  const double rounding = 3.6e-7 * rig_.plane_z_mm;
  struct Search {
    std::uint32_t outside = 0, inside = 0;
    double bound = 0;  // of sign * difference
  };
  // Of each column above and below
  std::array<std::vector<Search>, 2> searches{std::vector<Search>(columns), std::vector<Search>(columns)};
  std::vector<bool> judged(columns, false);
  for (int c = 0; c < rig_.camera.columns; ++c) {
    const auto i = static_cast<std::size_t>(c);
    if (!wanted[i]) {
      continue;
    }
    const int middle = row_of(part, c, 0.5 * (wanted[i]->low + wanted[i]->high));
    const double low = wanted[i]->low - options_.margin_mm - rounding;
    const double high = wanted[i]->high + options_.margin_mm + rounding;
    const std::array<double, 2> bounds = {sign > 0 ? low : -high, sign > 0 ? high : -low};
    judged[i] = middle != 0;
    for (const int side : {0, 1}) {
      const int step = side == 0 ? -1 : 1;
      const auto value = [&](int row) { return sign * static_cast<double>(part.difference[at(row, c)]); };
      int row = side == 0 ? middle + 1 : middle;
      bool outside = false;
      while (judged[i] && !outside) {
        const int next = row + step;
        // Heights must go on to rise or fall. NaN is not greater than anything.
        judged[i] = next >= 1 && next <= rig_.camera.rows && step * (value(next) - value(row)) > 0;
        outside = judged[i] && (side == 0 ? value(next) < bounds[0] : value(next) > bounds[1]);
        row = outside ? row : next;
      }
      if (judged[i]) {
        searches.at(static_cast<std::size_t>(side))[i] = {static_cast<std::uint32_t>(kParts * (row + step)),
                                                          static_cast<std::uint32_t>(kParts * row),
                                                          bounds.at(static_cast<std::size_t>(side))};
      }
    }
  }
  model::Moments moments;
  moments.resize(rig_.camera.columns);
  std::fill(moments.m0.begin(), moments.m0.end(), kParts);
  std::fill(moments.n.begin(), moments.n.end(), static_cast<std::uint32_t>(std::max(rig_.measure.min_lit_px, 1)));
  light_section::Profile profile;
  profile.resize(rig_.camera.columns);
  for (const std::size_t side : {0U, 1U}) {
    for (int width = kParts; width > 1; width /= 2) {
      for (std::size_t i = 0; i < columns; ++i) {
        moments.m1[i] = (searches.at(side)[i].outside + searches.at(side)[i].inside) / 2;
      }
      profiler_.profile(moments.view(), profile.view());
      for (std::size_t i = 0; i < columns; ++i) {
        if (judged[i]) {
          const double difference = sign * (rig_.plane_z_mm - static_cast<double>(profile.z[i]) -
                                            section_.at(static_cast<double>(profile.y[i]) - part.shift_mm, widest_mm_));
          Search& search = searches.at(side)[i];
          judged[i] = !std::isnan(difference);
          (side == 0 ? difference < search.bound : difference > search.bound) ? search.outside = moments.m1[i]
                                                                              : search.inside = moments.m1[i];
        }
      }
    }
  }
  Limits result(columns);
  for (std::size_t i = 0; i < columns; ++i) {
    const double half = 0.5 * lit_rows_;
    const std::uint32_t low = searches[0][i].outside;
    const std::uint32_t high = searches[1][i].outside;
    // The line leaves the outermost rows dark (line_is_cut_off).
    if (judged[i] && static_cast<double>(low) / kParts - half >= first_ + 0.5 &&
        static_cast<double>(high) / kParts + half <= last_ - 0.5) {
      const auto offset = static_cast<std::uint32_t>(kParts * sent_.row_offset);
      result[i] = {.low = low - offset, .high = high - offset, .judged = true};
    }
  }
  return result;
}

// The limits of all columns of the sensor between each of these places and the next; none behind the last.
std::vector<VerdictTables::Limits> VerdictTables::limits_of_stretches(const Placed& part,
                                                                      const std::vector<double>& begins) const {
  std::vector<Placed> beside;
  if (options_.play_across_mm > 0) {
    beside = {placed(part.shift_mm - options_.play_across_mm, 0), placed(part.shift_mm + options_.play_across_mm, 0)};
  }
  std::vector<Limits> result;
  Wanted before;
  for (std::size_t b = 0; b < begins.size(); ++b) {
    const bool last = b + 1 == begins.size();
    const Wanted here =
        last ? Wanted(static_cast<std::size_t>(rig_.camera.columns)) : wanted(part, begins[b], begins[b + 1]);
    if (!result.empty() && here == before) {
      result.push_back(result.back());
      continue;
    }
    before = here;
    result.push_back(limits(part, here));
    for (const Placed& other : beside) {
      join(result.back(), limits(other, here));
    }
  }
  return result;
}

VerdictTable VerdictTables::table(double shift_mm) const {
  VerdictTable table = this->table(shift_mm, play_along_mm_);
  if (table.rule.by_encoder) {
    leave_out_ends(table);
  }
  return table;
}

VerdictTable VerdictTables::table(const Placement& placement) const {
  // Edges are located to half a cell of the map. A turned part comes earlier on one side and later on the other.
  const double half_width = std::max(std::abs(tolerance_.left_mm), std::abs(tolerance_.right_mm));
  return table(placement.across_mm,
               0.5 * (frame_mm_ + rig_.parts->grid_mm) + half_width * std::abs(std::sin(placement.turn_rad)));
}

VerdictTable VerdictTables::table(double shift_mm, double play_along_mm) const {
  VerdictTable table{.rig = rig_.name,
                     .columns = sent_.columns,
                     .rows = sent_.rows,
                     .row_offset = sent_.row_offset,
                     .column_offset = sent_.column_offset,
                     .column_mm = column_mm_,
                     .row_mm = row_mm_,
                     .margin_mm = options_.margin_mm,
                     .play_across_mm = options_.play_across_mm,
                     .play_along_mm = play_along_mm,
                     .lit_rows = lit_rows_,
                     .section_mm = options_.section_mm,
                     .frame_mm = options_.frame_mm,
                     .shift_mm = shift_mm,
                     .encoder_mm_per_count = rig_.conveyor.encoder_mm_per_count};
  table.max_shift_columns = static_cast<int>(std::ceil(options_.max_shift_mm / std::abs(column_mm_) - 1e-9));
  if (table.max_shift_columns > model::kMaxShiftColumns) {
    throw UserError("--max-shift", fmt::format("is {} columns; at most {} can be set", table.max_shift_columns,
                                               model::kMaxShiftColumns));
  }
  const int most = table.max_shift_columns;
  std::vector<double> begins = {0};
  for (int s = -most; s <= most && !options_.section_mm; ++s) {
    const std::vector<double> more = boundaries(placed(shift_mm + s * column_mm_, play_along_mm));
    begins.insert(begins.end(), more.begin(), more.end());
  }
  if (options_.section_mm.value_or(2 * frame_mm_) < 2 * frame_mm_) {
    throw UserError("--section", fmt::format("is {:g} mm; it must be two frames or more, {:.3g} mm",
                                             *options_.section_mm, 2 * frame_mm_));
  }
  const double end = length_counts() * rig_.conveyor.encoder_mm_per_count;
  while (options_.section_mm && begins.back() < end) {
    begins.push_back(begins.back() + *options_.section_mm);
  }
  std::sort(begins.begin(), begins.end());
  begins.erase(std::remove_if(begins.begin(), begins.end(), [](double begin) { return begin < 0; }), begins.end());
  // Column c has the limits that hold for it wherever the part may be.
  std::vector<Limits> limits(begins.size(), Limits(static_cast<std::size_t>(rig_.camera.columns)));
  for (int s = -most; s <= most; ++s) {
    const std::vector<Limits> here = limits_of_stretches(placed(shift_mm + s * column_mm_, play_along_mm), begins);
    for (std::size_t b = 0; b < begins.size(); ++b) {
      for (int c = 0; c < rig_.camera.columns; ++c) {
        // Where its limits are moved out of the image, they are not used.
        const int seen = std::clamp(c + s, 0, rig_.camera.columns - 1);
        model::ColumnLimits& to = limits[b][static_cast<std::size_t>(c)];
        const model::ColumnLimits& from = here[b][static_cast<std::size_t>(seen)];
        to = s == -most ? from : joined(to, from);
      }
    }
  }
  const auto add = [&](double begin, const Limits& of_sensor) {
    const auto first = of_sensor.begin() + sent_.column_offset;
    VerdictTable::Section section{
        .begin = static_cast<std::uint32_t>(std::ceil(begin / rig_.conveyor.encoder_mm_per_count - 1e-9)),
        .limits = {first, first + sent_.columns}};
    if (table.sections.empty() || table.sections.back().limits != section.limits) {
      table.sections.push_back(std::move(section));
    }
  };
  // One section begins with each frame, at most. Where several would begin within a few frames, there is one in their
  // place whose limits hold in all of them, before and behind.
  const double shortest = 2 * frame_mm_;
  for (std::size_t b = 0; b < begins.size();) {
    std::size_t last = b;
    while (last + 1 < begins.size() && begins[last + 1] - begins[last] < shortest) {
      ++last;
    }
    if (last > b) {
      Limits between = b > 0 ? limits[b - 1] : limits[b];
      for (std::size_t i = b; i <= last; ++i) {
        join(between, limits[i]);
      }
      add(begins[b], between);
    }
    add(last > b ? std::max(begins[last], begins[b] + shortest) : begins[b], limits[last]);
    b = last + 1;
  }
  if (table.sections.size() > kMaxVerdictSections) {
    throw UserError(source_, fmt::format("there are {} sections along the part; a table has at most {}",
                                         table.sections.size(), kMaxVerdictSections));
  }
  check_bands(table, source_);
  if (table.judged() == 0) {
    throw UserError(source_,
                    fmt::format("no column of {} can be judged: regions are narrower or shorter than the "
                                "plays of {} mm across and {:.3g} mm along leave, or the line does not stay "
                                "within rows {} to {} with a margin of {} mm",
                                rig_.name, options_.play_across_mm, play_along_mm, first_, last_, options_.margin_mm));
  }
  set_rule(table, shift_mm);
  set_settings(table);
  return table;
}

void VerdictTables::set_rule(VerdictTable& table, double shift_mm) const {
  if (options_.start) {
    table.rule.by_encoder = true;
    table.rule.start = *options_.start;
    table.rule.length = length_counts();
    table.rule.pitch = options_.pitch.value_or(0);
    if (table.rule.pitch <= table.rule.length) {
      throw UserError("--pitch", fmt::format("is {} counts; a part takes {}", table.rule.pitch, table.rule.length));
    }
    return;
  }
  // Columns that are lit while there is no part, and those that are lit while there is one.
  int without = 0;
  int with = 0;
  const Placed part = placed(shift_mm, play_along_mm_);
  for (int c = sent_.column_offset; c < sent_.column_offset + sent_.columns; ++c) {
    bool belt = false;
    for (int row = static_cast<int>(std::ceil(first_)); row < last_ && !belt; ++row) {
      const float a = height_[at(row, c)];
      const float b = height_[at(row + 1, c)];
      belt = !std::isnan(a) && !std::isnan(b) && (a < 0) != (b < 0);
    }
    const bool of_part = std::any_of(part.regions.begin(), part.regions.end(), [&](const SeenRegion& region) {
      return region.places[static_cast<std::size_t>(c)].has_value();
    });
    without += belt ? 1 : 0;
    with += belt || of_part ? 1 : 0;
  }
  constexpr int kMinColumns = 8;
  if (with - without < kMinColumns) {
    throw UserError("--start", fmt::format("is needed: {} columns see the line without a part already, and {} with "
                                           "one, so light does not tell where a part begins (or let only rows near "
                                           "the part count: measure.window of the rig)",
                                           without, with));
  }
  table.rule.lit = without + (with - without + 1) / 2;
  table.rule.dark_frames = std::clamp(static_cast<int>(std::ceil(rig_.parts->gap_mm / frame_mm_)), 1, 255);
}

double VerdictTables::leading_edge_mm(const Placement& placement) const {
  return placement.seen_along(0, 0.5 * (tolerance_.left_mm + tolerance_.right_mm)) + meets_mm_;
}

std::uint32_t VerdictTables::length_counts() const {
  return static_cast<std::uint32_t>(
      std::ceil((tolerance_.length_mm + reach_mm_ + play_along_mm_) / rig_.conveyor.encoder_mm_per_count));
}

double VerdictTables::noise_rows() const {
  const double share = rig_.camera.exposure_s > 0 ? std::min(sent_.exposure_s / rig_.camera.exposure_s, 1.0) : 1;
  return light_section::centroid_noise(rig_.imaging, light_section::kPeakOfWhite * rig_.imaging.white * share,
                                       lit_rows_,
                                       static_cast<double>(rig_.measure.threshold) / rig_.measure.values_per_grey());
}

// The mean number of places in a good part where noise alone makes a defect: at each the hits of `width` columns are
// there at once. Columns lie on the reference.
double VerdictTables::false_alarms(const VerdictTable& table) const {
  const double sigma = noise_rows();
  if (!std::isfinite(sigma)) {
    return std::numeric_limits<double>::infinity();
  }
  const double frames = tolerance_.length_mm / frame_mm_;
  const VerdictTable::Section& most = *std::max_element(
      table.sections.begin(), table.sections.end(),
      [](const VerdictTable::Section& a, const VerdictTable::Section& b) { return judged_in(a) < judged_in(b); });
  std::vector<double> out;
  double places = 0;
  for (std::size_t i = 0; i < most.limits.size(); ++i) {
    const model::ColumnLimits& limits = most.limits[i];
    double probability = 0;
    if (limits.judged) {
      // In the middle of its band, as a good part is learned to be
      const double half = 0.5 * (limits.high - limits.low) / kParts;
      probability = 2 * beyond(half, sigma);
    }
    out.push_back(at_least(table.settings.hits, table.settings.history, probability));
    if (static_cast<int>(out.size()) >= table.settings.width) {
      places += std::accumulate(out.end() - table.settings.width, out.end(), 1.0, std::multiplies<>());
    }
  }
  return frames * places;
}

void VerdictTables::set_settings(VerdictTable& table) const {
  const double side = std::sqrt(tolerance_.min_defect_mm2);
  const double column = std::abs(column_mm_);
  const auto whole = [](double value, int most) { return std::clamp(static_cast<int>(value), 1, most); };
  constexpr int kMaxWidth = 255;
  // No less than what the host takes for a defect, one point less than cells, as a point reaches the cells on both
  // sides of it; no more than the square within the defect that is asked for.
  int width = whole(std::round(side / column) - 1, kMaxWidth);
  int hits = whole(std::round(side / frame_mm_) - 1, model::kMaxHistory);
  int max_width = width;
  int max_hits = hits;
  if (options_.defect_across_mm && options_.defect_along_mm) {
    max_width = whole(*options_.defect_across_mm / std::sqrt(2.0) / column, kMaxWidth);
    max_hits = whole(*options_.defect_along_mm / std::sqrt(2.0) / frame_mm_, model::kMaxHistory);
    width = std::min(width, max_width);
    hits = std::min(hits, max_hits);
  }
  model::VerdictSettings& settings = table.settings;
  settings.above = options_.look_for == TooFar::either || (options_.look_for == TooFar::low) == (row_mm_ > 0);
  settings.below = options_.look_for == TooFar::either || (options_.look_for == TooFar::high) == (row_mm_ > 0);
  settings.most_unlit = options_.max_unlit.value_or(settings.most_unlit);
  for (;;) {
    settings.width = width;
    settings.hits = settings.history = hits;
    if ((width == max_width && hits == max_hits) || false_alarms(table) <= options_.false_alarms) {
      break;
    }
    // Whichever is the smaller share of what may be
    (hits < max_hits && (width == max_width || hits * max_width <= width * max_hits)) ? ++hits : ++width;
  }
}

VerdictFacts VerdictTables::facts(const VerdictTable& table) const {
  VerdictFacts facts;
  facts.frame_mm = frame_mm_;
  facts.narrowest_mm = std::numeric_limits<double>::infinity();
  for (const VerdictTable::Section& section : table.sections) {
    for (const model::ColumnLimits& limits : section.limits) {
      if (limits.judged) {
        const double half = 0.5 * (limits.high - limits.low) / kParts * std::abs(row_mm_);
        facts.narrowest_mm = std::min(facts.narrowest_mm, half);
        facts.widest_mm = std::max(facts.widest_mm, half);
      }
    }
  }
  facts.rounding_mm = std::abs(row_mm_) / kParts;
  double judged_mm2 = 0;
  for (std::size_t s = 0; s < table.sections.size(); ++s) {
    const std::uint32_t end = s + 1 < table.sections.size() ? table.sections[s + 1].begin
                              : table.rule.by_encoder       ? table.rule.length
                                                            : length_counts();
    const double length = (end - table.sections[s].begin) * rig_.conveyor.encoder_mm_per_count;
    judged_mm2 += length * std::abs(column_mm_) * static_cast<double>(judged_in(table.sections[s]));
  }
  double all_mm2 = 0;
  for (const ToleranceRegion& region : tolerance_.regions) {
    std::vector<cv::Point2f> corners;
    for (std::size_t i = 0; i + 1 < region.corners_mm.size(); i += 2) {
      corners.emplace_back(static_cast<float>(region.corners_mm[i]), static_cast<float>(region.corners_mm[i + 1]));
    }
    all_mm2 += cv::contourArea(corners);
  }
  facts.judged = std::min(judged_mm2 / all_mm2, 1.0);
  facts.found_across_mm = (table.settings.width + 1) * std::abs(column_mm_);
  facts.found_along_mm = (table.settings.hits + 1) * frame_mm_;
  facts.noise_mm = noise_rows() * std::abs(row_mm_);
  facts.found_depth_mm =
      2 * facts.widest_mm + deviations_of_all(table.settings.width * table.settings.hits) * facts.noise_mm;
  facts.false_alarms = false_alarms(table);
  facts.finds_defect = facts.found_across_mm <= options_.defect_across_mm.value_or(facts.found_across_mm) &&
                       facts.found_along_mm <= options_.defect_along_mm.value_or(facts.found_along_mm);
  return facts;
}

}  // namespace selfproj::production
