// The rig that takes the images: its camera and projector as they stand, which the host may know or not.
#ifndef SELFPROJ_SIM_SCENE_PERTURBED_RIG_H
#define SELFPROJ_SIM_SCENE_PERTURBED_RIG_H

#include <array>
#include <cstdint>

#include "selfproj/rig/rig.h"
#include "sim/scene/optics.h"

namespace selfproj::sim {

// World frame: the plane of the belt is z = plane_z_mm, and the belt moves along +x. A camera without deviations is at
// the origin and looks along z.
struct PerturbedRig {
  // Camera and projector as the rig's file says. If it has a calibration, they are its full model, with lenses. With a
  // belt_pose the camera leans. A laser is a projector of kLaserLines lines, which `rig` has then, too: the middle one
  // lies in the light plane. A camera with belt_pose or laser is above the place from which it sees the light (for a
  // projector: the middle of its view) at x = y = 0 of the belt.
  // NOLINTNEXTLINE(google-explicit-constructor): a rig without deviations is a perturbed rig too
  PerturbedRig(const rig::Rig& of);

  PerturbedRig(const rig::Rig& of, const Pinhole& its_camera, const Pinhole& its_projector);

  rig::Rig rig;  // sizes, rates, light
  Pinhole camera;
  Pinhole projector;
};

// The lines of what stands for a laser; the middle one, from 0, is kLaserLine.
inline constexpr int kLaserLines = 41;
inline constexpr int kLaserLine = kLaserLines / 2;

// The middle of the area of the plane z = `z` that camera and projector both see. Uses rectangles, which both views
// nearly are.
Point3 middle_of_view(const PerturbedRig& actual, double z);

// How a camera or projector deviates from the rig's file.
struct Perturbation {
  std::array<double, 3> rotation_rad{};  // about the world's x, then y, then z, around its own centre
  Point3 shift_mm{};
  double focal_factor = 1;
  double row_centre_px = 0;
  double column_centre_px = 0;
  BrownLens::Coefficients lens{};
};

// The bounds of what hidden_rig draws, each number evenly between -bound and bound.
inline constexpr double kMaxRotationDeg = 0.5;
inline constexpr double kMaxShiftMm = 5;
inline constexpr double kMaxFocal = 0.01;
inline constexpr double kMaxCentrePx = 10;
inline constexpr BrownLens::Coefficients kMaxDistortion{0.1, 0.01, 0.001, 0.001, 0};

// The rig with deviations of camera and projector. Starts from the pinholes of the rig, without its calibration.
PerturbedRig perturbed_rig(const rig::Rig& nominal, const Perturbation& camera, const Perturbation& projector);

// The same with deviations drawn by this seed. Both are then shifted along the belt so that the middle of what they see
// is at x = y = 0 on it: the belt has no place of its own, and users lay parts where camera and projector look.
PerturbedRig hidden_rig(const rig::Rig& nominal, std::uint64_t seed);

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_SCENE_PERTURBED_RIG_H
