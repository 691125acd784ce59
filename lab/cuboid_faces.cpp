#include "lab/cuboid_faces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <vector>

#include "lab/line_planes.h"
#include "sim/scene/pinhole.h"
#include "sim/scene/self_scenes.h"

namespace selfproj {
namespace {

Face face_of(const Rig& rig, const Point3& p) {
  const double height = rig.plane_z_mm - p.z;
  const auto is = [&](double wanted) { return std::abs(height - wanted) < 0.05; };
  const auto in = [&](const Box& box) { return p.x > box.x0 && p.x < box.x1 && p.y > box.y0 && p.y < box.y1; };
  if (is(0)) {
    return Face::plane;
  }
  if (in(Cuboids::kLowPart.box)) {
    return is(Cuboids::kLow) ? Face::low : is(Cuboids::kLow - Cuboids::kLetterDepth) ? Face::letter : Face::none;
  }
  if (in(Cuboids::kHighPart.box)) {
    constexpr std::array<Face, 3> kBlocks{Face::block_3, Face::block_6, Face::block_9};
    for (std::size_t i = 0; i < kBlocks.size(); ++i) {
      if (is(Cuboids::kHigh + Cuboids::kBlockHeights.at(i))) {
        return kBlocks.at(i);
      }
    }
    return is(Cuboids::kHigh) ? Face::high : Face::none;
  }
  return Face::none;
}

}  // namespace

std::vector<Face> face_interiors(const Rig& rig, const FloatImage& truth) {
  constexpr int kMargin = 3;
  std::vector<Face> all(truth.values.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i] = std::isnan(truth.values[i]) ? Face::none
                                         : face_of(rig, point_of_pixel(rig, i, static_cast<double>(truth.values[i])));
  }
  const auto index = [&](int row, int column) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(truth.columns) + static_cast<std::size_t>(column);
  };
  std::vector<Face> inner(all.size(), Face::none);
  for (int r = kMargin; r + kMargin < truth.rows; ++r) {
    for (int c = kMargin; c + kMargin < truth.columns; ++c) {
      bool even = true;
      for (int dr = -kMargin; dr <= kMargin && even; ++dr) {
        for (int dc = -kMargin; dc <= kMargin && even; ++dc) {
          even = all[index(r + dr, c + dc)] == all[index(r, c)];
        }
      }
      if (even) {
        inner[index(r, c)] = all[index(r, c)];
      }
    }
  }
  return inner;
}

CuboidFigures cuboid_figures(const Rig& rig, const std::vector<Face>& faces, const FloatImage& depth,
                             const FloatImage& difference, const FloatImage& truth,
                             const std::function<double(std::size_t pixel)>& code_width) {
  CuboidFigures figures;
  std::array<std::size_t, kFaceNames.size()> widths{};  // number of known widths of each face
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (faces[i] == Face::none) {
      continue;
    }
    FaceFigures& face = figures[faces[i]];
    ++face.pixels;
    const auto z = static_cast<double>(depth.values[i]);
    const auto from_reference = static_cast<double>(difference.values[i]);
    if (std::isnan(z) || std::isnan(from_reference)) {
      face.errors.add(std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    ++face.valid;
    const double error = z - static_cast<double>(truth.values[i]);
    face.errors.add(error);
    face.height += rig.plane_z_mm - z;
    face.difference += from_reference;
    face.rms += error * error;
    face.most = std::max(face.most, std::abs(error));
    const double width = code_width(i);
    if (!std::isnan(width)) {
      face.width += width;
      ++widths.at(static_cast<std::size_t>(faces[i]));
    }
  }
  for (std::size_t k = 0; k < kFaceNames.size(); ++k) {
    FaceFigures& face = figures[static_cast<Face>(k)];
    const auto count = static_cast<double>(face.valid);  // NaN if there is none
    face.height /= count;
    face.difference /= count;
    face.rms = std::sqrt(face.rms / count);
    face.width /= static_cast<double>(widths.at(k));
  }
  return figures;
}

}  // namespace selfproj
