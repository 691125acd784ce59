// A rig small enough to be rendered live, and pictures that its projector shows only in part.
#ifndef SELFPROJ_TESTS_HOST_CAPTURE_SMALL_SCANNER_H
#define SELFPROJ_TESTS_HOST_CAPTURE_SMALL_SCANNER_H

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/images/image_files.h"
#include "selfproj/rig/rig.h"

namespace selfproj::test {

// Rig B with fewer pixels along each side, by these factors.
inline rig::Rig small_scanner(int camera, int projector) {
  rig::Rig rig = rig::load_rig("scanner");
  rig.camera.rows /= camera;
  rig.camera.columns /= camera;
  rig.camera.pixel_pitch_mm *= camera;
  rig.projector.lines /= projector;
  rig.projector.columns /= projector;
  rig.projector.line_pitch_mm *= projector;
  rig.projector.column_pitch_mm *= projector;
  rig.measure.max_z_per_line_mm *= projector;
  return rig;
}

using Picture8 = std::vector<std::uint8_t>;

// The new picture above, the old one from `percent` of the picture on.
inline Picture8 torn_below(const Picture8& old, Picture8 now, int percent) {
  const auto from = static_cast<std::ptrdiff_t>(now.size()) * percent / 100;
  std::copy(old.begin() + from, old.end(), now.begin() + from);
  return now;
}

// Half the old picture and half the new one, as in an exposure across the change.
inline Picture8 torn_across(const Picture8& old, Picture8 now) {
  std::transform(old.begin(), old.end(), now.begin(), now.begin(),
                 [](int a, int b) { return static_cast<std::uint8_t>((a + b) / 2); });
  return now;
}

inline double mean_difference(const images::Image& a, const images::Image& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    sum += std::abs(a.pixels[i] - b.pixels[i]);
  }
  return sum / static_cast<double>(a.pixels.size());
}

// An image is of another pattern if it differs by more from that of its own, grey values in the mean. Noise alone makes
// less than half of this.
constexpr double kOtherPattern = 4;

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_HOST_CAPTURE_SMALL_SCANNER_H
