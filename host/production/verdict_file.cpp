#include "host/production/verdict_file.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "host/files/input_file.h"
#include "host/files/text.h"
#include "host/rig/yaml.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/generated/selfproj_spec.h"
#include "selfproj/model/verdict.h"

namespace selfproj::production {
namespace {

constexpr int kMaxCount = (1 << 23) - 1;                   // half of the encoder's counts: further on is before
constexpr std::size_t kMostBytes = std::size_t{1} << 23U;  // 64 sections of 4096 columns take less
const std::vector<std::pair<const char*, bool>> kYesNo = {{"yes", true}, {"no", false}};
const std::vector<std::pair<const char*, bool>> kBegins = {{"light", false}, {"encoder", true}};

template <class TableT, class Visitor>
void visit_frames(TableT& table, Visitor& v) {
  v.text("rig", table.rig);
  v.begin("frames");
  v.integer("columns", table.columns, 4, spec::kColumnLimit);
  v.integer("rows", table.rows, 1, spec::kMaxRows);
  v.integer("column_offset", table.column_offset, 0, spec::kColumnLimit);
  v.integer("row_offset", table.row_offset, 0, spec::kMaxRows);
  v.number("column_mm", table.column_mm, 1, rig::kNotZero);
  v.number("row_mm", table.row_mm, 1, rig::kNotZero);
  v.end();
}

template <class TableT, class Visitor>
void visit_made_with(TableT& table, Visitor& v) {
  v.begin("made_with");
  v.number("margin_mm", table.margin_mm, 1, rig::kNotNegative);
  v.number("play_across_mm", table.play_across_mm, 1, rig::kNotNegative);
  v.number("play_along_mm", table.play_along_mm, 1, rig::kNotNegative);
  v.number("lit_rows", table.lit_rows, 1, rig::kPositive);
  if (v.has_any({"section_mm"}, table.section_mm)) {
    v.number("section_mm", *table.section_mm, 1, rig::kPositive);
  }
  if (v.has_any({"frame_mm"}, table.frame_mm)) {
    v.number("frame_mm", *table.frame_mm, 1, rig::kPositive);
  }
  if (v.has_any({"shift_mm"}, table.shift_mm)) {  // not in files of earlier versions
    v.number("shift_mm", *table.shift_mm, 1, rig::kAny);
  }
  if (v.has_any({"encoder_mm_per_count"}, table.encoder_mm_per_count)) {  // likewise
    v.number("encoder_mm_per_count", *table.encoder_mm_per_count, 1, rig::kPositive);
  }
  v.end();
}

template <class TableT, class Visitor>
void visit_settings(TableT& table, Visitor& v) {
  auto& settings = table.settings;
  v.begin("defect");
  v.integer("width", settings.width, 1, 255);
  v.integer("history", settings.history, 1, model::kMaxHistory);
  v.integer("hits", settings.hits, 1, model::kMaxHistory);
  v.choice("above", settings.above, kYesNo);
  v.choice("below", settings.below, kYesNo);
  v.integer("most_unlit", settings.most_unlit, 0, model::kUnlitNotJudged);
  v.integer("shift_columns", settings.shift_columns, -model::kMaxShiftColumns, model::kMaxShiftColumns);
  v.integer("shift_rows", settings.shift_rows, -model::kMaxShiftRows, model::kMaxShiftRows);
  v.integer("max_shift_columns", table.max_shift_columns, 0, model::kMaxShiftColumns);
  v.end();
}

// Counts are numbers of 24 bits, which an int holds.
template <class Visitor>
void visit_count(std::uint32_t& count, Visitor& v, const char* key, int low, int high) {
  auto value = static_cast<int>(count);
  v.integer(key, value, low, high);
  count = static_cast<std::uint32_t>(value);
}

template <class Visitor>
void visit_rule(model::PartRule& rule, Visitor& v) {
  v.begin("parts");
  v.choice("begin_by", rule.by_encoder, kBegins);
  if (rule.by_encoder) {
    visit_count(rule.start, v, "start_counts", 0, static_cast<int>(model::kCountMask));
    visit_count(rule.length, v, "length_counts", 1, kMaxCount);
    visit_count(rule.pitch, v, "pitch_counts", 2, kMaxCount);
  } else {
    v.integer("lit_columns", rule.lit, 1, 4095);
    v.integer("dark_frames", rule.dark_frames, 1, 255);
  }
  v.end();
}

// The limits of a row of neighbouring columns that are judged.
std::string stretch_text(const std::vector<model::ColumnLimits>& limits, std::size_t first, std::size_t end) {
  std::string low;
  std::string high;
  for (std::size_t i = first; i < end; ++i) {
    low += fmt::format("{}{}", i == first ? "" : ", ", limits[i].low);
    high += fmt::format("{}{}", i == first ? "" : ", ", limits[i].high);
  }
  return fmt::format("      - first_column: {}\n        low: [{}]\n        high: [{}]\n", first + 1, low, high);
}

std::string section_text(const VerdictTable::Section& section) {
  std::string stretches;
  const std::vector<model::ColumnLimits>& limits = section.limits;
  for (std::size_t first = 0; first < limits.size();) {
    std::size_t end = first;
    while (end < limits.size() && limits[end].judged) {
      ++end;
    }
    stretches += end > first ? stretch_text(limits, first, end) : std::string();
    first = end + 1;
  }
  return fmt::format("  - begin_counts: {}\n    columns:{}\n{}", section.begin, stretches.empty() ? " []" : "",
                     stretches);
}

// A list that FieldReader has no word for.
YAML::Node list_of(const YAML::Node& node, const char* key, const std::string& source, std::size_t most) {
  const YAML::Node list = node[key];
  if (!list.IsDefined() || !list.IsSequence()) {
    throw UserError(source,
                    fmt::format("is no verdict table: {} must be a list, as `selfproj verdict table` writes it", key));
  }
  if (list.size() > most) {
    throw UserError(source, fmt::format("{} has {} entries; at most {} are possible", key, list.size(), most));
  }
  return list;
}

YAML::Node without(const YAML::Node& node, const char* key) {
  YAML::Node rest(YAML::NodeType::Map);
  for (const auto& entry : node) {
    if (!entry.first.IsScalar() || entry.first.Scalar() != key) {
      rest[entry.first] = entry.second;
    }
  }
  return rest;
}

const YAML::Node& expect_map(const YAML::Node& node, const std::string& source) {
  if (!node.IsMap()) {
    throw UserError(source, "is not a map of keys");
  }
  return node;
}

void read_stretch(const YAML::Node& node, const std::string& source, VerdictTable::Section& section,
                  std::size_t& free_from) {
  rig::FieldReader reader(source, expect_map(node, source));
  int first = 0;
  std::vector<double> low;
  std::vector<double> high;
  reader.integer("first_column", first, 1, static_cast<int>(section.limits.size()));
  constexpr rig::ValueRange kLimit{.low = 0, .high = model::kMaxLimit};
  reader.numbers("low", low, 1, kLimit);
  reader.numbers("high", high, 1, kLimit);
  reader.end();
  const auto at = static_cast<std::size_t>(first - 1);
  if (low.empty() || low.size() != high.size()) {
    throw UserError(source, fmt::format("low has {} numbers and high {}; as many are expected, and at least one",
                                        low.size(), high.size()));
  }
  if (at < free_from || at + low.size() > section.limits.size()) {
    throw UserError(source, fmt::format("has columns {} to {}; they must follow column {} and end before {}", first,
                                        at + low.size(), free_from, section.limits.size() + 1));
  }
  for (std::size_t i = 0; i < low.size(); ++i) {
    if (low[i] != std::floor(low[i]) || high[i] != std::floor(high[i]) || low[i] > high[i]) {
      throw UserError(source, fmt::format("column {} has the limits {} and {}; whole numbers are expected, the first "
                                          "no greater than the second",
                                          at + i + 1, low[i], high[i]));
    }
    if (high[i] - low[i] > model::kMaxBand) {
      throw UserError(source,
                      fmt::format("column {} has the limits {} and {}; a board takes them no more than {} apart",
                                  at + i + 1, low[i], high[i], model::kMaxBand));
    }
    section.limits[at + i] = {
        .low = static_cast<std::uint32_t>(low[i]), .high = static_cast<std::uint32_t>(high[i]), .judged = true};
  }
  free_from = at + low.size();
}

VerdictTable::Section read_section(const YAML::Node& node, const std::string& source, int columns) {
  VerdictTable::Section section;
  section.limits.resize(static_cast<std::size_t>(columns));
  const YAML::Node stretches = list_of(expect_map(node, source), "columns", source, static_cast<std::size_t>(columns));
  rig::FieldReader reader(source, without(node, "columns"));
  visit_count(section.begin, reader, "begin_counts", 0, kMaxCount);
  reader.end();
  std::size_t free_from = 0;
  std::size_t number = 0;
  for (const auto& stretch : stretches) {
    read_stretch(stretch, fmt::format("{}: columns, entry {}", source, ++number), section, free_from);
  }
  return section;
}

}  // namespace

std::string to_yaml(const VerdictTable& table) {
  rig::FieldWriter writer;
  VerdictTable copy = table;  // visitors change what they read
  visit_frames(table, writer);
  visit_made_with(copy, writer);
  visit_settings(copy, writer);
  visit_rule(copy.rule, writer);
  std::string text = writer.yaml() + "sections:\n";
  for (const VerdictTable::Section& section : table.sections) {
    text += section_text(section);
  }
  return text;
}

VerdictTable parse_verdict_table(const std::string& yaml, const std::string& source) {
  const YAML::Node root = rig::parse_yaml(yaml, source);
  if (!root.IsMap()) {
    throw UserError(source, "is not a verdict table; keys and values are expected");
  }
  const YAML::Node sections = list_of(root, "sections", source, kMaxVerdictSections);
  VerdictTable table;
  rig::FieldReader reader(source, without(root, "sections"));
  visit_frames(table, reader);
  visit_made_with(table, reader);
  visit_settings(table, reader);
  visit_rule(table.rule, reader);
  reader.end();
  if (table.columns % 4 != 0) {
    throw UserError(source, fmt::format("frames.columns is {}; it must be a multiple of 4", table.columns));
  }
  if (!table.rule.by_encoder && table.rule.lit > table.columns) {
    throw UserError(source,
                    fmt::format("parts.lit_columns is {}; the frames have {} columns", table.rule.lit, table.columns));
  }
  if (table.settings.hits > table.settings.history) {
    throw UserError(source, fmt::format("defect.hits is {}, and history {}; it must not be greater",
                                        table.settings.hits, table.settings.history));
  }
  if (std::abs(table.settings.shift_columns) > table.max_shift_columns) {
    throw UserError(source, fmt::format("defect.shift_columns is {}; the limits hold for up to {} (max_shift_columns)",
                                        table.settings.shift_columns, table.max_shift_columns));
  }
  if (table.rule.by_encoder && table.rule.pitch <= table.rule.length) {
    throw UserError(source, fmt::format("parts.pitch_counts is {}, and length_counts {}; it must be greater",
                                        table.rule.pitch, table.rule.length));
  }
  for (const auto& node : sections) {
    const std::string where = fmt::format("{}: section {}", source, table.sections.size() + 1);
    VerdictTable::Section section = read_section(node, where, table.columns);
    const std::uint32_t before = table.sections.empty() ? 0 : table.sections.back().begin;
    if (table.sections.empty() ? section.begin != 0 : section.begin <= before) {
      throw UserError(where, fmt::format("begins at count {}; {}", section.begin,
                                         table.sections.empty() ? std::string("the first one must begin at 0")
                                                                : fmt::format("the one before begins at {}", before)));
    }
    table.sections.push_back(std::move(section));
  }
  if (table.sections.empty()) {
    throw UserError(source, "sections is empty");
  }
  check_rows(table, source);
  return table;
}

void check_rows(const VerdictTable& table, const std::string& source) {
  const int lowest = model::kRowParts, highest = model::kRowParts * table.rows;
  for (const VerdictTable::Section& section : table.sections) {
    for (std::size_t i = 0; i < section.limits.size(); ++i) {
      const model::ColumnLimits& limits = section.limits[i];
      const int low = static_cast<int>(limits.low) + table.settings.shift_rows;
      const int high = static_cast<int>(limits.high) + table.settings.shift_rows;
      if (limits.judged && (low < lowest || high > highest)) {
        throw UserError(source, fmt::format("column {} has limits at the rows {:.2f} and {:.2f}{}; the frames have "
                                            "rows 1 to {}",
                                            i + 1, static_cast<double>(low) / model::kRowParts,
                                            static_cast<double>(high) / model::kRowParts,
                                            table.settings.shift_rows != 0 ? ", shifted" : "", table.rows));
      }
    }
  }
}

VerdictTable load_verdict_table(const std::string& file) {
  return parse_verdict_table(files::read_text(file, kMostBytes), file);
}

void check_verdict_table(const VerdictTable& table, const rig::Rig& rig, const std::string& source) {
  const rig::RigRegion sent = rig.camera.sent();
  if (table.columns != sent.columns || table.rows != sent.rows || table.row_offset != sent.row_offset ||
      table.column_offset != sent.column_offset) {
    throw UserError(source,
                    fmt::format("is for frames of {} x {} pixels from row {}, column {} on; those of {} have "
                                "{} x {} from row {}, column {} on",
                                table.columns, table.rows, table.row_offset + 1, table.column_offset + 1, rig.name,
                                sent.columns, sent.rows, sent.row_offset + 1, sent.column_offset + 1));
  }
  constexpr double kOther = 0.01;  // by more than calibrations differ
  const double encoder = rig.conveyor.encoder_mm_per_count;
  if (table.encoder_mm_per_count && std::abs(encoder / *table.encoder_mm_per_count - 1) > kOther) {
    throw UserError(source, fmt::format("is for an encoder of {} mm a count; {} has {}", *table.encoder_mm_per_count,
                                        rig.name, encoder));
  }
  if (rig.parts && !rig.parts->by_encoder) {
    throw UserError(source, fmt::format("its parts and sections are those of an encoder's counts, and the section "
                                        "`parts` of {} says belt: clock",
                                        rig.name));
  }
}

}  // namespace selfproj::production
