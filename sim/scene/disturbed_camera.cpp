#include "sim/scene/disturbed_camera.h"

#include <algorithm>
#include <memory>
#include <span>
#include <vector>

#include "sim/scene/defocus.h"
#include "sim/scene/flicker.h"
#include "sim/scene/row_noise.h"
#include "sim/scene/saturation.h"
#include "sim/scene/second_line.h"
#include "sim/scene/vibration.h"

namespace selfproj {

std::unique_ptr<const DisturbedCamera> DisturbedCamera::of(const RealRig& real, const Scene& scene,
                                                           const LitSurface& surface, const World& world) {
  return world.disturbs_camera()
             ? std::unique_ptr<const DisturbedCamera>(new DisturbedCamera(real, scene, surface, world))
             : nullptr;
}

DisturbedCamera::DisturbedCamera(const RealRig& real, const Scene& scene, const LitSurface& surface, const World& world)
    : real_(real), world_(world), without_light_(real.rig.imaging.ambient), speed_(scene.speed()) {
  const std::size_t pixels = real.rig.camera.pixels();
  if (world.bounce) {
    bounce_.emplace(real, scene, surface, *world.bounce);
  }
  if (world.fixed_pattern) {
    fixed_pattern_.emplace(*world.fixed_pattern, real.rig.imaging.electrons_per_grey, pixels, world.seed);
  }
  if (world.defect_pixels) {
    defects_.emplace(*world.defect_pixels, pixels, world.seed);
  }
}

void DisturbedCamera::defocus(const Shot& shot, std::span<float> pixels) const {
  const RigCamera& camera = real_.rig.camera;
  const FocusedLens lens(camera.focal_length_mm, world_.camera_defocus->f_number, camera.pixel_pitch_mm,
                         real_.rig.plane_z_mm - world_.camera_defocus->focus_above_plane_mm);
  std::vector<float> sigma(pixels.size());
  shot.depths(sigma);
  std::transform(sigma.begin(), sigma.end(), sigma.begin(),
                 [&](float z) { return static_cast<float>(lens.sigma_px(static_cast<double>(z))); });
  spread(camera.rows, camera.columns, sigma, pixels);
}

void DisturbedCamera::add_light(const Shot& shot, std::span<float> pixels) const {
  const RigCamera& camera = real_.rig.camera;
  const double dark = real_.rig.imaging.dark;
  if (bounce_) {
    bounce_->add(shot.pattern, shot.t, pixels);
  }
  if (world_.second_line) {
    add_second_line(*world_.second_line, speed_ * shot.t, camera.rows, camera.columns, without_light_, pixels);
  }
  if (world_.flicker) {
    const auto grey = static_cast<float>(flicker_grey(*world_.flicker, shot.t, shot.exposure_s));
    std::transform(pixels.begin(), pixels.end(), pixels.begin(), [grey](float value) { return value + grey; });
  }
  if (world_.camera_defocus) {
    defocus(shot, pixels);
  }
  if (world_.vibration && world_.vibration->camera_px > 0) {
    move_image(camera.rows, camera.columns, camera_shift(*world_.vibration, shot.t), pixels);
  }
  if (world_.saturation) {
    saturate(*world_.saturation, dark, pixels);
  }
  if (fixed_pattern_) {
    fixed_pattern_->add_gains(dark, pixels);
  }
}

void DisturbedCamera::add_faults(int frame, std::span<float> pixels) const {
  if (fixed_pattern_) {
    fixed_pattern_->add_offsets(pixels);
  }
  if (world_.row_noise) {
    add_row_noise(*world_.row_noise, static_cast<std::uint64_t>(real_.rig.imaging.seed), frame,
                  real_.rig.camera.columns, pixels);
  }
  if (defects_) {
    defects_->apply(real_.rig.imaging.dark, pixels);
  }
}

}  // namespace selfproj
