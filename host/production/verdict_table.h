// Tables for the verdict inside the circuit (selfproj/model/verdict.h), computed from rig, reference and tolerance.
#ifndef SELFPROJ_HOST_PRODUCTION_VERDICT_TABLE_H
#define SELFPROJ_HOST_PRODUCTION_VERDICT_TABLE_H

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/production/part_reference.h"
#include "host/production/placement.h"
#include "host/production/tolerance.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/model/verdict.h"
#include "selfproj/rig/rig.h"

namespace selfproj::production {

// What a board needs to judge parts: limits of each section, settings, and where parts begin and end.
struct VerdictTable {
  using Section = model::SectionLimits;

  std::string rig;  // its name
  int columns = 0;  // of a frame
  int rows = 0;
  int row_offset = 0;  // rows and columns of the sensor before the frame
  int column_offset = 0;
  double column_mm = 0;  // by how much the next column lies further across on the part; may be less than 0
  double row_mm = 0;     // by how much one row further down is higher; less than 0: lower
  // What the limits were made with (VerdictOptions), for those of other shifts
  double margin_mm = 0;
  double play_across_mm = 0;
  double play_along_mm = 0;
  double lit_rows = 0;
  std::optional<double> section_mm = {};
  std::optional<double> frame_mm = {};
  std::optional<double> shift_mm = {};  // for parts so far across from where the reference lay; nothing: not known
  std::optional<double> encoder_mm_per_count = {};  // by which counts are made of mm; nothing: not known
  int max_shift_columns = 0;  // the limits hold for settings.shift_columns of up to this, both ways
  model::VerdictSettings settings = {};
  model::PartRule rule = {};
  std::vector<Section> sections = {};  // 1 to kMaxVerdictSections

  // Columns that are judged in at least one section.
  [[nodiscard]] int judged() const;
  bool operator==(const VerdictTable&) const = default;
};

inline constexpr int kMaxVerdictSections = 64;

// The settings for a part that lies `across_mm` further to the right and `higher_mm` higher than the one the table was
// made for. Throws UserError, naming `source`, if the table does not hold for it.
model::VerdictSettings shifted_settings(const VerdictTable& table, double across_mm, double higher_mm,
                                        const std::string& source);

enum class TooFar : std::uint8_t { high, low, either };

struct VerdictOptions {
  // Extent of the smallest defect that must be found; nothing: the square of the tolerance's smallest area.
  std::optional<double> defect_across_mm = {};
  std::optional<double> defect_along_mm = {};
  double false_alarms = 1e-4;  // of noise, in each good part, at most
  TooFar look_for = TooFar::either;
  double margin_mm = 0;                     // limits are further off by this
  double play_across_mm = 0.25;             // a part may lie so far beside where it is said to lie
  std::optional<double> play_along_mm{};    // and begin so much earlier or later; nothing: half a line and a frame
  std::optional<double> lit_rows{};         // that the line lights; nothing: light_section::usual_lit_rows
  double max_shift_mm = 0;                  // the shift of settings may be so large
  std::optional<double> section_mm{};       // length of a section; nothing: they begin where regions begin or end
  std::optional<double> frame_mm{};         // of the belt, from frame to frame; nothing: by the rig's speed and rate
  std::optional<int> max_unlit{};           // judged columns of a frame; nothing: light is not judged
  std::optional<std::uint32_t> start{};     // parts by the encoder: count at which part 0 begins; nothing: by light
  std::optional<std::uint32_t> pitch = {};  // and counts from part to part
};

// What was decided, for people.
struct VerdictFacts {
  double frame_mm = 0;         // of the belt, from frame to frame
  double narrowest_mm = 0;     // of all judged columns, half the least and half the greatest band
  double widest_mm = 0;        //
  double rounding_mm = 0;      // limits are further off than the tolerance says by up to this: one part of a row
  double found_across_mm = 0;  // whatever has this extent and is off by found_depth_mm is found 999 times in 1000
  double found_along_mm = 0;
  double found_depth_mm = 0;
  double noise_mm = 0;       // standard deviation of a column's height by the rig's section `imaging`
  double false_alarms = 0;   // of noise, in a good part, at most
  double judged = 0;         // share of the regions' area that is judged, about
  bool finds_defect = true;  // found_across_mm and found_along_mm are within the defect that was asked for
};

// What of a table can never happen, as it stands: one line for each, for people.
std::vector<std::string> never(const VerdictTable& table);

// Computes tables for one rig, reference and tolerance.
//
// A column of a section is judged if
//   - the pattern does not jump there or within kBesideWalls columns (SectionReference::jumps),
//   - all places of the part that may pass it in this section lie in the same region of the tolerance, or in the inner
//     half of the strip around it (Tolerance::edge_mm): the part may be beside its place by play_across_mm, and begin
//     earlier or later by play_along_mm,
//   - the line stays within the rows that count as long as the part is within the tolerance, so that it is not cut off,
//   - and heights rise or fall with the rows all the way to it.
//
// Its limits are the last rows, in 1/kRowParts, that are outside of the tolerance: those of the profiler's own heights
// at these centroids, less the reference at the place that the profiler gives. Limits are rounded away from the
// tolerance, and floating-point numbers count as rounded against it. So a column whose difference from the reference
// (as the host computes it) is within the tolerance of every region there is never out.
class VerdictTables {
 public:
  // Throws UserError, naming `source`, as check_tolerance does, if the rig's belt does not go by an encoder that counts
  // up, or if options do not go together.
  VerdictTables(const rig::Rig& rig, const light_section::ReferenceProfile& reference, const Tolerance& tolerance,
                const VerdictOptions& options, const std::string& source);

