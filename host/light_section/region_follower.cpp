#include "host/light_section/region_follower.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "selfproj/files/user_error.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/profile.h"

namespace selfproj::light_section {

RegionFollower::RegionFollower(const rig::Rig& rig, const ReferenceProfile& reference, const std::string& name)
    : camera_(rig.camera),
      measure_(rig.measure),
      name_(name),
      valid_(reference.valid),
      clocks_per_ms_(rig.pixel_clock_hz() / 1000),
      home_(rig.camera.sent().row_offset),
      asked_(home_),
      half_line_(0.25 * (rig.measure.min_lit_px + 0.5 * rig.measure.max_lit_px)) {
  if (!rig.camera.region) {
    throw UserError(name, "the rig has no region (camera.region); `selfproj rows` writes one");
  }
  middles_.reserve(valid_.size());
}

std::optional<int> RegionFollower::ask(int row, std::uint64_t clock) {
  asked_ = row;
  asked_at_ = clock;
  ++counts_.moves;
  return row;
}

std::optional<int> RegionFollower::look(const model::PacketView& packet) {
  const model::PacketHeader& header = packet.header;
  const std::optional<FramePlace> place = place_of_frame(camera_, header);
  const std::uint64_t clock = header.time_stamp;
  const auto ms_since = [&](std::uint64_t then) { return static_cast<double>(clock - then) / clocks_per_ms_; };
  if (first_ || clock < looked_at_) {  // the first frame, or the board began anew
    first_ = false;
    asked_at_ = looked_at_ = lit_at_ = clock;
  } else if (ms_since(looked_at_) < kLookMs) {
    return std::nullopt;
  }
  if (!place || header.rows != camera_.sent().rows) {
    return std::nullopt;
  }
  if (place->row != asked_) {
    if (ms_since(asked_at_) < kAnswerMs) {
      return std::nullopt;
    }
    ++counts_.failed;
    asked_ = place->row;
    before_.reset();
  }
  looked_at_ = clock;
  ++counts_.looks;

  runs_.resize(static_cast<model::Select>(header.select), header.columns);
  const model::RunsView runs = runs_.view();
  model::unpack_columns(header, packet.payload.data(), runs);
  counted_ = {.first = std::max<int>(header.first_row, 1),
              .last = header.last_row > 0 ? std::min<int>(header.last_row, header.rows) : header.rows};
  const auto first = static_cast<float>(place->row + counted_.first);
  const auto last = static_cast<float>(place->row + counted_.last);
  middles_.clear();
  double lit_rows = 0;
  std::size_t whole = 0;
  for (int i = 0; i < header.columns; ++i) {
    const std::uint32_t n = runs.moments.n[i];
    const std::uint32_t m0 = runs.moments.m0[i];
    if (m0 == 0 || n > static_cast<std::uint32_t>(measure_.max_lit_px) ||
        valid_[static_cast<std::size_t>(place->column + i)] == 0) {
      continue;
    }
    const auto lit = static_cast<float>(n);
    const float centroid =
        static_cast<float>(runs.moments.m1[i]) / static_cast<float>(m0) + static_cast<float>(place->row);
    const auto half = static_cast<float>(half_line_);
    if (!line_is_cut_off(centroid, lit, first, last)) {
      middles_.push_back(centroid);
      lit_rows += n;
      ++whole;
    } else if (centroid - first < last - centroid) {
      middles_.push_back(std::min(centroid + lit / 2 - half, centroid));  // it goes on above
    } else {
      middles_.push_back(std::max(centroid - lit / 2 + half, centroid));
    }
  }
  constexpr double kFollows = 0.1;
  if (whole > valid_.size() / 8) {
    half_line_ += kFollows * (0.5 * lit_rows / static_cast<double>(whole) - half_line_);
  }
  if (static_cast<double>(middles_.size()) <= kGain * static_cast<double>(valid_.size())) {
    if (ms_since(lit_at_) >= kHomeMs && asked_ != home_) {
      before_.reset();
      return ask(home_, clock);
    }
    return std::nullopt;
  }
  lit_at_ = clock;
  counts_.left += static_cast<double>(middles_.size() - whole) > kGain * static_cast<double>(middles_.size()) ? 1 : 0;
  std::sort(middles_.begin(), middles_.end());
  const double in_frame = static_cast<double>(middles_[middles_.size() / 2]) - place->row;
  expect_moved(in_frame);
  const std::optional<int> better = better_place(whole);
  if (!better) {
    return std::nullopt;
  }
  before_ = Before{.in_frame = in_frame, .rows = *better - asked_};
  return ask(*better, clock);
}

// A part may change just when the region moves, so once is chance.
void RegionFollower::expect_moved(double in_frame) {
  constexpr int kLeastRows = 4;
  constexpr int kTimes = 2;
  const std::optional<Before> before = std::exchange(before_, std::nullopt);
  if (!before || std::abs(before->rows) < kLeastRows) {
    return;
  }
  unmoved_ = std::abs(in_frame - before->in_frame) < 0.25 * std::abs(before->rows) ? unmoved_ + 1 : 0;
  if (unmoved_ == kTimes) {
    throw UserError(name_,
                    "the region was moved, but the line stays in the same rows of its frames: the camera does not obey "
                    "the register `region`");
  }
}

std::optional<int> RegionFollower::better_place(std::size_t whole) const {
  const int rows = camera_.sent().rows;
  const auto measured = [&](int row) {
    // The middles of lines that leave the outermost rows of the region dark, also where noise lights a row more
    const auto top = static_cast<float>(row + counted_.first + 1 + half_line_);
    const auto bottom = static_cast<float>(row + counted_.last - 1 - half_line_);
    return std::max<std::ptrdiff_t>(std::upper_bound(middles_.begin(), middles_.end(), bottom) -
                                        std::lower_bound(middles_.begin(), middles_.end(), top),
                                    0);
  };
  std::ptrdiff_t most = 0;
  for (int row = 0; row + rows <= camera_.rows; ++row) {
    most = std::max(most, measured(row));
  }
  const auto lit = static_cast<double>(middles_.size());
  if (static_cast<double>(most) - static_cast<double>(whole) <= kGain * lit) {
    return std::nullopt;
  }
  // The longest of the ranges of places that are about as good
  const auto good = most - static_cast<std::ptrdiff_t>(0.01 * lit);
  int best = 0;
  int longest = 0;
  for (int row = 0, begin = 0; row + rows <= camera_.rows; ++row) {
    if (measured(row) < good) {
      begin = row + 1;
    } else if (row + 1 - begin > longest) {
      longest = row + 1 - begin;
      best = begin + (longest - 1) / 2;
    }
  }
  return best == asked_ ? std::nullopt : std::optional(best);
}

}  // namespace selfproj::light_section
