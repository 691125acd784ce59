#include "host/structured_light/match_table.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <vector>

#include "host/rig/geometry.h"
#include "host/structured_light/check.h"

namespace selfproj {
namespace {

constexpr int kSteps = 4;     // steps of the walk for each line
constexpr double kGap = 2.5;  // lines between pieces of one place

void check_all(const Rig& rig, const SelfReference& reference, const MatchSettings& settings) {
  check_stripes(reference.stripes);
  check(settings.e >= 0 && settings.e < 1 << reference.stripes.bits, "match: e is not in 0..2^m - 1");
  check(settings.line_width > 0, "match: a' is not greater than 0");
  check(reference.points.line.rows == rig.camera.rows && reference.points.line.columns == rig.camera.columns &&
            reference.row.rows == rig.projector.lines && reference.row.columns == rig.projector.columns,
        "match: the reference is for another rig");
}

constexpr int kNoCell = std::numeric_limits<int>::min();  // outside the projector's image

// The middle of a step. Steps count from the edge of the first line.
double line_at(int step) { return (step + 0.5) / kSteps - 0.5; }

}  // namespace

MatchSearch::MatchSearch(const Rig& rig, const SelfReference& reference, const MatchSettings& settings)
    : rig_(&rig), reference_(&reference), settings_(settings) {
  check_all(rig, reference, settings);
  for (int c = 0; c < rig.projector.columns; ++c) {
    for (int l = 0; l < rig.projector.lines; ++l) {
      cells_.push_back(reference.cell(l, c));
    }
  }
  const int period = 2 << reference.stripes.bits;  // of both codes, in cells
  for (int cell = 0; cell < period; ++cell) {
    codes_.push_back(code_of_cell(reference.stripes, cell));
  }
  for (int step = 0; step < rig.projector.lines * kSteps; ++step) {
    tan_theta_.push_back(tan_theta(rig.projector, line_at(step)));
  }
}

int MatchSearch::Path::column(double line) const { return static_cast<int>(std::floor(at_0 + slope * line + 0.5)); }

int MatchSearch::cell_on(const Path& path, int step) const {
  const RigProjector& projector = rig_->projector;
  const int column = path.column(line_at(step));
  return column < 0 || column >= projector.columns
             ? kNoCell
             : cells_[static_cast<std::size_t>(column) * static_cast<std::size_t>(projector.lines) +
                      static_cast<std::size_t>(step / kSteps)];
}

// The first step at which the ray meets the light in front of the camera.
int MatchSearch::first_step(double alpha) const {
  const RigProjector& projector = rig_->projector;
  const auto meets = [&](double tangent) {
    return alpha + tangent > 0 && projector.x_mm + projector.z_mm * tangent > 0;
  };
  const auto at = std::partition_point(tan_theta_.begin(), tan_theta_.end(), [&](double t) { return !meets(t); });
  return static_cast<int>(at - tan_theta_.begin());
}

// The line is straight, so two of its points determine it.
MatchSearch::Path MatchSearch::epipolar_line(double alpha, double beta) const {
  const RigProjector& p = rig_->projector;
  const auto point = [&](double z, double& line, double& column) {
    const double x = z * alpha - p.x_mm;
    const double depth = (z - p.z_mm) * std::cos(p.tilt_rad) - x * std::sin(p.tilt_rad);
    const double side = -(z - p.z_mm) * std::sin(p.tilt_rad) - x * std::cos(p.tilt_rad);
    line = 0.5 * (p.lines - 1) + (p.focal_length_mm * side / depth - p.center_xp_mm) / p.line_pitch_mm;
    column = 0.5 * (p.columns - 1) + (p.focal_length_mm * z * beta / depth - p.center_yp_mm) / p.column_pitch_mm;
  };
  double line_0 = 0;
  double column_0 = 0;
  double line_1 = 0;
  double column_1 = 0;
  point(rig_->plane_z_mm, line_0, column_0);
  point(0.5 * (rig_->plane_z_mm + p.z_mm), line_1, column_1);
  const double slope = (column_1 - column_0) / (line_1 - line_0);
  return {column_0 - slope * line_0, slope};
}

void MatchSearch::add(const Match& candidate, int cell, std::vector<Match>& matches) const {
  const int codes = 1 << reference_->stripes.bits;
  const double a = settings_.line_width;
  const bool inside = settings_.printed_window
                          ? candidate.distance >= -a * settings_.e && candidate.distance < a * (codes - settings_.e)
                          : candidate.steps >= -settings_.e && candidate.steps < codes - settings_.e;
  if (!inside) {
    return;
  }
  const auto period = static_cast<int>(codes_.size());
  const int code = codes_[static_cast<std::size_t>(((cell % period) + period) % period)];
  Match& match = matches[static_cast<std::size_t>(code)];
  // The edge between two cells follows whole projector pixels. A slanted line may cross it to and fro; the pieces are
  // one place.
  const double gap = candidate.line - candidate.half_width - match.line - match.half_width;
  if (match.candidates > 0 && match.steps == candidate.steps && gap < kGap) {
    const double begin = match.line - match.half_width;
    const double end = candidate.line + candidate.half_width;
    const double middle = 0.5 * (begin + end);
    match.distance += middle - match.line;
    match.line = middle;
    match.half_width = 0.5 * (end - begin);
    return;
  }
  const int candidates = match.candidates + 1;
  // The search goes towards the camera, so of equals the later one is taken.
  const bool nearer = settings_.printed_window ? std::abs(candidate.distance) <= std::abs(match.distance)
                                               : std::abs(candidate.steps) <= std::abs(match.steps);
  if (match.candidates == 0 || nearer) {
    match = candidate;
  }
  match.candidates = candidates;
}

bool MatchSearch::can_find(int row, int column) const {
  const auto pixel =
      static_cast<std::size_t>(row) * static_cast<std::size_t>(rig_->camera.columns) + static_cast<std::size_t>(column);
  const double alpha = tan_alpha(rig_->camera, row + 1.0);  // geometry.h counts rows of a centroid from 1
  return reference_->measurable(pixel) && rig_->projector.z_mm * alpha < rig_->projector.x_mm;
}

void MatchSearch::find(int row, int column, std::vector<Match>& matches) const {
  const Stripes& stripes = reference_->stripes;
  matches.assign(std::size_t{1} << static_cast<unsigned>(stripes.bits), Match{});
  const auto pixel =
      static_cast<std::size_t>(row) * static_cast<std::size_t>(rig_->camera.columns) + static_cast<std::size_t>(column);
  if (!can_find(row, column)) {
    return;
  }
  const double alpha = tan_alpha(rig_->camera, row + 1.0);
  const double beta = tan_beta(rig_->camera, column);
  const int own = cell_of_row(row, rig_->camera.rows, stripes.width);
  const double seen_line = static_cast<double>(reference_->points.line.values[pixel]);
  const double seen_column = static_cast<double>(reference_->points.column.values[pixel]);
  const Path path = settings_.printed_direction ? Path{seen_column, 0} : epipolar_line(alpha, beta);
  const int end = rig_->projector.lines * kSteps;
  for (int first = first_step(alpha); first < end;) {
    const int cell = cell_on(path, first);
    int last = first + 1;
    while (last < end && cell_on(path, last) == cell) {
      ++last;
    }
    if (cell != kNoCell) {
      const double middle = 0.5 * (line_at(first) + line_at(last - 1));
      add({middle, 0.5 * (last - first) / kSteps, own - cell, middle - seen_line, 1}, cell, matches);
    }
    first = last;
  }
}

MatchTable::MatchTable(const Rig& rig, const SelfReference& reference, const MatchSettings& settings)
    : rows_(rig.camera.rows),
      columns_(rig.camera.columns),
      bits_(reference.stripes.bits),
      plane_(static_cast<std::ptrdiff_t>(rig.camera.rows) * rig.camera.columns) {
  const MatchSearch search(rig, reference, settings);
  const int codes = 1 << bits_;
  words_.assign(static_cast<std::size_t>(codes) * static_cast<std::size_t>(plane_), GrayMatch::kNone);
  for (int r = 0; r < rows_; ++r) {
    own_.push_back(cell_of_row(r, rows_, reference.stripes.width));
  }
  std::vector<Match> matches;
  std::size_t shown = 0;
  std::size_t missing = 0;
  std::size_t doubled = 0;
  for (int r = 0; r < rows_; ++r) {
    for (int c = 0; c < columns_; ++c) {
      if (!search.can_find(r, c)) {
        continue;
      }
      search.find(r, c, matches);
      for (int code = 0; code < codes; ++code) {
        const Match& match = matches[static_cast<std::size_t>(code)];
        ++shown;
        missing += match.candidates == 0 ? 1 : 0;
        doubled += match.candidates > 1 ? 1 : 0;
        if (match.candidates > 0) {
          words_[static_cast<std::size_t>(row(r).of(static_cast<unsigned>(code)) - words_.data() + c)] =
              GrayMatch::word_of(match.line);
        }
      }
    }
  }
  if (shown > 0) {
    missing_ = static_cast<double>(missing) / static_cast<double>(shown);
    doubled_ = static_cast<double>(doubled) / static_cast<double>(shown);
  }
}

std::vector<std::uint16_t> MatchTable::by_pixels() const {
  const int codes = 1 << bits_;
  std::vector<std::uint16_t> table;
  table.reserve(static_cast<std::size_t>(rows_) * static_cast<std::size_t>(columns_) * static_cast<std::size_t>(codes));
  for (int r = 0; r < rows_; ++r) {
    for (int c = 0; c < columns_; ++c) {
      for (int code = 0; code < codes; ++code) {
        table.push_back(word(r, c, code));
      }
    }
  }
  return table;
}

}  // namespace selfproj
