#include "host/production/part_cutter.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "host/files/user_error.h"

namespace selfproj {
namespace {

constexpr double kKeptPerCell = 4;  // frames that are kept before a part, at most, for each cell
constexpr std::size_t kMostKeptBefore = 512;

const Rig& with_parts(const Rig& rig) {
  if (!rig.parts) {
    throw UserError(rig.name, "has no section `parts`, which says how the stream is cut into parts");
  }
  return rig;
}

std::size_t ring_size(const Rig& rig) {
  const RigParts& rule = *rig.parts;
  if (rule.cut != PartCut::profile) {
    return 0;
  }
  const double frames = std::ceil(kKeptPerCell * rule.gap_mm / rule.grid_mm);
  return static_cast<std::size_t>(std::clamp(frames, 1.0, static_cast<double>(kMostKeptBefore)));
}

}  // namespace

PartCutter::PartCutter(const Rig& rig, Take take)
    : rig_(with_parts(rig)), rule_(*rig_.parts), take_(std::move(take)), belt_(rig_), grid_(rig_) {
  before_.resize(ring_size(rig_));
  for (Kept& kept : before_) {
    kept.profile.resize(rig_.camera.columns);
  }
}

// Frames that are nearer to each other than a quarter of a cell say nothing new.
void PartCutter::keep(double belt, const ProfileView& profile) {
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

void PartCutter::begin(double belt, const PacketHeader& header) {
  in_part_ = true;
  part_ = {};
  part_.first = header.sequence;
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

void PartCutter::put(double belt, const PacketHeader& header, const ProfileView& profile) {
  const bool first = present_to_ == present_from_ && part_.first == header.sequence;
  if (!first) {
    part_.missing += header.sequence > last_sequence_ ? header.sequence - last_sequence_ - 1 : 0;
    part_.restarted = part_.restarted || belt_.restarted();
  }
  grid_.add(belt, profile);
  ++part_.frames;
}

void PartCutter::extend(double belt, const PacketHeader& header, std::int64_t arrival_ns) {
  present_to_ = belt;
  part_.last = header.sequence;
  part_.last_ns = arrival_ns;
}

void PartCutter::end() {
  in_part_ = false;
  part_.length_mm = present_to_ - present_from_;
  if (rule_.cut != PartCut::distance && part_.length_mm < rule_.min_length_mm) {
    ++specks_;
    return;
  }
  part_.cells = grid_.cells();
  take_(std::move(part_));
  part_ = {};
}

void PartCutter::add(const PacketHeader& header, const ProfileView& profile, std::int64_t arrival_ns) {
  const double belt = belt_.add(header);
  const bool pause = any_ && belt_.pause_s() > rule_.pause_s;
  any_ = true;
  switch (rule_.cut) {
    case PartCut::profile: {
      const double width = grid_.width_above(profile);
      const bool present = width > 0 && width >= rule_.min_width_mm;
      if (in_part_ && !present && belt - present_to_ > rule_.gap_mm) {
        end();
      } else if (in_part_ && belt - present_from_ > rule_.length_mm) {
        part_.too_long = true;
        end();
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
    case PartCut::image:  // has no profiles; a rig of a light section cannot have it
      break;
    case PartCut::distance:
    case PartCut::trigger: {
      const bool by_distance = rule_.cut == PartCut::distance;
      if (in_part_ && !by_distance && pause) {
        end();
      } else if (in_part_ && std::abs(belt - present_from_) >= rule_.length_mm) {
        part_.too_long = !by_distance;
        end();
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
}

void PartCutter::finish() {
  if (!in_part_) {
    return;
  }
  if (rule_.cut == PartCut::distance) {  // the beginning of a part is none
    in_part_ = false;
    ++specks_;
  } else {
    end();
  }
}

}  // namespace selfproj
