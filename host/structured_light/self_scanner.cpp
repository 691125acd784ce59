#include "host/structured_light/self_scanner.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/files/numbers.h"
#include "model/cpu_clones.h"
#include "selfproj/structured_light/depth_geometry.h"

namespace selfproj::structured_light {
namespace {

constexpr float kLinesPerUnit = 1.0F / (1U << model::GrayMatch::kFractionBits);

// The word for no match becomes NaN through its bits. The compiler treats a choice between two values as control flow,
// and the loops would stay scalar.
[[gnu::always_inline]] inline float line_of(std::uint16_t word) {
  constexpr std::uint32_t kNanBits = 0x7FC00000;
  const std::uint32_t none = word == model::GrayMatch::kNone ? 1U : 0U;
  const float line = static_cast<float>(static_cast<std::int32_t>(word)) * kLinesPerUnit;
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(line) | ((0U - none) & kNanBits));
}

// Whether more than one pair is ambiguous.
[[gnu::always_inline]] inline bool is_unmeasurable(int ambiguous) { return (ambiguous & (ambiguous - 1)) != 0; }

// Neighbours mostly share one, two or three codes. Each code that occurs is looked up for all of them at once with
// plain loads, and the words are kept for the pixels that have this code. This is several times as fast as gathering
// words. Random codes, which no surface has, take longer.
constexpr std::ptrdiff_t kBlock = 64;
constexpr std::uint16_t kNoCode = 0xFFFF;

[[gnu::always_inline]] inline std::uint16_t ones_where(bool holds) {
  return static_cast<std::uint16_t>(-static_cast<int>(holds));
}

[[gnu::always_inline]] inline void look_up_block(const std::uint8_t* __restrict codes,
                                                 const std::uint8_t* __restrict ambiguous, std::ptrdiff_t at,
                                                 const MatchRow& row, float* __restrict lines) {
  alignas(kBlock) std::uint16_t keys[kBlock];
  alignas(kBlock) std::uint16_t found[kBlock];
  std::uint16_t code = kNoCode;
  for (std::ptrdiff_t k = 0; k < kBlock; ++k) {
    keys[k] = static_cast<std::uint16_t>(codes[at + k] | ones_where(is_unmeasurable(ambiguous[at + k])));
    found[k] = model::GrayMatch::kNone;
    code = std::min(code, keys[k]);
  }
  while (code != kNoCode) {
    const std::uint16_t* __restrict words = row.of(code) + at;
    std::uint16_t next = kNoCode;
    for (std::ptrdiff_t k = 0; k < kBlock; ++k) {
      const std::uint16_t key = keys[k];
      found[k] = static_cast<std::uint16_t>(found[k] & (words[k] | ones_where(key != code)));
      next = std::min(next, static_cast<std::uint16_t>(key | ones_where(key <= code)));
    }
    code = next;
  }
  for (std::ptrdiff_t k = 0; k < kBlock; ++k) {
    lines[at + k] = line_of(found[k]);
  }
}

SELFPROJ_CLONES void look_up(const std::uint8_t* codes, const std::uint8_t* ambiguous, std::ptrdiff_t count,
                             const MatchRow& row, float* lines) {
  if (count < kBlock) {
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      lines[i] = line_of(is_unmeasurable(ambiguous[i]) ? model::GrayMatch::kNone : row.of(codes[i])[i]);
    }
    return;
  }
  for (std::ptrdiff_t at = 0; at < count; at += kBlock) {
    look_up_block(codes, ambiguous, std::min(at, count - kBlock), row, lines);  // the last block may overlap others
  }
}

SELFPROJ_CLONES void subtract_all(const float* __restrict from, const float* __restrict z, std::ptrdiff_t count,
                                  float* __restrict difference) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    difference[i] = from[i] - z[i];
  }
}

}  // namespace

void subtract(const float* from, const float* z, std::ptrdiff_t count, float* difference) {
  subtract_all(from, z, count, difference);
}

void look_up_row(const MatchTable& table, int row, const std::uint8_t* codes, const std::uint8_t* ambiguous,
                 float* lines) {
  look_up(codes, ambiguous, table.columns(), table.row(row), lines);
}

