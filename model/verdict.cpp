#include "selfproj/model/verdict.h"

#include <algorithm>
#include <bit>
#include <stdexcept>

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
  check(s.hits >= 1 && s.hits <= s.history, "verdict: hits is not in 1 to history");
  check(s.most_unlit >= 0 && s.most_unlit <= 4095, "verdict: most_unlit is not in 0 to 4095");
  check(std::abs(s.shift_columns) <= kMaxShiftColumns, "verdict: shift_columns is not in -127 to 127");
  check(std::abs(s.shift_rows) <= kMaxShiftRows, "verdict: shift_rows is not in -8191 to 8191");
  check(s.bank == 0 || s.bank == 1, "verdict: bank is not 0 or 1");
}

}  // namespace

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

void Verdict::begin_section(int bank, int section, std::uint32_t count) {
  check(bank >= 0 && bank < 2 && section >= 1 && section < sections_, "verdict: there is no such section");
  begins_[static_cast<std::size_t>(bank * sections_ + section)] = count;
}

void Verdict::begin(const VerdictSettings& settings, std::uint32_t count) {
  check_settings(settings);
  settings_ = settings;
  in_part_ = true;
  fresh_ = true;
  section_ = 0;
  dark_ = 0;
  began_ = count;
  ++parts_;
}

void Verdict::find_part(const VerdictSettings& settings, const PartRule& rule, std::uint32_t encoder) {
  bool begins = false;
  if (rule.by_encoder) {
    in_part_ = in_part_ && way(encoder, began_) < rule.length;
    next_ = by_encoder_ ? next_ : rule.start;
    if (!in_part_ && reached(encoder, next_)) {
      begin(settings, next_);
      next_ += rule.pitch;
      begins = true;
    }
  } else if (begins_next_) {
    begin(settings, encoder);
    begins = true;
  }
  by_encoder_ = rule.by_encoder;
  begins_next_ = false;
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
  found.lacks_light = found.unlit > settings_.most_unlit;
}

void Verdict::look_for_light(const PartRule& rule, std::span<const std::uint32_t> m0) {
  const auto lit = m0.size() - static_cast<std::size_t>(std::count(m0.begin(), m0.end(), 0U));
  const bool dark = lit < static_cast<std::size_t>(rule.lit);
  if (!in_part_) {
    begins_next_ = !dark;
    return;
  }
  dark_ = dark ? dark_ + 1 : 0;
  in_part_ = dark_ < rule.dark_frames;
}

FrameVerdict Verdict::frame(const VerdictSettings& settings, const PartRule& rule, std::uint32_t encoder,
                            std::span<const std::uint32_t> m0, std::span<const std::uint32_t> m1, bool whole) {
  check(m0.size() == m1.size() && m0.size() <= static_cast<std::size_t>(columns_), "verdict: moments do not fit");
  find_part(settings, rule, encoder);
  FrameVerdict found;
  if (in_part_) {
    found.in_part = true;
    found.section = section_;
    found.part = (parts_ - 1) & 0xFFFF;
    judge(m0, m1, found);
    fresh_ = fresh_ && !whole;
  }
  if (whole && !rule.by_encoder) {
    look_for_light(rule, m0);
  }
  return found;
}

}  // namespace selfproj::model
