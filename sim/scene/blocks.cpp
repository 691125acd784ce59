#include "sim/scene/blocks.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "sim/scene/lit_surface.h"

namespace selfproj::sim {

std::vector<IndexSpan> BlockFold::pixels_of(const std::vector<IndexSpan>& blocks) const {
  std::vector<IndexSpan> pixels(static_cast<std::size_t>(rows_));
  for (int row = 0; row < rows_; ++row) {
    IndexSpan near;
    for (int down = row * kSubPixels / kBlockSide; down <= (row * kSubPixels + taps() - 1) / kBlockSide; ++down) {
      near.join(blocks[static_cast<std::size_t>(down)]);
    }
    if (!near.empty()) {
      pixels[static_cast<std::size_t>(row)] = {
          std::max(0, (near.first * kBlockSide - taps() + kSubPixels) / kSubPixels),
          std::min(columns_ - 1, ((near.last + 1) * kBlockSide - 1) / kSubPixels)};
    }
  }
  return pixels;
}

std::vector<IndexSpan> BlockFold::blocks_of(const std::vector<IndexSpan>& pixels) const {
  std::vector<IndexSpan> blocks(static_cast<std::size_t>(grid_.down()));
  for (int row = 0; row < rows_; ++row) {
    const IndexSpan span = pixels[static_cast<std::size_t>(row)];
    if (span.empty()) {
      continue;
    }
    const IndexSpan needed{span.first * kSubPixels / kBlockSide, (span.last * kSubPixels + taps() - 1) / kBlockSide};
    for (int down = row * kSubPixels / kBlockSide; down <= (row * kSubPixels + taps() - 1) / kBlockSide; ++down) {
      blocks[static_cast<std::size_t>(down)].join(needed);
    }
  }
  return blocks;
}

void BlockFold::fold_row(const float* sums, IndexSpan pixels, std::vector<float>& every, float* to) const {
  const int end = pixels.last + 1;
  std::fill(to + pixels.first, to + end, 0.0F);
  const auto last = static_cast<std::size_t>(pixels.last + (taps() - 1) / kSubPixels);
  for (int phase = 0; phase < kSubPixels; ++phase) {  // takes every kSubPixels-th sub-pixel
    for (auto c = static_cast<std::size_t>(pixels.first); c <= last; ++c) {
      every[c] = sums[c * kSubPixels + static_cast<std::size_t>(phase)];
    }
    for (int k = phase; k < taps(); k += kSubPixels) {
      const float weight = kernel_[static_cast<std::size_t>(k)];
      const float* shifted = every.data() + k / kSubPixels;
      for (int c = pixels.first; c < end; ++c) {
        to[c] += weight * shifted[c];
      }
    }
  }
}

// Folds each row of the strip's sub-pixels with the kernel along the columns, and adds its contributions to the rows of
// pixels around it. What is dark contributes nothing.
void BlockFold::add(const SubPixelStrip& strip, int down, std::span<float> image) const {
  const int first_column = std::max(0, (strip.first - taps() + kSubPixels) / kSubPixels);
  const int last_column = std::min(columns_ - 1, (strip.last - 1) / kSubPixels);
  std::array<std::vector<float>, kSubPixels> phases;  // every kSubPixels-th sub-pixel
  for (std::vector<float>& phase : phases) {
    phase.resize(static_cast<std::size_t>(strip.width / kSubPixels));
  }
  std::vector<float> line(static_cast<std::size_t>(columns_));
  for (int i = 0; i < kBlockSide; ++i) {
    const float* from = strip.row(i);
    if (std::all_of(from + strip.first, from + strip.last, [](float value) { return value == 0; })) {
      continue;
    }
    for (std::size_t c = 0; c < phases[0].size(); ++c) {
      for (std::size_t phase = 0; phase < kSubPixels; ++phase) {
        phases[phase][c] = from[c * kSubPixels + phase];
      }
    }
    std::fill(line.begin(), line.end(), 0.0F);
    for (int k = 0; k < taps(); ++k) {
      const float weight = kernel_[static_cast<std::size_t>(k)];
      const float* shifted = phases.at(static_cast<std::size_t>(k % kSubPixels)).data() + k / kSubPixels;
      for (int c = first_column; c <= last_column; ++c) {
        line[static_cast<std::size_t>(c)] += weight * shifted[c];
      }
    }
    const int sub_row = down * kBlockSide + i;  // from the first one of the margin
    const IndexSpan rows = rows_of(sub_row);
    for (int r = rows.first; r <= rows.last; ++r) {
      const float weight = kernel_[static_cast<std::size_t>(sub_row - r * kSubPixels)];
      float* to = image.data() + static_cast<std::ptrdiff_t>(r) * columns_;
      for (int c = first_column; c <= last_column; ++c) {
        to[c] += weight * line[static_cast<std::size_t>(c)];
      }
    }
  }
}

BlockViews::BlockViews(const PerturbedRig& actual, const BlockGrid& grid, HeightRange heights)
    : plane_z_(actual.rig.plane_z_mm),
      centre_(actual.camera.centre()),
      projector_(actual.projector),
      heights_(heights),
      slices_per_mm_(heights.high > heights.low ? kSlices / (heights.high - heights.low) : 0),
      lit_(grid.blocks(), ~std::uint32_t{0}) {
  corners_.reserve(grid.blocks());
  tangents_.reserve(grid.blocks());
  for (int down = 0; down < grid.down(); ++down) {
    for (int across = 0; across < grid.across(); ++across) {
      const std::array<Point3, 4> corners = actual.camera.corner_sights(grid.node_pixel(2 * down, 2 * across),
                                                                        grid.node_pixel(2 * down + 2, 2 * across + 2));
      corners_.push_back(corners);
      tangents_.push_back(tangents_of(corners));
    }
  }
}

bool BlockViews::is_dark(std::size_t block, HeightRange heights, const ProjectedLight& light) const {
  std::array<Point3, 8> points{};
  std::size_t count = 0;
  for (const Point3 sight : corners_[block]) {
    for (const double h : {heights.low, heights.high}) {
      points[count++] = centre_ + (plane_z_ - h - centre_.z) * sight;
    }
  }
  const std::optional<PixelBounds> b = projector_.bounds(points);
  return b && light.is_dark(b->row_0, b->row_1, b->column_0, b->column_1);
}

void BlockViews::set_light(const ProjectedLight& light) {
  for (std::size_t block = 0; block < lit_.size(); ++block) {
    lit_[block] = lit_slices(block, light, 0, kSlices);
  }
}

// Slices overlap a little, so that a height on their border is in both however it is rounded.
std::uint32_t BlockViews::lit_slices(std::size_t block, const ProjectedLight& light, unsigned first,
                                     unsigned count) const {
  constexpr double kOverlap = 1e-6;  // mm
  const double slice = (heights_.high - heights_.low) / kSlices;
  const HeightRange range{heights_.low + first * slice - kOverlap, heights_.low + (first + count) * slice + kOverlap};
  if (is_dark(block, range, light)) {
    return 0;
  }
  return count == 1
             ? std::uint32_t{1} << first
             : lit_slices(block, light, first, count / 2) | lit_slices(block, light, first + count / 2, count / 2);
}

}  // namespace selfproj::sim
