#include "host/light_section/scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "host/files/numbers.h"
#include "host/light_section/line_finder.h"
#include "host/light_section/pattern.h"
#include "host/rig/geometry.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/rig/optics.h"

namespace selfproj::light_section {
namespace {

// By how many rows the image of the line moves on the plane from one line to the next.
double pinhole_rows_per_line(const rig::Rig& rig) {
  const double depth = rig.plane_z_mm - rig.projector.z_mm;
  const double line = rig::line_on_middle(rig.projector, rig.plane_z_mm);
  const double x_per_line =
      depth * (rig::tan_theta(rig.projector, line + 0.5) - rig::tan_theta(rig.projector, line - 0.5));
  return -x_per_line / rig.plane_z_mm * rig.camera.focal_length_mm / rig.camera.pixel_pitch_mm;
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
  return 1 / (line_at(row + 0.5) - line_at(row - 0.5));
}

double rows_per_line(const rig::Rig& rig) {
  return rig.is_pinholes() ? pinhole_rows_per_line(rig) : lens_rows_per_line(rig);
}

// A second line with a quarter of the light counts where the rig would sum it.
rig::Rig with_runs(rig::Rig rig) {
  rig.measure.runs = rig.measure.runs.value_or(rig::RigRuns{.ambiguous_from = 0.25});
  return rig;
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

void add_sightings(LineFinder& finder, double line, const SensorView& image, std::vector<LineSighting>& seen) {
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

SweepCheck::SweepCheck(const rig::Rig& rig)
    : finder_(with_runs(rig)),
      sums_(!rig.measure.runs),
      rows_per_line_(rows_per_line(rig)),
      most_light_(static_cast<std::size_t>(rig.camera.columns)) {}

void SweepCheck::add(double line, const SensorView& image, const std::string& name) {
  finder_.find(image);
  Image& added = images_.emplace_back(Image{line, name, std::vector<Seen>(most_light_.size()), 0});
  for (std::size_t i = 0; i < most_light_.size(); ++i) {
    const bool second = finder_.validity(i) == Validity::ambiguous;
    second_lines_ += second ? 1 : 0;
    lines_ += second || finder_.has_line(i) ? 1 : 0;
    if (finder_.has_line(i)) {
      ++added.lines;
      added.seen[i] = {finder_.centroid(i), finder_.light(i)};
      most_light_[i] = std::max(most_light_[i], finder_.light(i));
    }
  }
}

// By how many rows the line moves from one image to another, in most columns that show it in both.
std::optional<double> SweepCheck::moved(const Image& from, const Image& to) const {
  std::vector<double> rows;
  for (std::size_t i = 0; i < most_light_.size(); ++i) {
    const double least = std::max(1.0, finder_.least_light(most_light_[i]));
    if (from.seen[i].light >= least && to.seen[i].light >= least) {
      rows.push_back(to.seen[i].row - from.seen[i].row);
    }
  }
  return rows.size() >= few() ? std::optional(files::median_of(std::move(rows))) : std::nullopt;
}

std::string SweepCheck::contradiction() const {
  constexpr double kOrdered = 0.25;  // of the way; the rest goes back and forth at edges
  constexpr double kSteps = 0.15;    // of a step
  constexpr double kManySecond = 0.05;
  constexpr std::size_t kFewest = 3;
  const auto expected = [&](const Image& from, const Image& to) { return rows_per_line_ * (to.line - from.line); };
  double way = 0;  // rows
  double net = 0;
  double right = 0;
  std::size_t pairs = 0;
  const Image* last = nullptr;
  for (const Image& image : images_) {
    if (image.lines < few()) {
      continue;
    }
    if (last != nullptr) {
      if (const std::optional<double> rows = moved(*last, image)) {
        ++pairs;
        way += std::abs(*rows);
        net += expected(*last, image) < 0 ? -*rows : *rows;
        right += std::abs(expected(*last, image));
      }
    }
    last = &image;
  }
  if (pairs >= kFewest && net < kOrdered * way) {
    return fmt::format(
        "the line moves by {:.0f} rows on a way of {:.0f}, not steadily by {:.0f} as on the plane: are the images in "
        "the order of the lines, and is the picture not mirrored?",
        net, way, right);
  }
  std::vector<std::optional<double>> paces;  // of neighbours, beside that on the plane
  for (std::size_t k = 1; k < images_.size(); ++k) {
    const std::optional<double> rows = moved(images_[k - 1], images_[k]);
    paces.push_back(rows ? std::optional(*rows / expected(images_[k - 1], images_[k])) : std::nullopt);
  }
  // Among even steps some that are whole ones, but others: an image is late, early, or exchanged with the next.
  const auto are = [&](std::size_t first, std::initializer_list<double> wanted) {
    const double even = first < paces.size() && paces[first] ? std::abs(*paces[first]) : 0;
    return first + wanted.size() <= paces.size() && even > kOrdered &&
           std::equal(wanted.begin(), wanted.end(), paces.begin() + static_cast<std::ptrdiff_t>(first),
                      [&](double want, const std::optional<double>& pace) {
                        return pace && std::abs(*pace / even - want) < kSteps;
                      });
  };
  for (std::size_t first = 0; first < paces.size(); ++first) {
    if (are(first, {1, 1, 0, 2, 1}) || are(first, {1, 1, 2, 0, 1}) || are(first, {1, 1, 2, -1, 2, 1})) {
      return fmt::format(
          "{} does not show the line between those of {} and {}: is it late, missing or in another place?",
          images_[first + 3].name, images_[first + 2].name, images_[first + 4].name);
    }
  }
  if (sums_ && static_cast<double>(second_lines_) > kManySecond * static_cast<double>(lines_)) {
    return fmt::format(
        "in {:.0f} % of the places there is a second line beside the brighter one, and all lit pixels of a column are "
        "summed; select the strongest run (--select strongest, measure.runs in the rig)",
        100 * static_cast<double>(second_lines_) / static_cast<double>(lines_));
  }
  return "";
}

LineScan::LineScan(const rig::Rig& rig, int every)
    : rig_(rig),
      finder_(rig),
      max_gap_(3.0 * every),
      sightings_(static_cast<std::size_t>(rig.camera.columns)),
      most_light_(static_cast<std::size_t>(rig.camera.columns)) {
  constexpr double kRows = 4;
  rows_per_line_ = std::abs(rows_per_line(rig));
  window_ = std::max(kRows, 1.5 * every * rows_per_line_);
}

void LineScan::add(double line, const SensorView& image) {
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
      squares_(static_cast<std::size_t>(rig.camera.columns)),
      counts_(static_cast<std::size_t>(rig.camera.columns)) {}

void CentroidMean::add(const SensorView& image) {
  finder_.find(image);
  ++images_;
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    if (finder_.has_line(i)) {
      sums_[i] += finder_.centroid(i);
      squares_[i] += finder_.centroid(i) * finder_.centroid(i);
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

std::string CentroidMean::contradiction() const {
  constexpr double kStill = 0.4;    // rows, standard deviation from image to image
  constexpr double kMayMove = 0.1;  // of the lit columns
  std::size_t lit = 0;
  std::size_t moving = 0;
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    if (counts_[i] > 0) {
      const double mean = sums_[i] / counts_[i];
      ++lit;
      moving += squares_[i] / counts_[i] - mean * mean > kStill * kStill ? 1 : 0;
    }
  }
  if (static_cast<double>(moving) <= kMayMove * static_cast<double>(lit)) {
    return "";
  }
  return fmt::format(
      "in {} of {} columns the line moves by more than {:g} rows from image to image; are they images of one part that "
      "stands still?",
      moving, lit, kStill);
}

}  // namespace selfproj::light_section
