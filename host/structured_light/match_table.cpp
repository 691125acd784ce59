#include "host/structured_light/match_table.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "host/rig/geometry.h"
#include "host/structured_light/check.h"

namespace selfproj::structured_light {
namespace {

constexpr int kSteps = 4;     // steps of the walk for each line
constexpr double kGap = 2.5;  // lines between pieces of one place

void check_all(const rig::Rig& rig, const SelfReference& reference, const MatchSettings& settings) {
  check_stripes(reference.stripes);
  check(settings.e >= 0 && settings.e < 1 << reference.stripes.bits, "match: e is not in 0..2^m - 1");
  check(settings.line_width > 0, "match: a' is not greater than 0");
  check(reference.points.line.rows == rig.camera.rows && reference.points.line.columns == rig.camera.columns &&
            reference.row.rows == rig.projector.lines && reference.row.columns == rig.projector.columns,
        "match: the reference is for another rig");
}

// The middle of a step. Steps count from the edge of the first line.
double line_at(int step) { return (step + 0.5) / kSteps - 0.5; }

}  // namespace

MatchSearch::MatchSearch(const rig::Rig& rig, const SelfReference& reference, const MatchSettings& settings)
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
    tan_theta_.push_back(rig::tan_theta(rig.projector, line_at(step)));
  }
  if (!rig.is_pinholes()) {
    optics_.emplace(rig);
    column_of_step_.resize(tan_theta_.size());
  }
}

int MatchSearch::Path::column(double line) const { return static_cast<int>(std::floor(at_0 + slope * line + 0.5)); }

// kNoCell outside the projector's image, too.
int MatchSearch::cell_at(int column, int step) const {
  const rig::RigProjector& projector = rig_->projector;
  return column < 0 || column >= projector.columns
             ? kNoCell
             : cells_[static_cast<std::size_t>(column) * static_cast<std::size_t>(projector.lines) +
                      static_cast<std::size_t>(step / kSteps)];
}

// The first step at which the ray meets the light in front of the camera.
int MatchSearch::first_step(double alpha) const {
  const rig::RigProjector& projector = rig_->projector;
  const auto meets = [&](double tangent) {
    return alpha + tangent > 0 && projector.x_mm + projector.z_mm * tangent > 0;
  };
  const auto at = std::partition_point(tan_theta_.begin(), tan_theta_.end(), [&](double t) { return !meets(t); });
  return static_cast<int>(at - tan_theta_.begin());
}

