#include "lab/match_shares.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/structured_light/self_reference.h"
#include "lab/line_planes.h"
#include "sim/scene/pinhole.h"

namespace selfproj {
namespace {

// Marks the pixels with a step (neighbours more than 1 mm apart in z, or the edge of a shadow) within `reach` pixels
// along rows and columns.
std::vector<std::uint8_t> steps_within(const FloatImage& z, int reach) {
  const auto at = [&](int r, int c) {
    return static_cast<std::size_t>(r) * static_cast<std::size_t>(z.columns) + static_cast<std::size_t>(c);
  };
  const auto differ = [&](std::size_t a, std::size_t b) {
    return std::isnan(z.values[a]) != std::isnan(z.values[b]) || std::abs(z.values[a] - z.values[b]) > 1;
  };
  std::vector<std::uint8_t> steps(z.values.size(), 0);
  for (int r = 0; r < z.rows; ++r) {
    for (int c = 0; c < z.columns; ++c) {
      const bool down = r + 1 < z.rows && differ(at(r, c), at(r + 1, c));
      const bool right = c + 1 < z.columns && differ(at(r, c), at(r, c + 1));
      steps[at(r, c)] = down || right ? 1 : 0;
    }
  }
  std::vector<std::uint8_t> along = steps;
  for (int r = 0; r < z.rows; ++r) {
    for (int c = 0; c < z.columns; ++c) {
      for (int k = std::max(0, c - reach); k <= std::min(z.columns - 1, c + reach) && along[at(r, c)] == 0; ++k) {
        along[at(r, c)] = steps[at(r, k)];
      }
    }
  }
  std::vector<std::uint8_t> result = along;
  for (int r = 0; r < z.rows; ++r) {
    for (int c = 0; c < z.columns; ++c) {
      for (int k = std::max(0, r - reach); k <= std::min(z.rows - 1, r + reach) && result[at(r, c)] == 0; ++k) {
        result[at(r, c)] = along[at(k, c)];
      }
    }
  }
  return result;
}

}  // namespace

MatchShares match_shares(const Rig& rig, const SelfReference& reference, const MatchSettings& settings,
                         const FloatImage& true_z, const FloatImage& reference_z) {
  const MatchSearch search(rig, reference, settings);
  const LinePlanes planes(rig);
  const int codes = 1 << reference.stripes.bits;
  const std::vector<std::uint8_t> near = steps_within(reference_z, codes * reference.stripes.width);
  std::vector<Match> matches;
  MatchShares shares;
  std::size_t wrong = 0;
  std::size_t missing = 0;
  std::size_t far_wrong = 0;
  for (std::size_t i = 0; i < true_z.values.size(); ++i) {
    const auto columns = static_cast<std::size_t>(rig.camera.columns);
    const int row = static_cast<int>(i / columns);
    const int column = static_cast<int>(i % columns);
    if (std::isnan(true_z.values[i]) || !search.can_find(row, column)) {
      continue;
    }
    const PixelPoint light = planes.light(i, static_cast<double>(true_z.values[i]));
    const auto line = static_cast<int>(std::lround(light.row));
    const auto across = static_cast<int>(std::lround(light.column));
    if (line < 0 || line >= rig.projector.lines || across < 0 || across >= rig.projector.columns) {
      continue;
    }
    const int cell = reference.cell(line, across);
    const int n = cell_of_row(row, rig.camera.rows, reference.stripes.width) - cell;
    if (n < -settings.e || n >= codes - settings.e) {
      continue;
    }
    search.find(row, column, matches);
    const Match& match = matches[static_cast<std::size_t>(code_of_cell(reference.stripes, cell))];
    const bool is_wrong = match.candidates > 0 && std::abs(match.line - light.row) > match.half_width + 1;
    ++shares.pixels;
    missing += match.candidates == 0 ? 1 : 0;
    wrong += is_wrong ? 1 : 0;
    if (near[i] == 0) {
      ++shares.far;
      far_wrong += is_wrong ? 1 : 0;
    }
  }
  shares.wrong = static_cast<double>(wrong) / static_cast<double>(shares.pixels);
  shares.none = static_cast<double>(missing) / static_cast<double>(shares.pixels);
  shares.far_wrong = static_cast<double>(far_wrong) / static_cast<double>(shares.far);
  return shares;
}

}  // namespace selfproj
