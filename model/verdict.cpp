#include "selfproj/model/verdict.h"

#include <algorithm>
#include <array>
#include <bit>
#include <stdexcept>
#include <utility>

#include "selfproj/model/generated/selfproj_spec.h"
#include "selfproj/model/little_endian.h"

namespace selfproj::model {
namespace {

constexpr int kGroup = 4;  // columns

// The way from `point` to `count`, and whether `count` is not before `point`.
std::uint32_t way(std::uint32_t count, std::uint32_t point) { return (count - point) & kCountMask; }
bool reached(std::uint32_t count, std::uint32_t point) { return way(count, point) <= kCountMask / 2; }

void check(bool good, const char* what) {
  if (!good) {
    throw std::invalid_argument(what);
  }
}

void check_settings(const VerdictSettings& s) {
  check(s.width >= 1 && s.width <= 255, "verdict: width is not in 1 to 255");
  check(s.history >= 1 && s.history <= kMaxHistory, "verdict: history is not in 1 to 8");
  check(s.hits >= 1 && s.hits <= 15, "verdict: hits is not in 1 to 15");
  check(s.most_unlit >= 0 && s.most_unlit <= kUnlitNotJudged, "verdict: most_unlit is not in 0 to 4095");
  check(std::abs(s.shift_columns) <= kMaxShiftColumns, "verdict: shift_columns is not in -127 to 127");
  check(std::abs(s.shift_rows) <= kMaxShiftRows, "verdict: shift_rows is not in -8191 to 8191");
  check(s.bank == 0 || s.bank == 1, "verdict: bank is not 0 or 1");
}

}  // namespace

VerdictWords verdict_words(const VerdictSettings& settings, const PartRule& rule) {
  const auto field = [](int value, int lsb, int bits) {
    return (static_cast<std::uint32_t>(value) & ((1U << bits) - 1)) << lsb;
  };
  return {
      .defect = field(settings.width, spec::kRegVerdictDefectWidthLsb, spec::kRegVerdictDefectWidthBits) |
                field(settings.history - 1, spec::kRegVerdictDefectHistoryLsb, spec::kRegVerdictDefectHistoryBits) |
                field(settings.hits, spec::kRegVerdictDefectHitsLsb, spec::kRegVerdictDefectHitsBits) |
                field(settings.above ? 1 : 0, spec::kRegVerdictDefectAboveLsb, 1) |
                field(settings.below ? 1 : 0, spec::kRegVerdictDefectBelowLsb, 1) |
                field(settings.bank, spec::kRegVerdictDefectBankLsb, 1) |
                field(settings.most_unlit, spec::kRegVerdictDefectMostUnlitLsb, spec::kRegVerdictDefectMostUnlitBits),
      .shift = field(settings.shift_columns, spec::kRegVerdictShiftColumnsLsb, spec::kRegVerdictShiftColumnsBits) |
               field(-settings.shift_rows, spec::kRegVerdictShiftRowsLsb, spec::kRegVerdictShiftRowsBits),
      .light = field(rule.lit, spec::kRegVerdictLightLitLsb, spec::kRegVerdictLightLitBits) |
               field(rule.dark_frames, spec::kRegVerdictLightDarkFramesLsb, spec::kRegVerdictLightDarkFramesBits),
  };
}

VerdictSettings settings_of_words(const VerdictWords& words) {
  const auto field = [](std::uint32_t word, int lsb, int bits) {
    return static_cast<int>((word >> lsb) & ((1U << bits) - 1));
  };
  const auto two_s_complement = [&](std::uint32_t word, int lsb, int bits) {
    const int value = field(word, lsb, bits);
    return value < 1 << (bits - 1) ? value : value - (1 << bits);
  };
  const auto of = [&](int lsb, int bits) { return field(words.defect, lsb, bits); };
  return {
      .width = of(spec::kRegVerdictDefectWidthLsb, spec::kRegVerdictDefectWidthBits),
      .history = of(spec::kRegVerdictDefectHistoryLsb, spec::kRegVerdictDefectHistoryBits) + 1,
      .hits = of(spec::kRegVerdictDefectHitsLsb, spec::kRegVerdictDefectHitsBits),
      .above = of(spec::kRegVerdictDefectAboveLsb, 1) != 0,
      .below = of(spec::kRegVerdictDefectBelowLsb, 1) != 0,
      .most_unlit = of(spec::kRegVerdictDefectMostUnlitLsb, spec::kRegVerdictDefectMostUnlitBits),
      .shift_columns =
          two_s_complement(words.shift, spec::kRegVerdictShiftColumnsLsb, spec::kRegVerdictShiftColumnsBits),
      .shift_rows = -two_s_complement(words.shift, spec::kRegVerdictShiftRowsLsb, spec::kRegVerdictShiftRowsBits),
      .bank = of(spec::kRegVerdictDefectBankLsb, 1),
  };
}

std::uint32_t limits_word(const ColumnLimits& limits) {
  check(limits.low <= limits.high && limits.high - limits.low <= kMaxBand,
        "verdict: the limits of a column are not in order, or too far apart");
  return limits.low << spec::kRegVerdictLimitsLowLsb | (limits.high - limits.low) << spec::kRegVerdictLimitsBandLsb |
         (limits.judged ? 1U : 0U) << spec::kRegVerdictLimitsJudgedLsb;
}

std::uint32_t verdict_control_word(bool on, bool hold, bool by_encoder, int packets) {
  return (on ? 1U : 0U) << spec::kRegVerdictControlOnLsb | (hold ? 1U : 0U) << spec::kRegVerdictControlHoldLsb |
         (by_encoder ? 1U : 0U) << spec::kRegVerdictControlByEncoderLsb |
         static_cast<std::uint32_t>(packets) << spec::kRegVerdictControlPacketsLsb;
}

std::vector<RegisterWrite> verdict_writes(const VerdictSettings& settings, const PartRule& rule) {
  const VerdictWords words = verdict_words(settings, rule);
  return {{spec::kRegVerdictDefect, words.defect},
          {spec::kRegVerdictShift, words.shift},
          {spec::kRegVerdictLight, words.light},
          {spec::kRegVerdictStart, rule.start & kCountMask},
          {spec::kRegVerdictLength, rule.length & kCountMask},
          {spec::kRegVerdictPitch, rule.pitch & kCountMask}};
}

std::vector<RegisterWrite> limits_writes(int bank, std::span<const SectionLimits> sections, int board_columns,
                                         int board_sections) {
  std::vector<RegisterWrite> writes;
  const auto aim = [&](int section, int column) {
    writes.push_back(
        {spec::kRegVerdictTable, static_cast<std::uint32_t>(column) << spec::kRegVerdictTableColumnLsb |
                                     static_cast<std::uint32_t>(section) << spec::kRegVerdictTableSectionLsb |
                                     static_cast<std::uint32_t>(bank) << spec::kRegVerdictTableBankLsb});
  };
  const auto begin = [&](int section, std::uint32_t count) {
    aim(section, 0);
    writes.push_back({spec::kRegVerdictBegin, count & kCountMask});
  };
  const int count = static_cast<int>(sections.size());
  for (int section = 0; section < count; ++section) {
    const SectionLimits& one = sections[static_cast<std::size_t>(section)];
    const int columns = static_cast<int>(one.limits.size());
    for (int column = 0; column < std::min(board_columns, columns + kMaxShiftColumns); ++column) {
      aim(section, column);
      writes.push_back({spec::kRegVerdictLimits,
                        limits_word(column < columns ? one.limits[static_cast<std::size_t>(column)] : ColumnLimits{})});
    }
    if (section > 0) {
      begin(section, one.begin);
    }
  }
  if (count > 0 && count < board_sections) {
    begin(count, kCountMask);  // never
  }
  return writes;
}

ColumnState column_state(const ColumnLimits& limits, int shift, std::uint32_t m0, std::uint32_t m1) {
  if (m0 == 0) {
    return ColumnState::unlit;
  }
  const auto weight = static_cast<std::int64_t>(m0);
  const std::int64_t at = kRowParts * static_cast<std::int64_t>(m1) - shift * weight;
  if (at < limits.low * weight) {
    return ColumnState::above;
  }
  return at > limits.high * weight ? ColumnState::below : ColumnState::good;
}

Verdict::Verdict(int columns, int sections)
    : columns_(columns),
      sections_(sections),
      limits_(static_cast<std::size_t>(2 * sections * columns)),
      begins_(static_cast<std::size_t>(2 * sections), 0),
      past_(static_cast<std::size_t>(columns), 0) {
  check(columns >= kGroup && columns % kGroup == 0, "verdict: columns is not a multiple of 4");
  check(sections >= 1 && sections <= 64, "verdict: sections is not in 1 to 64");
}

void Verdict::write(int bank, int section, int column, const ColumnLimits& limits) {
  check(bank >= 0 && bank < 2 && section >= 0 && section < sections_ && column >= 0 && column < columns_ &&
            limits.low <= kMaxLimit && limits.high <= kMaxLimit,
        "verdict: limits out of range");
  limits_[static_cast<std::size_t>((bank * sections_ + section) * columns_ + column)] = limits;
}

void Verdict::write(int bank, std::span<const SectionLimits> sections) {
  for (int section = 0; section < static_cast<int>(sections.size()); ++section) {
    const SectionLimits& one = sections[static_cast<std::size_t>(section)];
    for (int column = 0; column < static_cast<int>(one.limits.size()); ++column) {
      write(bank, section, column, one.limits[static_cast<std::size_t>(column)]);
    }
    if (section > 0) {
      begin_section(bank, section, one.begin);
    }
  }
  // A section more, which never begins, so that the last one does not end.
  if (const int next = static_cast<int>(sections.size()); next > 0 && next < sections_) {
    begin_section(bank, next, kCountMask);
  }
}

void Verdict::begin_section(int bank, int section, std::uint32_t count) {
  check(bank >= 0 && bank < 2 && section >= 1 && section < sections_, "verdict: there is no such section");
  begins_[static_cast<std::size_t>(bank * sections_ + section)] = count;
}

void Verdict::begin(const VerdictSettings& settings, bool hold, std::uint32_t count) {
  if (!hold) {
    check_settings(settings);
    settings_ = settings;
    taken_ = true;
  }
  in_part_ = true;
  fresh_ = true;
  bad_ = false;
  section_ = 0;
  dark_ = 0;
  began_ = count;
  ++parts_;
}

void Verdict::find_part(const VerdictSettings& settings, bool hold, const PartRule& rule, std::uint32_t encoder) {
  bool begins = false;
  bool begins_by_light = false;
  if (rule.by_encoder != by_encoder_) {
    in_part_ = false;
    waits_ = true;
    began_ = rule.by_encoder ? rule.start : began_;
  } else if (!rule.by_encoder) {
    begins_by_light = look_for_light(rule);
  }
  if (rule.by_encoder) {
    // The next part begins one pitch behind the one before.
    in_part_ = in_part_ && way(encoder, began_) < rule.length;
    const std::uint32_t next = began_ + (waits_ ? 0 : rule.pitch);
    begins = !in_part_ && reached(encoder, next) && (taken_ || !hold);
    if (begins) {
      begin(settings, hold, next);
      waits_ = false;
    }
  } else if (begins_by_light && (taken_ || !hold)) {
    begin(settings, hold, encoder);
    begins = true;
  }
  by_encoder_ = rule.by_encoder;
  if (in_part_ && !begins && section_ + 1 < sections_ &&
      way(encoder, began_) >= begins_[static_cast<std::size_t>(settings_.bank * sections_ + section_) + 1]) {
    ++section_;
  }
}

void Verdict::judge(std::span<const std::uint32_t> m0, std::span<const std::uint32_t> m1, FrameVerdict& found) {
  const int width = static_cast<int>(m0.size()) / kGroup * kGroup;
  int run = 0;  // neighbouring columns with enough hits that end here
  for (int column = 0; column < width; ++column) {
    const int from = column - settings_.shift_columns;
    const auto at = static_cast<std::size_t>(column);
    bool out = false;
    if (from >= 0 && from < columns_) {
      const ColumnLimits& limits =
          limits_[static_cast<std::size_t>((settings_.bank * sections_ + section_) * columns_ + from)];
      if (limits.judged) {
        const ColumnState state = column_state(limits, settings_.shift_rows, m0[at], m1[at]);
        out = (state == ColumnState::above && settings_.above) || (state == ColumnState::below && settings_.below);
        found.unlit += state == ColumnState::unlit ? 1 : 0;
      }
    }
    const auto hits = static_cast<std::uint8_t>((fresh_ ? 0 : past_[at] << 1) | (out ? 1 : 0));
    past_[at] = hits;
    const auto counted = static_cast<std::uint8_t>(hits & ((1 << settings_.history) - 1));
    run = std::popcount(counted) >= settings_.hits ? run + 1 : 0;
    if (run >= settings_.width && (!found.defect || found.first_column + found.columns == column + 1)) {
      found.defect = true;
      found.first_column = column + 2 - run;
      found.columns = run;
    }
  }
  found.lacks_light = settings_.most_unlit < kUnlitNotJudged && found.unlit > settings_.most_unlit;
}

// Looks at the light of the frame before. Returns whether a part begins.
bool Verdict::look_for_light(const PartRule& rule) {
  if (lit_ < 0) {
    return false;
  }
  const bool dark = lit_ < rule.lit;
  if (!in_part_) {
    return !dark;
  }
  dark_ = dark ? (dark_ + 1) % 256 : 0;
  in_part_ = !(dark && dark_ >= rule.dark_frames);
  return false;
}

void pack_verdict(const FrameVerdict& verdict, std::uint8_t* bytes) {
  std::array<std::uint32_t, 4> words{};
  const auto put = [&](std::uint32_t value, int lsb, int bits) {
    words[static_cast<std::size_t>(lsb / 32)] |= (value & ((1U << bits) - 1)) << lsb % 32;
  };
  put(static_cast<std::uint32_t>(verdict.first_column), spec::kVerdictFirstColumnLsb, spec::kVerdictFirstColumnBits);
  put(static_cast<std::uint32_t>(verdict.columns), spec::kVerdictColumnsLsb, spec::kVerdictColumnsBits);
  put(static_cast<std::uint32_t>(verdict.unlit), spec::kVerdictUnlitLsb, spec::kVerdictUnlitBits);
  put(1, spec::kVerdictJudgedLsb, 1);
  put(verdict.in_part ? 1 : 0, spec::kVerdictInPartLsb, 1);
  put(verdict.defect ? 1 : 0, spec::kVerdictDefectLsb, 1);
  put(verdict.lacks_light ? 1 : 0, spec::kVerdictLacksLightLsb, 1);
  put(static_cast<std::uint32_t>(verdict.bank), spec::kVerdictBankLsb, 1);
  put(static_cast<std::uint32_t>(verdict.section), spec::kVerdictSectionLsb, spec::kVerdictSectionBits);
  put(verdict.part, spec::kVerdictPartLsb, spec::kVerdictPartBits);
  for (std::size_t i = 0; i < words.size(); ++i) {
    store_little_endian(bytes + 4 * i, words[i]);
  }
}

std::optional<FrameVerdict> unpack_verdict(const std::uint8_t* bytes) {
  const auto get = [&](int lsb, int bits) {
    return load_little_endian<std::uint32_t>(bytes + 4 * (lsb / 32)) >> lsb % 32 & ((1U << bits) - 1);
  };
  const auto number = [&](int lsb, int bits) { return static_cast<int>(get(lsb, bits)); };
  if (get(spec::kVerdictJudgedLsb, 1) == 0) {
    return std::nullopt;
  }
  return FrameVerdict{.in_part = get(spec::kVerdictInPartLsb, 1) != 0,
                      .defect = get(spec::kVerdictDefectLsb, 1) != 0,
                      .lacks_light = get(spec::kVerdictLacksLightLsb, 1) != 0,
                      .section = number(spec::kVerdictSectionLsb, spec::kVerdictSectionBits),
                      .bank = number(spec::kVerdictBankLsb, 1),
                      .part = get(spec::kVerdictPartLsb, spec::kVerdictPartBits),
                      .first_column = number(spec::kVerdictFirstColumnLsb, spec::kVerdictFirstColumnBits),
                      .columns = number(spec::kVerdictColumnsLsb, spec::kVerdictColumnsBits),
                      .unlit = number(spec::kVerdictUnlitLsb, spec::kVerdictUnlitBits)};
}

FrameVerdict Verdict::frame(const VerdictSettings& settings, bool hold, const PartRule& rule, std::uint32_t encoder,
                            std::span<const std::uint32_t> m0, std::span<const std::uint32_t> m1, bool whole) {
  check(m0.size() == m1.size() && m0.size() <= static_cast<std::size_t>(columns_), "verdict: moments do not fit");
  find_part(settings, hold, rule, encoder);
  FrameVerdict found;
  found.section = section_;
  found.bank = settings_.bank;
  found.part = parts_ & 0xFFFF;
  if (in_part_) {
    found.in_part = true;
    judge(m0, m1, found);
    found.first_bad =
        (found.defect || found.lacks_light) && !std::exchange(bad_, bad_ || found.defect || found.lacks_light);
    bad_parts_ += found.first_bad ? 1U : 0U;
    fresh_ = fresh_ && !whole;
  }
  lit_ = whole ? static_cast<int>(m0.size()) - static_cast<int>(std::count(m0.begin(), m0.end(), 0U)) : -1;
  return found;
}

void Verdict::stop() {
  in_part_ = false;
  by_encoder_ = false;
  lit_ = -1;
}

}  // namespace selfproj::model
