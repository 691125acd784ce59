#include "host/production/depth_cutter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "host/files/user_error.h"
#include "host/rig/geometry.h"
#include "host/rig/optics.h"
#include "model/pixel_clock.h"

namespace selfproj {
namespace {

const RigParts& parts_of(const Rig& rig) {
  if (!rig.parts) {
    throw UserError(rig.name, "has no section `parts`, which says what a part is, and the grid of its map");
  }
  return *rig.parts;
}

MapGrid grid_of(const Rig& rig) {
  const double pixel = rig.plane_z_mm * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
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

}  // namespace

DepthGrid::DepthGrid(const Rig& rig)
    : plane_z_(rig.plane_z_mm),
      sums_(grid_of(rig)),
      x_per_z_(rig.camera.rows, rig.camera.columns, kNoValue),
      y_per_z_(rig.camera.rows, rig.camera.columns, kNoValue) {
  const RigOptics optics(rig);
  for (int r = 0; r < rig.camera.rows; ++r) {
    for (int c = 0; c < rig.camera.columns; ++c) {
      if (const auto ray = optics.ray({static_cast<double>(r), static_cast<double>(c)})) {
        x_per_z_.row(r)[c] = static_cast<float>((*ray)[0]);
        y_per_z_.row(r)[c] = static_cast<float>((*ray)[1]);
      }
    }
  }
}

HeightCells DepthGrid::cells(const FloatImage& depth) {
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

DepthCutter::DepthCutter(const Rig& rig, int patterns, Take take)
    : rule_(parts_of(rig)),
      clock_hz_(rig.pixel_clock_hz()),
      frame_s_(1 / rig.camera.frame_rate_hz),
      patterns_(static_cast<std::uint64_t>(patterns)),
      take_(std::move(take)),
      grid_(rig),
      sum_(rig.camera.rows, rig.camera.columns),
      count_(rig.camera.rows, rig.camera.columns),
      mean_(rig.camera.rows, rig.camera.columns) {}

void DepthCutter::add(const PacketHeader& header, const FloatImage& depth, std::int64_t arrival_ns) {
  if (rule_.cut != PartCut::trigger) {
    CutPart part;
    part.cells = grid_.cells(depth);
    part.first = header.sequence + 1 - patterns_;
    part.last = header.sequence;
    part.frames = patterns_;
    part.last_ns = arrival_ns;
    take_(std::move(part));
    return;
  }
  const bool restarted = any_ && header.time_stamp < time_stamp_;
  bool pause = !in_part_ || restarted;
  if (!pause) {
    // Frames that were lost are no pause: they took their time.
    const auto frames = static_cast<double>(header.sequence - sequence_);
    pause = seconds_of_clocks(header.time_stamp - time_stamp_, clock_hz_) > rule_.pause_s + frames * frame_s_;
  }
  if (pause) {
    finish();
    begin(header);
  }
  part_.missing += pause || header.sequence < sequence_ + 2 ? 0 : header.sequence - sequence_ - 2;
  any_ = true;
  time_stamp_ = header.time_stamp;
  sequence_ = header.sequence;
  part_.last_ns = arrival_ns;
  if (header.sequence >= clean_from_) {
    collect(header, depth, arrival_ns);
  }
}

void DepthCutter::begin(const PacketHeader& header) {
  in_part_ = true;
  part_ = CutPart{};
  // At the first start nothing came before.
  clean_from_ = any_ ? header.sequence + patterns_ : 0;
  images_ = 0;
  std::fill(sum_.values.begin(), sum_.values.end(), 0.0F);
  std::fill(count_.values.begin(), count_.values.end(), 0.0F);
}

void DepthCutter::collect(const PacketHeader& header, const FloatImage& depth, std::int64_t arrival_ns) {
  if (images_ == 0) {
    part_.first = header.sequence + 1 - patterns_;
  }
  part_.last = header.sequence;
  part_.last_ns = arrival_ns;
  ++images_;
  for (std::size_t i = 0; i < depth.values.size(); ++i) {
    const float z = depth.values[i];
    const bool there = !std::isnan(z);
    sum_.values[i] += there ? z : 0;
    count_.values[i] += there ? 1.0F : 0.0F;
  }
}

void DepthCutter::finish() {
  if (!in_part_) {
    return;
  }
  in_part_ = false;
  if (images_ == 0) {
    ++specks_;
    return;
  }
  const float least = 0.5F * static_cast<float>(images_);
  for (std::size_t i = 0; i < mean_.values.size(); ++i) {
    mean_.values[i] = count_.values[i] >= least ? sum_.values[i] / count_.values[i] : kNoValue;
  }
  part_.cells = grid_.cells(mean_);
  part_.frames = part_.last + 1 - part_.first - std::min(part_.missing, part_.last - part_.first);
  take_(std::move(part_));
}

}  // namespace selfproj
