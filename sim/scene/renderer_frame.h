// What the renderer of a line knows about a frame while it renders it.
#ifndef SELFPROJ_SIM_SCENE_RENDERER_FRAME_H
#define SELFPROJ_SIM_SCENE_RENDERER_FRAME_H

#include <cstddef>
#include <vector>

#include "sim/scene/block_grid.h"
#include "sim/scene/scene.h"

namespace selfproj {

// Values that are the same for all pixels of a frame.
struct FrameLight {
  double middle;        // middle of the exposure, s
  double exposure;      // s; 0 without motion blur
  int passes;           // how many instants each sub-pixel is sampled at
  HeightRange heights;  // of the whole scene during the exposure

  [[nodiscard]] double first() const { return middle - exposure / 2; }
  [[nodiscard]] double last() const { return middle + exposure / 2; }
};

// The grey values of a row of blocks, sub-pixel by sub-pixel, less those of a dark surface. Outside of the columns
// first..last - 1 they are 0.
struct SubPixelStrip {
  explicit SubPixelStrip(int sub_columns)
      : width(sub_columns), samples(static_cast<std::size_t>(sub_columns) * static_cast<std::size_t>(rows())) {}

  [[nodiscard]] static constexpr int rows() { return kBlockSide; }
  [[nodiscard]] float* row(int i) { return samples.data() + static_cast<std::ptrdiff_t>(i) * width; }
  [[nodiscard]] const float* row(int i) const { return samples.data() + static_cast<std::ptrdiff_t>(i) * width; }

  int width;
  int first = 0;
  int last = 0;
  std::vector<float> samples;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_RENDERER_FRAME_H