namespace {

// For each pixel the lines of all its matches, and the line of the reference.
std::vector<LineRange> line_ranges(const SelfReference& reference, const MatchTable& table) {
  std::vector<LineRange> ranges(reference.points.line.values.size());
  const auto columns = static_cast<std::size_t>(table.columns());
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    LineRange& range = ranges[i];
    const auto widen = [&range](float line) {
      range = range.first > range.last ? LineRange{line, line}
                                       : LineRange{std::min(range.first, line), std::max(range.last, line)};
    };
    if (const float line = reference.points.line.values[i]; !std::isnan(line)) {
      widen(line);
    }
    for (int code = 0; code < 1 << table.bits(); ++code) {
      const std::uint16_t word = table.word(static_cast<int>(i / columns), static_cast<int>(i % columns), code);
      if (word != model::GrayMatch::kNone) {
        widen(line_of(word));
      }
    }
  }
  return ranges;
}

}  // namespace

SelfScanner::SelfScanner(const rig::Rig& rig, const SelfReference& reference, const MatchTable& table, int threshold,
                         const DepthLimits& limits)
    : reference_(&reference),
      table_(&table),
      triangulation_(triangulation_of_rig(rig, reference.stripes.bits, limits)),
      decoder_({rig.camera.rows, rig.camera.columns, reference.stripes.bits, threshold}),
      board_codes_(triangulation_->pixels()),
      board_ambiguous_(triangulation_->pixels()),
      lines_(static_cast<std::size_t>(rig.camera.columns)),
      depth_(rig.camera.rows, rig.camera.columns, images::kNoValue),
      difference_(depth_),
      reference_depth_(depth_) {
  if (table.rows() != rig.camera.rows || table.columns() != rig.camera.columns ||
      table.bits() != reference.stripes.bits || reference.points.line.rows != rig.camera.rows ||
      reference.points.line.columns != rig.camera.columns) {
    throw std::invalid_argument("self scanner: rig, reference and table have different sizes");
  }
  planes_ = dynamic_cast<const PlaneTriangulation*>(triangulation_.get());
  if (planes_ == nullptr) {
    lenses_ = std::make_unique<LensLines>(rig, line_ranges(reference, table), limits);
  }
  for (int r = 0; r < rig.camera.rows; ++r) {
    depth_of_lines(r, reference.points.line.row(r), reference_depth_.row(r));
  }
}

void SelfScanner::depth_of_lines(int row, const float* lines, float* z) const {
  if (planes_ != nullptr) {
    planes_->depth_of_lines(row, lines, z);
  } else {
    lenses_->depth_of_lines(row, lines, z);
  }
}

bool SelfScanner::add_frame(const model::ImageView& image, int pattern, bool good) {
  if (!decoder_.add_frame(image, pattern, good)) {
    return false;
  }
  match(decoder_.codes().codes8, decoder_.codes().ambiguous8);
  return true;
}

void SelfScanner::add_codes(const std::uint16_t* words) {
  constexpr std::uint8_t kTwoPairs = 3;
  for (std::size_t i = 0; i < board_codes_.size(); ++i) {
    const unsigned code = model::code_of(words[i]);
    const bool measurable = model::is_measurable(words[i]) && code >> static_cast<unsigned>(table_->bits()) == 0;
    board_codes_[i] = measurable ? static_cast<std::uint8_t>(code) : std::uint8_t{0};
    board_ambiguous_[i] = measurable ? std::uint8_t{0} : kTwoPairs;
  }
  match(board_codes_.data(), board_ambiguous_.data());
}

// Processes row by row, so that the results of one step are still in the cache for the next.
void SelfScanner::match(const std::uint8_t* codes, const std::uint8_t* ambiguous) {
  codes_ = codes;
  ambiguous_ = ambiguous;
  const std::ptrdiff_t columns = depth_.columns;
  for (int r = 0; r < depth_.rows; ++r) {
    look_up_row(*table_, r, codes + r * columns, ambiguous + r * columns, lines_.data());
    depth_of_lines(r, lines_.data(), depth_.row(r));
    subtract(reference_depth_.row(r), depth_.row(r), columns, difference_.row(r));
  }
}

