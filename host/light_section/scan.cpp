#include "host/light_section/scan.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "host/light_section/line_finder.h"
#include "host/light_section/pattern.h"
#include "host/rig/geometry.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/rig/optics.h"

namespace selfproj::light_section {
namespace {

// By how many rows the image of the line moves on the plane from one line to the next.
double rows_per_line(const rig::Rig& rig) {
  const double depth = rig.plane_z_mm - rig.projector.z_mm;
  const double line = rig::line_on_middle(rig.projector, rig.plane_z_mm);
  const double x_per_line =
      depth * (rig::tan_theta(rig.projector, line + 0.5) - rig::tan_theta(rig.projector, line - 0.5));
  return std::abs(x_per_line) / rig.plane_z_mm * rig.camera.focal_length_mm / rig.camera.pixel_pitch_mm;
}

// The same through the lenses, from two rows in the middle of the image.
double lens_rows_per_line(const rig::Rig& rig) {
  const rig::RigOptics optics(rig);
  const double row = rig::middle_row(rig.camera) - 1;
  const double column = 0.5 * (rig.camera.columns - 1);
  const auto line_at = [&](double at_row) {
    const std::optional<cv::Vec2d> ray = optics.ray({at_row, column});
    const double z = rig.plane_z_mm;
    const auto light = ray ? optics.lit_by({(*ray)[0] * z, (*ray)[1] * z, z}) : std::nullopt;
    return light ? light->line : rig::kUnknown;
  };
  return 1 / std::abs(line_at(row + 0.5) - line_at(row - 0.5));
}

}  // namespace

std::vector<int> sweep_lines(const rig::Rig& rig, int every) {
  const double half = 0.5 * rig.measure.line_width_px;
  std::vector<int> lines;
  for (int line = 0; line < rig.projector.lines; line += every) {
    if (line - half >= -0.5 && line + half <= rig.projector.lines - 0.5) {
      lines.push_back(line);
    }
  }
  return lines;
}

void add_sightings(LineFinder& finder, double line, const model::ImageView& image, std::vector<LineSighting>& seen) {
  finder.find(image);
  for (std::size_t i = 0; i < finder.columns(); ++i) {
    if (finder.has_line(i)) {
      seen.push_back({line, finder.centroid(i) - 1, static_cast<int>(i), finder.light(i)});
    }
  }
}

void leave_out_reflections(const rig::Rig& rig, std::vector<LineSighting>& seen) {
  const LineFinder finder(rig);
  std::vector<double> most(static_cast<std::size_t>(rig.camera.columns), 0);
  const auto most_of = [&](const LineSighting& s) -> double& { return most[static_cast<std::size_t>(s.column)]; };
  for (const LineSighting& s : seen) {
    most_of(s) = std::max(most_of(s), s.light);
  }
  std::erase_if(seen, [&](const LineSighting& s) { return s.light < finder.least_light(most_of(s)); });
}

LineScan::LineScan(const rig::Rig& rig, int every)
    : rig_(rig),
      finder_(rig),
      max_gap_(3.0 * every),
      sightings_(static_cast<std::size_t>(rig.camera.columns)),
      most_light_(static_cast<std::size_t>(rig.camera.columns)) {
  constexpr double kRows = 4;
  rows_per_line_ = rig.is_pinholes() ? rows_per_line(rig) : lens_rows_per_line(rig);
  window_ = std::max(kRows, 1.5 * every * rows_per_line_);
}

void LineScan::add(double line, const model::ImageView& image) {
  finder_.find(image);
  for (std::size_t i = 0; i < sightings_.size(); ++i) {
    if (finder_.has_line(i)) {
      most_light_[i] = std::max(most_light_[i], finder_.light(i));
      const double row = finder_.centroid(i) - rig::middle_row(rig_.camera);
      if (std::abs(row) <= window_) {
        sightings_[i].push_back({line, row, finder_.light(i)});
      }
    }
  }
}

// A run is a piece of the sweep in which the rows grow or fall steadily, and stands for one surface.
std::optional<double> LineScan::crossing(std::vector<Sighting> seen, double least_light) const {
  std::sort(seen.begin(), seen.end(), [](const Sighting& a, const Sighting& b) { return a.line < b.line; });
  std::optional<double> found;
  double most_light = 0;
  std::size_t begin = 0;
  for (std::size_t end = 1; end <= seen.size(); ++end) {
    if (end < seen.size()) {
      const double lines = seen[end].line - seen[end - 1].line;
      const double rows = std::abs(seen[end].row - seen[end - 1].row);
      if (lines <= max_gap_ && rows <= 2 * lines * rows_per_line_ + 0.5) {
        continue;
      }
    }
    double light = 0;
    double rows = 0;
    double lines = 0;
    bool above = false;
    bool below = false;
    for (std::size_t k = begin; k < end; ++k) {
      light = std::max(light, seen[k].light);
      rows += seen[k].row;
      lines += seen[k].line;
      above = above || seen[k].row <= 0;
      below = below || seen[k].row >= 0;
    }
    const auto count = static_cast<double>(end - begin);
    const double mean_row = rows / count;
    const double mean_line = lines / count;
    double square = 0;
    double product = 0;
    for (std::size_t k = begin; k < end; ++k) {
      square += (seen[k].row - mean_row) * (seen[k].row - mean_row);
      product += (seen[k].row - mean_row) * (seen[k].line - mean_line);
    }
    begin = end;
    const double line = mean_line - mean_row * product / square;  // at row 0; NaN for a single sighting
    if (above && below && light > most_light && light >= least_light && std::isfinite(line) && can_be_lit(line)) {
      most_light = light;
      found = line;
    }
  }
  return found;
}

// Whether a column may see the light of this line at a point before camera and projector. Lenses are asked later.
bool LineScan::can_be_lit(double line) const {
  return !rig_.is_pinholes() ||
         (std::isfinite(rig::tan_theta(rig_.projector, line)) && rig::tan_theta(rig_.projector, line) > 0);
}

// Hot pixels near the middle row, or a reflection in their row, take a column its crossing. Its neighbours know it.
void LineScan::bridge(std::vector<double>& lines) const {
  constexpr std::size_t kReach = 2;         // columns to a neighbour on each side
  constexpr double kMaxLinesPerColumn = 1;  // steeper than 45 degrees on the built-in rig: perhaps a step
  const std::vector<double> found = lines;
  const auto neighbour = [&](std::size_t i, bool right) -> std::size_t {
    for (std::size_t k = 1; k <= kReach; ++k) {
      if (right ? i + k < found.size() : i >= k) {
        if (const std::size_t at = right ? i + k : i - k; !std::isnan(found[at])) {
          return at;
        }
      }
    }
    return i;
  };
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (!std::isnan(found[i]) || sightings_[i].empty()) {
      continue;
    }
    const std::size_t left = neighbour(i, false);
    const std::size_t right = neighbour(i, true);
    const auto columns = static_cast<double>(right - left);
    if (left < i && right > i && std::abs(found[right] - found[left]) <= kMaxLinesPerColumn * columns) {
      lines[i] = found[left] + static_cast<double>(i - left) / columns * (found[right] - found[left]);
    }
  }
}

