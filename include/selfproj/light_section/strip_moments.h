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

// What the words of a payload are.
struct ColumnWords {
  model::Select select = model::Select::all;
  model::Mode mode = model::Mode::grey_over;
  bool compact = false;
  bool wide = false;  // model::has_wide_words
  bool tall = false;  // of a build for more than 1,023 rows
};

// Those of a packet for which has_columns holds.
inline ColumnWords words_of(const model::PacketHeader& header) {
  return {.select = static_cast<model::Select>(header.select),
          .mode = static_cast<model::Mode>(header.mode),
          .compact = header.kind == spec::kKindCompact,
          .wide = model::has_wide_words(header),
          .tall = header.tall};
}

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

// What for_each_binary_word and for_each_grey_word call: takes the moments of all lit pixels, which have no second run.
[[gnu::always_inline]] inline auto take_moments(StripMoments& moments) {
  moments.second.fill(0);
  return [&moments](int i, std::uint32_t m0, std::uint32_t m1, std::uint32_t n) {
    const auto at = static_cast<std::size_t>(i);
    moments.m0[at] = static_cast<std::int32_t>(m0);
    moments.m1[at] = static_cast<std::int32_t>(m1);
    moments.n[at] = static_cast<std::int32_t>(n);
  };
}

// Words with the strongest run, and runs as numbers.
[[gnu::always_inline]] inline void unpack_binary_runs(const std::uint8_t* payload, int first, int count,
                                                      StripMoments& moments) {
  model::for_each_binary_run_word(
      payload, first, count,
      [&](int i, std::uint32_t m0, std::uint32_t m1, std::uint32_t n, std::uint8_t runs, std::uint8_t second) {
        const auto at = static_cast<std::size_t>(i);
        moments.m0[at] = static_cast<std::int32_t>(m0);
        moments.m1[at] = static_cast<std::int32_t>(m1);
        moments.n[at] = static_cast<std::int32_t>(n);
        moments.second[at] = max_of_binary_second(runs, second);
      });
}

[[gnu::always_inline]] inline void unpack_grey_runs(const std::uint8_t* payload, int first, int count,
                                                    StripMoments& moments) {
  model::for_each_grey_run_word(
      payload, first, count,
      [&](int i, std::uint32_t m0, std::uint32_t m1, std::uint32_t n, std::uint8_t /*runs*/, std::uint8_t second) {
        const auto at = static_cast<std::size_t>(i);
        moments.m0[at] = static_cast<std::int32_t>(m0);
        moments.m1[at] = static_cast<std::int32_t>(m1);
        moments.n[at] = static_cast<std::int32_t>(n);
        moments.second[at] = second;
      });
}

// 63 lit pixels may be as many as rows, which counts against the column.
[[gnu::always_inline]] inline void unpack_wide_grey_runs(const std::uint8_t* payload, int first, int count,
                                                         StripMoments& moments) {
  model::for_each_wide_grey_run_word(
      payload, first, count,
      [&](int i, std::uint32_t m0, std::uint32_t m1, std::uint32_t n, std::uint8_t /*runs*/, std::uint8_t second) {
        const auto at = static_cast<std::size_t>(i);
        moments.m0[at] = static_cast<std::int32_t>(m0);
        moments.m1[at] = static_cast<std::int32_t>(m1);
        moments.n[at] = static_cast<std::int32_t>(n == spec::kWideGreyRunNMax ? spec::kRowLimit : n);
        moments.second[at] = second;
      });
}

// Compact columns. `Select` is known to the compiler, so that the loop has no branch. What a word leaves open counts
// against the column: 63 lit pixels may be as many as rows, and a second run of 15/16 as strong as the first.
template <model::Select Select>
[[gnu::always_inline]] inline void unpack_compact_columns(const std::uint8_t* payload, int first, int count,
                                                          StripMoments& moments) {
  constexpr std::uint32_t kMany = spec::kCompactNMax;
  constexpr std::uint32_t kMostSecond = 15;
  model::for_each_compact_word(
      payload, first, count, [&](int i, std::uint32_t centroid, std::uint32_t n, std::uint32_t quality) {
        const auto at = static_cast<std::size_t>(i);
        const std::uint32_t second = Select == model::Select::strongest ? quality & kMostSecond : 0;
        moments.m0[at] = static_cast<std::int32_t>(centroid != 0 ? model::kCompactM0 : 0);
        moments.m1[at] = static_cast<std::int32_t>(centroid);
        moments.n[at] = static_cast<std::int32_t>(n == kMany ? spec::kRowLimit : n);
        moments.second[at] = static_cast<std::int32_t>(second == kMostSecond ? kMostSecond + 1 : second);
      });
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
