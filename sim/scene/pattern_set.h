// Patterns as the rig's projector throws them: a single image, or several that are shown one after another.
#ifndef SELFPROJ_SIM_SCENE_PATTERN_SET_H
#define SELFPROJ_SIM_SCENE_PATTERN_SET_H

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "host/images/image_files.h"
#include "host/rig/rig.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/renderer.h"

namespace selfproj {

// An image as the rig's projector throws it: its lines x columns, 8 bits, 255 for full light. Only the projector's
// blur, gamma and focus matter among the options. Throws UserError about `source` if the image has another size.
ProjectedLight project_image(const Rig& rig, const Image& image, const RenderOptions& options = {},
                             const std::string& source = "pattern");

// Patterns shown one after another, one for each frame, in a cycle.
class PatternSet {
 public:
  // Needs at least one image, else throws std::invalid_argument; also throws as project_image does.
  PatternSet(const Rig& rig, std::span<const Image> images, const RenderOptions& options = {});

  [[nodiscard]] int size() const { return static_cast<int>(light_.size()); }
  [[nodiscard]] const ProjectedLight& operator[](int pattern) const {
    return light_[static_cast<std::size_t>(pattern)];
  }
  // Frame k shows pattern k mod size().
  [[nodiscard]] const ProjectedLight& of_frame(int frame) const { return (*this)[frame % size()]; }

 private:
  std::vector<ProjectedLight> light_;
};

// The 2 bits patterns of (4.1) along the projector's lines, with values 0 and 255, lines x columns: positive and
// negative of plane 0 (the most significant), then of plane 1, and so on. `bits` is 1..12.
std::vector<Image> gray_patterns(const RigProjector& projector, int bits);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_PATTERN_SET_H
