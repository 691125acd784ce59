// Vibration: the belt swings up and down, and the camera tips, which moves its image.
#ifndef SELFPROJ_SIM_SCENE_VIBRATION_H
#define SELFPROJ_SIM_SCENE_VIBRATION_H

#include <memory>
#include <span>

#include "sim/scene/scene.h"

namespace selfproj {

struct Vibration {
  double belt_mm = 0;  // amplitude
  double belt_hz = 25;
  double camera_px = 0;  // amplitude along rows and, a quarter of a period later, along columns
  double camera_hz = 50;
};

// The scene on a belt that swings: its heights are those of `scene`, which must live as long, and
// belt_mm sin(2π belt_hz t) more.
std::unique_ptr<Scene> on_swinging_belt(const Scene& scene, const Vibration& vibration);

// How far the camera's image is moved at the time t, pixels.
struct ImageShift {
  double rows, columns;
};
ImageShift camera_shift(const Vibration& vibration, double t);

// Moves an image: what was at a pixel comes to its place plus the shift. Keys's cubic convolution, which moves the
// centroid of a spot exactly. The border is repeated outwards.
void move_image(int rows, int columns, ImageShift shift, std::span<float> pixels);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_VIBRATION_H
