#include "host/production/cutter.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "selfproj/model/pixel_clock.h"

namespace selfproj::production {
namespace {

constexpr double kKeptPerCell = 4;  // frames that are kept before a part, at most, for each cell
constexpr std::size_t kMaxKeptBefore = 512;

std::size_t ring_size(const rig::Rig& rig) {
  const rig::RigParts& rule = *rig.parts;
  if (rule.cut != rig::PartCut::profile) {
    return 0;
  }
  const double frames = std::ceil(kKeptPerCell * rule.gap_mm / rule.grid_mm);
  return static_cast<std::size_t>(std::clamp(frames, 1.0, static_cast<double>(kMaxKeptBefore)));
}

}  // namespace

ProfileCutter::ProfileCutter(const rig::Rig& rig) : rig_(rig), rule_(parts_of(rig_)), belt_(rig_), grid_(rig_) {
  before_.resize(ring_size(rig_));
  for (Kept& kept : before_) {
    kept.profile.resize(rig_.camera.columns);
  }
}

// Frames that are nearer to each other than a quarter of a cell say nothing new.
void ProfileCutter::keep(double belt, const light_section::ProfileView& profile) {
  if (kept_ > 0 && std::abs(belt - last_kept_) < rule_.grid_mm / kKeptPerCell) {
    return;
  }
  newest_ = (newest_ + 1) % before_.size();
  kept_ = std::min(kept_ + 1, before_.size());
  Kept& kept = before_[newest_];
  kept.belt = last_kept_ = belt;
  const int columns = rig_.camera.columns;
  std::copy_n(profile.x, columns, kept.profile.x.begin());
  std::copy_n(profile.y, columns, kept.profile.y.begin());
  std::copy_n(profile.z, columns, kept.profile.z.begin());
  std::copy_n(profile.validity, columns, kept.profile.validity.begin());
}

void ProfileCutter::begin(double belt, const model::PacketHeader& header) {
  in_part_ = true;
  part_ = {};
  part_.first = header.sequence;
  part_.cut_off = std::exchange(began_with_a_part_, false);
  if (rule_.cut == rig::PartCut::profile && !part_.cut_off) {
    part_.missing = lost_before(header);  // they may have been of the part, too
  }
  present_from_ = present_to_ = belt;
  part_.begin_mm = belt;
  const std::size_t size = before_.size();
  std::size_t used = 0;
  while (used < kept_ && belt - before_[(newest_ + size - used) % size].belt <= rule_.gap_mm) {
    ++used;
  }
  if (used > 0) {
    part_.begin_mm = before_[(newest_ + size - used + 1) % size].belt;
  }
  grid_.begin(part_.begin_mm);
  for (; used > 0; --used) {
    Kept& kept = before_[(newest_ + size - used + 1) % size];
    grid_.add(kept.belt, kept.profile.view());
    ++part_.frames;
  }
  kept_ = 0;
}

std::uint64_t ProfileCutter::lost_before(const model::PacketHeader& header) const {
  return header.sequence > last_sequence_ ? header.sequence - last_sequence_ - 1 : 0;
}

void ProfileCutter::put(double belt, const model::PacketHeader& header, const light_section::ProfileView& profile) {
  const bool first = present_to_ == present_from_ && part_.first == header.sequence;
  if (!first) {
    part_.missing += lost_before(header);
    part_.restarted = part_.restarted || belt_.restarted();
  }
  grid_.add(belt, profile);
  ++part_.frames;
}

void ProfileCutter::extend(double belt, const model::PacketHeader& header, std::int64_t arrival_ns) {
  present_to_ = belt;
  part_.last = header.sequence;
  part_.last_ns = arrival_ns;
}

std::optional<CutPart> ProfileCutter::end() {
  in_part_ = false;
  part_.length_mm = present_to_ - present_from_;
  if (rule_.cut != rig::PartCut::distance && part_.length_mm < rule_.min_length_mm) {
    ++specks_;
    return std::nullopt;
  }
  part_.cells = grid_.cells();
  return std::exchange(part_, {});
}

std::optional<CutPart> ProfileCutter::add(const model::PacketHeader& header, const light_section::ProfileView& profile,
                                          std::int64_t arrival_ns) {
  std::optional<CutPart> complete;
  const double belt = belt_.add(header);
  const bool pause = any_ && belt_.pause_s() > rule_.pause_s;
  began_with_a_part_ = rule_.cut == rig::PartCut::profile && !any_;
  any_ = true;
  switch (rule_.cut) {
    case rig::PartCut::profile: {
      const double width = grid_.width_above(profile);
      const bool present = width > 0 && width >= rule_.min_width_mm;
      if (in_part_ && !present && belt - present_to_ > rule_.gap_mm) {
        part_.missing += lost_before(header);
        complete = end();
      } else if (in_part_ && belt - present_from_ > rule_.length_mm) {
        part_.too_long = true;
        complete = end();
      }
      if (!in_part_ && present) {
        begin(belt, header);
      }
      if (in_part_) {
        put(belt, header, profile);
        if (present) {
          extend(belt, header, arrival_ns);
        }
      } else {
        keep(belt, profile);
      }
      break;
    }
    case rig::PartCut::image:  // has no profiles; a rig of a light section cannot have it
      break;
    case rig::PartCut::distance:
    case rig::PartCut::trigger: {
      const bool by_distance = rule_.cut == rig::PartCut::distance;
      if (in_part_ && !by_distance && pause) {
        complete = end();
      } else if (in_part_ && std::abs(belt - present_from_) >= rule_.length_mm) {
        part_.too_long = !by_distance;
        complete = end();
      }
      if (!in_part_) {
        begin(belt, header);
      }
      put(belt, header, profile);
      extend(belt, header, arrival_ns);
      break;
    }
  }
  last_sequence_ = header.sequence;
  return complete;
}

std::optional<CutPart> ProfileCutter::finish() {
  if (in_part_ && rule_.cut == rig::PartCut::distance) {  // the beginning of a part is none
    in_part_ = false;
    ++specks_;
  }
  part_.cut_off = part_.cut_off || (rule_.cut == rig::PartCut::profile && part_.last == last_sequence_);
  return in_part_ ? end() : std::nullopt;
}

DepthCutter::DepthCutter(const rig::Rig& rig, int patterns)
    : grid_(rig),
      rule_(*rig.parts),
      clock_hz_(rig.pixel_clock_hz()),
      frame_s_(1 / rig.camera.sent().frame_rate_hz),
      patterns_(static_cast<std::uint64_t>(patterns)),
      sum_(rig.camera.rows, rig.camera.columns),
      count_(rig.camera.rows, rig.camera.columns),
      mean_(rig.camera.rows, rig.camera.columns) {}

std::optional<CutPart> DepthCutter::add(const model::PacketHeader& header, const images::FloatImage& depth,
                                        std::int64_t arrival_ns) {
  if (rule_.cut != rig::PartCut::trigger) {
    CutPart part;
    part.cells = grid_.cells(depth);
    part.first = header.sequence + 1 - patterns_;
    part.last = header.sequence;
    part.frames = patterns_;
    part.last_ns = arrival_ns;
    return part;
  }
  std::optional<CutPart> complete;
  const bool restarted = any_ && header.time_stamp < time_stamp_;
  bool pause = !in_part_ || restarted;
  if (!pause) {
    // Frames that were lost are no pause: they took their time.
    const auto frames = static_cast<double>(header.sequence - sequence_);
    pause = model::seconds_of_clocks(header.time_stamp - time_stamp_, clock_hz_) > rule_.pause_s + frames * frame_s_;
  }
  if (pause) {
    complete = finish();
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
  return complete;
}

void DepthCutter::begin(const model::PacketHeader& header) {
  in_part_ = true;
  part_ = CutPart{};
  // At the first start nothing came before.
  clean_from_ = any_ ? header.sequence + patterns_ : 0;
  images_ = 0;
  std::fill(sum_.values.begin(), sum_.values.end(), 0.0F);
  std::fill(count_.values.begin(), count_.values.end(), 0.0F);
}

void DepthCutter::collect(const model::PacketHeader& header, const images::FloatImage& depth, std::int64_t arrival_ns) {
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

std::optional<CutPart> DepthCutter::finish() {
  if (!in_part_) {
    return std::nullopt;
  }
  in_part_ = false;
  if (images_ == 0) {
    ++specks_;
    return std::nullopt;
  }
  const float least = 0.5F * static_cast<float>(images_);
  for (std::size_t i = 0; i < mean_.values.size(); ++i) {
    mean_.values[i] = count_.values[i] >= least ? sum_.values[i] / count_.values[i] : images::kNoValue;
  }
  part_.cells = grid_.cells(mean_);
  part_.frames = part_.last + 1 - part_.first - std::min(part_.missing, part_.last - part_.first);
  return std::exchange(part_, {});
}

}  // namespace selfproj::production
