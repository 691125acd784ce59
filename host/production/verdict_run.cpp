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
  model.write(table.settings.bank, table.sections);
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
    max_waiting_ = static_cast<std::size_t>(
        std::ceil(kLengths * (rig.parts.value().length_mm + 2 * rig.parts->gap_mm) / tables_->frame_mm()));
  }
}

model::FrameVerdict VerdictRun::judge(model::Verdict& model, const model::PartRule& rule,
                                      const model::VerdictSettings& settings, const model::PacketHeader& header,
                                      const std::vector<std::uint32_t>& m0, const std::vector<std::uint32_t>& m1) {
  const model::FrameVerdict found =
      model.frame(settings, false, rule, header.encoder & model::kCountMask, m0, m1, true);
  if (!found.in_part) {
    return found;
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
  return found;
}

namespace {

std::string verdict_text(const model::FrameVerdict& verdict) {
  if (!verdict.in_part) {
    return "no part";
  }
  return fmt::format("section {}, {} unlit, {}", verdict.section, verdict.unlit,
                     verdict.defect
                         ? fmt::format("a defect of {} columns from {} on", verdict.columns, verdict.first_column)
                         : "no defect");
}

}  // namespace

// Board and model say the same of every frame if they have seen the same frames. The board may have seen more: before
// this program began, or packets that were lost on the way. From the next part on both are in step again.
void VerdictRun::compare(const model::PacketHeader& header, const std::vector<std::uint32_t>& m0,
                         const std::vector<std::uint32_t>& m1, const model::FrameVerdict& here,
                         const std::optional<model::FrameVerdict>& board) {
  const bool gap = !last_sequence_ || header.sequence != *last_sequence_ + 1;
  last_sequence_ = header.sequence;
  if (gap) {
    in_step_ = false;
  }
  if (!board) {
    return;
  }
  ++board_.frames;
  board_.defects += board->defect ? 1 : 0;
  if (!here.in_part && !board->in_part) {
    in_step_ = in_step_ || !gap;
    return;
  }
  if (!in_step_) {
    ++board_.after_gap;
    return;
  }
  if (here.in_part == board->in_part && here.defect == board->defect && here.lacks_light == board->lacks_light &&
      here.section == board->section && here.first_column == board->first_column && here.columns == board->columns &&
      here.unlit == board->unlit) {
    return;
  }
  if (board_.disagree++ == 0) {
    board_.first = fmt::format("frame {}: the board says {}, the model {}", header.sequence + 1, verdict_text(*board),
                               verdict_text(here));
    const int first = board->defect ? board->first_column : here.first_column;
    if (first > 0 && first <= static_cast<int>(m0.size())) {
      const auto column = static_cast<std::size_t>(first - 1);
      const int from = first - 1 - table_.settings.shift_columns;
      const auto section = static_cast<std::size_t>(here.section);
      board_.first += fmt::format("; column {} has M0 = {}, M1 = {}", first, m0[column], m1[column]);
      if (from >= 0 && from < table_.columns && section < table_.sections.size() &&
          !table_.sections[section].limits.empty()) {
        const model::ColumnLimits& limits = table_.sections[section].limits[static_cast<std::size_t>(from)];
        board_.first += fmt::format(" and limits {} and {} of 1/{} row{}", limits.low, limits.high, model::kRowParts,
                                    limits.judged ? "" : ", not judged");
      }
    }
  }
}

void VerdictRun::add(const model::PacketHeader& header, const std::vector<std::uint32_t>& m0,
                     const std::vector<std::uint32_t>& m1, const std::optional<model::FrameVerdict>& board) {
  const auto place = light_section::place_of_frame(rig_.camera, header).value_or(light_section::FramePlace{});
  if (header.columns != table_.columns || header.rows != table_.rows || place.row != table_.row_offset ||
      place.column != table_.column_offset) {
    throw UserError(source_, fmt::format("is for frames of {} x {} pixels from row {}, column {} on; one of {} x {} "
                                         "from row {}, column {} on came",
                                         table_.columns, table_.rows, table_.row_offset + 1, table_.column_offset + 1,
                                         header.columns, header.rows, place.row + 1, place.column + 1));
  }
  if (!tables_) {
    compare(header, m0, m1, judge(model_, table_.rule, table_.settings, header, m0, m1), board);
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