// The line is straight, so two of its points determine it.
MatchSearch::Path MatchSearch::epipolar_line(double alpha, double beta) const {
  const rig::RigProjector& p = rig_->projector;
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
  const double gap = std::abs(candidate.line - match.line) - candidate.half_width - match.half_width;
  if (match.candidates > 0 && match.steps == candidate.steps && gap < kGap) {
    const double begin = std::min(match.line - match.half_width, candidate.line - candidate.half_width);
    const double end = std::max(match.line + match.half_width, candidate.line + candidate.half_width);
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
  if (!reference_->measurable(pixel)) {
    return false;
  }
  if (optics_) {
    return !curve({static_cast<double>(row), static_cast<double>(column)}).empty();
  }
  const double alpha = rig::tan_alpha(rig_->camera, row + 1.0);  // geometry.h counts rows of a centroid from 1
  return rig_->projector.z_mm * alpha < rig_->projector.x_mm;
}

// Steps first..last - 1 lie in the cell.
void MatchSearch::add_run(int first, int last, int cell, const Own& own, std::vector<Match>& matches) const {
  if (cell != kNoCell) {
    const double middle = 0.5 * (line_at(first) + line_at(last - 1));
    add({middle, 0.5 * (last - first) / kSteps, own.cell - cell, middle - own.line, 1}, cell, matches);
  }
}

void MatchSearch::find(int row, int column, std::vector<Match>& matches) const {
  const Stripes& stripes = reference_->stripes;
  matches.assign(std::size_t{1} << static_cast<unsigned>(stripes.bits), Match{});
  const auto pixel =
      static_cast<std::size_t>(row) * static_cast<std::size_t>(rig_->camera.columns) + static_cast<std::size_t>(column);
  if (!reference_->measurable(pixel)) {
    return;
  }
  const Own own{cell_of_row(row, rig_->camera.rows, stripes.width),
                static_cast<double>(reference_->points.line.values[pixel]),
                static_cast<double>(reference_->points.column.values[pixel])};
  if (optics_) {
    find_through_lenses({static_cast<double>(row), static_cast<double>(column)}, own, matches);
    return;
  }
  if (!can_find(row, column)) {
    return;
  }
  const double alpha = rig::tan_alpha(rig_->camera, row + 1.0);
  const double beta = rig::tan_beta(rig_->camera, column);
  const Path path = settings_.printed_direction ? Path{own.column, 0} : epipolar_line(alpha, beta);
  const auto cell_on = [&](int step) { return cell_at(path.column(line_at(step)), step); };
  const int end = rig_->projector.lines * kSteps;
  for (int first = first_step(alpha); first < end;) {
    const int cell = cell_on(first);
    int last = first + 1;
    while (last < end && cell_on(last) == cell) {
      ++last;
    }
    add_run(first, last, cell, own, matches);
    first = last;
  }
}

// Places of the projector along the pixel's ray, in the order of its lines: as far as its image goes, or the lens
// model. Empty if the ray meets no light.
std::vector<rig::ProjectorPlace> MatchSearch::curve(const rig::CameraPlace& place) const {
  constexpr int kParts = 16;
  constexpr int kPlaces = 49;
  const std::optional<cv::Vec2d> ray = optics_->ray(place);
  const rig::RigProjector& projector = rig_->projector;
  const auto meet = [&](int part) {
    const double line = -0.5 + static_cast<double>(projector.lines) * part / kParts;
    return optics_->meet(*ray, {line, 0, 0.5 * (projector.columns - 1)});
  };
  std::optional<double> first;
  std::optional<double> last;
  for (int part = 0; ray && part <= kParts && !first; ++part) {
    first = meet(part);
  }
  for (int part = kParts; ray && first && part >= 0 && !last; --part) {
    last = meet(part);
  }
  return first && last && *first != *last ? optics_->epipolar_line(*ray, *first, *last, kPlaces)
                                          : std::vector<rig::ProjectorPlace>();
}

// Writes the projector columns of the curve's steps, linear between its places, and returns the first step and the one
// after the last.
std::pair<int, int> MatchSearch::columns_along(const std::vector<rig::ProjectorPlace>& curve) const {
  const int end = rig_->projector.lines * kSteps;
  const auto step_of = [](double line) { return (line + 0.5) * kSteps - 0.5; };
  const int first = std::clamp(static_cast<int>(std::ceil(step_of(curve.front().line))), 0, end);
  const int last = std::clamp(static_cast<int>(std::floor(step_of(curve.back().line))) + 1, first, end);
  std::size_t k = 0;
  for (int step = first; step < last; ++step) {
    const double line = line_at(step);
    while (k + 2 < curve.size() && curve[k + 1].line < line) {
      ++k;
    }
    const double t = (line - curve[k].line) / (curve[k + 1].line - curve[k].line);
    const double column = curve[k].column + t * (curve[k + 1].column - curve[k].column);
    column_of_step_[static_cast<std::size_t>(step)] = static_cast<int>(std::floor(column + 0.5));
  }
  return {first, last};
}

void MatchSearch::find_through_lenses(const rig::CameraPlace& place, const Own& own,
                                      std::vector<Match>& matches) const {
  const std::vector<rig::ProjectorPlace> curve = this->curve(place);
  if (curve.empty()) {
    return;
  }
  const auto [begin, end] = columns_along(curve);
  const auto cell_on = [&](int step) {
    const int column = settings_.printed_direction ? static_cast<int>(std::floor(own.column + 0.5))
                                                   : column_of_step_[static_cast<std::size_t>(step)];
    return cell_at(column, step);
  };
  // The search goes towards the camera.
  const int way = optics_->lines_rise() ? 1 : -1;
  const int from = way > 0 ? begin : end - 1;
  const int to = way > 0 ? end : begin - 1;
  for (int first = from; first != to;) {
    const int cell = cell_on(first);
    int last = first + way;
    while (last != to && cell_on(last) == cell) {
      last += way;
    }
    add_run(std::min(first, last - way), std::max(first, last - way) + 1, cell, own, matches);
    first = last;
  }
}

MatchTable::MatchTable(const rig::Rig& rig, const SelfReference& reference, const MatchSettings& settings)
    : rows_(rig.camera.rows),
      columns_(rig.camera.columns),
      bits_(reference.stripes.bits),
      plane_(static_cast<std::ptrdiff_t>(rig.camera.rows) * rig.camera.columns) {
  const MatchSearch search(rig, reference, settings);
  const int codes = 1 << bits_;
  words_.assign(static_cast<std::size_t>(codes) * static_cast<std::size_t>(plane_), model::GrayMatch::kNone);
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
              model::GrayMatch::word_of(match.line);
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

}  // namespace selfproj::structured_light
