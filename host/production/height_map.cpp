#include "host/production/height_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "host/rig/geometry.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/rig/optics.h"

namespace selfproj::production {
namespace {

constexpr double kWidestBridge = 2;       // cells between two points that are joined
constexpr double kMostBesidePlane = 0.3;  // how far points may be from the plane of a belt, as a share of its distance

MapGrid grid_of(const rig::Rig& rig) {
  const double pixel = pixel_mm(rig);
  const double pitch = parts_of(rig).grid_mm;
  if (pitch < pixel) {
    throw UserError(rig.name, fmt::format("parts.grid_mm is {}; the camera's pixels are {:.4g} mm apart on the plane",
                                          pitch, pixel));
  }
  MapGrid grid;
  grid.pitch_mm = pitch;
  grid.rows = static_cast<int>(std::ceil(rig.camera.rows * pixel / pitch)) + 1;
  grid.columns = static_cast<int>(std::ceil(rig.camera.columns * pixel / pitch)) + 1;
  grid.across_mm = -0.5 * (grid.columns - 1) * pitch;
  return grid;
}

// Of a camera that leans, or a laser.
BeltView leaning_view(const rig::Rig& rig) {
  constexpr int kSteps = 64;  // rows and columns that are looked at
  constexpr double kFar = std::numeric_limits<double>::infinity();
  const rig::RigOptics optics(rig);
  const double rows = rig.camera.rows;
  const double columns = rig.camera.columns;
  BeltView view;
  double first_x = kFar;
  double last_x = -kFar;
  view.left_mm = kFar;
  view.right_mm = -kFar;
  double off_plane = kFar;  // of the point that is nearest to the plane in the middle column
  double middle_y = 0;
  for (int c = 0; c <= kSteps; ++c) {
    double off_beside = kFar;
    double y_beside = 0;
    for (int r = 0; r <= kSteps; ++r) {
      const rig::CameraPlace place{(rows - 1) * r / kSteps, (columns - 1) * c / kSteps};
      const std::optional<cv::Vec2d> ray = optics.ray(place);
      const std::optional<double> met = !ray                     ? std::nullopt
                                        : optics.has_projector() ? std::optional(rig.plane_z_mm)
                                                                 : optics.meet(*ray, {});
      if (!met || !(std::abs(*met - rig.plane_z_mm) <= kMostBesidePlane * rig.plane_z_mm)) {
        continue;
      }
      const double x = (*ray)[0] * *met;
      const double y = (*ray)[1] * *met;
      first_x = std::min(first_x, x);
      last_x = std::max(last_x, x);
      view.left_mm = std::min(view.left_mm, y);
      view.right_mm = std::max(view.right_mm, y);
      // The light of a projector lies about the middle row.
      const double off = optics.has_projector() ? std::abs(r - kSteps / 2) : std::abs(*met - rig.plane_z_mm);
      if (off < off_beside) {
        off_beside = off;
        y_beside = y;
      }
      if (c == kSteps / 2 && off < off_plane) {
        off_plane = off;
        view.along_mm = x;
        middle_y = y;
      }
    }
    if (c == kSteps / 2 + 1) {
      view.column_mm = std::abs(y_beside - middle_y) * kSteps / (columns - 1);
    }
  }
  if (!(last_x >= first_x) || !(view.column_mm > 0)) {
    throw UserError(rig.name, "its camera does not see its light on the belt");
  }
  view.reach_mm = std::max(last_x - view.along_mm, view.along_mm - first_x);
  return view;
}

}  // namespace

const rig::RigParts& parts_of(const rig::Rig& rig) {
  if (!rig.parts) {
    throw UserError("--rig",
                    fmt::format("{} has no section `parts`, which says how the stream is cut into parts", rig.name));
  }
  return *rig.parts;
}

BeltView belt_view(const rig::Rig& rig) {
  if (rig.light_plane || rig.belt_pose) {
    return leaning_view(rig);
  }
  const double across = rig.plane_z_mm * rig::tan_beta(rig.camera, rig.camera.columns - 0.5);
  return {.column_mm = rig.plane_z_mm * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm,
          .along_mm = 0,
          .reach_mm = rig.plane_z_mm * rig::tan_alpha(rig.camera, rig.camera.rows + 0.5),
          .left_mm = -across,
          .right_mm = across};
}

rig::RigParts usual_parts(const rig::Rig& rig, bool by_encoder) {
  constexpr double kStepsOfGrid = 20;  // to the next power of ten
  constexpr double kFinest = 0.01;     // mm
  constexpr double kLengthStep = 10;   // mm
  const BeltView view = belt_view(rig);
  const double step = std::pow(10, std::ceil(std::log10(view.column_mm))) / kStepsOfGrid;
  const auto round = [](double value) { return std::round(1e6 * value) / 1e6; };  // as it is read
  const double grid = round(std::max(kFinest, step * std::ceil(view.column_mm / step)));
  rig::RigParts parts;
  parts.by_encoder = by_encoder;
  parts.grid_mm = grid;
  parts.above_mm = round(4 * grid);
  parts.min_width_mm = round(8 * grid);
  parts.gap_mm = round(12 * grid);
  parts.pause_s = 5 / rig.camera.sent().frame_rate_hz;
  parts.min_length_mm = round(20 * grid);
  parts.length_mm = kLengthStep * std::ceil(2 * (view.right_mm - view.left_mm) / kLengthStep);
  return parts;
}

HeightGrid::HeightGrid(const rig::Rig& rig)
    : columns_(rig.camera.columns), plane_z_(rig.plane_z_mm), above_(rig.parts.value().above_mm) {
  const BeltView view = belt_view(rig);
  column_mm_ = view.column_mm;
  light_x_ = view.along_mm;
  const rig::RigParts& parts = *rig.parts;
  if (parts.grid_mm < column_mm_) {
    throw UserError(rig.name, fmt::format("parts.grid_mm is {}; the camera's columns are {:.4g} mm apart on the plane, "
                                          "so at least {:g} is needed",
                                          parts.grid_mm, column_mm_, std::ceil(100 * column_mm_) / 100));
  }
  const double along = parts.length_mm + 2 * parts.gap_mm + 2 * view.reach_mm;
  MapGrid grid;
  grid.pitch_mm = parts.grid_mm;
  grid.columns = static_cast<int>(std::ceil((view.right_mm - view.left_mm) / parts.grid_mm)) + 1;
  grid.rows = static_cast<int>(std::ceil(along / parts.grid_mm)) + 2;
  grid.across_mm = view.left_mm;
  grid.along_mm = -view.reach_mm;
  sums_ = CellSums(grid);
  points_.resize(static_cast<std::size_t>(columns_));
}

void HeightGrid::begin(double belt_mm) {
  begin_ = belt_mm;
  sums_.clear();
  std::fill(points_.begin(), points_.end(), Point{});
}

void HeightGrid::add(double belt_mm, const light_section::ProfileView& profile) {
  for (int i = 0; i < columns_; ++i) {
    Point& last = points_[static_cast<std::size_t>(i)];
    if (profile.validity[i] != static_cast<std::uint8_t>(light_section::Validity::valid)) {
      last.there = false;
      continue;
    }
    const double row = grid().row_of(belt_mm - begin_ - (static_cast<double>(profile.x[i]) - light_x_));
    const double column = grid().column_of(static_cast<double>(profile.y[i]));
    const auto height = static_cast<float>(plane_z_ - static_cast<double>(profile.z[i]));
    sums_.put(row, column, height);
    const double way = std::abs(row - static_cast<double>(last.row));
    if (last.there && way > 1 && way <= kWidestBridge) {
      sums_.put(0.5 * (row + static_cast<double>(last.row)), 0.5 * (column + static_cast<double>(last.column)),
                0.5F * (height + last.height));
    }
    last = {static_cast<float>(row), static_cast<float>(column), height, true};
  }
}

double HeightGrid::width_above(const light_section::ProfileView& profile) const {
  const auto highest_z = static_cast<float>(plane_z_ - above_);
  int count = 0;
  for (int i = 0; i < columns_; ++i) {
    count +=
        profile.validity[i] == static_cast<std::uint8_t>(light_section::Validity::valid) && profile.z[i] < highest_z
            ? 1
            : 0;
  }
  return count * column_mm_;
}

DepthGrid::DepthGrid(const rig::Rig& rig)
    : plane_z_(rig.plane_z_mm),
      sums_(grid_of(rig)),
      x_per_z_(rig.camera.rows, rig.camera.columns, images::kNoValue),
      y_per_z_(rig.camera.rows, rig.camera.columns, images::kNoValue) {
  const rig::RigOptics optics(rig);
  for (int r = 0; r < rig.camera.rows; ++r) {
    for (int c = 0; c < rig.camera.columns; ++c) {
      if (const auto ray = optics.ray({static_cast<double>(r), static_cast<double>(c)})) {
        x_per_z_.row(r)[c] = static_cast<float>((*ray)[0]);
        y_per_z_.row(r)[c] = static_cast<float>((*ray)[1]);
      }
    }
  }
}

HeightCells DepthGrid::cells(const images::FloatImage& depth) {
  const MapGrid& grid = sums_.grid();
  const double middle = 0.5 * (grid.rows - 1);  // the row of x = 0
  sums_.clear();
  for (std::size_t i = 0; i < depth.values.size(); ++i) {
    const float z = depth.values[i];
    const float x = z * x_per_z_.values[i];
    if (std::isnan(x)) {
      continue;
    }
    sums_.put(middle + static_cast<double>(x) / grid.pitch_mm,
              grid.column_of(static_cast<double>(z * y_per_z_.values[i])),
              static_cast<float>(plane_z_ - static_cast<double>(z)));
  }
  return sums_.cells();
}

}  // namespace selfproj::production