void SelfScanner::newest_lines(int row, float* lines) const {
  const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(row) * depth_.columns;
  look_up_row(*table_, row, codes_ + first, ambiguous_ + first, lines);
}

void SelfScanner::explain(std::vector<PointState>& states) const {
  states.assign(triangulation_->pixels(), PointState::not_measurable);
  if (codes_ == nullptr) {
    return;
  }
  std::vector<float> lines(static_cast<std::size_t>(depth_.columns));
  for (int r = 0; r < depth_.rows; ++r) {
    const std::size_t first = static_cast<std::size_t>(r) * lines.size();
    newest_lines(r, lines.data());
    for (std::size_t c = 0; c < lines.size(); ++c) {
      if (!is_unmeasurable(ambiguous_[first + c]) && reference_->measurable(first + c)) {
        const float z = depth_.values[first + c];
        states[first + c] = planes_ != nullptr ? planes_->explain_line(first + c, lines[c], z)
                                               : lenses_->explain_line(first + c, lines[c], z);
      }
    }
  }
}

std::optional<double> SelfScanner::pace() const {
  constexpr int kLeastBorders = 200;
  if (codes_ == nullptr) {
    return std::nullopt;
  }
  const Stripes& stripes = reference_->stripes;
  const int last = (1 << stripes.bits) - 1;
  const int back = stripes.code == StripeCode::cyclic && stripes.bits > 1 ? -1 : 1;  // what a step back counts
  const auto columns = static_cast<std::size_t>(depth_.columns);
  const auto measured = [&](std::size_t i) { return !is_unmeasurable(ambiguous_[i]) && reference_->measurable(i); };
  int expected = 0;
  int made = 0;
  for (int r = 1; r < depth_.rows; ++r) {
    const int step = cell_of_row(r, reference_->camera_rows, stripes.width) -
                     cell_of_row(r - 1, reference_->camera_rows, stripes.width);
    const std::size_t first = static_cast<std::size_t>(r) * columns;
    for (std::size_t next = first; next < first + columns; ++next) {
      const std::size_t here = next - columns;
      if (!measured(here) || !measured(next)) {
        continue;
      }
      const int change = (codes_[next] - codes_[here]) & last;
      expected += step;
      if (change == 1) {
        ++made;
      } else if (change == last) {
        made += back;
      }
    }
  }
  return expected < kLeastBorders ? std::nullopt : std::optional(static_cast<double>(made) / expected);
}

std::string contradiction_of(const SequenceCheck& check, const std::vector<std::string>& names,
                             const SelfScanner& scanner) {
  constexpr double kLeastPace = 0.25;  // surfaces that lean so much against the reference fill no image
  if (std::string between = contradiction_of(check, names); !between.empty()) {
    return between;
  }
  const std::optional<double> pace = scanner.pace();
  return !pace || *pace >= kLeastPace
             ? ""
             : fmt::format(
                   "down the image the code does not count on as the reference's stripes do ({:.2f} times as often): "
                   "were these images taken under the patterns of this reference, and are they not mirrored?",
                   files::rounded(*pace, 2));
}

std::string doubt_of(const SelfScanner& scanner) {
  constexpr double kSlow = 0.6;
  constexpr double kFast = 1.6;
  const std::optional<double> pace = scanner.pace();
  return !pace || (*pace > kSlow && *pace < kFast)
             ? ""
             : fmt::format(
                   "down the image the code counts on {:.2f} times as often as the reference's stripes: do the "
                   "surfaces "
                   "lean so much, or are these images of another reference's patterns?",
                   *pace);
}

std::string reason_without_points(const DepthShares& shares) {
  if (shares.of(PointState::valid) > 0) {
    return "";
  }
  const std::size_t coded = shares.total() - shares.of(PointState::not_measurable);
  return coded == 0
             ? "no pixel has a code where the reference was seen: is there light, and is the threshold below the "
               "contrast of positive and negative?"
             : fmt::format("none of {} pixels with a code has a point: are rig, reference and e those of the images?",
                           coded);
}

}  // namespace selfproj::structured_light
