#include "host/production/verdict_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/production/verdict_file.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/differential_profile.h"

namespace selfproj::production {
namespace {

constexpr std::size_t kMaxRecent = 1U << 16U;

model::Verdict model_of(const VerdictTable& table) {
  model::Verdict model(table.columns, static_cast<int>(table.sections.size()));
  for (std::size_t s = 0; s < table.sections.size(); ++s) {
    const VerdictTable::Section& section = table.sections[s];
    for (int c = 0; c < table.columns; ++c) {
      model.write(table.settings.bank, static_cast<int>(s), c, section.limits[static_cast<std::size_t>(c)]);
    }
    if (s > 0) {
      model.begin_section(table.settings.bank, static_cast<int>(s), section.begin);
    }
  }
  return model;
}

}  // namespace

VerdictRun::VerdictRun(const rig::Rig& rig, VerdictTable table, std::string source, std::size_t keep,
                       std::unique_ptr<const VerdictTables> tables)
    : rig_(rig),
      table_(std::move(table)),
      source_(std::move(source)),
      keep_(keep),
      tables_(std::move(tables)),
      model_(model_of(table_)),
      belt_(rig) {
  check_verdict_table(table_, rig, source_);
  if (tables_) {
    // A part waits until it has passed.
    constexpr double kLengths = 2;
    const double frame_mm = rig.conveyor.speed_mm_per_s / rig.camera.sent().frame_rate_hz;
    max_waiting_ = static_cast<std::size_t>(
        std::ceil(kLengths * (rig.parts.value().length_mm + 2 * rig.parts->gap_mm) / frame_mm));
  }
}

void VerdictRun::judge(model::Verdict& model, const model::PartRule& rule, const model::VerdictSettings& settings,
                       const model::PacketHeader& header, const std::vector<std::uint32_t>& m0,
                       const std::vector<std::uint32_t>& m1) {
  const model::FrameVerdict found = model.frame(settings, rule, header.encoder & model::kCountMask, m0, m1, true);
  if (!found.in_part) {
    return;
  }
  if (part_ != found.part) {
    part_ = found.part;
    defect_ = false;
    ++parts_;
  }
  parts_with_defect_ += found.defect && !defect_ ? 1 : 0;
  defect_ = defect_ || found.defect;
  ++judged_frames_;
  defect_frames_ += found.defect ? 1 : 0;
  const JudgedFrame frame{header.sequence, found};
  recent_.push_back(frame);
  if (recent_.size() > kMaxRecent) {
    recent_.pop_front();
  }
  if (kept_.size() < keep_) {
    kept_.push_back(frame);
  }
}

void VerdictRun::add(const model::PacketHeader& header, const std::vector<std::uint32_t>& m0,
                     const std::vector<std::uint32_t>& m1) {
  const auto place = light_section::place_of_frame(rig_.camera, header).value_or(light_section::FramePlace{});
  if (header.columns != table_.columns || header.rows != table_.rows || place.row != table_.row_offset ||
      place.column != table_.column_offset) {
    throw UserError(source_, fmt::format("is for frames of {} x {} pixels from row {}, column {} on; one of {} x {} "
                                         "from row {}, column {} on came",
                                         table_.columns, table_.rows, table_.row_offset + 1, table_.column_offset + 1,
                                         header.columns, header.rows, place.row + 1, place.column + 1));
  }
  if (!tables_) {
    judge(model_, table_.rule, table_.settings, header, m0, m1);
    return;
  }
  waiting_.push_back({belt_.add(header), header, m0, m1});
  if (waiting_.size() > max_waiting_) {
    waiting_.pop_front();
  }
}

void VerdictRun::judge_placed(const CutPart& part, const Placement& placement) {
  VerdictTable table = tables_->table(placement);
  table.settings.bank = table_.settings.bank;
  model::Verdict model = model_of(table);
  const double edge_mm = part.begin_mm + tables_->leading_edge_mm(placement);
  const auto first =
      std::find_if(waiting_.begin(), waiting_.end(), [&](const Waiting& frame) { return frame.belt_mm >= edge_mm; });
  if (first == waiting_.end()) {
    return;
  }
  // Counts wrap as those of the circuit do.
  const auto before =
      static_cast<std::int64_t>(std::llround((first->belt_mm - edge_mm) / rig_.conveyor.encoder_mm_per_count));
  const model::PartRule rule{.by_encoder = true,
                             .start = static_cast<std::uint32_t>(first->header.encoder - before) & model::kCountMask,
                             .length = tables_->length_counts(),
                             .pitch = model::kCountMask / 2};
  model::VerdictSettings settings = table_.settings;
  settings.shift_columns = settings.shift_rows = 0;  // the limits are shifted
  part_.reset();
  for (auto frame = first; frame != waiting_.end(); ++frame) {
    judge(model, rule, settings, frame->header, frame->m0, frame->m1);
  }
}

std::optional<PartMoments> VerdictRun::judge(const CutPart& part, const PartResult& result) {
  const bool placed = result.placement && result.verdict != Verdict::inconclusive;
  if (tables_ && placed) {
    judge_placed(part, *result.placement);
  }
  while (!waiting_.empty() && waiting_.front().header.sequence <= part.last) {
    waiting_.pop_front();
  }
  PartMoments found;
  for (const JudgedFrame& frame : recent_) {
    if (frame.sequence < part.first || frame.sequence > part.last) {
      continue;
    }
    ++found.frames;
    found.dark_frames += frame.verdict.lacks_light ? 1 : 0;
    if (frame.verdict.defect) {
      if (found.defect_frames++ == 0) {
        found.first_frame = frame.sequence;
        found.first_column = frame.verdict.first_column;
      }
      found.columns = std::max(found.columns, frame.verdict.columns);
    }
  }
  while (!recent_.empty() && recent_.front().sequence <= part.last) {
    recent_.pop_front();
  }
  return tables_ && !placed ? std::nullopt : std::optional(found);
}

std::string judged_csv(const std::vector<JudgedFrame>& frames) {
  std::string text = "sequence,part,section,defect,first_column,columns,unlit,lacks_light\n";
  for (const JudgedFrame& frame : frames) {
    const model::FrameVerdict& v = frame.verdict;
    fmt::format_to(std::back_inserter(text), "{},{},{},{},{},{},{},{}\n", frame.sequence, v.part, v.section,
                   v.defect ? 1 : 0, v.first_column, v.columns, v.unlit, v.lacks_light ? 1 : 0);
  }
  return text;
}

}  // namespace selfproj::production
