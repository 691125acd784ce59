#include "selfproj/light_section/inspection.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <vector>

#include "selfproj/light_section/differential_profile.h"
#include "selfproj/model/pixel_clock.h"

namespace selfproj::light_section {

Inspection::Inspection(const rig::Rig& rig, int columns, const InspectionOptions& options)
    : rig_(rig), columns_(columns), options_(options) {
  if (columns <= 0) {
    throw std::invalid_argument("an inspection needs columns");
  }
  const std::size_t frames = std::min(options.expected_frames, options.max_frames);
  frames_.reserve(frames);
  const std::size_t size = frames * static_cast<std::size_t>(columns);
  for (auto* values : {&values_.m0, &values_.m1, &values_.n}) {
    values->reserve(size);
  }
  for (auto* values : {&values_.x, &values_.y, &values_.z, &values_.dx, &values_.dy, &values_.dz}) {
    values->reserve(size);
  }
  values_.validity.reserve(size);
}

bool Inspection::begin_frame(const model::PacketHeader& header) {
  const FramePlace place = place_of_frame(rig_.camera, header).value_or(FramePlace{});
  if (place.column + header.columns > columns_) {
    throw std::invalid_argument("a frame that is wider than the profiles");
  }
  if (frames_.size() >= options_.max_frames) {
    ++not_kept_;
    return false;
  }
  frames_.push_back({.sequence = header.sequence,
                     .time_stamp = header.time_stamp,
                     .encoder = header.encoder,
                     .mode = header.mode,
                     .threshold = header.threshold,
                     .pixel_bits = header.pixel_bits,
                     .select = header.select,
                     .gap = header.gap,
                     .window = {header.first_row, header.last_row},
                     .row_offset = static_cast<std::uint16_t>(place.row)});
  const std::size_t size = frames_.size() * static_cast<std::size_t>(columns_);
  for (auto* values : {&values_.m0, &values_.m1, &values_.n}) {
    values->resize(size);
  }
  if (has_runs() || header.select == spec::kSelectStrongest) {
    values_.runs.resize(size);
    values_.second.resize(size);
  }
  return true;
}

void Inspection::add_profile(const ProfileView& profile) {
  const auto append = [this](auto& to, const auto* values) { to.insert(to.end(), values, values + columns_); };
  append(values_.x, profile.x);
  append(values_.y, profile.y);
  append(values_.z, profile.z);
  append(values_.dx, profile.dx);
  append(values_.dy, profile.dy);
  append(values_.dz, profile.dz);
  append(values_.validity, profile.validity);
}

model::RunsView Inspection::last_frame(const model::PacketHeader& header) {
  const auto first_column = static_cast<std::size_t>(place_of_frame(rig_.camera, header).value_or(FramePlace{}).column);
  const std::size_t begin = (frames_.size() - 1) * static_cast<std::size_t>(columns_) + first_column;
  const bool runs = has_runs();
  return {{values_.m0.data() + begin, values_.m1.data() + begin, values_.n.data() + begin},
          runs ? values_.runs.data() + begin : nullptr,
          runs ? values_.second.data() + begin : nullptr};
}

void Inspection::add(const model::PacketHeader& header, const model::RunsView& runs, const ProfileView& profile) {
  if (!begin_frame(header)) {
    return;
  }
  const model::RunsView to = last_frame(header);
  std::copy_n(runs.moments.m0, header.columns, to.moments.m0);
  std::copy_n(runs.moments.m1, header.columns, to.moments.m1);
  std::copy_n(runs.moments.n, header.columns, to.moments.n);
  if (runs.runs != nullptr && runs.second != nullptr && to.runs != nullptr) {
    std::copy_n(runs.runs, header.columns, to.runs);
    std::copy_n(runs.second, header.columns, to.second);
  }
  add_profile(profile);
}

void Inspection::add(const model::PacketHeader& header, std::span<const std::uint8_t> payload,
                     const ProfileView& profile) {
  if (payload.size() != model::frame_payload_bytes(header)) {
    throw std::invalid_argument("a payload of another width");
  }
  if (!begin_frame(header)) {
    return;
  }
  model::unpack_columns(header, payload.data(), last_frame(header));
  add_profile(profile);
}

bool Inspection::encoder_counts() const {
  return std::any_of(frames_.begin(), frames_.end(),
                     [this](const Frame& frame) { return frame.encoder != frames_.front().encoder; });
}

std::vector<double> Inspection::belt_mm() const {
  const bool by_encoder = encoder_counts();
  std::vector<double> belt;
  belt.reserve(frames_.size());
  double position = 0;
  double step = rig_.conveyor.speed_mm_per_s / rig_.camera.sent().frame_rate_hz;
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    const bool restarted = i > 0 && frames_[i].time_stamp < frames_[i - 1].time_stamp;
    if (i > 0 && !restarted) {
      // Differences modulo 2^32 and 2^64, because counters may wrap.
      step = by_encoder
                 ? static_cast<std::int32_t>(frames_[i].encoder - frames_[i - 1].encoder) *
                       rig_.conveyor.encoder_mm_per_count
                 : model::seconds_of_clocks(frames_[i].time_stamp - frames_[i - 1].time_stamp, rig_.pixel_clock_hz()) *
                       rig_.conveyor.speed_mm_per_s;
    }
    position += i > 0 ? step : 0;
    belt.push_back(position);
  }
  return belt;
}

double Inspection::frame_spacing_mm() const {
  return frames_.size() > 1 ? std::abs(belt_mm().back()) / static_cast<double>(frames_.size() - 1)
                            : rig_.conveyor.speed_mm_per_s / rig_.camera.sent().frame_rate_hz;
}

double Inspection::column_spacing_mm() const {
  return rig_.plane_z_mm * rig_.camera.pixel_pitch_mm / rig_.camera.focal_length_mm;
}

images::FloatImage Inspection::map(const std::vector<float>& values, double offset, double factor) const {
  images::FloatImage image(static_cast<int>(frames_.size()), columns_, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values_.validity[i] == static_cast<std::uint8_t>(Validity::valid)) {
      image.values[i] = static_cast<float>(offset + factor * static_cast<double>(values[i]));
    }
  }
  return image;
}

images::FloatImage Inspection::height() const { return map(values_.z, rig_.plane_z_mm, -1); }

images::FloatImage Inspection::difference() const { return map(values_.dz, 0, -1); }

images::FloatImage Inspection::x() const { return map(values_.x, 0, 1); }

images::FloatImage Inspection::y() const { return map(values_.y, 0, 1); }

images::FloatImage Inspection::centroid() const {
  images::FloatImage image(static_cast<int>(frames_.size()), columns_, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < values_.m0.size(); ++i) {
    if (values_.m0[i] > 0 && values_.validity[i] == static_cast<std::uint8_t>(Validity::valid)) {
      const Frame& frame = frames_[i / static_cast<std::size_t>(columns_)];
      image.values[i] =
          static_cast<float>(frame.row_offset + static_cast<double>(values_.m1[i]) / values_.m0[i]);  // (3.2)
    }
  }
  return image;
}

}  // namespace selfproj::light_section
