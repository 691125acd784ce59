#include "selfproj/light_section/validity_counts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <string>

namespace selfproj::light_section {
namespace {

// Whether packets of such a rig say no more than 63 lit pixels.
bool ends_n(const rig::RigMeasure& measure) {
  return measure.sends_compact() || (measure.bits() > spec::kPixelBits && measure.runs);
}

// The end of "... % of the columns".
std::string reason_of(Validity validity, const rig::RigMeasure& measure) {
  switch (validity) {
    case Validity::unlit:
      return fmt::format(
          "show no light above the threshold of {}: raise the exposure or lower the threshold, and look "
          "whether the line falls into the camera's view{}",
          measure.threshold,
          measure.bits() > spec::kPixelBits ? "; where images are read, whether --shift leaves the values as they are"
                                            : "");
    case Validity::too_few:
      return fmt::format("have fewer than {} lit pixels: raise the exposure, or lower the threshold or min_lit_px",
                         measure.min_lit_px);
    case Validity::too_wide:
      return fmt::format(
          "have more than {} lit pixels: lower the exposure, raise the threshold or max_lit_px, or keep "
          "other light out{}",
          measure.max_lit_px,
          ends_n(measure) ? "; where packets say 63 lit pixels there may be more, so such columns are counted here"
                          : "");
    case Validity::cut_off:
      return measure.window ? "have the line at the border of the rows that count: move or widen measure.window"
                            : "have the line at the border of the image: the part is higher or lower than the camera "
                              "sees, or camera and light do not meet there";
    case Validity::no_reference:
      return fmt::format(
          "have no reference: the reference is of something else, its light does not reach them, or max_z_per_line_mm, "
          "{:g}, is too small there; make one of what is measured (selfproj pattern), and see whether plane_z_mm is "
          "where the belt is",
          measure.max_z_per_line_mm);
    case Validity::out_of_range:
      return "cannot be triangulated: is the rig that of these images, and is max_z_per_line_mm not too small?";
    case Validity::ambiguous:
      return "have a second line nearly as strong: keep reflections out, limit the rows (measure.window), or raise "
             "ambiguous_from";
    case Validity::valid:
    case Validity::outside:
      break;
  }
  return "";
}

}  // namespace

void count_columns(std::span<const std::uint8_t> validity, ValidityCounts& counts) {
  std::array<std::uint32_t, kValidities> own{};
  for (const std::uint8_t value : validity) {
    ++own.at(value);
  }
  for (std::size_t i = 0; i < own.size(); ++i) {
    counts.at(i) += own.at(i);
  }
}

std::string doubt_about_columns(const ValidityCounts& counts, const rig::RigMeasure& measure) {
  constexpr double kLeastShare = 0.1;
  constexpr auto kOutside = static_cast<std::size_t>(Validity::outside);  // the rig says so
  const std::uint64_t all = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0}) - counts[kOutside];
  const std::uint64_t valid = counts.front();
  if (2 * valid >= all) {
    return "";
  }
  std::array<std::size_t, kOutside - 1> order{};
  std::iota(order.begin(), order.end(), 1);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return counts[a] > counts[b]; });
  const auto share = [&](std::uint64_t count) { return static_cast<double>(count) / static_cast<double>(all); };
  std::string text = valid == 0 ? fmt::format("none of the {} columns became a point", all)
                                : fmt::format("only {:.1f} % of the columns became points", 100 * share(valid));
  for (std::size_t i = 0; i < order.size() && share(counts[order[i]]) >= kLeastShare; ++i) {
    text += fmt::format("{} {:.0f} % {}", i == 0 ? ":" : ";", 100 * share(counts[order[i]]),
                        reason_of(static_cast<Validity>(order[i]), measure));
  }
  return text;
}

}  // namespace selfproj::light_section
