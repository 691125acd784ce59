#include "host/gray/self_scanner.h"

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

#include "model/cpu_clones.h"

namespace selfproj {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kLinesPerUnit = 1.0F / (1U << GrayMatch::kFractionBits);

constexpr std::uint32_t kNanBits = 0x7FC00000;

// More than one ambiguous pair.
[[gnu::always_inline]] inline bool is_unmeasurable(int ambiguous) { return (ambiguous & (ambiguous - 1)) != 0; }

SELFPROJ_CLONES void look_up(const std::uint8_t* __restrict codes, const std::uint8_t* __restrict ambiguous,
                             std::int32_t count, const std::uint32_t* __restrict pairs, std::int32_t pitch,
                             float* __restrict lines) {
  for (std::int32_t i = 0; i < count; ++i) {
    const std::uint32_t pair = pairs[static_cast<std::int32_t>(codes[i]) * pitch + (i >> 1)];
    const auto word = static_cast<std::int32_t>((pair >> (static_cast<std::uint32_t>(i & 1) * 16U)) & 0xFFFFU);
    // What is none becomes NaN by its bits: a choice between two values is control flow to the compiler here, and the
    // loop then stays scalar.
    const std::uint32_t none = (word == GrayMatch::kNone ? 1U : 0U) | (is_unmeasurable(ambiguous[i]) ? 1U : 0U);
    const float line = static_cast<float>(word) * kLinesPerUnit;
    lines[i] = std::bit_cast<float>(std::bit_cast<std::uint32_t>(line) | ((0U - none) & kNanBits));
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
  look_up(codes, ambiguous, table.columns(), table.row(row), static_cast<std::int32_t>(table.pitch()), lines);
}

SelfScanner::SelfScanner(const Rig& rig, const SelfReference& reference, const MatchTable& table, int threshold,
                         const DepthLimits& limits)
    : reference_(&reference),
      table_(&table),
      triangulation_(rig, reference.stripes.bits, limits),
      decoder_({rig.camera.rows, rig.camera.columns, reference.stripes.bits, threshold}),
      board_codes_(triangulation_.pixels()),
      board_ambiguous_(triangulation_.pixels()),
      lines_(static_cast<std::size_t>(rig.camera.columns)),
      depth_(rig.camera.rows, rig.camera.columns, kNan),
      difference_(depth_),
      reference_depth_(depth_) {
  if (table.rows() != rig.camera.rows || table.columns() != rig.camera.columns ||
      table.bits() != reference.stripes.bits || reference.points.line.rows != rig.camera.rows ||
      reference.points.line.columns != rig.camera.columns) {
    throw std::invalid_argument("self scanner: rig, reference and table have different sizes");
  }
  for (int r = 0; r < rig.camera.rows; ++r) {
    triangulation_.depth_of_lines(r, reference.points.line.row(r), reference_depth_.row(r));
  }
}

bool SelfScanner::take(const ImageView& image, int pattern, bool good) {
  if (!decoder_.take(image, pattern, good)) {
    return false;
  }
  match(decoder_.codes().codes8, decoder_.codes().ambiguous8);
  return true;
}

void SelfScanner::take_codes(const std::uint16_t* words) {
  constexpr std::uint8_t kTwoPairs = 3;
  for (std::size_t i = 0; i < board_codes_.size(); ++i) {
    const unsigned code = words[i] & ((1U << spec::kCodeCodeBits) - 1);
    const bool measurable =
        (words[i] & GrayDecoder::kMeasurable) != 0 && code >> static_cast<unsigned>(table_->bits()) == 0;
    board_codes_[i] = measurable ? static_cast<std::uint8_t>(code) : std::uint8_t{0};
    board_ambiguous_[i] = measurable ? std::uint8_t{0} : kTwoPairs;
  }
  match(board_codes_.data(), board_ambiguous_.data());
}

// Row by row, so that what one step leaves is still near when the next one takes it.
void SelfScanner::match(const std::uint8_t* codes, const std::uint8_t* ambiguous) {
  codes_ = codes;
  ambiguous_ = ambiguous;
  const std::ptrdiff_t columns = depth_.columns;
  for (int r = 0; r < depth_.rows; ++r) {
    look_up_row(*table_, r, codes + r * columns, ambiguous + r * columns, lines_.data());
    triangulation_.depth_of_lines(r, lines_.data(), depth_.row(r));
    subtract(reference_depth_.row(r), depth_.row(r), columns, difference_.row(r));
  }
}

void SelfScanner::explain(std::vector<PointState>& states) const {
  states.assign(triangulation_.pixels(), PointState::not_measurable);
  if (codes_ == nullptr) {
    return;
  }
  std::vector<float> lines(static_cast<std::size_t>(depth_.columns));
  for (int r = 0; r < depth_.rows; ++r) {
    const std::size_t first = static_cast<std::size_t>(r) * lines.size();
    look_up_row(*table_, r, codes_ + first, ambiguous_ + first, lines.data());
    for (std::size_t c = 0; c < lines.size(); ++c) {
      if (!is_unmeasurable(ambiguous_[first + c]) && reference_->measurable(first + c)) {
        states[first + c] = triangulation_.explain_line(first + c, lines[c], depth_.values[first + c]);
      }
    }
  }
}

}  // namespace selfproj
