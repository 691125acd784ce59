// Parts on a belt with defects planted into their surface, as profiles: rendered, reduced to packets, and measured.
#ifndef SELFPROJ_LAB_PLANTED_PARTS_H
#define SELFPROJ_LAB_PLANTED_PARTS_H

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "host/images/image_files.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"
#include "sim/cosim/light_section.h"
#include "sim/scene/planted_part.h"
#include "sim/scene/renderer.h"

namespace selfproj::lab {

using sim::PartPose;
using sim::PlantedDefect;
using sim::PlantedPart;

// The defect at which the goal is set: its size and depth, mm.
inline constexpr double kGoalSize = 2;
inline constexpr double kGoalDepth = 0.3;

// Bounds of the others, which are drawn evenly on a logarithmic scale.
inline constexpr double kMinSize = 0.5, kMaxSize = 10;
inline constexpr double kMinDepth = 0.05, kMaxDepth = 1;

struct DrawnPart {
  PartPose pose;  // turned by up to 1 degree
  std::vector<PlantedDefect> defects;
  std::uint64_t noise = 0;  // seed
};

// Part `number` of this seed, shifted across by up to max_shift_mm. A planted part has the goal's defect on one tread,
// and one of any size and depth on the other; both anywhere, half of them bumps.
DrawnPart draw_part(const rig::Rig& rig, std::uint64_t seed, std::uint64_t number, bool planted,
                    double max_shift_mm = 1);

// A part before the camera without its noise: of each frame the grey values.
struct CleanPart {
  std::vector<std::vector<float>> frames;
};

// The rig of such parts: a belt that moves 0.25 mm a frame, and the section `parts`.
rig::Rig rig_of_planted_parts(rig::Rig rig);

// Appends parts to one stream of frames.
class PlantedParts {
 public:
  using Take =
      std::function<void(const model::PacketHeader&, const light_section::ProfileView&, const model::Moments&)>;

  PlantedParts(const sim::LightSection& setup, const sim::RenderOptions& options) : setup_(setup), options_(options) {}

  // Passes the profiles of these parts on in the order of the belt, with bare belt before and behind each. What lies
  // between two parts, further than the shadow of the first one reaches, is left out. Works with
  // several threads (0: one for each core); `take` is called in the thread that calls.
  void pass(const std::vector<DrawnPart>& parts, int threads, const Take& take);

  // The images of the frames in which such a part passes by the camera, with as much bare belt before it that nothing
  // is missing where another part came before.
  [[nodiscard]] std::vector<images::Image> images_of(const DrawnPart& part) const;

  // The same as pass() for parts that lie exactly alike, each with noise of this seed: images are those that pass()
  // would render, in a tenth of the time. Not in a world with disturbances.
  [[nodiscard]] CleanPart clean(const DrawnPart& part) const;
  void pass(const CleanPart& clean, const std::vector<std::uint64_t>& noise, int threads, const Take& take);

 private:
  struct Measured {
    light_section::Profile profile;
    model::Moments moments;
  };
  using Frames = std::vector<Measured>;
  using Draw = std::function<void(std::size_t frame, std::span<std::uint8_t> pixels)>;

  [[nodiscard]] Frames measured(const Draw& draw) const;
  void pass(std::size_t parts, int threads, const std::function<Frames(std::size_t)>& part, const Take& take);

  const sim::LightSection& setup_;
  sim::RenderOptions options_;
  std::uint64_t sequence_ = 0;
};

}  // namespace selfproj::lab

#endif  // SELFPROJ_LAB_PLANTED_PARTS_H