  // The table for a part that is shifted across by `shift_mm`. Throws UserError if no column can be judged, the part
  // needs more than kMaxVerdictSections sections, or light does not tell where parts begin.
  [[nodiscard]] VerdictTable table(double shift_mm = 0) const;

  [[nodiscard]] VerdictFacts facts(const VerdictTable& table) const;

  // How far the belt moves from frame to frame.
  [[nodiscard]] double frame_mm() const { return frame_mm_; }

  // The table for a part whose place is known: shifted as it lies, and with no more play along than its edges and its
  // turn leave. Throws as table() does.
  [[nodiscard]] VerdictTable table(const Placement& placement) const;

  // Of a part that lies like this: where along, from the beginning of its map, its leading edge meets the light in the
  // middle of it; there a part begins. And how many counts it takes from there.
  [[nodiscard]] double leading_edge_mm(const Placement& placement) const;
  [[nodiscard]] std::uint32_t length_counts() const;

 private:
  struct Range {
    double low = 0, high = 0;
    bool operator==(const Range&) const = default;
  };
  // Where a region of the tolerance is seen: of each column the place across at the middle of the band, on the part,
  // and how far from there it is at other heights of the band; nothing where it is not seen. Along the belt it is seen
  // `along_mm` behind where the light meets the part: of the region in the middle, more or less by `spread_mm`.
  struct SeenPlace {
    double across_mm = 0;
    double along_mm = 0;
    double play_mm = 0;
  };
  struct SeenRegion {
    std::vector<std::optional<SeenPlace>> places;
    double along_mm = 0;
    double spread_mm = 0;
  };
  // A part that is shifted across.
  struct Placed {
    double shift_mm = 0;
    double play_along_mm = 0;
    std::vector<float> difference;  // of each column at the rows 1, 2, ...
    std::vector<SeenRegion> regions;
  };
  // What a section asks of each column: the difference that it may have.
  using Wanted = std::vector<std::optional<Range>>;
  using Limits = std::vector<model::ColumnLimits>;

  [[nodiscard]] std::size_t at(int row, int column) const {
    return static_cast<std::size_t>(row - 1) * static_cast<std::size_t>(rig_.camera.columns) +
           static_cast<std::size_t>(column);
  }
  void sample();
  void measure_scale();
  [[nodiscard]] Placed placed(double shift_mm, double play_along_mm) const;
  [[nodiscard]] int row_of(const Placed& part, int column, double difference_mm) const;
  [[nodiscard]] std::vector<double> boundaries(const Placed& part) const;
  [[nodiscard]] bool in_strip(std::size_t region, double along0, double along1, double across0, double across1) const;
  [[nodiscard]] Wanted wanted(const Placed& part, double from_mm, double to_mm) const;
  [[nodiscard]] Limits limits(const Placed& part, const Wanted& wanted) const;
  [[nodiscard]] VerdictTable table(double shift_mm, double play_along_mm) const;
  [[nodiscard]] std::vector<Limits> limits_of_stretches(const Placed& part, const std::vector<double>& begins) const;
  void set_rule(VerdictTable& table, double shift_mm) const;
  void set_settings(VerdictTable& table) const;
  [[nodiscard]] double noise_rows() const;
  [[nodiscard]] double false_alarms(const VerdictTable& table) const;

  rig::Rig rig_;
  rig::RigRegion sent_;
  Tolerance tolerance_;
  VerdictOptions options_;
  std::string source_;
  light_section::DifferentialProfiler profiler_;  // of the whole sensor; all its rows count
  SectionReference section_;
  std::vector<std::pair<double, double>> jumps_;
  std::vector<ToleranceRegion> widened_;  // the regions, with half of the strip around them
  double widest_mm_ = 0;                  // between neighbouring points of the section
  double lit_rows_ = 0;
  double first_ = 0, last_ = 0;  // rows of the sensor that count
  double frame_mm_ = 0;
  double play_along_mm_ = 0;
  double light_mm_ = 0;  // x of the light on the plane
  double meets_mm_ = 0;  // the light meets parts so much further along
  double reach_mm_ = 0;  // and the last one of its regions so much later
  // Of each column of the sensor, at the rows 1, 2, ...; NaN where there is no point.
  std::vector<float> height_, across_, along_;
  double column_mm_ = 0;  // as in VerdictTable
  double row_mm_ = 0;
};

}  // namespace selfproj::production

#endif  // SELFPROJ_HOST_PRODUCTION_VERDICT_TABLE_H
