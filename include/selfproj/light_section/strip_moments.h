// What the kernels of profiles have in common.
#ifndef SELFPROJ_LIGHT_SECTION_STRIP_MOMENTS_H
#define SELFPROJ_LIGHT_SECTION_STRIP_MOMENTS_H

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "selfproj/light_section/profile.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/packet.h"
#include "selfproj/model/packet_payload.h"
#include "selfproj/rig/rig.h"

namespace selfproj::light_section {

// The kernels process this many columns at a time, in steps that each keep to one width of numbers. The intermediate
// results, 3 KiB, stay in the first-level cache beside the tables and the profile. With 512 columns they did not.
inline constexpr int kStrip = 128;

struct StripMoments {
  alignas(64) std::array<std::int32_t, kStrip> m0;
  alignas(64) std::array<std::int32_t, kStrip> m1;
  alignas(64) std::array<std::int32_t, kStrip> n;
  // M0 of the second run in sixteenths of the strongest one's, at most; 0 with Select::all
  alignas(64) std::array<std::int32_t, kStrip> second;
};

// Which lines count.
struct LineRules {
  float rows;    // of the sensor
  float offset;  // rows of the sensor before the frame
  float first;   // row of the frame that counts
  float last;
  std::int32_t min_lit;
  std::int32_t max_lit;
  std::int32_t ambiguous_from;  // in sixteenths: a column whose `second` is that or more is ambiguous
};

// The rules of a rig. Its share of the strongest run, in sixteenths, is rounded up.
inline std::int32_t sixteenths_that_are_ambiguous(const rig::RigMeasure& measure) {
  return static_cast<std::int32_t>(std::ceil(16 * measure.runs.value_or(rig::RigRuns{}).ambiguous_from));
}
// For frames of `rows` rows that begin after `offset` rows of the sensor. The rig's window
// counts rows of the frame, as the board does.
inline LineRules line_rules(const rig::RigCamera& camera, const rig::RigMeasure& measure, int offset, int rows) {
  const model::RowWindow window = measure.window.value_or(model::RowWindow{});
  const int last = window.last == 0 ? rows : std::min(window.last, rows);
  return {.rows = static_cast<float>(camera.rows),
          .offset = static_cast<float>(offset),
          .first = static_cast<float>(std::max(window.first, 1)),
          .last = static_cast<float>(last),
          .min_lit = measure.min_lit_px,
          .max_lit = measure.max_lit_px,
          .ambiguous_from = sixteenths_that_are_ambiguous(measure)};
}
inline LineRules line_rules(const rig::Rig& rig) { return line_rules(rig.camera, rig.measure, 0, rig.camera.rows); }

// The most that `second` may be, in sixteenths. A binary word says only whether it is 8 or more; what it leaves open
// counts against the column.
[[gnu::always_inline]] constexpr std::int32_t max_of_binary_second(std::uint32_t runs, std::uint32_t second) {
  return second >= 8 ? 16 : runs > 1 ? 7 : 0;
}

// `second` as the host has it from a packet, from what RunsView has.
constexpr std::int32_t second_on_board(model::Mode mode, std::uint32_t runs, std::uint32_t second) {
  return mode == model::Mode::binary ? max_of_binary_second(runs, second) : static_cast<std::int32_t>(second);
}

// What a word leaves open counts against the column: 63 lit pixels may be as many as rows, and a second run of 15/16 as
// strong as the first.
template <model::ColumnWord Word>
[[gnu::always_inline]] inline void unpack_strip(const std::uint8_t* payload, int first, int count,
                                                StripMoments& moments) {
  using model::ColumnWord;
  constexpr bool kIsCompact = Word == ColumnWord::compact || Word == ColumnWord::compact_run;
  constexpr std::uint32_t kMany = kIsCompact                          ? spec::kCompactNMax
                                  : Word == ColumnWord::wide_grey_run ? spec::kWideGreyRunNMax
                                                                      : UINT32_MAX;
  constexpr std::int32_t kMostSecond = 15;
  model::for_each_column<Word>(payload, first, count, [&moments](int i, const model::Column& column) {
    const auto at = static_cast<std::size_t>(i);
    moments.m0[at] = static_cast<std::int32_t>(column.m0);
    moments.m1[at] = static_cast<std::int32_t>(column.m1);
    moments.n[at] = static_cast<std::int32_t>(column.n == kMany ? spec::kRowLimit : column.n);
    const std::int32_t second = model::is_run(Word) ? column.second : 0;
    moments.second[at] = Word == ColumnWord::binary_run ? max_of_binary_second(column.runs, column.second)
                         : Word == ColumnWord::compact_run && second == kMostSecond ? kMostSecond + 1
                                                                                    : second;
  });
}

// The same of any words.
[[gnu::always_inline]] inline void unpack_strip(model::ColumnWord word, const std::uint8_t* payload, int first,
                                                int count, StripMoments& moments) {
  const auto unpack = [&]<model::ColumnWord Word>() __attribute__((always_inline)) {
    unpack_strip<Word>(payload, first, count, moments);
  };
  model::with_word(word, unpack);
}

[[gnu::always_inline]] inline void copy_runs(const model::RunsView& from, int first, int count, StripMoments& moments) {
  for (int i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    moments.m0[at] = static_cast<std::int32_t>(from.moments.m0[first + i]);
    moments.m1[at] = static_cast<std::int32_t>(from.moments.m1[first + i]);
    moments.n[at] = static_cast<std::int32_t>(from.moments.n[first + i]);
    moments.second[at] = from.second == nullptr ? 0 : from.second[first + i];
  }
}

constexpr std::int32_t code(Validity validity) { return static_cast<std::int32_t>(validity); }

// The validity of a column with centroid c, where `found` is what triangulation says.
[[gnu::always_inline]] inline std::int32_t validity_of(float c, std::int32_t m0, std::int32_t n, std::int32_t second,
                                                       std::int32_t has_reference, std::int32_t found,
                                                       const LineRules& rules) {
  std::int32_t s = has_reference != 0 ? found : code(Validity::no_reference);
  s = second >= rules.ambiguous_from ? code(Validity::ambiguous) : s;
  s = line_is_cut_off(c, static_cast<float>(n), rules.first, rules.last) ? code(Validity::cut_off) : s;
  s = n > rules.max_lit ? code(Validity::too_wide) : s;
  s = n < rules.min_lit ? code(Validity::too_few) : s;
  s = n == 0 ? code(Validity::unlit) : s;
  s = m0 == 0 ? code(Validity::unlit) : s;
  return s;
}

}  // namespace selfproj::light_section

#endif  // SELFPROJ_LIGHT_SECTION_STRIP_MOMENTS_H
