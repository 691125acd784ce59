// Parts on a belt with defects planted into their surface, as profiles: rendered, reduced to packets, and measured.
#ifndef SELFPROJ_LAB_PLANTED_PARTS_H
#define SELFPROJ_LAB_PLANTED_PARTS_H

#include <cstdint>
#include <functional>
#include <vector>

#include "host/light_section/profile.h"
#include "host/rig/rig.h"
#include "model/packet.h"
#include "sim/cosim/light_section.h"
#include "sim/scene/planted_part.h"
#include "sim/scene/renderer.h"

namespace selfproj {

// The defect at which the goal is set: its size and depth, mm.
inline constexpr double kGoalSize = 2;
inline constexpr double kGoalDepth = 0.3;

// Bounds of the others, which are drawn evenly on a logarithmic scale.
inline constexpr double kLeastSize = 0.5, kMostSize = 10;
inline constexpr double kLeastDepth = 0.05, kMostDepth = 1;

struct DrawnPart {
  PartPose pose;  // shifted by up to 1 mm, turned by up to 1 degree
  std::vector<PlantedDefect> defects;
  std::uint64_t noise = 0;  // seed
};

// Part `number` of this seed. A planted part has the goal's defect on one tread, and one of any size and depth on the
// other; both anywhere, half of them bumps.
DrawnPart draw_part(const Rig& rig, std::uint64_t seed, std::uint64_t number, bool planted);

// The rig of such parts: a belt that moves 0.25 mm a frame, and the section `parts`.
Rig rig_of_planted_parts(Rig rig);

// Appends parts to one stream of frames.
class PlantedParts {
 public:
  using Take = std::function<void(const PacketHeader&, const ProfileView&)>;

  PlantedParts(const LightSection& setup, const RenderOptions& options) : setup_(setup), options_(options) {}

  // Passes the profiles of these parts on in the order of the belt, with bare belt before and behind each. What lies
  // between two parts, further than the shadow of the first one reaches, is left out. Works with
  // several threads (0: one for each core); `take` is called in the thread that calls.
  void pass(const std::vector<DrawnPart>& parts, int threads, const Take& take);

 private:
  [[nodiscard]] std::vector<Profile> profiles_of(const DrawnPart& part) const;

  const LightSection& setup_;
  RenderOptions options_;
  std::uint64_t sequence_ = 0;
};

}  // namespace selfproj

#endif  // SELFPROJ_LAB_PLANTED_PARTS_H
