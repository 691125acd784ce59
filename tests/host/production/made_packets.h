// The packets that a board would send of made parts (made_parts.h) on an empty plane, whose straight line is projected.
#ifndef SELFPROJ_TESTS_HOST_PRODUCTION_MADE_PACKETS_H
#define SELFPROJ_TESTS_HOST_PRODUCTION_MADE_PACKETS_H

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "host/rig/geometry.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"
#include "tests/host/production/made_parts.h"

namespace selfproj::test {

// Appends the packets of parts one after another. `lead` mm of bare belt are before and behind each. Heights of parts
// are some millimetres, so that the line stays in the image; `noise` is that of the centroids, in rows.
class MadePackets {
 public:
  MadePackets(const rig::Rig& rig, std::uint64_t seed) : rig_(rig), random_(seed) {
    const std::vector<double> heights(static_cast<std::size_t>(rig.camera.columns), 0.0);
    reference_ = light_section::reference_of_curve(rig, light_section::curve_of_heights(rig, heights));
    moments_.resize(rig.camera.columns);
    payload_.resize(model::moments_payload_bytes(rig.measure.mode, rig.camera.columns));
  }

  double step_mm = 0.1;
  double noise = 0.02;
  std::vector<std::uint8_t> bytes;

  void pass(const MadePart& part, double lead) {
    const double edge = belt_ + lead;
    for (const double end = edge + part.length + lead; belt_ < end; belt_ += step_mm) {
      frame(part, belt_ - edge);
    }
  }

  // The belt without a part for this way.
  void bare(double mm) {
    for (const double end = belt_ + mm; belt_ < end; belt_ += step_mm) {
      frame(MadePart(), -1000);
    }
  }

  [[nodiscard]] std::string text() const { return {bytes.begin(), bytes.end()}; }

 private:
  // tan α at which a column sees its light plane at this height.
  [[nodiscard]] double alpha(std::size_t i, double height) const {
    const double theta = reference_.tan_theta[i];
    return (rig_.projector.x_mm + rig_.projector.z_mm * theta) / (rig_.plane_z_mm - height) - theta;
  }

  void frame(const MadePart& part, double along) {
    std::normal_distribution<double> normal(0, noise);
    for (int column = 0; column < rig_.camera.columns; ++column) {
      const auto i = static_cast<std::size_t>(column);
      // What is nearest to the camera: the top where the part is, or the plane. Light and top meet where the guess of
      // the height is that of the top there.
      double tan = alpha(i, 0);
      double guess = part.height(0.5 * part.length, 0);
      bool seen =
          std::isnan(part.seen(along, rig_.plane_z_mm * rig::tan_beta(rig_.camera, column)));  // else a side of it
      for (int round = 0; round < 4; ++round) {
        const double z = rig_.plane_z_mm - guess;
        const double top = part.seen(along - z * alpha(i, guess), z * rig::tan_beta(rig_.camera, column));
        if (std::isnan(top)) {
          break;
        }
        guess = top;
        tan = alpha(i, top);
        seen = true;
      }
      const double row = rig::centroid_of(rig_.camera, tan) + normal(random_);
      constexpr double kLight = 200'000;
      seen = seen && row > 4 && row < rig_.camera.rows - 3;
      moments_.m0[i] = seen ? static_cast<std::uint32_t>(kLight) : 0;
      moments_.m1[i] = seen ? static_cast<std::uint32_t>(std::lround(kLight * row)) : 0;
      moments_.n[i] = seen ? 5 : 0;
    }
    model::PacketHeader header;
    header.kind = spec::kKindMoments;
    header.sequence = sequence_;
    header.time_stamp = 15120 * sequence_;
    header.encoder = static_cast<std::uint32_t>(std::llround(belt_ / rig_.conveyor.encoder_mm_per_count));
    header.columns = static_cast<std::uint16_t>(rig_.camera.columns);
    header.rows = static_cast<std::uint16_t>(rig_.camera.rows);
    header.mode = static_cast<std::uint8_t>(rig_.measure.mode);
    header.threshold = static_cast<std::uint8_t>(rig_.measure.threshold);
    model::pack_moments(rig_.measure.mode, rig_.camera.columns, moments_.view(), payload_.data());
    model::append_packet(header, payload_, 0, bytes);
    ++sequence_;
  }

  rig::Rig rig_;
  std::mt19937_64 random_;
  light_section::ReferenceProfile reference_;
  model::Moments moments_;
  std::vector<std::uint8_t> payload_;
  double belt_ = 50;
  std::uint64_t sequence_ = 0;
};

// The rig of such parts, which are 8 mm high.
inline rig::Rig rig_of_made_packets() {
  rig::Rig rig = rig_with_parts();
  rig.name = "made";
  rig.parts->above_mm = 4;
  return rig;
}

// A part of the run: 20 mm long, 40 mm wide, 8 mm high; with a dent of 0.5 mm on 3 x 3 mm at (12, 5), if wanted.
inline MadePart made_part(bool dent, double across = 0, double turn_deg = 0) {
  MadePart part{.length = 20, .width = 40, .across = across, .turn_deg = turn_deg};
  part.height = [dent](double v, double w) {
    return dent && std::abs(v - 12) < 1.5 && std::abs(w - 5) < 1.5 ? 7.5 : 8;
  };
  return part;
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_HOST_PRODUCTION_MADE_PACKETS_H