ReferenceProfile LineScan::reference() const {
  std::vector<double> lines(sightings_.size(), rig::kUnknown);
  for (std::size_t i = 0; i < sightings_.size(); ++i) {
    lines[i] = crossing(sightings_[i], finder_.least_light(most_light_[i])).value_or(rig::kUnknown);
  }
  bridge(lines);
  ReferenceProfile reference = reference_of_scan(rig_, lines);
  reference.measured = selection_of(rig_.measure.of_board());
  return reference;
}

ReferenceProfile scan_reference(const rig::Rig& rig,
                                const std::function<images::Image(const images::FloatImage& pattern)>& show_and_take,
                                int every) {
  LineScan scan(rig, every);
  for (const int line : sweep_lines(rig, every)) {
    scan.add(line, show_and_take(draw_straight_line(rig, line)).view());
  }
  return scan.reference();
}

CentroidMean::CentroidMean(const rig::Rig& rig)
    : finder_(rig),
      sums_(static_cast<std::size_t>(rig.camera.columns)),
      counts_(static_cast<std::size_t>(rig.camera.columns)) {}

void CentroidMean::add(const model::ImageView& image) {
  finder_.find(image);
  ++images_;
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    if (finder_.has_line(i)) {
      sums_[i] += finder_.centroid(i);
      ++counts_[i];
    }
  }
}

std::vector<double> CentroidMean::centroids() const {
  std::vector<double> means(sums_.size(), rig::kUnknown);
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    if (counts_[i] > 0 && 2 * counts_[i] >= images_) {
      means[i] = sums_[i] / counts_[i];
    }
  }
  return means;
}

}  // namespace selfproj::light_section
