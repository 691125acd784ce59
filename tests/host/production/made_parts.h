// Profiles of made parts: rectangles of a known shape that lie anyhow on the belt, as a light section would see them.
#ifndef SELFPROJ_TESTS_HOST_PRODUCTION_MADE_PARTS_H
#define SELFPROJ_TESTS_HOST_PRODUCTION_MADE_PARTS_H

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "host/production/cutter.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"

namespace selfproj::test {

inline rig::Rig rig_with_parts() {
  rig::Rig rig = rig::load_rig("light-section");
  rig.parts = rig::RigParts{.cut = rig::PartCut::profile,
                            .by_encoder = true,
                            .grid_mm = 0.25,
                            .above_mm = 5,
                            .min_width_mm = 2,
                            .gap_mm = 3,
                            .pause_s = 0.005,
                            .min_length_mm = 5,
                            .length_mm = 60};
  return rig;
}

// A rectangle of length x width mm. `height` is that above the plane at (along, across) of the part, along from its
// leading edge, across from its middle; NaN where nothing is seen. It lies shifted and turned on the belt.
struct MadePart {
  double length = 30;
  double width = 40;
  std::function<double(double, double)> height = [](double, double) { return 20.0; };
  double across = 0;    // shift of its middle
  double turn_deg = 0;  // as Placement turns it
  double noise = 0;     // mm

  [[nodiscard]] double seen(double along, double y) const {  // along from the place of its leading edge on the belt
    const double s = std::sin(turn_deg * std::numbers::pi / 180);
    const double c = std::cos(turn_deg * std::numbers::pi / 180);
    const double u = along - 0.5 * length;
    const double w = y - across;
    const double v = u * c - w * s + 0.5 * length;
    const double q = u * s + w * c;
    return v >= 0 && v <= length && std::abs(q) <= 0.5 * width ? height(v, q)
                                                               : std::numeric_limits<double>::quiet_NaN();
  }
};

// The parts that a cutter made of what is sent to it.
struct Cut {
  explicit Cut(const rig::Rig& rig) : cutter(rig) {}

  void add(std::optional<production::CutPart> part) {
    if (part) {
      parts.push_back(std::move(*part));
    }
  }
  void finish() { add(cutter.finish()); }

  std::vector<production::CutPart> parts;
  production::ProfileCutter cutter;
};

// Sends frames of a belt to a cutter.
class MadeBelt {
 public:
  MadeBelt(const rig::Rig& rig, std::uint64_t seed) : rig_(rig), random_(seed) { profile_.resize(rig.camera.columns); }

  double step_mm = 0.1;
  double jitter = 0;           // a step is up to this share longer or shorter
  std::uint64_t sequence = 0;  // of the next frame
  std::uint64_t clocks = 15120;
  double belt_mm = 100;

  // The belt without a part for this way.
  void bare(Cut& cut, double mm) {
    for (const double end = belt_mm + mm; belt_mm < end;) {
      send(
          cut, [](double) { return std::numeric_limits<double>::quiet_NaN(); }, 0);
    }
  }

  // The part, whose leading edge is `lead` mm away, and the same behind it.
  void pass(Cut& cut, const MadePart& part, double lead = 5) {
    const double edge = belt_mm + lead;
    for (const double end = edge + part.length + lead; belt_mm < end;) {
      const double along = belt_mm - edge;
      send(
          cut, [&](double y) { return part.seen(along, y); }, part.noise);
    }
  }

  void send(Cut& cut, const std::function<double(double)>& height, double noise) {
    std::normal_distribution<double> normal(0, 1);
    const double column = rig_.plane_z_mm * rig_.camera.pixel_pitch_mm / rig_.camera.focal_length_mm;
    for (int i = 0; i < rig_.camera.columns; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const double y = (i - 0.5 * (rig_.camera.columns - 1)) * column;
      const double h = height(y);
      const bool there = !std::isnan(h);
      profile_.x[at] = 0;
      profile_.y[at] = static_cast<float>(y);
      profile_.z[at] = static_cast<float>(rig_.plane_z_mm - h - (noise > 0 ? noise * normal(random_) : 0));
      profile_.validity[at] =
          static_cast<std::uint8_t>(there ? light_section::Validity::valid : light_section::Validity::unlit);
    }
    model::PacketHeader header;
    header.sequence = sequence;
    header.time_stamp = sequence * clocks + pause_;
    header.encoder = static_cast<std::uint32_t>(std::llround(belt_mm / rig_.conveyor.encoder_mm_per_count));
    cut.add(cut.cutter.add(header, profile_.view(), static_cast<std::int64_t>(sequence) * 100'000));
    ++sequence;
    belt_mm += step_mm * (1 + jitter * std::uniform_real_distribution<double>(-1, 1)(random_));
  }

  void pause(double seconds) { pause_ += static_cast<std::uint64_t>(seconds * rig_.pixel_clock_hz()); }

 private:
  rig::Rig rig_;
  std::mt19937_64 random_;
  light_section::Profile profile_;
  std::uint64_t pause_ = 0;
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_HOST_PRODUCTION_MADE_PARTS_H
